# SPDX-License-Identifier: GPL-3.0-or-later
"""The least strengthening of a scene: ties by cuts, verified by the search for the least factor, rounded up to bars that can be bought.

before = limit analyses without candidates, whose mechanisms below the target are the first cuts
repeat
    F = forces of least cost for all cuts
    associated mechanisms below the target under F are cuts, until there are none
    limit analyses with F: mechanisms below the target are cuts, until there are none
    limit analyses with the next bars up: likewise
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from masonry_cd.analysis.limit.found import FoundMechanism
from masonry_cd.analysis.limit.solution import Unbounded
from masonry_cd.analysis.limit.strengthening import EarlyMechanism, Least, OutOfReach, associated, cut_of, falling, least_forces
from masonry_cd.app.result import Say, silent
from masonry_cd.app.scene import Scene
from masonry_cd.app.strengthen_table import BarTable
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import LimitCase, limit_case
from masonry_cd.limit.checked import Checked, way_words
from masonry_cd.strengthening.asked import StrengtheningTask, asked_of

MARGIN = 1e-3  # share of the target by which cuts ask for more, so that what is solved to a tolerance reaches it
ROUNDS = 60  # of cuts at most
SAME = 1e-9  # share by which a force may exceed that of a bar

Cases = tuple[LimitCase, ...]  # the whole under each push, then macro-elements


@dataclass(frozen=True, eq=False)
class DesignTie:
    """A tie of the design."""

    number: int  # of the candidate
    force: float  # least yield force [N]
    bar: BarTable  # the next one up
    yields: float  # at which the bar or its anchorage yields [N]
    length: float  # [m]
    worth: float  # of one kN more, in load factor
    cost: float  # with the bar


@dataclass(frozen=True, eq=False)
class StrengtheningDesign:
    """The least ties that bring a scene to its target."""

    asked: StrengtheningTask
    least: Least
    ties: tuple[DesignTie, ...]
    cost: float  # with bars
    before: tuple[LimitCase, ...]  # the whole under each push, then macro-elements
    with_least: tuple[LimitCase, ...]  # with the least forces
    after: tuple[LimitCase, ...]  # with bars
    cuts: tuple[EarlyMechanism, ...]
    seconds: float

    @property
    def reached(self) -> float:
        """The least share of what is asked of them at which all mechanisms that were found start with the least forces; 1 without one."""
        return min(((cut.alone + float(cut.worth @ self.least.force)) / cut.asked for cut in self.cuts), default=1.0)

    @property
    def rows(self) -> list[dict[str, object]]:
        """The tables ``[[structure.ties]]`` of its ties."""
        return rows_of(self.asked, [(tie.number, tie.bar.diameter, tie.yields) for tie in self.ties])


def strengthened(scene: Scene, say: Say = silent) -> StrengtheningDesign:
    """Find the least ties that a scene asks for.

    Raises:
        InputError: anything wrong with the scene, or a target that its candidates do not reach.
    """
    begin, asked = time.perf_counter(), asked_of(scene)
    with scene.locating():
        return _designed(asked, begin, say)


def _designed(asked: StrengtheningTask, begin: float, say: Say) -> StrengtheningDesign:
    """The least ties, of a question that was asked at a time ``begin`` [s].

    Raises:
        InputError: a target that the candidates do not reach.
    """
    count = len(asked.rows)
    before = _analysed(asked, np.zeros(count))
    cuts = [*_below(asked, before, np.zeros(count))]
    say(f"{count} candidates, {len(cuts)} mechanisms start below {asked.goal.words}")
    for _ in range(ROUNDS):
        least, cuts = _associated(asked, cuts)
        found = before if not least.force.any() else _analysed(asked, least.force)
        more, chosen = [*_below(asked, found, least.force)], _with_bars(asked, least.force)
        if not more:
            after = found if not chosen.any() else _analysed(asked, chosen)
            more = [*_below(asked, after, chosen)]
        say(f"{int((least.force > 0.0).sum())} ties, cost {least.cost:.4g}: {len(more)} mechanisms start below the target")
        if not more:
            break
        cuts = [*cuts, *more]
    else:
        raise _no_end()
    ties = tuple(_ties(asked, least, chosen))
    cost = sum(tie.cost for tie in ties)
    return StrengtheningDesign(asked, least, ties, cost, before, found, after, tuple(cuts), time.perf_counter() - begin)


def rows_of(asked: StrengtheningTask, ties: Sequence[tuple[int, float, float]]) -> list[dict[str, object]]:
    """Tables ``[[structure.ties]]`` of candidates by number, diameter [m] and yield force [N]."""
    return [dict(asked.rows[i]) | {"diameter": diameter, "yield_force": force} for i, diameter, force in ties]


def _analysed(asked: StrengtheningTask, force: np.ndarray) -> tuple[LimitCase, ...]:
    """The limit analyses with candidates of yield forces (N,)."""
    rows = rows_of(asked, [(int(i), next_up(asked, float(force[i])).diameter, float(force[i])) for i in np.flatnonzero(force)])
    return tuple(limit_case(scene, wanted=wanted) for scene, wanted in asked.analyses(rows))


def _associated(asked: StrengtheningTask, cuts: list[EarlyMechanism]) -> tuple[Least, list[EarlyMechanism]]:
    """The forces of least cost under which no associated mechanism starts below the target, and the cuts that say so.

    Raises:
        InputError: the candidates do not reach it, or no answer.
    """
    for _ in range(ROUNDS):
        least = _least(asked, cuts)
        more = [*_early(asked, least.force)]
        if not more:
            return least, cuts
        cuts = [*cuts, *more]
    raise _no_end()


def _no_end() -> InputError:
    """Too many rounds."""
    return InputError("strengthen", f"no answer in {ROUNDS} rounds of cuts: fewer candidates?")


def _early(asked: StrengtheningTask, force: np.ndarray) -> Iterator[EarlyMechanism]:
    """Cuts of associated mechanisms that start below the target, or fall, with candidates of yield forces (N,)."""
    whole, candidates = asked.whole(force), asked.candidates
    for name, free, way in asked.parts(whole):
        try:
            found = associated(whole, free, way)
        except Unbounded:
            falls = falling(candidates, whole, free, way, force, f"{name}: what falls under the dead loads")
            if falls is not None:
                yield falls
            continue
        if found is not None and not found.stones and found.oscillator.alpha < (1.0 + 0.5 * MARGIN) * (least := asked.goal.asked(found)):
            yield cut_of(candidates, whole.assembly, found, force, (1.0 + MARGIN) * least, _named(asked, name, found))


def _below(asked: StrengtheningTask, cases: Sequence[LimitCase], force: np.ndarray) -> Iterator[EarlyMechanism]:
    """Cuts of the mechanisms of limit analyses that start below the target, with candidates of yield forces (N,)."""
    early = [each for case in cases for each in counted(case) if each.one.oscillator.alpha < asked.goal.asked(each.one)]
    known = [each for each in early if each.one.mechanism is not None]
    if early and not known:
        raise InputError("strengthen", f"no answer: the velocities of {early[0].words} are not kept")
    for each in known:
        words = _named(asked, f"{each.part.element.name}, push {way_words(each.part.direction)}", each.one)
        yield cut_of(asked.candidates, asked.structure.assembly, each.one, force, (1.0 + MARGIN) * asked.goal.asked(each.one), words)


def _named(asked: StrengtheningTask, part: str, one: FoundMechanism) -> str:
    """A mechanism of a part under a push, with the groups of the blocks that move."""
    assert one.mechanism is not None
    assembly = asked.structure.assembly
    moving = np.bincount(assembly.group_of[one.mechanism.moving & ~assembly.fixed], minlength=len(assembly.groups))
    groups = [f"{moving[g]} of {assembly.groups[g]}" for g in np.argsort(-moving, kind="stable") if moving[g]]
    return f"{part}: {one.name} ({', '.join(groups)})"


def next_up(asked: StrengtheningTask, force: float) -> BarTable:
    """The weakest bar of the catalogue that bears a force [N]."""
    return next(bar for bar in asked.table.catalogue if (bar.yield_force or 0.0) >= (1.0 - SAME) * force)


def _with_bars(asked: StrengtheningTask, force: np.ndarray) -> np.ndarray:
    """(N,) at which the next bars up, or their anchorages, yield for forces (N,) [N]."""
    found = np.zeros_like(force)
    for i in np.flatnonzero(force):
        found[i] = min(next_up(asked, float(force[i])).yield_force or 0.0, asked.candidates.most[i])
    return found


def _ties(asked: StrengtheningTask, least: Least, yields: np.ndarray) -> Iterator[DesignTie]:
    """The ties of a design whose bars yield at (N,) [N]."""
    for i in map(int, np.flatnonzero(least.force)):
        bar, length = next_up(asked, float(least.force[i])), float(asked.lengths[i])
        by_force = float(asked.candidates.per_force[i]) * yields[i] if bar.price is None else bar.price * length
        cost = by_force + float(asked.candidates.anchors[i])
        yield DesignTie(i, float(least.force[i]), bar, float(yields[i]), length, 1e3 * float(least.worth[i]), cost)


def counted(case: LimitCase) -> list[Checked]:
    """The mechanisms of a limit analysis that count: not those of stones of one course that slide by themselves, which no tie holds."""
    return [each for each in case.mechanisms if not each.one.stones]


def _least(asked: StrengtheningTask, cuts: Sequence[EarlyMechanism]) -> Least:
    """The forces of least cost.

    Raises:
        InputError: the mechanism that they do not bring to the target.
    """
    try:
        return least_forces(asked.candidates, cuts, asked.table.fewest)
    except OutOfReach as short:
        crossed = "even with all candidates at their largest force" if short.cut.worth.any() else "no candidate crosses it"
        what = "load factor" if short.cut.of_target else "share of the dead loads"
        starts = f"starts at a {what} of {short.most:.4g}, {short.cut.asked:.4g} is required"
        raise InputError(
            "strengthen",
            f"{asked.goal.words} is out of reach: {short.cut.words}: {starts}; {crossed}",
        ) from None
