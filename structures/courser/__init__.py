# SPDX-License-Identifier: GPL-3.0-or-later
"""Coursed masonry that kinds of structure share: lines of arches (:mod:`.arch_profiles`), head joints of a bond (:mod:`.bond`), courses
and their stones (:mod:`.courses`), walls along x and y with their openings (:mod:`.wall_plan`), the courses of vaults
(:mod:`.vault_courses`) and of rings over a polygon (:mod:`.rings`), and columns in drums (:mod:`.columns`)."""
