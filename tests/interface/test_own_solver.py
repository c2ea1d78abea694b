# SPDX-License-Identifier: GPL-3.0-or-later
"""Solvers that Python gives: the bits of ours where they call ours, and answers that are judged outside them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hostile import refused_at
from places import ROOT

import masonry_cd as mc
from masonry_cd.interface.protocols import Options, Problem, Solution
from masonry_cd.mechanics.solvers import SOLVERS

SCENE = mc.scene(ROOT / "examples" / "trilithon.toml", "run.duration=0.02", "report.crack_map=false")


def swept(problem: Problem, options: Options, start: Solution | None) -> Solution:
    """Gauss-Seidel, which spoils what it starts from and praises itself."""
    found = SOLVERS["nlgs"](problem, options, start)
    if start is not None:
        start.impulse[:] = np.nan
    return replace(found, error=0.0)


def test_a_function_that_calls_ours_has_its_bits_and_is_measured_outside(tmp_path: Path) -> None:
    ours, own = mc.Simulation(SCENE.changed("run.solver=nlgs")), mc.Simulation(SCENE, solver=swept)
    ours.step(5), own.step(5)
    own.save(tmp_path / "half")
    copy, later = own.copy(), mc.Simulation(SCENE, solver=swept)
    later.restore(tmp_path / "half")
    for sim in (ours, own, copy, later):
        sim.run()
        assert np.array_equal(sim.state.position, ours.state.position) and np.array_equal(sim.state.velocity, ours.state.velocity)
    assert own.report is not None and ours.report is not None
    assert own.report.error > 0.0 and own.report.error == pytest.approx(ours.report.error, rel=1e-3)


@pytest.mark.filterwarnings("ignore::masonry_cd.interface.returned.RunWarning")
def test_a_run_says_that_python_solved_it_and_that_it_missed(tmp_path: Path) -> None:
    """Impulses that are zero let the blocks fall; what they leave is an error of one."""
    free = mc.Simulation(SCENE, solver=lambda problem, options, start: Solution(np.zeros((problem.contacts, problem.dimension)), None, 0))
    run = free.record(tmp_path / "out", progress=False)
    assert run.summary["solver"]["name"] == "python" and run.summary["python"]
    assert run.summary["solver"]["steps_missed"] > 0 and run.summary["solver"]["error_max"] == pytest.approx(1.0)
    with refused_at("checkpoint.npz"):
        mc.resume(run)


@pytest.mark.parametrize(
    "answer",
    [
        lambda p: p,
        lambda p: Solution(p[:-1], None, 1),
        lambda p: Solution(np.full_like(p, np.nan), None, 1),
        lambda p: Solution(p, None, -1),
        lambda p: Solution(p.astype(object), None, 1),
    ],
)
def test_answers_that_are_none_are_named(answer: Callable[[np.ndarray], Any]) -> None:
    sim = mc.Simulation(SCENE, solver=lambda problem, options, start: answer(np.zeros((problem.contacts, problem.dimension))))
    with refused_at("solver"):
        sim.step()


@pytest.mark.parametrize(
    ("where", "given"),
    [
        ("solver", {"solver": lambda problem: None}),
        ("solver", {"solver": "nlgs"}),
        ("friction", {"friction": lambda contacts, step: 0.5}),
        ("forces", {"forces": lambda: 0.0}),
        ('forces["lintel"]', {"forces": {"lintel": lambda: (0, 0, 0)}}),
        ('motions["left"]', {"motions": {"left": lambda time, step: (0, 0, 0)}}),
        ("law", {"law": mc.JointLaw(lambda opening, slip: None, stiffness=1e6)}),  # type: ignore[arg-type,misc]
    ],
)
def test_functions_that_take_something_else_are_refused_before_the_run(where: str, given: dict[str, Any]) -> None:
    with refused_at(where):
        mc.Simulation(SCENE, **given)


def test_functions_of_events_are_refused_where_they_are_named() -> None:
    with refused_at("on opening"):
        mc.Simulation(SCENE).on("opening", lambda sim: None)
