# SPDX-License-Identifier: GPL-3.0-or-later
r"""Bonds that soften: how their damage enters a step, and how it is carried over it.

**The law.** Of the area A of a contact the share 1 - D is bonded and the share D is dry (Alfano & Sacco, Int. J. Numer. Methods Eng. 68,
2006): the bonded one is a spring both ways, the dry one a spring that does not pull, with Coulomb's friction. So compression always has
the whole stiffness, tension (1 - D) k_n, and the bond unloads to the origin. D follows the curve of ``cohesive_curve.py`` by the slip
beyond mu sigma / k_t: under a pressure sigma the shear stress is that of the bond plus mu sigma, at its peak c + mu sigma.

**The step.** The two shares are two contacts at one point, and D is held while the step is solved. So the problem is one of springs and
dry contacts as always: it has a solution whatever the softening, and no solver knows of it. The D held is that at the place of the
generalised midpoint rule, extrapolated along the curve from the last step (an internal variable extrapolated, the step solved, the law
integrated from its result: IMPL-EX, Oliver, Huespe & Cante, Comput. Methods Appl. Mech. Engrg. 197, 2008). Where the bond turns out to
carry more than NEAR of its strength above the curve at that place, at the onset or where it breaks at once, the step is solved again with
the D that its result asks for, no less than before: D grows to 1 at the most, so this ends. After ROUNDS the D reached is held.

**After it** D is that of the separation at the end of the step. What the bond took is the area between two places on the curve; what
friction took where bonded area became dry under pressure is friction; what else the step lost, or gained, is damping. It vanishes with the
length of the step, by an order between one and two for theta = 1/2, and by the first, that of the springs, above.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.bonds import BondMemory, Bonds
from masonry_cd.mechanics.dynamics.cohesive_curve import Curves, Mix
from masonry_cd.mechanics.dynamics.joint_law import JointMemory, LawSprings
from masonry_cd.mechanics.dynamics.step_problem import Solved, SpringWork, StepProblem
from masonry_cd.mechanics.dynamics.system import MotionState, System

NEAR = 0.02  # of the strength, by which the stress of a step may be above the curve
ROUNDS = 6  # solutions of a step at the most
INTACT = 1e-3  # of what is bonded at the beginning of a step stays so within it, at the least


# --- into the step -----------------------------------------------------------------------------------------------------------


class Start(NamedTuple):
    """The contacts of a step that have some bond, H of the N found."""

    on: np.ndarray  # (H,) which of the contacts found
    curves: Curves
    damage: np.ndarray  # (H,) D at the beginning of the step
    share: np.ndarray  # (H,) D held in it
    spent: np.ndarray  # (H,)
    mix: Mix  # at the beginning
    slip: np.ndarray  # (H, 3) of the bond in the frame of the antagonist [m]
    size: np.ndarray  # (H,) of that


def split(
    system: System, last: MotionState, found: ContactSet, bonding: float, least: np.ndarray | None
) -> tuple[MotionState, ContactSet, Bonds]:
    """The contacts found with those twice that are in part dry, the last motion by these contacts, and their bonds.

    ``bonding``: gaps up to which new contacts are bonded [m]; ``least``: damage to hold of each contact found, or more; None: as computed.
    """
    first = np.flatnonzero(~last.bonds.twin)
    old = np.where(found.previous >= 0, first[np.minimum(found.previous, len(first) - 1)], -1)
    start = _start(system, last, found, old, bonding, least)
    twice = np.zeros(len(old), dtype=bool)
    twice[start.on] = start.share > 0.0
    place = np.cumsum(1 + twice) - 1 - twice  # of the first copy
    taken = np.repeat(np.arange(len(old)), 1 + twice)
    twin, dry, held = np.zeros(len(taken), dtype=bool), np.flatnonzero(start.share > 0.0), place[start.on]
    twin[held[dry] + 1] = True
    had = (old >= 0) & np.append(last.bonds.twin, False)[old + 1]  # a dry share in the last step
    source = np.where(twin, np.where(had, old + 1, -1)[taken], old[taken])

    def carried(array: np.ndarray) -> np.ndarray:
        return np.where((source >= 0).reshape(-1, *[1] * (array.ndim - 1)), array[source], array.dtype.type(0))

    joints = JointMemory(*[carried(array) for array in last.joints])
    joints.slip[held[dry] + 1] = _dry_slip(start, dry, had[start.on[dry]], joints.slip[held[dry] + 1])
    joints.bonded[twin], joints.bonded[held] = False, True
    area = found.area[taken]
    area[held] *= 1.0 - start.share
    area[held[dry] + 1] *= start.share[dry]
    softens = _softens(system, found)
    follows = (old >= 0) | softens  # a new one of a joint that softens is what its damage says, bonded or dry
    copies = ContactSet(*[array[taken] for array in found])
    copies = copies._replace(area=area, previous=np.where(follows[taken], np.arange(len(taken)), -1))
    motion = last._replace(impulse=carried(last.impulse), false_slip=carried(last.false_slip), joints=joints)
    if len(last.approach):
        motion = motion._replace(approach=carried(last.approach))
    left = (1.0 - start.share) * (1.0 + start.mix.rho * start.curves.place(start.share, start.mix.rho))
    bonds = Bonds(taken, twin, held, start.curves, start.damage, start.share, start.curves.bound * left, start.spent, motion.false_slip)
    return motion, copies, bonds


def _softens(system: System, found: ContactSet) -> np.ndarray:
    """(N,) bool: contacts whose joint has a bond that softens, or had one."""
    return np.asarray((system.assembly.laws.fracture[system.assembly.rows(*found.bodies.T)] > 0.0) & (found.area > 0.0))


def _start(system: System, last: MotionState, found: ContactSet, old: np.ndarray, bonding: float, least: np.ndarray | None) -> Start:
    """The bonds at the beginning of a step, and the damage to hold in it; ``old`` (N,): contacts in the last motion, -1: new ones."""
    new = np.where(found.gap <= bonding, 0.0, 1.0)
    damage = np.where(_softens(system, found), np.where(old >= 0, last.bonds.damage[old], new), 1.0)
    on = np.flatnonzero(damage < 1.0)
    at, known, groups, damage = old[on], old[on] >= 0, system.assembly.rows(*found.bodies[on].T), damage[on]
    stretch, growth, spent = (np.where(known, array[at], 0.0) for array in (last.bonds.stretch, last.bonds.growth, last.bonds.spent))
    slip = np.where(known[:, None], last.joints.slip[at], 0.0)
    size = np.sqrt((slip**2).sum(axis=1))
    curves = Curves.of(system.assembly.laws, system.assembly.friction, groups)
    mix = curves.mix(stretch, size)
    ahead = curves.place(damage, mix.rho) + system.assembly.laws.theta[groups] * growth
    share = np.where(growth > 0.0, np.maximum(damage, curves.damage(ahead, mix.rho)), damage)
    share = np.minimum(share if least is None else np.maximum(share, least[on]), 1.0 - INTACT * (1.0 - damage))
    return Start(on, curves, damage, share, spent, mix, slip, size)


def _dry_slip(start: Start, dry: np.ndarray, had: np.ndarray, slip: np.ndarray) -> np.ndarray:
    """Elastic slip (D, 3) of dry shares in a step [m]: where one ``had`` a slip, that of its area, and of what area becomes dry in the step
    the slip of the bond, cut back to what friction bears."""
    cut = (_kept(start.mix.held, start.size)[:, None] * start.slip)[dry]
    before = np.where(had, np.minimum(1.0, start.damage[dry] / start.share[dry]), 0.0)[:, None]
    return before * slip + (1.0 - before) * cut


def _kept(most: np.ndarray, size: np.ndarray) -> np.ndarray:
    """Share (H,) of slips of some sizes that stays where friction bears slips up to ``most`` [m]."""
    return np.minimum(1.0, np.divide(most, size, out=np.ones(len(size)), where=size > 0.0))


def bounded(bonds: Bonds, springs: LawSprings, active: np.ndarray, step: float) -> LawSprings:
    """The springs of the contacts ``active`` (C,) with the cones of the bonds, in a step of length h [s]."""
    which, row = bonds.rows(active)
    bond = springs.bond.copy()
    bond[row] = step * bonds.bound[which] * springs.area[row] / (1.0 - bonds.share[which])
    return springs._replace(bond=bond)


def solve_softening(system: System, attempt: Callable[[np.ndarray | None], tuple[StepProblem, Solved]]) -> tuple[StepProblem, Solved]:
    """Solve a step by attempts, each with the least damage (N,) of the contacts found, None in the first; its problem, and the solution."""
    made, solved = attempt(None)
    for _ in range(ROUNDS - 1):
        least = _asked_for(system, made, made.velocity(solved.solution.impulse))
        if least is None:
            break
        made, solved = attempt(least)
    return made, solved


def _asked_for(system: System, made: StepProblem, v: np.ndarray) -> np.ndarray | None:
    """The damage (N,) that contacts have to have where a bond carries too much, for velocities (F, n) at the end; None: none does."""
    bonds, parted = made.bonds, _parted(system, made, v)
    assert bonds is not None
    theta, which = parted.theta, parted.which
    stretch = (1.0 - theta) * parted.stretch[0] + theta * parted.stretch[1]
    slip = (1.0 - theta)[:, None] * parted.slip[0] + theta[:, None] * parted.slip[1]
    curves, share = bonds.curves.some(which), bonds.share[which]
    mix = curves.mix(stretch, np.sqrt((slip**2).sum(axis=1)))
    above = (1.0 - share) * (1.0 + mix.rho * mix.r) - curves.strength(mix.r)
    wrong = (mix.r > 0.0) & (above > NEAR) & (1.0 - share > 1.5 * INTACT * (1.0 - bonds.damage[which]))
    if not wrong.any():
        return None
    out = np.zeros(len(bonds.of_detector(bonds.taken)))
    out[bonds.taken[bonds.held]] = bonds.share
    out[bonds.taken[bonds.held[which[wrong]]]] = curves.damage(mix.r, mix.rho)[wrong]
    return out


# --- and out of it -----------------------------------------------------------------------------------------------------------


class Parted(NamedTuple):
    """How far the bonded shares of R rows came apart in a step: at its beginning and at its end, between two q_m."""

    which: np.ndarray  # (R,) of the bonds
    row: np.ndarray  # (R,) of the problem
    theta: np.ndarray  # (R,) of the springs
    stretch: tuple[np.ndarray, np.ndarray]  # (R,) each [m]
    slip: tuple[np.ndarray, np.ndarray]  # (R, m - 1) each [m]
    speed: np.ndarray  # (R, m) relative velocity, mean over the step [m/s]


def _parted(system: System, made: StepProblem, v: np.ndarray) -> Parted:
    """Return the separations of the bonds in a step that ended with velocities (F, n)."""
    bonds, springs, rows, h = made.bonds, made.springs, made.rows, system.constants.step
    assert bonds is not None
    assert springs is not None
    which, row = bonds.rows(rows.active)
    gap, before, group = made.found.gap[rows.active[row]], springs.before[row], rows.groups[row]
    u = replace(made.problem, offset=rows.offset).subset(row).relative_velocity(v)
    u[:, 0] -= np.where(gap > system.constants.closed, gap / h, 0.0)
    theta = system.assembly.laws.theta[group[:, 0], group[:, 1]]
    ends = gap - (1.0 - theta) * h * before[:, 0], gap + theta * h * u[:, 0]
    slip, along = springs.slip[row], theta[:, None]
    moved = h * (along * u[:, 1:] + (1.0 - along) * before[:, 1:])
    return Parted(which, row, theta, ends, (slip, slip + moved), 0.5 * (before + u))


def soften(
    system: System, made: StepProblem, v: np.ndarray, impulse: np.ndarray, memory: JointMemory, work: SpringWork
) -> tuple[BondMemory, SpringWork]:
    """Carry the bonds over a step: what they hand on, and what all springs did, with ``work`` of the others; ``memory`` gets their slips.

    Velocities (F, n) at the end of the step, its impulses (C, m) [N s].
    """
    bonds, springs, parted = made.bonds, made.springs, _parted(system, made, v)
    assert bonds is not None
    assert springs is not None
    which, row, curves, share = parted.which, parted.row, bonds.curves.some(parted.which), bonds.share[parted.which]
    size = [np.sqrt((slip**2).sum(axis=1)) for slip in parted.slip]
    begin, end = (curves.mix(stretch, long) for stretch, long in zip(parted.stretch, size, strict=True))
    before = bonds.damage[which]
    damage = np.maximum(before, curves.damage(end.r, end.rho))
    there = curves.place(before, end.rho)
    gone = np.maximum(there, end.r)
    taken = np.where(damage > before, curves.taken(gone, end.rho) - curves.taken(there, end.rho), 0.0)
    spent = np.where(damage < 1.0, np.minimum(1.0, bonds.spent[which] + taken), 1.0)
    out = BondMemory.of(bonds)
    k = bonds.held[which]
    out.damage[k], out.spent[k], out.stretch[k] = damage, spent, parted.stretch[1]
    out.growth[k] = np.where(damage > before, gone - there, 0.0)
    kept = _kept(end.held, size[1])
    _remember_slips(made, parted, kept, damage, memory)

    area = springs.area[row] / (1.0 - share)
    across, along = area * curves.normal, area * curves.tangential
    least = np.minimum(end.held, size[1])
    rubbed = float((along * least * 0.5 * (begin.slip + end.slip) * (damage - before)).sum())
    pull = [0.5 * (across * stretch**2 + along * long**2) for stretch, long in zip(parted.stretch, size, strict=True)]
    dry = 0.5 * (across * np.minimum(0.0, parted.stretch[1]) ** 2 + along * least**2)
    return out, work._replace(
        taken=work.taken - float((impulse[row] * parted.speed).sum()),
        friction=work.friction + rubbed,
        before=work.before + float(((1.0 - share) * pull[0]).sum()),
        after=work.after + float(((1.0 - damage) * pull[1] + (damage - share) * dry).sum()),
        bond=float((area * end.energy * taken).sum()),
    )


def _remember_slips(made: StepProblem, parted: Parted, kept: np.ndarray, damage: np.ndarray, memory: JointMemory) -> None:
    """Put the slips of bonds into ``memory``, and of area that became dry the share that friction ``kept`` (R,) bears."""
    bonds, rows, row = made.bonds, made.rows, parted.row
    assert bonds is not None
    k, turn = bonds.held[parted.which], made.predicted.rotation[rows.blocks[row, 1]]
    world = (parted.slip[1][:, :, None] * rows.frame[row, 1 : parted.slip[1].shape[1] + 1]).sum(axis=1)
    slip = (turn * world[:, :, None]).sum(axis=1)
    cut, share = kept[:, None] * slip, bonds.share[parted.which]
    had = np.append(bonds.twin, False)[k + 1]
    old = np.where(had, share / np.maximum(damage, share).clip(1e-300), 0.0)[:, None]
    dry = old * memory.slip[np.where(had, k + 1, k)] + (1.0 - old) * cut
    memory.slip[k + had] = dry
    memory.slip[k] = np.where((damage < 1.0)[:, None], slip, dry)
    memory.bonded[k] = damage < 1.0
