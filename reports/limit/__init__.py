"""Limit analyses in tables and pictures: the mechanism, and the forces at collapse."""
