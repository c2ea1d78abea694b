# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases, one file each: ``CASE = Case(...)``. They are known by their name and listed here in the order of the page."""

from masonry_cd.studies.laboratory.cases import (
    arch,
    arch_bridge,
    bed,
    bending,
    columns,
    cyclic_walls,
    dry_walls,
    mortar_walls,
    overturning,
    restitution,
)

_ORDER = (dry_walls, cyclic_walls, mortar_walls, bending, arch, arch_bridge, columns, restitution, overturning, bed)
CASES = {one.CASE.name: one.CASE for one in _ORDER}
