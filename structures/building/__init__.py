# SPDX-License-Identifier: GPL-3.0-or-later
"""Buildings from a plan: walls of any direction, their junctions and openings, vaults, columns and arcades."""
