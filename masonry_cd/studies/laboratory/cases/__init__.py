# SPDX-License-Identifier: GPL-3.0-or-later
"""The cases, a file for each set of tests: ``CASE = Case(...)``. They are known by their name and listed here in the order of the page."""

from masonry_cd.studies.laboratory.cases import (
    arch,
    arch_bridge,
    bed,
    bending,
    columns,
    dry_walls,
    granite_walls,
    overturning,
    restitution,
    rocking_set,
)

_OTHERS = (bending, arch, arch_bridge, columns, restitution, rocking_set, overturning, bed)
CASES = {
    case.name: case
    for case in (dry_walls.CASE, granite_walls.CYCLIC, granite_walls.MORTAR, granite_walls.CRACKED, *(one.CASE for one in _OTHERS))
}
