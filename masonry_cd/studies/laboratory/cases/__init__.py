"""The cases, one file each: ``CASE = Case(...)``. They are known by their name and listed here in the order of the page."""

from masonry_cd.studies.laboratory.cases import arch, bed, bending, columns, dry_walls

CASES = {one.name: one for one in (dry_walls.CASE, bending.CASE, arch.CASE, columns.CASE, bed.CASE)}
