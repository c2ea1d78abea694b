# SPDX-License-Identifier: GPL-3.0-or-later
"""The layout of result.h5: one table of its datasets, by which it is written, checked, read, sealed and documented (docs/outputs.md).

SI units, world frame. The first dimension says how a dataset comes about: what has a row per frame F, step N, shock K or byte of the
closing words grows as the run goes, in chunks and without compression; largest values over all steps are written over; all else is written
once. The order of what is written once is that of its checksum, so a new dataset goes behind the others of its kind. Numbers of a step, of
the shape (N,) each, are not among these: :mod:`masonry_cd.app.per_step` declares them.

Files of older versions lack some datasets; what they lack is not read, or is taken from the frames. One without the attribute
``format`` is from before there were checksums; it still reads.
"""

from __future__ import annotations

from typing import NamedTuple

from masonry_cd.io.gauges import GUIDE_COLUMNS
from masonry_cd.mechanics.model.joint_laws import bonded, crushing, histories

FORMAT = 1  # of the layout; raised when an older program would misread it
REAL, WHOLE, FLAG, TEXT, BYTES = "f", "iu", "b", "O", "S"  # kinds of numpy's types
KINDS = {REAL: "real numbers", WHOLE: "whole numbers", FLAG: "flags", TEXT: "texts", BYTES: "texts", REAL + WHOLE: "numbers"}
DIMENSIONS = {
    "F": "frames", "N": "steps", "K": "shocks", "bytes": "bytes", "B": "blocks", "S": "supports", "J": "joints",
    "P": "parts, the whole last", "H": "levels of the height, the foot first", "T": "bars of ties",
    "M": "meshed blocks", "V": "nodes of meshes", "E": "elements", "G": "faces on which fill lies",
}  # fmt: skip
GROWS = ("F", "N", "K", "bytes")  # first dimensions of what grows


class Dataset(NamedTuple):
    """A dataset of the file."""

    name: str
    shape: tuple[str | int, ...]  # sizes, dimensions by their names, or one more than such a dimension, "B+1"
    kind: str  # of its type
    unit: str
    meaning: str
    when: str = ""  # where a file has it; empty: everywhere

    @property
    def grows(self) -> bool:
        """Return True if it gets rows as the run goes."""
        return self.shape[0] in GROWS

    @property
    def peak(self) -> bool:
        """Return True if it holds largest values over all steps, which are written over."""
        return self.name.startswith(("joints/peak/", "peaks/"))


FILLED = "there is fill; not in files of older versions"
FILL, MESHED, STRESSED = "blocks carry fill", "blocks are meshed and the scene asks for stress", "the scene asks for stress"
NEWER, ELASTIC, SEQUENCE = "not in files of older versions", "blocks deform", "the loads are a sequence of shocks"
CHANGED = "the scene has [[events]], or Python recorded the run"
PUSHED, WATCHED = "there are pushes by displacement or props", "the scene asks in [output]"

DATASETS = (
    Dataset("blocks/name", ("B",), TEXT, "", "name of the block"),
    Dataset("blocks/group", ("B",), TEXT, "", "group of the block"),
    Dataset("blocks/fixed", ("B",), FLAG, "", "the block is a support"),
    Dataset("blocks/density", ("B",), REAL, "kg/m3", "density of the block"),
    Dataset("blocks/vertex_start", ("B+1",), WHOLE, "", "where the vertices of each block begin, and where the last end"),
    Dataset("blocks/vertices", ("corners", 3), REAL, "m", "corners as built; a sphere has one, its centre"),
    Dataset("blocks/face_start", ("B+1",), WHOLE, "", "where the faces of each block begin"),
    Dataset("blocks/loop_start", ("faces+1",), WHOLE, "", "where the vertices of each face begin"),
    Dataset("blocks/loops", ("entries",), WHOLE, "", "vertices of the faces, counted in each block, counter-clockwise seen from outside"),
    Dataset("joints/block_a", ("J",), WHOLE, "", "number of the first block"),
    Dataset("joints/block_b", ("J",), WHOLE, "", "number of the second block"),
    Dataset("joints/area", ("J",), REAL, "m2", "area at rest"),
    Dataset("joints/normal", ("J", 3), REAL, "", "normal at rest, from the first block to the second"),
    Dataset("joints/polygon_start", ("J+1",), WHOLE, "", "where the corners of each joint begin"),
    Dataset("joints/polygon", ("points", 3), REAL, "m", "corners of the joints at rest"),
    Dataset("blocks/structure", ("B",), TEXT, "", "the structure that the block belongs to", "a scene has several"),
    Dataset("blocks/stone", ("B",), TEXT, "", "the stone that the block is a piece of; empty for a whole stone", "stones crack"),
    Dataset("blocks/support", (1,), WHOLE, "", "block to which displacements are relative, -1 without one", NEWER),
    Dataset("blocks/radius", ("B",), REAL, "m", "radius of a sphere, 0 for polyhedra", "there are spheres"),
    Dataset("blocks/carried_mass", ("B",), REAL, "kg", "mass of the fill that the block carries", FILL),
    Dataset("blocks/carried_centre", ("B", 3), REAL, "m", "centre of that mass", FILL),
    Dataset("blocks/carried_inertia", ("B", 3, 3), REAL, "kg m2", "inertia of that mass about its centre", FILL),
    Dataset("blocks/fill_block", ("G",), WHOLE, "", "block on which the fill lies", FILLED),
    Dataset("blocks/fill_level", ("G",), REAL, "m", "level of the fill there", FILLED),
    Dataset("blocks/fill_start", ("G+1",), WHOLE, "", "where the corners of each face begin", FILLED),
    Dataset("blocks/fill_corners", ("fill corners", 3), REAL, "m", "corners of the faces at rest", FILLED),
    Dataset("meshes/block", ("M",), WHOLE, "", "numbers of the meshed blocks", MESHED),
    Dataset("meshes/node_start", ("M+1",), WHOLE, "", "where the nodes of each block begin", MESHED),
    Dataset("meshes/nodes", ("V", 3), REAL, "m", "nodes as built, in a plane in the middle of the block", MESHED),
    Dataset("meshes/element_start", ("M+1",), WHOLE, "", "where the elements of each block begin", MESHED),
    Dataset("meshes/elements", ("E", "d+1"), WHOLE, "", "nodes of tetrahedra, or of triangles in a plane", MESHED),
    Dataset("joints/peak/opening", ("J",), REAL, "m", "largest opening"),
    Dataset("joints/peak/sliding", ("J",), REAL, "m", "largest sliding"),
    Dataset("joints/peak/rotation", ("J",), REAL, "rad", "largest rotation"),
    Dataset("joints/peak/contact_area_loss", ("J",), REAL, "", "largest share of the area without contact"),
    Dataset("joints/peak/first_opening_time", ("J",), REAL, "s", "time of the first opening; NaN where it never opened"),
    Dataset("peaks/displacement", ("B",), REAL, "m", "largest displacement of each centre of mass relative to the support", NEWER),
    Dataset("peaks/drift", ("P",), REAL, "", "largest drift of each part", NEWER),
    Dataset("peaks/level_displacement", ("P", "H"), REAL, "m", "largest horizontal displacement of each level", NEWER),
    Dataset("peaks/level_drift", ("P", "H"), REAL, "", "largest drift of each level", NEWER),
    Dataset("peaks/hinge_opening", ("J",), REAL, "m", "largest opening while the joint was a hinge", NEWER),
    Dataset("peaks/hinge_time", ("J",), REAL, "s", "time of that opening; NaN without a hinge", NEWER),
    Dataset("peaks/hinge_place", ("J", 3), REAL, "m", "point of contact at that time, in the position at rest; NaN without a hinge", NEWER),
    Dataset("time", ("F",), REAL, "s", "time of the frame"),
    Dataset("position", ("F", "B", 3), REAL, "m", "positions of the centres of mass"),
    Dataset("orientation", ("F", "B", 4), REAL, "", "unit quaternions, w first"),
    Dataset("velocity", ("F", "B", 6), REAL, "m/s, rad/s", "linear and angular velocity"),
    Dataset("joints/opening", ("F", "J"), REAL, "m", "widest corner gap"),
    Dataset("joints/sliding", ("F", "J"), REAL, "m", "sliding of the corners in contact"),
    Dataset("joints/rotation", ("F", "J"), REAL, "rad", "relative rotation of the blocks"),
    Dataset("joints/contact_area", ("F", "J"), REAL, "m2", "area in contact"),
    Dataset("joints/normal_force", ("F", "J"), REAL, "N", "normal force at the frame"),
    Dataset("joints/shear_force", ("F", "J"), REAL, "N", "shear force at the frame"),
    Dataset("joints/force_point", ("F", "J", 3), REAL, "m", "point where the force crosses the plane of the joint; NaN without a force"),
    Dataset("joints/force", ("F", "J", 3), REAL, "N", "mean force on the second block during the previous step", NEWER),
    Dataset(
        "reaction",
        ("F", "S", 6),
        REAL,
        "N, N m",
        "mean force and moment, about the centre of each support, on the blocks that it carries",
        NEWER,
    ),
    Dataset("present", ("F", "B"), FLAG, "", "the block exists", CHANGED),
    Dataset("gradient", ("F", "B", 3, 3), REAL, "", "displacement gradient of the blocks, body frame; zero for rigid blocks", ELASTIC),
    *(Dataset(f"joints/{law.name}", ("F", "J"), REAL, law.unit, law.meaning, "joints have the law") for law in histories()),
    Dataset("stress", ("F", "B", 6), REAL, "Pa", "mean stress since the previous frame: xx yy zz xy yz xz, tension positive", STRESSED),
    Dataset("joints/mean_normal_force", ("F", "J"), REAL, "N", "mean normal force since the previous frame", STRESSED),
    Dataset(
        "joints/edge_stress", ("F", "J"), REAL, "Pa", "largest compression from that force; infinite where it acts at an edge", STRESSED
    ),
    Dataset("meshes/displacement", ("F", "V", 3), REAL, "m", "u of the nodes, body frame: one built at X is at x + R (X - c + u)", MESHED),
    Dataset(
        "meshes/stress",
        ("F", "E", 6),
        REAL,
        "Pa",
        "mean stress of the elements since the previous frame, with the components of the stress of blocks",
        MESHED,
    ),
    Dataset("ties/tension", ("N", "T"), REAL, "N", "tension of each bar, in the order of the attribute ties", "there are ties"),
    *(Dataset(f"guides/{name}", ("N", "guides"), REAL, "", "see io/gauges.py", PUSHED) for name in GUIDE_COLUMNS),
    Dataset("gauges/points", ("N", "watched", 6), REAL, "m, m/s", "displacement and velocity of points", WATCHED),
    Dataset(
        "gauges/base", ("N", 6), REAL, "m, m/s", "displacement and velocity of the support to which displacements are relative", WATCHED
    ),
    Dataset("gauges/joints", ("N", "watched joints", 8), REAL, "m, N, N m", "see io/gauges.py", WATCHED),
    Dataset("gauges/cracks", ("N", "cracks", 3), REAL, "m", "displacement of the second point relative to the first", WATCHED),
    Dataset("gauges/supports", ("N", "watched supports", 3), REAL, "N", "force on the blocks that the support carries", WATCHED),
    Dataset("shocks/name", ("K",), BYTES, "", "name of the shock", SEQUENCE),
    Dataset("shocks/frame", ("K",), WHOLE, "", "frame at the end of the rest after the shock", SEQUENCE),
    Dataset("shocks/start", ("K",), REAL, "s", "start of the shock", SEQUENCE),
    Dataset("shocks/end", ("K",), REAL, "s", "end of the shock", SEQUENCE),
    Dataset("shocks/opening", ("K", "J"), REAL, "m", "largest opening so far", SEQUENCE),
    Dataset("shocks/sliding", ("K", "J"), REAL, "m", "largest sliding so far", SEQUENCE),
    Dataset("shocks/rotation", ("K", "J"), REAL, "rad", "largest rotation so far", SEQUENCE),
    Dataset("shocks/contact_area_loss", ("K", "J"), REAL, "", "largest share of the area without contact so far", SEQUENCE),
    Dataset("shocks/first_opening_time", ("K", "J"), REAL, "s", "time of the first opening; NaN where it had not opened", SEQUENCE),
    Dataset("shocks/peaks/drift", ("K", "P"), REAL, "", "largest drift of each part so far", SEQUENCE),
    Dataset("shocks/peaks/hinge_opening", ("K", "J"), REAL, "m", "largest opening so far while the joint was a hinge", SEQUENCE),
    Dataset(
        "closing", ("bytes",), "u", "", "JSON of the keys of summary.json that do not follow from the other datasets", "the run has ended"
    ),
)
BY_NAME = {dataset.name: dataset for dataset in DATASETS}
ATTRIBUTES = {
    "scene": "the text of the scene file",
    "title": "title of the scene",
    "versions": "versions of the program and of the packages that affect its numbers (JSON)",
    "run": "unique name of the run",
    "inputs": "SHA-256 of each file that the scene reads (JSON)",
}  # which every file has
OPTIONAL_ATTRIBUTES = {"ties": "the bars of ties (JSON)", "gauges": "further quantities that are recorded in every step (JSON)"}
OTHER_ATTRIBUTES = {
    "scene_file": "path of the scene file relative to the folder of this file",
    "format": "version of the layout",
    "constant": "SHA-256 of all datasets that do not grow, and of the attributes except scene_file",
}


def _under(folder: str, *, of: str = "") -> tuple[str, ...]:
    """Names of the datasets in a folder of the file, those of a first dimension, or else those that are written once or over."""
    chosen = (one for one in DATASETS if one.name.rpartition("/")[0] == folder and (one.shape[0] == of if of else not one.grows))
    return tuple(one.name.rpartition("/")[2] for one in chosen)


CONSTANTS = tuple(one.name for one in DATASETS if not one.grows and not one.peak)  # in the order of their checksum
JOINT_CONSTANTS, MESH_ARRAYS = _under("joints"), _under("meshes")
JOINT_PEAKS, STEP_PEAKS, SHOCK_PEAKS = _under("joints/peak"), _under("peaks"), _under("shocks/peaks", of="K")
JOINT_HISTORIES = tuple(name for name in _under("joints", of="F") if not BY_NAME[f"joints/{name}"].when)
LAW_HISTORIES = tuple(law.name for law in histories())
BONDED, CRUSHED = bonded.HISTORY.name, crushing.HISTORY.name
FORCE, REACTION, GRADIENT, STRESS, CLOSING, PRESENT = "force", "reaction", "gradient", "stress", "closing", "present"
MEAN_NORMAL_FORCE, EDGE_STRESS = "mean_normal_force", "edge_stress"
NODE_DISPLACEMENT, ELEMENT_STRESS = "meshes/displacement", "meshes/stress"
