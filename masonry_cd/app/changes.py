# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes of the model in the middle of a run: blocks that come and go, supports that let go, ties, props, bonds, friction, gravity.

The events of a scene and the calls of Python are the same changes, with the same keys and checks. A change makes of one stage
(:mod:`masonry_cd.mechanics.dynamics.stage`) the next. The stage in which a run stands follows from the changes made so far and from the
steps of the loads at which they were made, so that is all that a checkpoint keeps of them.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from loads.supports import Names, select
from masonry_cd.foundation.arrays import Stored
from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.foundation.fields import Table, Vector
from masonry_cd.foundation.quantities import counted, length
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped, Stepper
from masonry_cd.mechanics.dynamics.stage import StepperStage, enter
from masonry_cd.mechanics.dynamics.system import RunLoads
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.by_group import by_pair
from masonry_cd.mechanics.model.joint_laws.friction import Friction
from masonry_cd.mechanics.model.joint_laws.tables import JointLaws
from masonry_cd.mechanics.model.materials import Material

NOT_THERE = "does not exist at that time; blocks that a later change adds do not exist before it"
ROOM = 1e-2  # share of the smallest width by which a block that is put in may overlap others, and is lifted out of them


class MaterialChange(Table):
    """Keys of [material] that are others from then on."""

    friction: Friction | None = None
    """New friction of all joints, written as in [material]."""
    joints: dict[str, Any] | None = None
    """New joint laws, written as in [material]; rigid joints stay rigid, elastic ones elastic, and dry ones dry."""


class Change(Table):
    """A change of the model at one time, between two steps."""

    remove: Names = None
    """Blocks or groups that are taken away; * stands for any letters."""
    add: Names = None
    """Blocks or groups that are put in where they were built; a block that no earlier event takes away is absent until then."""
    release: Names = None
    """Supports that become free blocks."""
    cut: Names = None
    """Pairs of groups, "arch-pier", whose joints lose their bond."""
    take_out: Names = None
    """Names of ties and props that are taken out."""
    put_in: Names = None
    """Names of ties and props that are put in, ties with their first tension; one that no earlier event takes out is absent until then."""
    material: MaterialChange | None = None
    """Friction and laws of the joints from then on."""
    gravity: Annotated[Vector | None, Unit("m/s2")] = None
    """Gravity from then on, instead of that of [run] or of an earlier change."""

    @property
    def words(self) -> str:
        """The change as text, as in the closing lines."""
        named = (
            ("removes", self.remove), ("adds", self.add), ("releases", self.release), ("cuts", self.cut),
            ("takes out", self.take_out), ("puts in", self.put_in),
        )  # fmt: skip
        words = [f"{verb} {', '.join(names)}" for verb, names in named if names]
        if self.material is not None:
            words.append("changes the " + " and ".join(sorted(self.material.model_fields_set)) + " of joints")
        if self.gravity is not None:
            words.append(f"turns gravity to ({', '.join(f'{g:g}' for g in self.gravity)}) m/s2")
        return "; ".join(words)


@dataclass(frozen=True, eq=False)
class ChangeableModel:
    """The parts of a run that changes act on."""

    assembly: Assembly
    acceleration: np.ndarray  # (N + 1, 3) of all free blocks, gravity included [m/s2]
    there: Mapping[str, bool]  # ties, props and pushes by name
    material: Mapping[str, Any]  # the table [material]
    gravity: np.ndarray  # (3,) [m/s2]

    @classmethod
    def of(cls, assembly: Assembly, loads: RunLoads, material: Mapping[str, Any], gravity: Sequence[float]) -> ChangeableModel:
        """Return the model of a run that has not begun."""
        there = {} if loads.forces is None else loads.forces.switches
        return cls(assembly, loads.acceleration, there, material, np.asarray(gravity, dtype=float))

    def stage(self, loads: RunLoads) -> StepperStage:
        """The stage with what other loads do."""
        forces = loads.forces if loads.forces is None or loads.forces.switches == self.there else loads.forces.switched(self.there)
        return StepperStage(self.assembly, replace(loads, acceleration=self.acceleration, forces=forces))


def check(change: Change, model: ChangeableModel, where: str, any_time: bool = False) -> None:
    """Refuse a change that names what is not there, or would change nothing; ``any_time``: the model may be another when it comes.

    Raises:
        InputError: names the key.
    """
    if not change.words:
        raise InputError(where, f"changes nothing; keys: {', '.join(Change.model_fields)}")
    changed(model, change, 0, where)
    _bonds(change, model.assembly, where)
    if not any_time:
        _refuse_idle(change, model, where)


def _refuse_idle(change: Change, model: ChangeableModel, where: str) -> None:
    """Refuse to take away what is not there, and to put in what is."""
    absent = np.zeros(model.assembly.count, dtype=bool) if model.assembly.absent is None else model.assembly.absent
    for key, names, gone in (("remove", change.remove, True), ("add", change.add, False)):
        idle = names and (absent[select(names, model.assembly, where)] == gone).all()
        if idle:
            raise InputError(f"{where}.{key}", f"{_quoted(names)} {NOT_THERE if gone else 'is there already'}")
    for key, names, there in (("take_out", change.take_out, False), ("put_in", change.put_in, True)):
        idle = names and all(model.there[name] == there for name in names)
        if idle:
            raise InputError(f"{where}.{key}", f"{_quoted(names)} {'is there already' if there else NOT_THERE}")


def changed(model: ChangeableModel, change: Change, step: int, where: str) -> ChangeableModel:
    """The model after a change that is made at a step of the loads.

    Raises:
        InputError: names the key that is at fault.
    """
    material, table = change.material, dict(model.material)
    assembly = _with_blocks(model.assembly, change, where)
    if material is not None:
        table |= material.model_dump(exclude_none=True)
        with _under(where):
            assembly = _with_laws(assembly, parse_table(Material, table, "material"))
    gravity, pull = model.gravity, model.acceleration
    if change.gravity is not None:
        gravity, pull = np.array(change.gravity), pull.copy()
        pull[step + 1 :] += gravity - model.gravity
    return ChangeableModel(assembly, pull, _switched(model.there, change, where), table, gravity)


def _quoted(names: Sequence[str] | None) -> str:
    return ", ".join(f'"{name}"' for name in names or ())


@contextmanager
def _under(where: str) -> Iterator[None]:
    """Give the faults of the body, which name keys of [material], the place of a change."""
    try:
        yield
    except InputError as error:
        raise error.each(lambda fault: fault._replace(place=f"{where}.{fault.place}")) from None


def _with_blocks(assembly: Assembly, change: Change, where: str) -> Assembly:
    """The blocks of which some have gone, others have come, and supports are released."""
    if change.remove:
        assembly = without(assembly, change.remove, f"{where}.remove")
    if change.add:
        assembly = without(assembly, change.add, f"{where}.add", gone=False)
    if change.release:
        chosen = select(change.release, assembly, f"{where}.release")
        _keep_footings(chosen, assembly, f"{where}.release")
        loose = np.flatnonzero(chosen & ~np.array([block.fixed for block in assembly.blocks]))
        if len(loose):
            raise InputError(f"{where}.release", f'"{assembly.names[loose[0]]}" is not a support')
        fixed = assembly.fixed & ~chosen
        assembly = replace(assembly, fixed=fixed, support_of=np.where(fixed, assembly.support_of, -1))
    return assembly


def without(assembly: Assembly, names: Sequence[str], where: str, gone: bool = True) -> Assembly:
    """The blocks of which those of some names are not there, or are there again.

    Raises:
        InputError: names that fit nothing, or a support.
    """
    return _without(assembly, select(names, assembly, where), where, gone)


def _without(assembly: Assembly, chosen: np.ndarray, where: str, gone: bool = True) -> Assembly:
    """The blocks of which those chosen, (B,) bool, are not there, or are there again."""
    _keep_footings(chosen, assembly, where)
    stuck = np.flatnonzero(chosen & assembly.fixed)
    if len(stuck):
        name = assembly.names[stuck[0]]
        raise InputError(where, f'"{name}" is a support, and only free blocks come and go; release = "{name}" makes it a free block')
    absent = np.where(chosen, gone, False if assembly.absent is None else assembly.absent)
    return replace(assembly, absent=absent if absent.any() else None)


def _keep_footings(chosen: np.ndarray, assembly: Assembly, where: str) -> None:
    """Refuse changes of blocks chosen, (B,) bool, that stand on the ground or for it."""
    footings = assembly.footings
    held = np.zeros(0, dtype=int) if footings is None else footings.blocks[chosen[footings.blocks].any(axis=1), 0]
    if len(held):
        raise InputError(where, f'"{assembly.names[held[0]]}" stands on [[ground]], and a footing neither comes, goes nor lets go')


def _with_laws(assembly: Assembly, material: Material) -> Assembly:
    """The blocks with other friction and joint laws of the same kinds."""
    before, changed = assembly.laws, assembly.with_laws(material)
    laws = changed.laws
    laws = replace(laws, retardation=np.where(laws.at_first_period > 0.0, before.retardation, laws.retardation))
    if not _are_of_one_kind(before, laws):
        raise InputError(
            "material.joints",
            "makes joints of another kind: those that are rigid, elastic or bonded, can soften or crush or have more points, stay so; "
            "cut breaks bonds, and a stiffness of 1e12 N/m3 is as good as rigid",
        )
    return replace(changed, laws=laws)


def _are_of_one_kind(before: JointLaws, after: JointLaws) -> bool:
    """True where the joints that are elastic, have bonds, can soften or can crush are the same, with as many points each."""
    kinds = ((laws.elastic, laws.apex > 0.0, laws.fracture > 0.0, laws.crushing > 0.0, laws.points) for laws in (before, after))
    return all(np.array_equal(one, other) for one, other in zip(*kinds, strict=True))


def _switched(there: Mapping[str, bool], change: Change, where: str) -> Mapping[str, bool]:
    """Which ties and props are there once some of them have come or gone."""
    known = list(there)
    for key, names in (("take_out", change.take_out), ("put_in", change.put_in)):
        for name in names or ():
            if name not in known:
                listed = f"; there are {', '.join(known)}" if known else '; a tie or prop with name = "..." has one'
                raise InputError(f"{where}.{key}", f'no tie, prop or push is named "{name}"{suggest(name, known)}{listed}')
    return {**there, **dict.fromkeys(change.take_out or (), False), **dict.fromkeys(change.put_in or (), True)}


def _bonds(change: Change, assembly: Assembly, where: str) -> np.ndarray:
    """The pairs of groups whose joints lose their bond, (G, G).

    Raises:
        InputError: a pair without bonds.
    """
    out = np.zeros(assembly.friction.shape, dtype=bool)
    for pair in change.cut or ():
        pairs = [(i, j) for i, j, _ in by_pair({pair: True}, assembly.groups, f"{where}.cut")]
        if not any(assembly.laws.apex[i, j] > 0.0 for i, j in pairs):
            raise InputError(f"{where}.cut", f'joints "{pair}" have no bond: material.joints.cohesion gives them one')
        for i, j in pairs:
            out[i, j] = True
    return out


def waiting(assembly: Assembly, changes: Sequence[tuple[str, Change]]) -> tuple[Assembly, dict[str, bool]]:
    """The blocks before any of some changes in the order in which they come, and ties and props by name.

    What is put in before anything takes it away is not there yet.

    Args:
        assembly: with all blocks.
        changes: and where each stands.

    Raises:
        InputError: unknown names of blocks.
    """
    seen, there = np.zeros(assembly.count, dtype=bool), dict[str, bool]()
    for where, change in changes:
        if change.remove:
            seen = seen | select(change.remove, assembly, f"{where}.remove")
        if change.add:
            late = select(change.add, assembly, f"{where}.add") & ~seen
            assembly, seen = _without(assembly, late, f"{where}.add"), seen | late
        there = dict.fromkeys(change.put_in or (), False) | dict.fromkeys(change.take_out or (), True) | there
    return assembly, there


def _require_room(stepper: Stepper, model: ChangeableModel, where: str) -> None:
    """Refuse blocks that would lie in others where they are put in.

    Raises:
        InputError: names the two that overlap most.
    """
    trial, absent = copy.copy(stepper), stepper.assembly.absent
    enter(trial, model.stage(stepper.system.loads))
    linkage = trial.system.linkage
    torn = 0.0 if linkage is None else linkage.largest_violation(trial.state)
    if torn > ROOM * stepper.width:
        raise InputError(where, f"a link would have to close {torn:.3g} m or rad: its blocks have moved apart")
    try:
        rows = trial.friction_problem().rows
    except RunStopped as stopped:
        raise InputError(where, f"the blocks would overlap: {stopped}") from None
    if absent is None:
        return
    deep = np.where(absent[rows.blocks].any(axis=1), -rows.gap, 0.0)
    if deep.max(initial=0.0) > ROOM * stepper.width:
        a, b = (f'"{stepper.assembly.names[block]}"' for block in rows.blocks[int(deep.argmax())])
        raise InputError(where, f"the blocks would overlap: {a} by {length(float(deep.max()))} into {b}")


def released(assembly: Assembly, changes: Sequence[Change]) -> Assembly:
    """The blocks of which none is a support that a change releases."""
    names = [name for change in changes for name in change.release or ()]
    loose = select(names, assembly, "release") if names else np.zeros(assembly.count, dtype=bool)
    blocks = tuple(replace(block, fixed=False) if free else block for block, free in zip(assembly.blocks, loose.tolist(), strict=True))
    return replace(assembly, blocks=blocks, fixed=assembly.fixed & ~loose)


@dataclass(eq=False)
class Changes:
    """The changes of a run that a stepper makes, those made so far, and the model that they led to."""

    base: ChangeableModel  # before any of them
    known: list[tuple[Change, str]]  # and where it stands
    made: list[tuple[int, int]] = field(default_factory=list)  # which of the known ones, and at which step of the loads
    model: ChangeableModel = field(init=False)

    def __post_init__(self) -> None:
        self.model = self._after(self.made)

    @classmethod
    def of(cls, stepper: Stepper, material: Mapping[str, Any], known: Sequence[tuple[Change, str]] = ()) -> Changes:
        """Return the changes of a stepper at the beginning of its run, with the table [material] of its scene."""
        return cls(ChangeableModel.of(stepper.assembly, stepper.system.loads, material, stepper.settings.gravity), list(known))

    def make(self, number: int, stepper: Stepper) -> None:
        """Make a known change now.

        Raises:
            InputError: gravity would lead out of the plane in which the scene is solved, or a block has no room; nothing is changed.
        """
        change, where = self.known[number]
        plane = stepper.plane
        if change.gravity is not None and plane is not None and change.gravity[plane.axis]:
            way = f"it acts along {'xyz'[plane.axis]}, across the plane in which this scene is solved"
            raise InputError(f"{where}.gravity", f"{way}; run.planar = false has it move in space")
        bonds = _bonds(change, stepper.assembly, where)
        model = changed(self.model, change, stepper.load_step, where)
        if change.add:
            _require_room(stepper, model, f"{where}.add")
        self.model = model
        self.made.append((number, stepper.load_step))
        enter(stepper, self.model.stage(stepper.system.loads))
        if bonds.any():
            stepper.cut_bonds(bonds)

    def copied(self) -> Changes:
        """A copy that goes its own way."""
        return Changes(self.base, list(self.known), list(self.made))

    def snapshot(self) -> dict[str, np.ndarray]:
        """Those made so far, for a checkpoint."""
        return {"made": np.array(self.made, dtype=np.int64).reshape(-1, 2)}

    def restore(self, stored: Stored, stepper: Stepper) -> None:
        """Have a stepper be in the stage of a checkpoint, before its motion is restored.

        Raises:
            InputError: changes that this scene does not have.
        """
        made = stored.whole("made", None, 2)
        if (made[:, 0] >= len(self.known)).any() or (made[:, 1] >= len(stepper.system.loads.acceleration)).any():
            stored.refuse("made", "not those of this scene")
        self.made = [(int(number), int(step)) for number, step in made]
        self.model = self._after(self.made)
        enter(stepper, self.model.stage(stepper.system.loads))

    def _after(self, made: Sequence[tuple[int, int]]) -> ChangeableModel:
        model = self.base
        for number, step in made:
            model = changed(model, self.known[number][0], step, self.known[number][1])
        return model


def read_changes(tables: Any) -> list[tuple[Change, str]]:
    """Changes as tables, as a checkpoint has them.

    Raises:
        InputError: they are none.
    """
    if not isinstance(tables, list):
        raise InputError("changes", "not what a simulation leaves")
    return [(parse_table(Change, table, "change"), "change") for table in tables]


def in_words(change: Change, assembly: Assembly) -> str:
    """Return a change as text, with the number of blocks in its groups."""
    words = change.words
    for names in (change.remove, change.add):
        if names and (count := int(select(names, assembly, "").sum())) > len(names):
            words = words.replace(", ".join(names), f"{', '.join(names)} ({counted(count, 'block')})", 1)
    return words
