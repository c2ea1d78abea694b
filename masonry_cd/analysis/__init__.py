# SPDX-License-Identifier: GPL-3.0-or-later
"""Questions asked of a model or of the results of a run: damage, limit load, modes, stress, code checks, fragilities."""
