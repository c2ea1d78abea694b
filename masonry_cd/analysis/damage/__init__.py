"""Damage of joints, of parts and of the whole: measures, grades, mechanisms."""
