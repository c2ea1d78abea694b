# SPDX-License-Identifier: GPL-3.0-or-later
"""Simulations that are pickled go on with the same bits, and frames in memory are those of the file."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from places import ROOT

import masonry_cd as mc

pytestmark = pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
SCENE = mc.scene(ROOT / "examples" / "trilithon.toml", "run.duration=0.04", "run.frames_per_second=100", "report.crack_map=false")
BLOCKS = [mc.box((-1, -1, -0.5), (1, 1, 0)), mc.box((-0.2, -0.2, 0), (0.2, 0.2, 1.0))]
POST = {
    "structure": {"blocks": BLOCKS, "fixed": "b0"},
    "material": {"density": 2000.0, "friction": 0.6},
    "run": {"dt": 1e-3, "duration": 0.03},
}
HEARD: list[Any] = []


def push(time: float) -> tuple[float, float, float]:
    """Tips the post [N]."""
    return 3000.0 * time / 0.03, 0.0, 0.0


def weakening(contacts: Any) -> np.ndarray:
    """Friction that falls with the speed."""
    return np.asarray(0.3 + 0.3 * np.exp(-contacts.speed / 0.1))


def hear(sim: mc.Simulation, joint: int) -> None:
    """Note an opening."""
    HEARD.append(joint)


@pytest.mark.parametrize("given", [{}, {"forces": {"b1": push}, "friction": weakening, "velocities": {"b1": (0.1, 0.0, 0.0)}}])
def test_a_pickled_simulation_goes_on_with_the_same_bits(given: dict[str, Any]) -> None:
    """One made of arrays, whose files go with it; its folder may be gone meanwhile."""
    sim = mc.Simulation(POST, **given)
    sim.on("opening", hear)
    sim.step(12)
    HEARD.clear()
    parcel = pickle.dumps(sim)
    sim.run()
    heard, state, energy = list(HEARD), sim.state, sim.energy
    del sim
    HEARD.clear()
    again = pickle.loads(parcel)
    assert again.steps == 12
    again.run()
    assert np.array_equal(again.state.position, state.position) and np.array_equal(again.state.velocity, state.velocity)
    assert again.energy == energy and heard == HEARD


def test_changes_of_the_model_are_pickled() -> None:
    """A block taken away before, and one put in after."""
    sim = mc.Simulation(SCENE)
    sim.step(10)
    sim.remove("lintel")
    sim.step(5)
    again = pickle.loads(pickle.dumps(sim))
    assert again.absent.sum() == 1
    for one in (sim, again):
        one.add("lintel")
        one.run()
    assert np.array_equal(again.state.position, sim.state.position) and again.energy == sim.energy
    waiting = pickle.loads(pickle.dumps(mc.Simulation(SCENE, waiting="lintel")))
    assert waiting.absent.tolist() == [False, False, False, True]


def test_a_scene_is_pickled_with_its_arrays() -> None:
    one = mc.scene(POST)
    again = pickle.loads(pickle.dumps(one))
    assert again.text == one.text and again.checked.folder != one.checked.folder
    assert np.array_equal(again.structure["b1"].vertices, one.structure["b1"].vertices)


def test_what_cannot_be_pickled_is_named() -> None:
    with refused_at("friction"):
        pickle.dumps(mc.Simulation(SCENE, friction=lambda contacts: contacts.friction))
    sim = mc.Simulation(SCENE)
    sim.on("step", lambda sim: None)
    with refused_at("on step"):
        pickle.dumps(sim)


@pytest.mark.parametrize(
    "events", [[], [{"at": 0.014, "remove": ["lintel"]}, {"at": 0.024, "add": ["lintel"]}], [{"at": 0.02, "release": ["base"]}]]
)
def test_frames_in_memory_are_those_of_the_file(tmp_path: Path, events: list[dict[str, Any]]) -> None:
    lengths: list[int] = []
    scene = SCENE.changed(events=events)
    sim = mc.Simulation(scene)
    sim.on("step", lambda sim: lengths.append(sim.frames.sizes["time"]))
    kept = sim.record(to="memory")
    assert lengths[0] == 1 and lengths[-1] == kept.sizes["time"] == 5  # while it goes
    written = mc.Simulation(scene).record(tmp_path / "out", progress=False).to_xarray()
    assert set(kept.variables) == set(written.variables)
    for name in kept.variables:
        assert (kept[name] == written[name]).all() and kept[name].attrs == written[name].attrs, name


def test_frames_are_refused_where_none_are_kept() -> None:
    sim = mc.Simulation(SCENE)
    for place, call in (
        ("frames", lambda: sim.frames),
        ("record", lambda: sim.record("out", to="memory")),  # type: ignore[call-overload]
        ("record", lambda: sim.record(to="disc")),  # type: ignore[call-overload]
    ):
        with refused_at(place):
            call()
    sim.step()
    with refused_at("record"):
        sim.record(to="memory")
