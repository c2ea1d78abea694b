# SPDX-License-Identifier: GPL-3.0-or-later
"""The Moreau-Jean step: motion, contact rows, impacts, joint laws, islands, energy."""
