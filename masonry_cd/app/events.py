# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables ``[[events]]`` of a scene: changes of the model at a time, or once a gauge passes a value.

    [[events]]
    at = 2.0                                                       # s, of the loads
    remove = "centring"

    [[events]]
    when = { gauge = "crown", quantity = "z", below = -0.01 }      # a gauge of [output]
    put_in = "prop 2"

An event comes once, before the first step that begins at its time or later, or before the step after the one in which its gauge passed the
value. Several that are due at once come in the order of the scene.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from typing import Annotated, Any, Self

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.app.changes import Change, ChangeableModel, Changes, changed, check, in_words, released
from masonry_cd.app.gauge_rows import GaugeRows
from masonry_cd.app.measured_joints import MeasuredJoints
from masonry_cd.app.pair_joints import PairJoints
from masonry_cd.app.staying_support import staying_support
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError, of_each, parse_table, suggest
from masonry_cd.foundation.fields import Instant, Number, Table
from masonry_cd.io.gauges import Gauges
from masonry_cd.io.summary_tables import Event
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.snapshot import part, prefixed
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joints import JointMeasures, Joints

QUANTITIES: Mapping[str, tuple[str, ...]] = {
    "points": ("x", "y", "z"),
    "joints": ("opening", "sliding", "normal_force", "shear_force"),
    "cracks": ("x", "y", "z"),
    "supports": ("x", "y", "z"),
    "guides": ("force", "moment", "displacement"),
}
"""Quantities that a condition can name, by the kind of the gauge: displacements and openings [m], forces [N], moments [N m]."""


class Condition(Table):
    """The value that a gauge has to pass, ``when = { gauge = "crown", quantity = "z", below = -0.01 }``."""

    gauge: str
    """Name of a point, joint, crack or support of [output], of a push by displacement or a prop."""
    quantity: str
    """x, y, z of points, cracks and supports; opening, sliding, normal_force, shear_force of joints; force, moment, displacement of pushes
    and props."""
    above: Number | None = None
    """The event comes once the quantity is more than this, in SI units."""
    below: Number | None = None
    """The event comes once the quantity is less than this."""

    @model_validator(mode="after")
    def _one_bound(self) -> Self:
        if (self.above is None) == (self.below is None):
            raise ValueError("give exactly one of above and below")
        return self

    def is_met(self, value: float) -> bool:
        """True where a value has passed the bound."""
        return value > self.above if self.above is not None else value < (self.below or 0.0)

    @property
    def words(self) -> str:
        """The condition as text, as in the closing lines."""
        bound = f"above {self.above:g}" if self.above is not None else f"below {self.below:g}"
        return f'once {self.quantity} of "{self.gauge}" is {bound}'


class EventTable(Change):
    """A table ``[[events]]``."""

    at: Instant | None = None
    """Time of the loads at which it comes."""
    when: Condition | None = None
    """Condition on a gauge, instead of ``at``."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name of the event in the closing lines and in summary.json."""

    @model_validator(mode="after")
    def _one_cause(self) -> Self:
        if (self.at is None) == (self.when is None):
            raise ValueError("give exactly one of at and when")
        return self

    @property
    def order(self) -> float:
        """Sort key of the event: its time [s], infinite for one with a condition."""
        return math.inf if self.at is None else self.at

    @property
    def cause(self) -> str:
        """The time or condition of the event, as text."""
        return self.when.words if self.when is not None else f"at {self.at:g} s"


def parse_events(tables: Sequence[Mapping[str, Any]]) -> tuple[EventTable, ...]:
    """The events of a scene.

    Raises:
        InputError: the faults of all of them together.
    """
    return tuple(of_each(lambda i: parse_table(EventTable, tables[i], f"events[{i}]"), range(len(tables))))


def check_events(events: Sequence[EventTable], first: ChangeableModel, settings: Run, gauges: Gauges, joints: Joints) -> list[str]:
    """A line on each event of a scene, whose model is the first before any of them.

    Those that come at a time are tried in their order, those with a condition on the model before any; where there is one of these, what
    an event finds is not known.

    Raises:
        InputError: events that name what is not there, would change nothing or come after the end; the faults of all of them together.
    """
    models, model, unknown = dict[int, ChangeableModel](), first, any(one.when is not None for one in events)
    for i in sorted((i for i, one in enumerate(events) if one.at is not None), key=lambda i: events[i].order):
        models[i] = model
        with suppress(InputError):  # said below
            model = changed(model, events[i], 0, f"events[{i}]")

    def line(i: int) -> str:
        event, where = events[i], f"events[{i}]"
        if event.when is not None:
            find_condition(event.when, gauges, joints, where)
        check(event, models.get(i, first), where, any_time=unknown)
        if event.at is not None and event.at >= settings.duration:
            raise InputError(f"{where}.at", f"is {event.at:g} s, and the loads end at run.duration = {settings.duration:g} s")
        return line_of(event, i, first.assembly)

    return of_each(line, range(len(events)))


def line_of(event: EventTable, number: int, assembly: Assembly) -> str:
    """An event in a line, for who starts the run."""
    return f"{event.name or f'events[{number}]'} {event.cause}: {in_words(event, assembly)}"


@dataclass(frozen=True)
class Looked:
    """A condition, found among the gauges of a run."""

    gauge: Gauges  # the one that it looks at
    rows: str  # the dataset of its values
    column: int
    blocks: tuple[int, ...]  # on which it is; while one is not there, the condition is not met
    relative: bool = False  # to the support of displacements


def find_condition(condition: Condition, gauges: Gauges, joints: Joints, where: str) -> Looked:
    """Find the gauge of a condition.

    Raises:
        InputError: no such gauge, or it has no such quantity.
    """
    every = [(kind, one) for kind, ones in gauges._asdict().items() for one in ones]
    found = [(kind, one) for kind, one in every if one.name == condition.gauge]
    names = [one.name for _, one in every]
    if not found:
        listed = f"gauges: {', '.join(names)}" if names else "[[output.point]] with a name makes one"
        raise InputError(f"{where}.when.gauge", f'"{condition.gauge}" is not a gauge{suggest(condition.gauge, names)}; {listed}')
    kind, one = found[0]
    if condition.quantity not in QUANTITIES[kind]:
        raise InputError(f"{where}.when.quantity", f'"{condition.quantity}" is none of {", ".join(QUANTITIES[kind])}, which this gauge has')
    rows = f"guides/{condition.quantity}" if kind == "guides" else f"gauges/{kind}"
    if kind == "guides":
        return Looked(Gauges(guides=gauges.guides), rows, gauges.guides.index(one), ())
    only: Any = {kind: (one,)}
    if kind == "joints":
        blocks: tuple[int, ...] = int(joints.block_a[one.joint]), int(joints.block_b[one.joint])
    else:
        blocks = one.blocks if kind == "cracks" else (one.block,)
    return Looked(Gauges(**only), rows, QUANTITIES[kind].index(condition.quantity), blocks, getattr(one, "relative", False))


@dataclass(eq=False)
class Events:
    """The events of a run on its way."""

    changes: Changes
    tables: Sequence[EventTable]
    stepper: Stepper
    joints: Joints
    support: int  # to which displacements are relative; -1 without one
    looked: Mapping[int, Looked]  # of the events that have a condition
    met: list[int] = field(default_factory=list)  # whose condition holds, and that are to come before the next step
    follow: Callable[[], None] | None = None  # called when the model has changed
    _rows: Mapping[int, GaugeRows] = field(init=False)

    def __post_init__(self) -> None:
        self._rows = {i: GaugeRows(one.gauge, self.stepper, self.joints, self.support) for i, one in self.looked.items()}
        self._pair_joints = PairJoints(self.stepper.assembly)
        self._measured = MeasuredJoints(self.stepper, self.joints, changes=True) if self.looked else None

    @classmethod
    def of(cls, tables: Sequence[EventTable], material: Mapping[str, Any], stepper: Stepper, joints: Joints, gauges: Gauges) -> Events:
        """Return the events of a stepper at the beginning of its run, with the table [material] of its scene and the gauges of the run."""
        known = [(table, f"events[{i}]") for i, table in enumerate(tables)]
        looked = {i: find_condition(one.when, gauges, joints, f"events[{i}]") for i, one in enumerate(tables) if one.when is not None}
        changes = Changes.of(stepper, material, known)
        held = released(stepper.assembly, tables).fixed if tables else stepper.assembly.fixed
        velocity, tick = stepper.system.loads.support_velocity, stepper.settings.dt
        support = staying_support(stepper.assembly, velocity, tick, joints, held)
        return cls(changes, tables, stepper, joints, support, looked)

    @property
    def stops(self) -> list[int]:
        """Steps of the loads before which events are due, (E,) at most."""
        return [int(np.ceil(table.at / self.stepper.settings.dt - 1e-6)) for table in self.tables if table.at is not None]

    def before_step(self) -> bool:
        """Have the events come that are due before the step that comes; whether there were any.

        Raises:
            RunStopped: there is no room for a block that one puts in.
        """
        now, made = self.stepper.load_step * self.stepper.settings.dt, {number for number, _ in self.changes.made}
        timed = [i for i, table in enumerate(self.tables) if table.at is not None and table.at <= now + 1e-6 * self.stepper.settings.dt]
        due = sorted(i for i in {*timed, *self.met} if i not in made)
        for number in due:
            try:
                self.changes.make(number, self.stepper)
            except InputError as fault:
                raise RunStopped(f"step {self.stepper.steps + 1}: {fault}") from None
        self.met.clear()
        if due and self.follow is not None:
            self.follow()
        return bool(due)

    def after_step(self) -> None:
        """Look whether the step has met conditions."""
        if self._measured is None:
            return
        now, absent = self._measured.now(), self.stepper.assembly.absent
        made = {number for number, _ in self.changes.made}
        for number, looked in self.looked.items():
            condition = self.tables[number].when
            there = absent is None or not absent[list(looked.blocks)].any()
            if number not in made and there and condition is not None and condition.is_met(self._value(number, looked, now)):
                self.met.append(number)

    def _value(self, number: int, looked: Looked, now: JointMeasures) -> float:
        """Return the value of the gauge of an event after the last step."""
        rows = self._rows[number]
        rows.step(now, self._pair_joints.of(self.stepper.detector.pairs))
        found = rows.take()
        row = np.atleast_2d(found[looked.rows][0])
        value = float(row[0, looked.column])
        return value - float(found["gauges/base"][0, looked.column]) if looked.relative else value

    def copied(self, stepper: Stepper, follow: Callable[[], None]) -> Events:
        """Return an independent copy for another stepper; ``follow`` is called when its model has changed."""
        other = Events(self.changes.copied(), self.tables, stepper, self.joints, self.support, self.looked, list(self.met), follow)
        if other._measured is not None and self._measured is not None and self._measured.rest is not None:
            other._measured.restore(self._measured.rest)
        return other

    def snapshot(self) -> dict[str, np.ndarray]:
        """Return the arrays of a checkpoint: events made, conditions met, and the rest that joints are measured from."""
        rest = {} if self._measured is None else prefixed("rest", vars(self._measured.rest))
        return self.changes.snapshot() | {"met": np.array(self.met, dtype=np.int64)} | rest

    def restore(self, stored: Stored, arrays: Mapping[str, np.ndarray]) -> None:
        """Put the stepper into the stage of a checkpoint, before its motion is restored.

        Raises:
            InputError: events that this scene does not have.
        """
        met = stored.whole("met", None)
        if (met >= len(self.tables)).any():
            stored.refuse("met", "not those of this scene")
        self.changes.restore(stored, self.stepper)
        if self._measured is not None:
            kept = stored.part("rest")
            for name in vars(self._measured.rest):
                kept.real(name, self.joints.count)
            self._measured.restore(JointMeasures(**part("rest", arrays)))
        self.met = met.tolist()

    def rows(self) -> tuple[Event, ...]:
        """Return each event with the time at which it was made, None where it was not, for summary.json."""
        when = {number: step * self.stepper.settings.dt for number, step in self.changes.made}
        every = ((i, one, in_words(one, self.stepper.assembly)) for i, one in enumerate(self.tables))
        return tuple(Event(name=one.name or f"events[{i}]", cause=one.cause, change=words, time=when.get(i)) for i, one, words in every)
