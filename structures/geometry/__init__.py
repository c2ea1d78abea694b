# SPDX-License-Identifier: GPL-3.0-or-later
"""Geometry of blocks: prisms, cuts, convex parts, overlaps, gaps, soundness."""
