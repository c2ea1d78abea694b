"""The blocks of a run in flat arrays, as a result file holds them."""

from __future__ import annotations

from collections.abc import Iterator

import h5py
import numpy as np

from masonry_cd.model.blocks import Block


def write_blocks(group: h5py.Group, blocks: tuple[Block, ...]) -> None:
    """Write the blocks in flat arrays."""
    text = h5py.string_dtype()
    group.create_dataset("name", data=[b.name for b in blocks], dtype=text)
    group.create_dataset("group", data=[b.group for b in blocks], dtype=text)
    if any(b.structure for b in blocks):
        group.create_dataset("structure", data=[b.structure for b in blocks], dtype=text)
    group["fixed"] = np.array([b.fixed for b in blocks])
    group["density"] = np.array([b.density for b in blocks])
    group["vertex_start"] = np.cumsum([0, *(len(b.vertices) for b in blocks)])
    group["vertices"] = np.concatenate([b.vertices for b in blocks])
    group["face_start"] = np.cumsum([0, *(len(b.faces) for b in blocks)])
    group["loop_start"] = np.cumsum([0, *(len(face) for b in blocks for face in b.faces)])
    group["loops"] = np.array([i for b in blocks for face in b.faces for i in face])


def read_blocks(group: h5py.Group) -> Iterator[Block]:
    """Read back what :func:`write_blocks` wrote."""
    names, groups = group["name"].asstr()[...], group["group"].asstr()[...]
    structures = group["structure"].asstr()[...] if "structure" in group else [""] * len(names)
    arrays = {name: group[name][...] for name in ("fixed", "density", "vertex_start", "vertices", "face_start", "loop_start", "loops")}
    for i, name in enumerate(names):
        vertices = arrays["vertices"][arrays["vertex_start"][i] : arrays["vertex_start"][i + 1]]
        loops = range(arrays["face_start"][i], arrays["face_start"][i + 1])
        faces = tuple(tuple(arrays["loops"][arrays["loop_start"][f] : arrays["loop_start"][f + 1]].tolist()) for f in loops)
        yield Block(name, vertices, faces, float(arrays["density"][i]), groups[i], bool(arrays["fixed"][i]), structure=structures[i])
