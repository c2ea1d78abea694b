# SPDX-License-Identifier: GPL-3.0-or-later
"""How masonry is laid out: profiles of arches, openings, courses, walls in plan."""
