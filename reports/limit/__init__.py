# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analyses in tables and pictures: the mechanism, and the forces at collapse."""
