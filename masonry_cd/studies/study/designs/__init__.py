# SPDX-License-Identifier: GPL-3.0-or-later
"""Designs: which runs a study has. Each file defines one, by the name that the study file gives it."""
