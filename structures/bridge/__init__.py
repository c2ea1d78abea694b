# SPDX-License-Identifier: GPL-3.0-or-later
"""Masonry bridges: spans, rings, piers, walls and the fill between them."""
