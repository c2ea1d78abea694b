# SPDX-License-Identifier: GPL-3.0-or-later
"""Damage of joints, of parts and of the whole: measures, grades, mechanisms."""
