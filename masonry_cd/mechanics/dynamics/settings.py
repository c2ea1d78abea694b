# SPDX-License-Identifier: GPL-3.0-or-later
"""The table ``[run]`` of a scene file: time, solver and output."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field, WithJsonSchema, model_validator

from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.fields import MOST_STEPS, Count, Flag, Number, Table, Vector, is_number
from masonry_cd.foundation.units import Unit, Usual
from masonry_cd.mechanics.model.usual import ACCELERATIONS
from masonry_cd.mechanics.solvers.options import LARGEST_SEED, MOST_ITERATIONS
from masonry_cd.mechanics.solvers.solver_name import SolverName

EARTH = Usual(9.5, 10.5, "gravity on earth is 9.81 m/s2", ACCELERATIONS, size=True)
ACCEPT = 10.0  # natural map error that is accepted, in tolerances
WAIT = 5.0  # by which twice the duration is exceeded at most where a run waits for its blocks to be still [s]
UNTIL_LOADS_END = 0.0  # as run.duration before the loads are known: it follows from them
AUTO = "auto"  # as run.dt: the time step adapts
LONGEST_STEP = 1e-2  # dt_max when not given [s]
RUNGS = 5  # halvings from dt_max to the shortest step when dt_min is not given
_STEP: dict[str, Any] = {"anyOf": [{"type": "number", "exclusiveMinimum": 0, "maximum": 0.1}, {"const": AUTO}]}
ADAPTIVE_KEYS = ("dt_min", "dt_max", "dt_tolerance")


class FirstVelocities(Table):
    """Velocities that the blocks begin with, drawn at random: tiny ones show how far a chaotic run spreads."""

    size: Annotated[Number, Unit("m/s"), Field(gt=0, le=1)]
    """Largest in each direction; in a scene that moves in its plane, in the two of that plane."""
    seed: Annotated[Count, Field(ge=0, le=LARGEST_SEED)] = 0
    """Seed of the draw."""


class Run(Table):
    """The table ``[run]``: time, solver and output."""

    dt: Annotated[Number, Unit("s"), Field(gt=0, le=0.1), WithJsonSchema(_STEP)]
    """Time step, or "auto": it adapts between dt_min and dt_max, and this is the shortest, by which the loads are sampled."""
    dt_min: Annotated[Number, Unit("s"), Field(gt=0, le=0.1)] | None = None
    """Lower bound of the time step, with dt = "auto" only. Steps are dt_max halved as often as stays above it; 5 times when not given."""
    dt_max: Annotated[Number, Unit("s"), Field(gt=0, le=0.1)] | None = None
    """The longest step; with dt = "auto" only, 0.01 when not given."""
    dt_tolerance: Annotated[Number, Unit("m"), Field(gt=0)] | None = None
    """Local error of a step that is aimed at, root mean square over the blocks; with dt = "auto" only."""
    duration: Annotated[Number, Unit("s"), Field(gt=0)] = UNTIL_LOADS_END
    """Duration of the run; up to the end of the loads and a rest of 1 s, none after a push by displacement, when not given."""
    until_still: Flag | None = None
    """Go on after the duration, with the base at rest, until all standing blocks are still; true by default where damage is graded."""
    longest: Annotated[Number, Unit("s"), Field(gt=0)] | None = None
    """Time at which such a run ends in any case; twice the duration plus 5 s when not given."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.5
    """Parameter of the Moreau-Jean step: 0.5 keeps the energy of a free motion, 1 damps it."""
    solver: SolverName = "auto"
    """Solver of the friction problem of each step."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    """Natural map error that each step has to reach."""
    accept: Annotated[Number, Field(gt=0, lt=1)] | None = None
    """Natural map error with which a step of packed grains may be left, and above which no step is accepted; left out: ten tolerances."""
    max_iterations: Annotated[Count, Field(ge=1, le=MOST_ITERATIONS)] | None = None
    """Iterations of each island after which a step counts as missed; the solver's own limit when not given."""
    seed: Annotated[Count, Field(ge=0, le=LARGEST_SEED)] = 0
    """Seed of the order in which contacts are swept."""
    threads: Annotated[Count, Field(ge=1, le=10_000)] | None = None
    """Cores to use; as many as pay for the size of the scene when not given. It changes no bit."""
    frames_per_second: Annotated[Number, Unit("1/s"), Field(gt=0)] = 50.0
    """Frames written per second of the simulated time."""
    checkpoint_every: Annotated[Number, Unit("s"), Field(ge=0)] = 10.0
    """Time of the clock between two checkpoints."""
    planar: Flag = True
    """Solve a scene that moves in its plane with half the contacts and three unknowns per block; the answer is the same."""
    islands: Flag = True
    """Solve groups of blocks that touch each other only through supports separately, and skip those at rest; the answer is the same."""
    settle: Flag = True
    """Let elastic joints take up the weight and the tension of ties before the run; otherwise both act suddenly, and it swings."""
    first_velocities: FirstVelocities | None = None
    """Velocities that the blocks begin with, drawn at random, {size, seed}; at rest when not given."""
    gravity: Annotated[Vector, Unit("m/s2"), EARTH] = (0.0, 0.0, -9.81)
    """Acceleration of gravity, a vector."""

    @model_validator(mode="before")
    @classmethod
    def _ladder(cls, given: Any) -> Any:
        """Put the shortest step in the place of "auto"."""
        if not isinstance(given, Mapping):
            return given
        if given.get("dt") != AUTO:
            asked = [key for key in ADAPTIVE_KEYS if given.get(key) is not None]
            if asked and "dt" in given:
                raise ValueError(f'{asked[0]} is for dt = "auto" alone, and dt is given as {given["dt"]!r}')
            return given
        longest = given.get("dt_max", LONGEST_STEP)
        shortest = given.get("dt_min", longest * 2.0**-RUNGS if is_number(longest) else longest)
        if not (is_number(longest) and is_number(shortest) and shortest > 0.0 and 0.0 < longest <= 0.1):
            return {**given, "dt": LONGEST_STEP}  # one of the two is refused by its own name
        if shortest > longest:
            raise ValueError(f"dt_min {shortest:g} s is above dt_max {longest:g} s")
        return {**given, "dt_max": longest, "dt": math.ldexp(longest, -math.floor(math.log2(longest / shortest) + 1e-9))}

    @model_validator(mode="after")
    def _fits(self) -> Run:
        if self.has_duration:
            self.check_times()
        return self

    def check_times(self) -> None:
        """Check what the duration has to fit.

        Raises:
            ValueError: a key that it does not fit.
        """
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

    @property
    def has_duration(self) -> bool:
        """Return True if the duration is known: a scene may leave it to its loads."""
        return self.duration != UNTIL_LOADS_END

    def lasting(self, duration: float) -> Run:
        """The settings with a duration [s].

        Raises:
            InputError: one that does not fit the other keys.
        """
        made = self.model_copy(update={"duration": duration})
        try:
            made.check_times()
        except ValueError as reason:
            raise InputError("run", str(reason)) from None
        return made

    @property
    def accepted(self) -> float:
        """Natural map error at which a step may be left that costs far more than others."""
        return ACCEPT * self.tolerance if self.accept is None else self.accept

    @property
    def is_adaptive(self) -> bool:
        """Return True if the time step adapts."""
        return self.dt_max is not None

    @property
    def longest_step(self) -> float:
        """The longest time step [s]."""
        return self.dt if self.dt_max is None else self.dt_max

    @property
    def longest_ticks(self) -> int:
        """The longest step in shortest ones: a power of two."""
        return round(self.longest_step / self.dt)

    @property
    def spans(self) -> tuple[int, ...]:
        """The lengths that a step may have, in shortest ones: 1, 2, 4 ..."""
        return tuple(1 << rung for rung in range(self.longest_ticks.bit_length()))

    @property
    def steps(self) -> int:
        """Steps N of length dt that cover the duration."""
        return math.ceil(self.duration / self.dt - 1e-6)

    @property
    def most_steps(self) -> int:
        """Steps after which a run ends that goes on until its blocks are still."""
        longest = min(2.0 * self.duration + WAIT, MOST_STEPS * self.dt) if self.longest is None else self.longest
        return max(self.steps, math.ceil(longest / self.dt - 1e-6))

    @property
    def frame_every(self) -> int:
        """Steps of length dt between two frames: whole longest steps, or a power of two where that is longer than a frame lasts."""
        frames = self.frames_per_second * self.longest_step  # of a step; so few that they have no reciprocal where none falls into any run
        if not frames * MOST_STEPS > 1.0:
            return int(MOST_STEPS)
        if frames <= 1.0 or not self.is_adaptive:
            return max(1, round(1.0 / frames)) * self.longest_ticks
        return max(1, self.longest_ticks >> round(math.log2(frames)))
