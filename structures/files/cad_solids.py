# SPDX-License-Identifier: GPL-3.0-or-later
"""The solids of a CAD model as they are, each a block: read by the OpenCASCADE kernel in a child process (:mod:`structures.files.foreign`).

Labels of the model become names; what stands before the last part of a label, an assembly in it, is the group. Curved faces become flat
facets, as where a solid is cut (:mod:`structures.files.facets`). This module imports nothing but numpy, and gmsh when it is called.
"""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import numpy as np

from structures.files import step_names
from structures.files.facets import curved_faces, gathered, left_out, opened, shells_of
from structures.files.foreign import FileContents, FileShell, Refused

SAME = 1e-7  # corners this close are one, as a share of the extents of the whole
ROOT = "Shapes"  # under which the kernel puts all labels


def read(path: Path, chord: float | None = None) -> FileContents:
    """Read the solids of a STEP or BREP file.

    Args:
        path: of the file.
        chord: how far a flat facet may be off its curved face, in units of the file.

    Returns:
        a shell of each solid, whose corners are not joined yet; and two figures, in units of the file: how near corners are that are one,
        and how far facets are off curved faces.

    Raises:
        Refused: a file that cannot be read, curved faces without ``chord``, facets that stay farther off, or
            other names than solids.
    """
    own = step_names.get(path)
    with opened(path, labels=own is None) as gmsh:
        unread = left_out(gmsh, path)
        curved_faces(gmsh, chord, path.name)
        volumes = [tag for _, tag in gmsh.model.occ.getEntities(3)]
        boxes = np.array([gmsh.model.occ.getBoundingBox(3, tag) for tag in volumes])
        same = SAME * float((boxes[:, 3:].max(axis=0) - boxes[:, :3].min(axis=0)).max())
        shells, off = shells_of(gmsh, volumes, chord, same, path.name)
        names, groups = own or named([gmsh.model.getEntityName(3, tag) for tag in volumes])
    if not len(names) == len(groups) == len(shells):
        raise Refused(path.name, f"has {len(shells)} solids, {len(names)} names and {len(groups)} groups of blocks")
    pieces = [FileShell(k, names[k], *gathered(shell), group=groups[k]) for k, shell in enumerate(shells)]
    return FileContents(pieces, (same, off), unread)


def named(labels: list[str]) -> tuple[list[str], list[str]]:
    """Names, each once, and groups of solids, from labels such as ``Shapes/arch/v1``."""
    paths = [[word for word in label.split("/") if word] for label in labels]
    paths = [path[1:] if path[:1] == [ROOT] else path for path in paths]
    bare = [path[-1] if path else f"b{k}" for k, path in enumerate(paths)]
    count, taken, names = Counter(bare), Counter[str](), []
    for name in bare:
        names.append(f"{name}.{taken[name]}" if count[name] > 1 else name)
        taken[name] += 1
    return names, [path[-2] if len(path) > 1 else "" for path in paths]
