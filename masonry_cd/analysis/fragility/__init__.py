# SPDX-License-Identifier: GPL-3.0-or-later
"""Findings from all runs of a study together: intensity measures, limit states, fragilities and their bands."""
