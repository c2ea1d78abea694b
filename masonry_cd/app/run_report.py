# SPDX-License-Identifier: GPL-3.0-or-later
"""The account of a run, step after step: for its closing lines and summary.json."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.adaptive import AdaptedStep
from masonry_cd.mechanics.dynamics.energy_terms import WORKS
from masonry_cd.mechanics.dynamics.jams import find_jam, named
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper, StepReport

COUNTS = 1e-6  # false slip from which on it counts, as a share of the smallest width: as overlaps that are left alone
DEEP = 0.01  # overlap from which on its blocks are named, as a share of the smallest width
FASTER = 1.5  # times the closing speed that was last looked into: one that is looked into again
NUMBER = re.compile(r"[-+]?\d+(\.\d+)?(e[-+]?\d+)?")


@dataclass
class RunReport:
    """The account of a run, for its closing lines and summary.json."""

    steps: int = 0
    stepping_seconds: float = 0.0
    contacts_mean: float = 0.0
    contacts_max: int = 0
    iterations_mean: float = 0.0
    iterations_max: int = 0
    error_mean: float = 0.0
    error_max: float = 0.0
    violation_max: float = 0.0  # of the contact laws in a step, see dynamics/violations.py [m/s]
    false_slip_max: float = 0.0  # that violations have added up to at a contact [m]
    false_opening_max: float = 0.0  # that a violation has left at a contact [m]
    false_slip_where: str = ""  # as text, of one that COUNTS
    steps_as_before: int = 0  # steps that the impulses of the step before solved: no iteration
    steps_missed: int = 0  # steps whose natural map error is above the tolerance
    steps_accepted: int = 0  # those of them whose error the scene accepts
    steps_apart: int = 0  # steps that solved impacts apart from forces
    islands_mean: float = 0.0  # see dynamics/islands.py
    islands_max: int = 0
    sleeping_mean: float = 0.0  # share of the blocks that slept
    penetration_max: float = 0.0  # [m]
    penetration_where: str = ""  # as text, of one that is DEEP
    shortening_max: float = 0.0  # of springs [m]
    shortening_where: str = ""  # as text, of one that is DEEP
    steps_closing: int = 0  # steps missed that left a contact closing, so that overlaps grow
    closing_max: float = 0.0  # fastest of them [m/s]
    closing_seen: float = 0.0  # and of those that were looked into [m/s]
    jam: str = ""  # as text, what leaves them no solution; empty where nothing is known to
    energy: dict[str, float] = field(default_factory=dict)  # totals at the end [J]
    balance_max: float = 0.0  # largest |balance| so far [J]
    planar: bool = False
    solver_reasons: dict[str, int] = field(default_factory=dict)  # how often each reason was given, # for its numbers
    left_out: dict[str, int] = field(default_factory=dict)  # of the detection, see there
    spans: dict[str, int] = field(default_factory=dict)  # steps by their length in shortest ones, where it adapts
    repeated_error: int = 0  # attempts undone for their local error
    repeated_solver: int = 0  # attempts undone since the solver missed its tolerance
    steps_too_long: int = 0  # of the shortest length, and yet wanted shorter
    local_error_max: float = 0.0  # of the steps that stand [m]
    base_drift_max: float = 0.0  # of the supports from their motion, see dynamics/local_error.py [m]
    stopped: str = ""  # why the run ended early; empty when it did not
    signal: int = 0  # the number of the one that stopped it
    ended_still: bool = False  # the last step ended the rest that the run ends with, since all that stands was still

    work_max: float = 0.0  # largest work of the base, gravity or forces, or kinetic energy, so far [J]
    fall: float = 0.0  # what a step of free fall of length dt would give to all free blocks [J]
    resolution: float = 0.0  # that times the tolerance, summed over the steps: works below it are what solving leaves [J]

    @classmethod
    def read(cls, table: object) -> RunReport:
        """A report from what ``asdict`` made of one.

        Raises:
            InputError: a table of other keys, or of values that are not of their kind.
        """
        own = cls()
        if not isinstance(table, dict) or table.keys() != vars(own).keys():
            raise InputError("report", "not that of a run")
        for name, value in vars(own).items():
            given = list(table[name].values()) if isinstance(value, dict) and isinstance(table[name], dict) else [table[name]]
            kinds = (bool,) if isinstance(value, bool) else (str,) if isinstance(value, str) else (int, float)
            if isinstance(value, dict) and not isinstance(table[name], dict):
                raise InputError(f"report.{name}", "no table")
            if any(not isinstance(one, kinds) or (isinstance(one, bool) and bool not in kinds) for one in given):
                raise InputError(f"report.{name}", "not of its kind")
            if isinstance(value, int) and not isinstance(value, bool) and not (isinstance(table[name], int) and abs(table[name]) < 2**53):
                raise InputError(f"report.{name}", "no whole number")
        return cls(**table)

    @property
    def balance_error(self) -> float:
        """Largest |balance| over the largest work done, or kinetic energy reached; over ``resolution`` where nothing moved."""
        scale = max(self.work_max, self.resolution)
        return self.balance_max / scale if scale > 0 else 0.0

    @property
    def at_rest(self) -> bool:
        """Return True if works and motions stayed below what solving to the tolerance leaves, so that they are no measure."""
        return bool(self.work_max <= self.resolution)

    @property
    def lift_share(self) -> float:
        """Work of lifting blocks out of overlaps over the same: energy that the correction of positions puts in, outside the balance."""
        scale = max(self.work_max, self.resolution)
        return abs(self.energy.get("correction", 0.0)) / scale if scale > 0 else 0.0

    def look(self, step: StepReport, stepper: Stepper) -> None:
        """Name the blocks of a step that overlap most, those whose joint is shortened most, and what leaves a step no solution."""
        assembly, time, closing = stepper.assembly, stepper.state.time, step.closing
        if step.penetration > max(self.penetration_max, DEEP * stepper.width):
            self.penetration_where = f"{named([assembly.names[b] for b in step.overlapping])} at {time:.4g} s"
        if step.shortening.depth > max(self.shortening_max, DEEP * stepper.width):
            share = 100.0 * step.shortening.depth / stepper.width
            pair = named([assembly.names[b] for b in step.shortening.blocks])
            self.shortening_where = f"{share:.2g} % of the smallest width, between {pair} at {time:.4g} s"
        if step.violation.slip > max(self.false_slip_max, COUNTS * stepper.width):
            self.false_slip_where = f"{named([assembly.names[b] for b in step.violation.blocks])} at {time:.4g} s"
        if closing is not None and closing.speed > FASTER * self.closing_seen:
            jam, self.closing_seen = find_jam(closing), closing.speed
            self.jam = self.jam if jam is None else f"{jam.in_words(assembly)} at {time:.4g} s"

    def note_adapted(self, step: AdaptedStep, drift: float) -> None:
        """Take in what choosing the length of a step took, and by how much the supports are off after it [m]."""
        self.spans[str(step.span)] = self.spans.get(str(step.span), 0) + 1
        self.repeated_error += step.repeated_error
        self.repeated_solver += step.repeated_solver
        self.steps_too_long += step.too_long
        self.local_error_max = max(self.local_error_max, step.error)
        self.base_drift_max = max(self.base_drift_max, drift)

    def add(self, step: StepReport, tolerance: float, energy: Mapping[str, float], span: int = 1) -> None:
        """Take in one step, a given number of times as long as dt, and the energies after it."""
        n = self.steps
        self.steps += 1
        self.stepping_seconds += step.seconds
        self.contacts_mean += (step.contacts - self.contacts_mean) / (n + 1)
        self.iterations_mean += (step.iterations - self.iterations_mean) / (n + 1)
        self.error_mean += (step.error - self.error_mean) / (n + 1)
        self.contacts_max = max(self.contacts_max, step.contacts)
        self.iterations_max = max(self.iterations_max, step.iterations)
        self.error_max = max(self.error_max, step.error)
        self.violation_max = max(self.violation_max, step.violation.speed)
        self.false_slip_max = max(self.false_slip_max, step.violation.slip)
        self.false_opening_max = max(self.false_opening_max, step.violation.opening)
        self.penetration_max = max(self.penetration_max, step.penetration)
        self.shortening_max = max(self.shortening_max, step.shortening.depth)
        if step.closing is not None:
            self.steps_closing += 1
            self.closing_max = max(self.closing_max, step.closing.speed)
        self.steps_as_before += step.iterations == 0 and step.contacts > 0
        self.steps_missed += not step.error <= tolerance
        self.steps_accepted += step.accepted
        self.steps_apart += step.apart
        self.islands_mean += (step.islands - self.islands_mean) / (n + 1)
        self.islands_max = max(self.islands_max, step.islands)
        self.sleeping_mean += (step.sleeping - self.sleeping_mean) / (n + 1)
        kind = NUMBER.sub("#", step.reason)  # like counts with like, and the dict stays small
        self.solver_reasons[kind] = self.solver_reasons.get(kind, 0) + 1
        self.resolution += tolerance * self.fall * span * span
        self.energy = dict(energy)
        works = (abs(energy[name]) for name in WORKS)
        self.work_max = max(self.work_max, *works, energy["kinetic"])
        self.balance_max = max(self.balance_max, abs(energy["balance"]))
