# SPDX-License-Identifier: GPL-3.0-or-later
"""Problems of compas_dem become scenes, by stand-ins of its public classes; Results by the package itself, where it is installed."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hostile import refused_at

import masonry_cd as mc

RUN = {"dt": 1e-3, "duration": 0.1}
BASE, STONE = mc.box((-2, -2, -1), (2, 2, 0)), mc.box((-0.5, -0.5, 0), (0.5, 0.5, 1.0))
WEIGHT = 2000.0 * 9.81


class StandInMesh:
    """Stand-in for a Mesh of COMPAS."""

    def __init__(self, shape: tuple[Any, Any]) -> None:
        self.vertices, self.faces = np.array(shape[0]), [list(face) for face in shape[1]]

    def to_vertices_and_faces(self) -> tuple[list[list[float]], list[list[int]]]:
        """Corners and loops."""
        return self.vertices.tolist(), self.faces

    def face_center(self, face: int) -> list[float]:
        """Return the centre of a rectangle."""
        return list(self.vertices[self.faces[face]].mean(axis=0))

    def face_area(self, face: int) -> float:
        """Return the area of a rectangle."""
        a, b, c = self.vertices[self.faces[face][:3]]
        return float(np.linalg.norm(np.cross(b - a, c - b)))


def group(**entries: Any) -> SimpleNamespace:
    """Boundary conditions."""
    return SimpleNamespace(**{"g": 9.81, "body_forces": [], "point_loads": [], "surface_loads": [], "displacements": []} | entries)


def point(block: int, force: Any, moment: Any = None, at: Any = None, loading: str = "ramp") -> SimpleNamespace:
    """A point load."""
    return SimpleNamespace(block_index=block, force=force, moment=moment, point=at, loading_type=loading)


def problem(*groups: SimpleNamespace, **contact: Any) -> SimpleNamespace:
    """A stone on a support."""
    stone = SimpleNamespace(density=2000.0)
    elements = [
        SimpleNamespace(graphnode=4, is_support=True, material=None, modelgeometry=StandInMesh(BASE)),
        SimpleNamespace(graphnode=7, is_support=False, material=stone, modelgeometry=StandInMesh(STONE)),
    ]
    law = SimpleNamespace(**{"mu": 0.6, "c": None, "t_c": None} | contact)
    properties = SimpleNamespace(contact_model=law, joint_model=None)
    return SimpleNamespace(
        name="stone", model=SimpleNamespace(elements=lambda: elements), boundary_conditions=groups, contact_properties=properties
    )


def reaction(asked: SimpleNamespace) -> np.ndarray:
    """Force and moment of the support on the stone, about the centre of the support, at the end."""
    sim = mc.Simulation(mc.from_compas_dem(asked, run=RUN))
    sim.run()
    return sim.reactions()["block4"]


def test_forces_and_moments_of_all_groups_reach_the_support() -> None:
    top = next(i for i, face in enumerate(STONE[1]) if np.array(STONE[0])[list(face)][:, 2].min() == 1.0)
    surface = SimpleNamespace(block_index=7, face_index=top, load=[0.0, 0.0, -500.0], loading_type="ramp")
    pushed = SimpleNamespace(acceleration=[1.0, 0.0, 0.0], loading_type="instantaneous")
    off = group(point_loads=[point(7, [0.0, 0.0, -1000.0], at=[0.25, 0.0, 1.0]), point(7, [0.0, 0.0, 0.0], moment=[0.0, 300.0, 100.0])])
    found = reaction(problem(off, group(surface_loads=[surface], body_forces=[pushed])))
    assert found[:3] == pytest.approx([-2000.0, 0.0, WEIGHT + 1500.0], abs=2.0)
    assert found[5] == pytest.approx(-100.0, abs=1.0)
    # about the centre of the support, half a metre down: weight, loads and the push at 0.5 m above the bed
    assert found[4] == pytest.approx(-(1000.0 * 0.25 + 300.0 + 2000.0 * 1.0), abs=5.0)


def test_a_support_that_is_moved_takes_the_stone_along() -> None:
    down = SimpleNamespace(block_index=4, translation=[0.0, None, -0.01])
    back = SimpleNamespace(block_index=4, translation=[None, None, -0.02])
    sim = mc.Simulation(mc.from_compas_dem(problem(group(displacements=[down]), group(displacements=[back])), run=RUN))
    sim.run()
    assert sim.state.position[:, 2] == pytest.approx([-0.52, 0.48], abs=1e-4)


def test_a_support_that_is_turned_tilts_the_stone() -> None:
    tilted = SimpleNamespace(block_index=4, rotation=[0.0, 0.05, 0.0])
    sim = mc.Simulation(mc.from_compas_dem(problem(group(displacements=[tilted])), run={"dt": 1e-3, "duration": 0.5}))
    sim.run()
    for b in (0, 1):
        assert 2.0 * np.arcsin(sim.state.orientation[b, 2]) == pytest.approx(0.05, abs=1e-3)


def test_contact_and_joint_models_are_the_material() -> None:
    asked = problem(c=2e4, t_c=1e4)
    asked.contact_properties.joint_model = SimpleNamespace(kn=1e10, kt=4e9)
    material = mc.from_compas_dem(asked, run=RUN).tables["material"]
    joints = {"cohesion": 2e4, "tension": 1e4, "normal_stiffness": 1e10, "tangential_stiffness": 4e9}
    assert material["friction"] == 0.6 and material["joints"] == joints
    assert mc.from_compas_dem(problem(), run=RUN, material={"friction": 0.4}).tables["material"] == {"friction": 0.4}


@pytest.mark.parametrize(
    "asked",
    [
        problem(group(), group(g=1.62)),
        problem(group(point_loads=[point(4, [1.0, 0.0, 0.0])])),
        problem(group(point_loads=[point(5, [1.0, 0.0, 0.0])])),
        problem(group(displacements=[SimpleNamespace(block_index=7, translation=[0.0, 0.0, 0.1])])),
        SimpleNamespace(),
    ],
)
def test_what_a_scene_cannot_say_is_refused(asked: SimpleNamespace) -> None:
    with refused_at("from_compas_dem"):
        mc.from_compas_dem(asked, run=RUN)


def test_a_run_is_asked_for_and_the_package_where_results_are_made() -> None:
    with refused_at("run"):
        mc.from_compas_dem(problem(), run={"dt": 1e-3})
    bare = problem()
    bare.contact_properties.contact_model = None
    with refused_at("from_compas_dem"):
        mc.from_compas_dem(bare, run=RUN)


def test_results_are_those_of_the_package() -> None:
    """A stone of 19.6 kN, pushed to the side below friction."""
    pytest.importorskip("compas_dem", reason="compas_dem is not installed: pip install compas_dem")
    from compas.data import json_dumps, json_loads
    from compas.datastructures import Mesh
    from compas_dem.material import Stone
    from compas_dem.models import BlockModel
    from compas_dem.problem import Problem

    model = BlockModel()
    model.add_support_from_mesh(Mesh.from_vertices_and_faces(*map(list, BASE)))
    stone = model.add_block_from_mesh(Mesh.from_vertices_and_faces(*map(list, STONE)))
    material = Stone(density=2000.0)
    model.add_material(material)
    for element in model.elements():
        model.assign_material(material, element=element)
    asked = Problem(model)
    asked.set_contact_model("MohrCoulomb", mu=0.6)
    asked.add_boundary_condition("push").add_point_load(stone, [3000.0, 0.0, 0.0])
    sim = mc.Simulation(mc.from_compas_dem(asked, run=RUN))
    with refused_at("to_compas_dem"):
        mc.to_compas_dem(sim, asked)
    sim.run()
    results = json_loads(json_dumps(mc.to_compas_dem(sim, asked)))
    (edge,) = results.edges()
    assert results.face_contact(edge) and len(results.contact_point(edge)) == 4
    assert results.resultant_global(edge) == pytest.approx([3000.0, 0.0, -WEIGHT], abs=5.0)  # on the support, the first of the edge
    assert results.resultant_local(edge)[2] == pytest.approx(WEIGHT, abs=5.0)
    assert results.contact_frame(edge).zaxis.z == pytest.approx(1.0) and results.contact_polygon(edge).area == pytest.approx(1.0, rel=1e-3)
    data = results.contact_data(edge)
    assert sum(force["c_np"] for force in data.forces) == pytest.approx(WEIGHT, abs=5.0)
    assert results.displacement(stone) == pytest.approx([0.0, 0.0, 0.0], abs=1e-4) and results.metadata["n_steps"] == 100
