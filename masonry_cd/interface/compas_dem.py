# SPDX-License-Identifier: GPL-3.0-or-later
"""A backend of compas_dem (Block Research Group, ETH Zurich): its Problem becomes a scene, and a simulation of that its Results.

What is read of a Problem are its public classes of version 0.6: the blocks of its model with their densities and supports, contact and
joint model, and all boundary conditions at once, as its own time stepping does:

    ramp             a load grows over RAMP of the run and stays           instantaneous    it is there from the beginning
    displacement, rotation    of a support, over RAMP of the run, smoothly

kn and kt count per area [Pa/m], as its 3DEC backend takes them. compas_dem is imported only where Results are made.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from importlib import import_module
from typing import Any

import numpy as np

from masonry_cd.app.step_contacts import Contacts
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.extras import require
from masonry_cd.interface.scenes import Scene, scene
from masonry_cd.interface.simulation import Simulation
from masonry_cd.mechanics.model.blocks import Block

RAMP = 0.98  # share of the run after which what grows stands
GRAVITY = 9.81  # of a Problem without boundary conditions [m/s2]
POINTS = 21  # of the course of a rotation
CALLED = "block{}"  # by the node of the graph


def from_compas_dem(problem: Any, **tables: Any) -> Scene:
    """The scene of a Problem of compas_dem.

    Args:
        problem: with its model loaded.
        tables: of the scene: ``run`` with dt and duration, over which loads grow, is needed; others change what follows from the
            Problem, as ``material={"joints": {...}}``. Unless ``run`` says otherwise a scene in a plane is solved in space, so that all
            corners of a joint have a force.

    Raises:
        InputError: a block that moves and is not a support, loads on supports, several gravities, no contact model, blocks without density.
    """
    try:
        elements = list(problem.model.elements())
        groups = list(problem.boundary_conditions)
    except (AttributeError, ValueError):
        text = f"a Problem of compas_dem with its model is needed, got a {type(problem).__name__}"
        raise InputError("from_compas_dem", text) from None
    run = tables.pop("run", None)
    if not isinstance(run, Mapping) or not {"dt", "duration"} <= set(run):
        raise InputError("run", "missing; from_compas_dem needs dt and duration, over which loads grow")
    gravities = {float(group.g) for group in groups} or {GRAVITY}
    if len(gravities) > 1:
        raise InputError("from_compas_dem", f"boundary conditions of several gravities g: {', '.join(f'{g:g}' for g in sorted(gravities))}")
    blocks = {element.graphnode: _block(element, _density(element, elements)) for element in elements}
    time = RAMP * float(run["duration"])
    source = {
        "title": str(getattr(problem, "name", None) or "compas_dem"),
        "structure": {"blocks": list(blocks.values())},
        "material": _material(problem.contact_properties),
        "loads": [*_loads(groups, {e.graphnode: e for e in elements}, blocks, time), *_displacements(groups, blocks, time)],
        "run": {"planar": False, "gravity": [0.0, 0.0, -gravities.pop()], **run},
    }
    return scene(source, **tables)


def to_compas_dem(sim: Simulation, problem: Any) -> Any:
    """The Results of compas_dem of how a simulation of :func:`from_compas_dem` stands.

    Transformations of all blocks from where they were built, and by pair of blocks in touch the points, frames and forces of the last step:
    forces on the first block of an edge, frames whose z axis is the normal of the contact, normal forces above zero where it presses.

    Args:
        sim: after a step.
        problem: that the scene was made of.

    Raises:
        InputError: no step was made, a scene of something else, or compas_dem is not installed.
    """
    require("to_compas_dem", "compas_dem")
    nodes = [element.graphnode for element in problem.model.elements()]
    if [block.name for block in sim.structure] != [CALLED.format(node) for node in nodes]:
        raise InputError("to_compas_dem", "the simulation is not of the blocks of this Problem")
    if sim.report is None:
        raise InputError("to_compas_dem", "no step was made, so that there are no forces")
    geometry = import_module("compas.geometry")
    results = import_module("compas_dem.problem").Results(model_id=str(problem.model.guid), problem_id=str(problem.guid))
    for b, block in enumerate(sim.structure):
        results.set_node(nodes[b], "transformation", geometry.Transformation.from_matrix(_matrix(sim, b, block).tolist()))
    contacts, graph = sim.contacts, problem.model.graph
    for pair in np.unique(np.sort(contacts.blocks, axis=1), axis=0).tolist():
        edge = nodes[pair[0]], nodes[pair[1]]
        if not graph.has_edge(edge) and graph.has_edge(edge[::-1]):
            edge = edge[::-1]
        elif not graph.has_edge(edge):
            results.metadata.setdefault("added_edges", []).append(list(edge))
        own = np.flatnonzero((np.sort(contacts.blocks, axis=1) == pair).all(axis=1))
        for name, value in _edge(contacts, own, nodes.index(edge[0]), geometry).items():
            results.set_edge(edge, name, value)
    report = sim.report
    results.metadata |= {"solver": "masonry_cd", "time": sim.time, "n_steps": sim.steps, "error": report.error, "energy": sim.energy}
    return results


def _density(element: Any, elements: list[Any]) -> float:
    """Return the density [kg/m3] of a block; of a support without a material that of any other, since no result depends on it.

    Raises:
        InputError: a block without one.
    """
    candidates = [element, *(elements if element.is_support else ())]
    known = [one.material.density for one in candidates if getattr(one, "material", None) is not None and one.material.density]
    if not known:
        raise InputError("from_compas_dem", f"block {element.graphnode} has no material with a density")
    return float(known[0])


def _block(element: Any, density: float) -> dict[str, Any]:
    """A block in the place that the model gives it."""
    vertices, faces = element.modelgeometry.to_vertices_and_faces()
    fixed = bool(element.is_support)
    group = "base" if fixed else "block"
    return {
        "name": CALLED.format(element.graphnode), "vertices": vertices, "faces": faces, "density": density, "fixed": fixed, "group": group,
    }  # fmt: skip


def _material(properties: Any) -> dict[str, Any]:
    """Friction and joints.

    Raises:
        InputError: no contact model.
    """
    contact, springs = properties.contact_model, properties.joint_model
    if contact is None:
        raise InputError("from_compas_dem", 'no contact model; problem.set_contact_model("MohrCoulomb", mu=0.6) gives the Problem one')
    joints = {"cohesion": contact.c, "tension": contact.t_c}
    if springs is not None:
        joints |= {"normal_stiffness": springs.kn, "tangential_stiffness": springs.kt}
    joints = {key: float(value) for key, value in joints.items() if value}
    return {"friction": float(contact.mu), **({"joints": joints} if joints else {})}


def _loads(groups: list[Any], elements: Mapping[int, Any], blocks: Mapping[int, dict[str, Any]], time: float) -> Iterator[dict[str, Any]]:
    """Point loads that stand for the loads of all groups."""
    for group in groups:
        for entry in group.body_forces:
            for block in blocks.values():
                if not block["fixed"]:
                    mass = _shape(block).mass_properties.volume * block["density"]
                    yield _point(block, mass * np.array(entry.acceleration, dtype=float), entry, time)
        for entry in group.point_loads:
            block = _loaded(blocks, entry)
            force, moment = (np.array(given or (0.0, 0.0, 0.0), dtype=float) for given in (entry.force, entry.moment))
            if force.any() or moment.any():
                about = {"moment": moment.tolist()} if moment.any() else {}
                yield _point(block, force, entry, time, entry.point if force.any() else None) | about
        for entry in group.surface_loads:
            block, mesh = _loaded(blocks, entry), elements[entry.block_index].modelgeometry
            force = np.array(entry.load, dtype=float) * float(mesh.face_area(entry.face_index))
            yield _point(block, force, entry, time, mesh.face_center(entry.face_index))


def _loaded(blocks: Mapping[int, dict[str, Any]], entry: Any) -> dict[str, Any]:
    """The block that a load names.

    Raises:
        InputError: there is none, or it is a support.
    """
    block = blocks.get(entry.block_index)
    if block is None or block["fixed"]:
        what = "a support, which no load moves" if block else "which is not in the model"
        raise InputError("from_compas_dem", f"a load is on block {entry.block_index}, {what}")
    return block


def _point(block: Mapping[str, Any], force: np.ndarray, entry: Any, time: float, point: Any = None) -> dict[str, Any]:
    """A point load [N] at a point [m], the centre of mass where there is none."""
    at = {} if point is None else {"point": [float(x) for x in point]}
    return {"kind": "point", "block": block["name"], "force": force.tolist(), "ramp": time if entry.loading_type == "ramp" else 0.0, **at}


def _shape(block: Mapping[str, Any]) -> Block:
    """A block, for its mass."""
    return Block(block["name"], np.array(block["vertices"], dtype=float), tuple(map(tuple, block["faces"])), block["density"])


def _displacements(groups: list[Any], blocks: Mapping[int, dict[str, Any]], time: float) -> Iterator[dict[str, Any]]:
    """Motions of supports that stand for the prescribed displacements and rotations, of which later ones count by component.

    Raises:
        InputError: a block that is not a support.
    """
    moved: dict[tuple[int, str], list[float]] = {}
    for group in groups:
        for entry in group.displacements:
            node = entry.block_index
            if node not in blocks or not blocks[node]["fixed"]:
                raise InputError("from_compas_dem", f"block {node} is moved and no support; model.add_support({node}) makes it one")
            for kind in ("translation", "rotation"):
                own = moved.setdefault((node, kind), [0.0, 0.0, 0.0])
                for d, value in enumerate(getattr(entry, kind, None) or ()):
                    own[d] = own[d] if value is None else float(value)
    x = np.linspace(0.0, 1.0, POINTS)
    smooth = x * x * x * (10.0 + x * (6.0 * x - 15.0))
    for (node, kind), vector in moved.items():
        if any(vector):
            name, size = blocks[node]["name"], math.hypot(*vector)
            if kind == "translation":
                yield {"kind": "settlement", "supports": name, "direction": vector, "displacement": size, "duration": time}
            else:
                angles = (math.degrees(size) * smooth).tolist()
                yield {"kind": "motion", "supports": name, "axis": vector, "time": (time * x).tolist(), "rotation": angles}


def _matrix(sim: Simulation, b: int, block: Block) -> np.ndarray:
    """How a block has moved since it was built, (4, 4)."""
    made = np.eye(4)
    made[:3, :3] = sim.state.rotation[b]
    made[:3, 3] = sim.state.position[b] - made[:3, :3] @ block.mass_properties.centre
    return made


def _edge(contacts: Contacts, own: np.ndarray, first: int, geometry: Any) -> dict[str, Any]:
    """Return the contacts (indices) of two blocks by the names of Results; forces act on the ``first``."""
    interactions = import_module("compas_dem.interactions")
    own = own[_around(contacts.point[own], contacts.frame[own[0]])]
    sign = np.where(contacts.blocks[own, 0] == first, 1.0, -1.0)[:, None]
    world, points = sign * contacts.force[own], contacts.point[own]
    local = np.einsum("cij,cj->ci", contacts.frame[own], contacts.force[own])  # along n, t1, t2
    at, total = [geometry.Point(*point) for point in points.tolist()], world.sum(axis=0)
    frames = [geometry.Frame(at[k], frame[1].tolist(), frame[2].tolist()) for k, frame in enumerate(contacts.frame[own])]
    forces = [{"c_np": max(n, 0.0), "c_nn": max(-n, 0.0), "c_u": u, "c_v": v} for n, u, v in local.tolist()]
    pressed = float(np.abs(local[:, 0]).sum())
    made: dict[str, Any] = {
        "contact_points": points.tolist(), "gap": contacts.gap[own].tolist(), "contact_frames": frames, "contact_frame": frames[0],
        "force_normal": local[:, 0].tolist(), "force_tangent1": local[:, 1].tolist(), "force_tangent2": local[:, 2].tolist(),
        "force_vector": world.tolist(), "nodal_force_magnitudes": np.linalg.norm(world, axis=1).tolist(),
        "resultant_global": total.tolist(), "resultant_local": local[:, [1, 2, 0]].sum(axis=0).tolist(),
        "force_magnitude": float(np.linalg.norm(total)),
        "face_contact": len(at) > 2, "edge_contact": len(at) == 2, "point_contact": len(at) == 1,
    }  # fmt: skip
    if pressed > 0.0:
        made["force_point"] = (np.abs(local[:, 0]) @ points / pressed).tolist()
    if len(at) > 2:
        made["contact_polygon"] = geometry.Polygon(at)
        made["contact_data"] = interactions.FrictionContact(points=at, frame=frames[0], forces=forces)
    elif len(at) == 2:
        line = geometry.Line(*at)
        frame = geometry.Frame(line.midpoint, *frames[0][1:])
        made |= {"contact_geometry": line, "contact_data": interactions.EdgeContact(points=at, frame=frame, forces=forces)}
    else:
        made |= {"contact_geometry": at[0], "contact_data": interactions.VertexContact(point=at[0], frame=frames[0], forces=forces)}
    return made


def _around(points: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """The order (C,) of points (C, 3) about their middle, counter-clockwise seen along the normal."""
    flat = (points - points.mean(axis=0)) @ frame[1:].T
    return np.argsort([math.atan2(y, x) for x, y in flat.tolist()], kind="stable")
