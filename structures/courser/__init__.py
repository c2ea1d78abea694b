# SPDX-License-Identifier: GPL-3.0-or-later
"""What coursed masonry of all kinds shares: lines of arches (:mod:`.arch_profiles`), head joints of a bond (:mod:`.bond`), the courses
of vaults (:mod:`.vault_courses`) and of rings over a polygon (:mod:`.rings`), and columns in drums (:mod:`.columns`)."""
