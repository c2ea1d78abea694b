# SPDX-License-Identifier: GPL-3.0-or-later
"""The shaking and the forces: every [[loads]] table of a scene, summed into arrays over the time steps.

A kind of load is a :class:`loads.motion.LoadKind`, listed by name in the ``KINDS`` of a module in :mod:`loads.kinds`. Gravity acts in
full from the start unless a table of kind "gravity" ramps it.

Support s follows the sum over the tables  v_s(t) = sum_i share_is v_i(t - delay_is). Supports whose delays and shares agree in every table
have one motion: it is computed once, and the assembly's ``support_of`` says which block follows which. One that turns about a point has a
motion of its own.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from loads import fill
from loads.acted import Acted
from loads.bar_frequency import check_together as check_ties
from loads.bars import Forces
from loads.kinds.driven import check_inertia, check_together
from loads.kinds.gravity import GravityTable
from loads.kinds.tie import TieTable, bar
from loads.kinds.tilt import TiltTable, load_factors
from loads.motion import LoadAction, LoadKind, LoadTable, RunGrid, Turning
from loads.supports import ShakingTable
from masonry_cd.foundation import plugins
from masonry_cd.foundation.errors import InputError, of_each, parse_table, suggest
from masonry_cd.foundation.extensions import Entries
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.fill import Fill
from masonry_cd.mechanics.model.guides import Guide
from masonry_cd.mechanics.model.shocks import Pause, Shock

__all__ = ["KINDS", "Loading", "build", "parse_load", "suggest"]

REST = 1.0  # after the loads of a run that states no duration [s]
FASTEST = 1e4  # speed of a support [m/s]
STRONGEST = 1e6  # body force [m/s2]
LARGEST = 4e9  # bytes that the motions of the supports may take

KINDS: Entries[LoadKind] = Entries("loads.kinds", "KINDS")


@dataclass(frozen=True, eq=False)
class Loading:
    """All loads of a run at its times t_k = k dt, k = 0 .. N.

    Attributes:
        support_velocity: (N + 1, S, 3) velocity of each support motion [m/s]; S = 1: all supports move together. (N + 1, S, 6) with the
            angular velocity [rad/s] where a support turns.
        acceleration: (N + 1, 3) of every free block [m/s2]: gravity and what else pulls on all blocks.
        lines: on the loads, for the user.
        summary: the same numbers, ready for JSON.
        support_of: (B,) the motion that each block follows, -1 for a free block: the assembly's for this run; None without an assembly.
        shocks: of sequences, in order of time.
        pauses: rests that the run loop may end early, see :mod:`loads.kinds.sequence`.
        warnings: of what is likely a mistake in the tables.
        acted: how much of each load that says so has acted by a time.
        forces: on single blocks, which depend on where the blocks are, see ``loads.bars``; None where there are none.
    """

    support_velocity: np.ndarray
    acceleration: np.ndarray
    lines: tuple[str, ...]
    summary: dict[str, Any]
    support_of: np.ndarray | None = None
    shocks: tuple[Shock, ...] = ()
    pauses: tuple[Pause, ...] = ()
    forces: Forces | None = None
    warnings: tuple[str, ...] = ()
    acted: tuple[Acted, ...] = ()

    def load_factor(self, gravity: Sequence[float]) -> np.ndarray:
        """lambda at the times t_k, (N + 1,): body force across gravity over that along it; of a tilt, the tangent of its angle."""
        return load_factors(self.acceleration, np.asarray(gravity, dtype=float))


def build(
    tables: Sequence[Mapping[str, Any]],
    dt: float,
    steps: int,
    gravity: Sequence[float],
    folder: Path,
    assembly: Assembly | None = None,
    longest: float | None = None,
    ties: Sequence[tuple[str, Mapping[str, Any]]] = (),
    own: Sequence[LoadAction] = (),
    fills: Sequence[Fill] = (),
) -> Loading:
    """Sum all [[loads]] tables, and the ties of the structure.

    Args:
        tables: as read from the scene file.
        dt: time step, or the shortest where it adapts [s].
        steps: number of steps N.
        gravity: (3,) [m/s2].
        folder: the scene file's folder, to which paths are relative.
        assembly: the blocks; without them no load may name one.
        longest: the longest step where it adapts [s].
        ties: tables of kind "tie", with what the structure calls them; nothing is said of each of them.
        own: what code in addition to the scene adds.
        fills: of the bridges of the structure.

    Raises:
        InputError: an unknown kind, a bad key, or a bad record file; the faults of all loads together.
    """
    grid = RunGrid(float(dt), int(steps), np.asarray(gravity, dtype=float), Path(folder), assembly, longest, fills)
    every = asked(tables, grid.folder)
    parts = of_each(lambda one: one.kind.part(one.table, grid, one.where), every)
    shaken = not all(one.kind.gentle for one in every)
    filled = [fill.part(each, grid, shaken) for each in fills]
    parts += [*own, *filled]
    if not _given_gravity(every, filled):
        parts.append(KINDS["gravity"].part(GravityTable(), grid, "gravity"))
    tied = [bar(parse_table(TieTable, table, where), grid, where) for where, table in ties]
    forces = Forces.of([*(force for part in parts for force in part.forces), *tied])
    if forces is not None:
        check_ties(forces.ties, grid)
    _check_guides(parts, forces, grid)
    acceleration = np.zeros((grid.steps + 1, 3))
    for part in parts:
        if part.acceleration is not None:
            acceleration += part.acceleration
    velocity, support_of = _support_motions(parts, grid)
    _check_range("supports would move", velocity, FASTEST, "m/s")
    _check_range("blocks would be pulled", acceleration, STRONGEST, "m/s2")
    base = _base(velocity, grid.dt)
    acted = tuple(part.acted for part in parts if part.acted is not None)
    lines = [*(line for part in parts for line in part.lines), *(line for one in acted for line in one.lines(grid.end))]
    if base["end_speed"] > 1e-3 * base["peak_speed"]:
        lines.append(f"base: still moving at {base['end_speed']:.3g} m/s when the run ends at {grid.end:g} s")
    if velocity.shape[1] > 1:
        lines.append(
            f"base: {velocity.shape[1]} motions of the supports, apart by at most {base['largest_difference']:.4g} m; "
            "displacements are relative to the support that moves least"
        )
    if "peak_rotation" in base:
        lines.append(f"base: turns by up to {base['peak_rotation']:.3g} degrees; what is relative to a support turns with it")
    warnings = tuple(line for part in parts for line in part.warnings)
    warnings += tuple(filter(None, (fill.beyond(each, velocity, grid) for each in fills if shaken)))
    summary = {"tables": [part.summary for part in parts], "base": base}
    shocks = sorted((shock for part in parts for shock in part.shocks), key=lambda shock: shock.first)
    pauses = sorted((pause for part in parts for pause in part.pauses), key=lambda pause: pause.first)
    quiet = tuple(pause for pause in pauses if _nothing_changes(pause, velocity, acceleration))
    lines += [f'rest after "{pause.after}": not ended early, since other loads act in it' for pause in pauses if pause not in quiet]
    return Loading(velocity, acceleration, tuple(lines), summary, support_of, tuple(shocks), quiet, forces, warnings, acted)


def end_of(
    tables: Sequence[Mapping[str, Any]], dt: float, gravity: Sequence[float], folder: Path, assembly: Assembly, fills: Sequence[Fill] = ()
) -> tuple[float, float]:
    """When all loads have done what they do, and how long the structure should rest after it [s], for a run that states no duration.

    Raises:
        InputError: no load says when it ends.
    """
    grid = RunGrid(float(dt), 1, np.asarray(gravity, dtype=float), Path(folder), assembly, fills=fills)
    end, rest = 0.0, 0.0
    for one in asked(tables, grid.folder):
        end, rest = max(end, _end(one, grid)), rest if one.kind.slow(one.table) else REST
    if not end > 0.0:
        raise InputError("run.duration", "missing, and no load says how long the run is to last")
    return end, rest


def _end(one: LoadEntry, grid: RunGrid) -> float:
    """When a load has done what it does [s]; 0 of one that acts all along."""
    kind, table, where = one
    if kind.end is not None:
        return kind.end(table, grid, where)
    acted = kind.part(table, grid, where).acted
    if acted is not None and not math.isfinite(acted.end):
        raise InputError("run.duration", f"missing, and {where} has no {acted.measure} at which it stops")
    return 0.0 if acted is None else acted.end


class LoadEntry(NamedTuple):
    """A table of a scene."""

    kind: LoadKind
    table: LoadTable
    where: str  # its place, ``loads[0]``


def asked(tables: Sequence[Mapping[str, Any]], folder: Path) -> list[LoadEntry]:
    """All [[loads]] tables of a scene in a folder, checked.

    Raises:
        InputError: the faults of all of them together.
    """

    def one(at: int) -> LoadEntry:
        table = parse_load(tables[at], f"loads[{at}]", folder)
        return LoadEntry(load_kind(table.kind, f"loads[{at}]", folder), table, f"loads[{at}]")

    return of_each(one, range(len(tables)))


def parse_load(table: Mapping[str, Any], where: str, folder: Path | None = None) -> LoadTable:
    """Validate one table by the model of its kind.

    Raises:
        InputError: an unknown kind or a bad key, named as one of ``where``.
    """
    kind = table.get("kind")
    if kind is None:
        raise InputError(f"{where}.kind", f"missing; kinds: {', '.join(KINDS)}")
    return parse_table(load_kind(str(kind), where, folder).table, table, where)


def shakes(tables: Sequence[Mapping[str, Any]]) -> bool:
    """Return True if one of some tables shakes the base; a settlement moves it once."""
    kinds = [kind_of(table) for table in tables]
    return any(kind is not None and issubclass(kind.table, ShakingTable) for kind in kinds)


def kind_of(table: Mapping[str, Any]) -> LoadKind | None:
    """The kind of a table, ours or that of a package; None of one that is not known."""
    name = str(table.get("kind"))
    return load_kind(name, "loads") if name in KINDS or name in plugins.names("loads") else None


def load_kind(kind: str, where: str, folder: Path | None = None) -> LoadKind:
    """A kind of load: ours, or one that a package adds, or a file in the folder of the scene.

    Raises:
        InputError: no such kind, or something else than a kind.
    """
    if kind in KINDS:
        return KINDS[kind]
    found = plugins.find("loads", kind, f"{where}.kind", KINDS, folder)
    if not (callable(getattr(found, "part", None)) and isinstance(getattr(found, "table", None), type)):
        raise InputError(f"{where}.kind", f'"{kind}" is not a LoadKind(table, part)')
    return found if isinstance(found, LoadKind) else LoadKind(found.table, found.part)


def _nothing_changes(pause: Pause, velocity: np.ndarray, acceleration: np.ndarray) -> bool:
    """True when the base stands still and the body force is constant over a pause, so that it may be ended early."""
    during = slice(pause.first, pause.last + 1)
    return not velocity[during].any() and bool((acceleration[during] == acceleration[pause.first]).all())


def _check_guides(parts: Sequence[LoadAction], forces: Forces | None, grid: RunGrid) -> None:
    """Check pushes by displacement and props together.

    Raises:
        InputError: two that move one block, or one whose inertia would be more than its force.
    """
    wheres = [f"loads[{i}]" for i, part in enumerate(parts) for force in part.forces if isinstance(force, Guide)]
    if forces is not None and grid.assembly is not None and wheres:
        check_together(forces.guides, grid.assembly, wheres)
        check_inertia(forces.guides, forces.points, grid, wheres)


def _given_gravity(every: Sequence[LoadEntry], filled: Sequence[LoadAction]) -> bool:
    """Return True if there is a table of kind gravity.

    Raises:
        InputError: there are several gravities, or one is ramped while a tilt begins to turn it or while fill presses.
    """
    falls = [(one.where, one.table) for one in every if isinstance(one.table, GravityTable)]
    tilts = [(one.where, one.table) for one in every if isinstance(one.table, TiltTable)]
    if len(falls) > 1:
        raise InputError(falls[1][0], f"gravity is given twice, first in {falls[0][0]}")
    for where, table in falls:
        if table.ramp > 0.0 and any(part.summary["pressure"] > 0.0 for part in filled):
            raise InputError(f"{where}.ramp", "fill presses in full from the start, on walls that have no weight yet; leave the ramp out")
        early = next((place for place, tilt in tilts if table.ramp > (0.0 if tilt.initial > 0.0 else tilt.start)), "")
        if early:
            raise InputError(early, f"gravity is ramped over {table.ramp:g} s; begin the tilt after that, from an initial angle of 0")
    return bool(falls)


def _check_range(what: str, values: np.ndarray, most: float, unit: str) -> None:
    """Refuse motions beyond what anything that is built meets, which are mistaken units or damaged files.

    Raises:
        InputError: names the largest value and the limit.
    """
    largest = float(np.abs(values).max(initial=0.0))
    if not largest <= most:
        asked = f"{largest:.3g} {unit}, at most {most:g} are allowed"
        raise InputError("loads", f"the {what} at up to {asked}: check units and factors")


def _base(velocity: np.ndarray, dt: float) -> dict[str, Any]:
    """Numbers of the base's motions on the run's own steps, where positions follow the trapezoidal rule (theta 0.5)."""
    turned = 0.5 * dt * np.abs(np.cumsum(velocity[1:, :, 3:] + velocity[:-1, :, 3:], axis=0)).max(initial=0.0)
    velocity = velocity[..., :3]
    moved = np.zeros_like(velocity)
    np.cumsum(0.5 * dt * (velocity[1:] + velocity[:-1]), axis=0, out=moved[1:])
    speed = np.sqrt((velocity**2).sum(axis=2).max(axis=1))
    apart = moved.max(axis=1) - moved.min(axis=1)
    return {
        "motions": velocity.shape[1],
        "peak_speed": float(speed.max()),
        "end_speed": float(speed[-1]),
        "peak_displacement": [float(d) for d in np.abs(moved).max(axis=(0, 1))],
        "end_displacement": [float(d) for d in moved[-1, 0]],
        "largest_difference": float(np.sqrt((apart**2).sum(axis=1)).max()),
    } | ({"peak_rotation": math.degrees(turned)} if turned else {})


def _support_motions(parts: Sequence[LoadAction], grid: RunGrid) -> tuple[np.ndarray, np.ndarray | None]:
    """The distinct motions of the supports and which block follows which.

    Args:
        parts: what the tables contribute.
        grid: the run.

    Returns:
        Velocities (N + 1, S, 3) [m/s], or (N + 1, S, 6) where one turns, and ``support_of`` (B,), -1 for a free block;
        None without an assembly.

    Raises:
        InputError: more motions than memory should be required.
    """
    moving = [each for part in parts for each in (part, *part.more) if each.motion is not None]
    turning = _turning(moving, grid)
    delays, shares, of, support_of = _distinct(moving, turning, grid)
    size = 8.0 * (6 if turning else 3) * (grid.steps + 1) * len(delays)
    if size > LARGEST:
        many = f"{len(delays)} supports that each move on their own take {size / 1e9:.1f} GB over {grid.steps} steps"
        raise InputError("loads", f"{many}; name fewer groups, or shorten the run")
    velocity = np.zeros((grid.steps + 1, len(delays), 3))
    for i, part in enumerate(moving):
        assert part.motion is not None
        done: dict[float, np.ndarray] = {}
        for s, (delay, share) in enumerate(zip(delays[:, i], shares[:, i], strict=True)):
            if share == 0.0:
                continue
            if delay not in done:
                done = {delay: part.motion(grid.times - delay)}  # only the last is kept: rows are sorted by delay
            velocity[:, s] += share * done[delay]
    return (_with_rotation(velocity, of, turning, grid) if turning else velocity), support_of


def _turning(parts: Sequence[LoadAction], grid: RunGrid) -> dict[int, Turning]:
    """How supports turn, by their numbers.

    Raises:
        InputError: one that turns twice.
    """
    out: dict[int, Turning] = {}
    for part in parts:
        if part.turning is not None and part.share is not None and grid.assembly is not None:
            for b in np.flatnonzero(part.share).tolist():
                if b in out:
                    raise InputError("loads", f'"{grid.assembly.names[b]}" is turned twice; one load may turn it, others may shift it')
                out[b] = part.turning
    return out


def _with_rotation(velocity: np.ndarray, of: Sequence[int], turning: Mapping[int, Turning], grid: RunGrid) -> np.ndarray:
    """Motions (N + 1, S, 6) of which each is that of a support, S, by the velocities (N + 1, S, 3) next to what turning adds."""
    out = np.pad(velocity, ((0, 0), (0, 0), (0, 3)))
    turned = {id(each): each.on(grid) for each in turning.values()}
    for s, block in enumerate(of):
        if block in turning:
            each, found = turning[block], turned[id(turning[block])]
            out[:, s, 3:] = found.velocity
            if each.about is not None:
                out[:, s, :3] += found.of_arm(grid.blocks("loads").centre[block] - each.about, grid.dt)
    return out


def _distinct(
    parts: Sequence[LoadAction], turning: Mapping[int, Turning], grid: RunGrid
) -> tuple[np.ndarray, np.ndarray, Sequence[int], np.ndarray | None]:
    """Delays and shares of the distinct motions by table, (S, tables) each, a block of each (S,), and the motion of each block (B,)."""
    assembly, n = grid.assembly, len(parts)
    if assembly is None or not assembly.fixed.any():
        support_of = None if assembly is None else np.full(assembly.count, -1)
        return np.zeros((1, n)), np.ones((1, n)), [-1], support_of
    fixed = np.flatnonzero(assembly.fixed)
    table = np.zeros((len(fixed), 2 * n + 1))  # a last column, zero but of supports that turn, which have motions of their own
    table[:, -1] = [1.0 + b if b in turning else 0.0 for b in fixed.tolist()]
    for i, part in enumerate(parts):
        table[:, i] = 0.0 if part.delay is None else part.delay[fixed]
        table[:, n + i] = 1.0 if part.share is None else part.share[fixed]
    rows, first, index = np.unique(table, axis=0, return_index=True, return_inverse=True)
    support_of = np.full(assembly.count, -1)
    support_of[fixed] = index.ravel()
    return rows[:, :n], rows[:, n : 2 * n], fixed[first].tolist(), support_of
