# SPDX-License-Identifier: GPL-3.0-or-later
"""What a result file holds, by name.

Layout (F frames, N steps, B blocks, J joints; SI units, world frame):

    /time (F,)  /position (F, B, 3)  /orientation (F, B, 4) w first  /velocity (F, B, 6) linear, angular
    /gradient (F, B, 3, 3)   of the displacement of blocks that deform, body frame; zeros of rigid ones; only where blocks deform
    /joints/{block_a, block_b, area, normal, polygon_start, polygon}          what the joints are
    /joints/{opening, sliding, rotation, contact_area, normal_force, shear_force} (F, J)
    /joints/force_point (F, J, 3)    where the force of a joint crosses its plane, NaN where it has none
    /joints/force (F, J, 3)   mean force of the joint on its block b over the step before, its opposite acts on block a [N]
    /reaction (F, S, 6)   force and moment about its centre of mass of each of S supports on what it carries, likewise [N, N m]
    /joints/bonded (F, J)   share of the area that is bonded; only where joints are
    /joints/crushed (F, J)   by how much the joint is shorter for good where it is most so [m]; only where joints can crush
    /joints/peak/{opening, sliding, rotation, contact_area_loss, first_opening_time} (J,)   over all steps
    /stress (F, B, 6)   mean stress of the blocks since the frame before, xx yy zz xy yz xz, tension positive [Pa]; NaN of supports and in
        the first frame; only where the scene asks for it, as the next two:
    /joints/mean_normal_force (F, J)   mean normal force since the frame before [N]
    /joints/edge_stress (F, J)   largest compression by that force, see masonry_cd/mechanics/model/edge_stress.py [Pa]; infinite at an edge
    /meshes/{block (M,), node_start (M + 1,), nodes (K, 3), element_start (M + 1,), elements (E, d + 1)}   the meshes of M blocks that are
        cut into tetrahedra, or triangles in a plane: nodes as built [m], in a plane in the middle of the block; corners of elements among
        all nodes; only where blocks are meshed and the scene asks for stress, as the next two, in single precision:
    /meshes/displacement (F, K, 3)   of the nodes, beyond the motion of the rigid block, body frame [m]: a node built at X is at
        x + R (X - c + u), with the position x and the rotation R of its block, built at c
    /meshes/stress (F, E, 6)   mean stress of the elements since the frame before, as /stress [Pa]
    /peaks/{displacement (B,), drift (P,), level_displacement (P, L), level_drift (P, L)}   over all steps, of blocks, parts and levels
    /peaks/{hinge_opening (J,), hinge_time (J,), hinge_place (J, 3)}   likewise, of joints while they were hinges
    /energy/* (N,) [J]   /solver/{iterations, error, seconds, contacts} (N,)   /penetration (N,) [m]
    /solver/violation (N,) [m/s], /solver/{false_slip, false_opening} (N,) [m]   of the contact laws, see
    masonry_cd/mechanics/dynamics/violations.py /step_time (N,) [s]   /load_step (N,), the step of the loads that was applied /ties/tension
    (N, T) [N]   of each bar, in the order of the attribute ties; absent without ties /shocks/{name, start, end, frame} (S,)   of a
    sequence: times [s], and the frame at the end of the rest after each shock /shocks/{opening, sliding, rotation, contact_area_loss,
    first_opening_time} (S, J)   the peaks of the joints up to there /shocks/peaks/{drift (S, P), hinge_opening (S, J)}   likewise, those of
    the parts and hinges /closing (L,)   bytes of what summary.json holds of a run that has ended, beside the damage (JSON) /blocks/*   the
    blocks as they were built: a report needs no scene; /blocks/structure only where a scene has several;
        /blocks/radius (B,) [m] only where there are spheres, 0 of polyhedra; a sphere has one vertex, its centre, and no face;
        /blocks/support (1,), to which displacements are relative, -1 without one
    /segments/*   checksums, see segments.py
    /guides/*, /gauges/*   what a scene looks at in every step, see gauges.py
    attributes: scene (the text of the scene file), scene_file (where it lies, seen from this file's folder), title, versions (JSON), run (a
        name that no other run has), format (of this layout), ties (JSON, see tie_bars.py), inputs (JSON: SHA-256 of each file that the
        scene reads), constant (SHA-256 of all that does not grow, but for scene_file)

Files of older versions have neither /joints/force nor /reaction, and neither /peaks nor /blocks/support: their largest drifts and hinges
are those of the frames.
A file without the attribute ``format`` is of a version of the program before there were checksums; it still reads.
"""

from __future__ import annotations

from masonry_cd.mechanics.model.joint_laws import bonded, crushing, histories
from masonry_cd.mechanics.model.joints import Joints

FORMAT = 1  # of the layout; raised when an older program would misread it
FRAME_FIELDS = ("time", "position", "orientation", "velocity")
JOINT_HISTORIES = ("opening", "sliding", "rotation", "contact_area", "normal_force", "shear_force", "force_point")
FORCE, REACTION = "force", "reaction"  # of joints and supports; older files have none
GRADIENT = "gradient"  # a history that only runs with blocks that deform have
LAW_HISTORIES = tuple(history.name for history in histories())  # those that only runs have some of whose joints have the law
BONDED, CRUSHED = bonded.HISTORY.name, crushing.HISTORY.name  # share of the area; by how much a joint is shorter for good [m]
STRESS = "stress"  # a history that only runs have whose scene asks for it, as those of the joints:
MEAN_NORMAL_FORCE, EDGE_STRESS = "mean_normal_force", "edge_stress"
NODE_DISPLACEMENT, ELEMENT_STRESS = "meshes/displacement", "meshes/stress"  # and these two where blocks are meshed as well
MESH_ARRAYS = ("block", "node_start", "nodes", "element_start", "elements")  # under /meshes, likewise
JOINT_PEAKS = ("opening", "sliding", "rotation", "contact_area_loss", "first_opening_time")
STEP_PEAKS = ("displacement", "drift", "level_displacement", "level_drift", "hinge_opening", "hinge_time", "hinge_place")  # under /peaks
SHOCK_PEAKS = ("drift", "hinge_opening")  # under /shocks/peaks
JOINT_CONSTANTS = tuple(Joints.__dataclass_fields__)
BLOCK_ARRAYS = ("name", "group", "fixed", "density", "vertex_start", "vertices", "face_start", "loop_start", "loops")
OPTIONAL_ARRAYS = (  # where a scene has several structures; in new files; where there are spheres; where blocks carry fill; stress of
    # meshed blocks
    "blocks/structure", "blocks/support", "blocks/radius", "blocks/carried_mass", "blocks/carried_centre", "blocks/carried_inertia",
    *(f"meshes/{name}" for name in MESH_ARRAYS),
)  # fmt: skip
OPTIONAL_ATTRIBUTES = ("ties", "gauges")  # where there are some, see tie_bars.py and gauges.py
ATTRIBUTES = ("scene", "title", "versions", "run", "inputs")
CLOSING = "closing"
