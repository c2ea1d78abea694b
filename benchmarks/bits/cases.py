# SPDX-License-Identifier: GPL-3.0-or-later
"""The scenes: a TOML file next to this one each, changes to it, and friction problems of it that are solved by themselves."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent


@dataclass(frozen=True)
class Solve:
    """A friction problem that a scene dumps, solved from its file."""

    solver: str
    tolerance: float = 1e-8
    local: bool = False  # by its Delassus matrix alone, without bodies
    max_iterations: int = 500

    @property
    def name(self) -> str:
        """For the results."""
        return f"{'local' if self.local else 'bodies'}-{self.solver}"


@dataclass(frozen=True)
class Case:
    """A run, and what is solved after it."""

    scene: Path
    changes: tuple[str, ...] = ()  # of the scene, as --set takes them
    dump: int | None = None  # step whose problem is written
    solves: tuple[Solve, ...] = ()  # of that problem


def of(scene: str, *changes: str, dump: int | None = None, solves: tuple[Solve, ...] = ()) -> Case:
    """A case by the name of its file."""
    return Case(HERE / f"{scene}.toml", changes, dump, solves)


SOLVERS = ("auto", "nlgs", "accelerated", "admm", "newton", "interior", "pivoting")
BODIES = tuple(Solve(name) for name in SOLVERS)
LOCAL = tuple(Solve(name, local=True) for name in SOLVERS)
LIMIT = "run.max_iterations=300"  # a step that misses its tolerance has bits too
TURNS = '{kind="motion",supports="abutment2",time=[0,0.1,0.3],displacement=[0,0.01,0.02],rotation=[0,0.5,-1],axis="y",about=[2,0,0]}'

CASES = {
    "aqueduct": of("aqueduct"),
    "aqueduct-admm": of("aqueduct", "run.solver=admm", "run.duration=0.16", LIMIT),
    "aqueduct-newton": of("aqueduct", "run.solver=newton", "run.duration=0.16"),
    "aqueduct-nlgs": of("aqueduct", "run.solver=nlgs", "run.duration=0.08", LIMIT),
    "aqueduct-interior": of("aqueduct", "run.solver=interior", "run.duration=0.08"),
    "aqueduct-pivoting": of("aqueduct", "run.solver=pivoting", "run.duration=0.16", LIMIT),
    "aqueduct-space": of("aqueduct", "run.planar=false", "run.duration=0.04", "run.tolerance=1e-3"),
    "tower": of("tower"),
    "church": of("church"),
    "church-threads": of("church", "run.threads=2", "run.solver=admm", "run.duration=0.04"),
    "church-nlgs": of("church", "run.threads=2", "run.solver=nlgs", "run.duration=0.015", "run.max_iterations=100"),
    "elastic": of("elastic"),
    "deformable": of("elastic", "material.deformable=uniform", "material.young=2e9"),
    "deformable-space": of("tower", "material.deformable=uniform", "material.young=2e9", "run.duration=0.04"),
    "mortar": of("mortar"),
    "islands": of("islands"),
    "islands-whole": of("islands", "run.islands=false", "run.duration=0.2"),
    "debris": of("debris"),
    "falling": of("falling"),
    "alone": of("alone"),
    "settlement": of("settlement"),
    "turning": of("settlement", f"loads=[{TURNS}]"),
    "tilt": of("tilt"),
    "shocks": of("shocks"),
    "record": of("record"),
    "file": of("file"),
    "tied": of("tied"),
    "problem-plane": of("elastic", "run.duration=0.06", dump=30, solves=BODIES),
    "problem-space": of("tower", "run.duration=0.3", dump=150, solves=BODIES + LOCAL),
}
