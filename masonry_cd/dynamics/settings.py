"""The table ``[run]`` of a scene file: time, solver and output."""

from __future__ import annotations

import math
from typing import Annotated

from pydantic import Field, model_validator

from masonry_cd.fields import Count, Flag, Number, Table, Vector
from masonry_cd.solvers.options import LARGEST_SEED, MOST_ITERATIONS
from masonry_cd.solvers.solver_name import SolverName

ACCEPT = 10.0  # natural map error that is accepted, in tolerances
WAIT = 5.0  # by which twice the duration is exceeded at most where a run waits for its blocks to be still [s]
MOST_STEPS = 2e7  # of a run: some 4 GB of loads


class Run(Table):
    """The table ``[run]``: time, solver and output."""

    dt: Annotated[Number, Field(gt=0, le=0.1)]
    """Time step [s]."""
    duration: Annotated[Number, Field(gt=0)]
    """How long to compute [s]."""
    until_still: Flag | None = None
    """Go on after the duration, with the base at rest, until all standing blocks are still; true by default where damage is graded."""
    longest: Annotated[Number, Field(gt=0)] | None = None
    """When such a run ends in any case [s]; twice the duration plus 5 s when not given."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.5
    """Of the Moreau-Jean step: 0.5 keeps the energy of a free motion, 1 damps it."""
    solver: SolverName = "auto"
    """Of the friction problem of each step."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    """Natural map error that each step has to reach."""
    accept: Annotated[Number, Field(gt=0, lt=1)] | None = None
    """Natural map error at which a step may be left that would cost far more than others; ten times the tolerance when not given."""
    max_iterations: Annotated[Count, Field(ge=1, le=MOST_ITERATIONS)] | None = None
    """Iterations of each island after which a step counts as missed; the solver's own limit when not given."""
    seed: Annotated[Count, Field(ge=0, le=LARGEST_SEED)] = 0
    """Of the order in which contacts are swept."""
    threads: Annotated[Count, Field(ge=1, le=10_000)] = 1
    """Cores to use."""
    frames_per_second: Annotated[Number, Field(gt=0)] = 50.0
    """Frames written per second of the simulated time [1/s]."""
    checkpoint_every: Annotated[Number, Field(ge=0)] = 10.0
    """Time of the clock between two checkpoints [s]."""
    planar: Flag = True
    """Solve a scene that moves in its plane with half the contacts and three unknowns per block; the answer is the same."""
    islands: Flag = True
    """Solve by itself what touches the rest only through supports, and let it sleep while it rests; the answer is the same."""
    settle: Flag = True
    """Let elastic joints take up the weight before the run begins; else it comes upon them at once, and they swing."""
    gravity: Vector = (0.0, 0.0, -9.81)
    """[m/s2]."""

    @model_validator(mode="after")
    def _fits(self) -> Run:
        if self.duration < self.dt:
            raise ValueError(f"duration {self.duration:g} s is shorter than one step dt {self.dt:g} s")
        if self.longest is not None and self.until_still is False:
            raise ValueError("longest belongs to until_still = true")
        if self.longest is not None and self.longest < self.duration:
            raise ValueError(f"longest {self.longest:g} s is shorter than the duration {self.duration:g} s")
        if self.accept is not None and self.accept < self.tolerance:
            raise ValueError(f"accept {self.accept:g} is below the tolerance {self.tolerance:g}")
        for key, time in (("duration", self.duration), ("longest", self.longest or 0.0)):
            if time > MOST_STEPS * self.dt:
                raise ValueError(f"{key} {time:g} s takes {time / self.dt:.2g} steps of dt {self.dt:g} s; at most {MOST_STEPS:g}")
        return self

    @property
    def accepted(self) -> float:
        """Natural map error at which a step may be left that costs far more than others."""
        return ACCEPT * self.tolerance if self.accept is None else self.accept

    @property
    def steps(self) -> int:
        """Steps N that cover the duration."""
        return math.ceil(self.duration / self.dt - 1e-6)

    @property
    def most_steps(self) -> int:
        """Steps after which a run ends that goes on until its blocks are still."""
        longest = min(2.0 * self.duration + WAIT, MOST_STEPS * self.dt) if self.longest is None else self.longest
        return max(self.steps, math.ceil(longest / self.dt - 1e-6))

    @property
    def frame_every(self) -> int:
        """Steps between two frames."""
        frames = self.frames_per_second * self.dt  # of a step; so few that they have no reciprocal where none falls into any run
        return max(1, round(1.0 / frames)) if frames * MOST_STEPS > 1.0 else int(MOST_STEPS)
