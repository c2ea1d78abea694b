# SPDX-License-Identifier: GPL-3.0-or-later
"""Account: the energy balance of a run, closed in each step.

With mean velocities over the step, v = (v_old + v_new) / 2, it is exact for theta = 1/2 up to the turning of the inertia:

    kinetic + elastic + friction + impact + damping + bond + crushing + ground + radiation  =
        work of the supports and of guides (driving.py) + work of gravity + work of point loads and ties + changes  (+ balance)

The kinetic energy changes by p . H v, which is the relative motion of the contacts (lost in friction and impacts) less the part of the
supports' own motion (work of the base). What a tie stores in its stretch counts as work until it gives it back. elastic is the energy of
the springs of elastic joints and of blocks that deform, damping what these lost to their dashpots, to their theta, in breaking and where a
joint passes to another face, whose springs begin without force; bond is what bonds that soften took (softening.py), crushing what joints
take that are shortened for good. ground is the energy of the springs below footings, radiation what the dashpots there take
(founding.py). changes is what is put in with blocks and joints that become others (stage.py), and below zero what is taken out.
correction is the work of lifting blocks out of overlaps, next to the balance.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows, Velocities, support_velocity
from masonry_cd.mechanics.dynamics.driving import work_of_guides
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES, LOSSES, WORKS
from masonry_cd.mechanics.dynamics.new_state import Update
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import EnergyBalance, MotionState, System
from masonry_cd.mechanics.friction.contact_geometry import velocity_between
from masonry_cd.mechanics.model.state import State

NONE_ELASTIC = np.zeros(0, dtype=np.bool_)


def at_start(system: System, state: State, angular_momentum: np.ndarray) -> EnergyBalance:
    """The account of a run that begins in a state with angular momenta (B, 3): all totals zero."""
    velocity = state.velocity[system.free]
    linear = np.sum(system.assembly.mass[system.free] * (velocity[:, :3] ** 2).sum(axis=1))
    kinetic = 0.5 * float(linear + np.sum(angular_momentum[system.free] * velocity[:, 3:]))
    return EnergyBalance(dict.fromkeys(ENERGIES, 0.0), kinetic)


def account(system: System, last: MotionState, made: StepProblem, impulse: np.ndarray, new: Update) -> EnergyBalance:
    """Add the work and the losses of a step to the account of the run; ``impulse`` (C, m) is that of the step [N s]."""
    predicted, loads, totals, begun = made.predicted, made.predicted.loads, dict(last.energy.totals), last.energy.begun
    elastic = NONE_ELASTIC if made.springs is None else made.springs.elastic
    before, after = Velocities(last.v, loads.support_before), Velocities(new.v, loads.support_after)
    weights = WorkWeights(system.free_mass, loads.acceleration, last.state.position, new.state.position, new.lifted)
    friction, impact, base, gravity, correction = works(made.rows, elastic, impulse, before, after, weights)
    if predicted.carried_impulse is not None:
        impact -= 0.5 * float(np.sum(predicted.carried_impulse * (last.v + new.v)))
    if predicted.linked is not None:
        mean, support = 0.5 * (last.v + new.v), 0.5 * (loads.support_before + loads.support_after)
        by_links, lost = predicted.linked.work(system, made.link_impulse(impulse, new.v), mean, support)
        base, impact = base + by_links, impact + lost
    ground = new.ground
    stored = totals["elastic"] - new.strains.before if last.steps else new.springs.before
    if last.energy.changed and last.steps:
        totals["change_work"] += new.springs.before - stored
        stored = new.springs.before
    if system.laws is not None:
        begun += new.springs.before if last.steps == 0 else 0.0
        _book_springs(totals, new, stored)
    totals["elastic"] = new.springs.after + new.strains.elastic
    totals["ground"] = ground.after
    totals["damping"] += new.strains.lost + ground.damping
    totals["radiation"] += ground.radiated
    begun += new.strains.before + ground.before if last.steps == 0 else 0.0
    totals["kinetic"] = new.kinetic
    totals["friction"] += friction
    totals["impact"] += impact
    totals["base_work"] += base + work_of_guides(predicted.driven, last.v, new.v) + ground.base
    totals["gravity_work"] += gravity
    totals["correction"] -= correction
    if predicted.force_impulse is not None:
        totals["force_work"] += 0.5 * float(np.sum(predicted.force_impulse * (last.v + new.v)))
    totals["balance"] = begun + sum(map(totals.__getitem__, WORKS)) - sum(map(totals.__getitem__, LOSSES))
    return EnergyBalance(totals, begun)


def _book_springs(totals: dict[str, float], new: Update, elastic: float) -> None:
    """Book what the springs did; ``elastic`` is their energy before the step [J]."""
    work = new.springs
    totals["friction"] += work.friction
    totals["bond"] += work.bond
    totals["crushing"] += work.crushing
    totals["damping"] += work.taken - work.friction - work.bond - work.crushing - (work.after - elastic)


class WorkWeights(NamedTuple):
    """Weights on which a body acceleration works: B blocks that have moved, lifted out of overlaps or not."""

    mass: np.ndarray  # (B,) [kg]; 0: a support
    acceleration: np.ndarray  # (3,) [m/s2]
    begin: np.ndarray  # (B, 3) positions at the beginning of the step [m]
    end: np.ndarray  # (B, 3) at its end
    lifted: np.ndarray  # (B, 3) of that way out of overlaps; (0, 3): none was


@entry()
def works(
    rows: ContactRows, elastic: np.ndarray, impulse: np.ndarray, before: Velocities, after: Velocities, weights: WorkWeights
) -> tuple[float, float, float, float, float]:
    """Return the losses of rigid contacts in friction and impacts, the work of the supports, of the weights, and of these in lifting [J].

    elastic (C,) bool: springs, whose losses are not counted here, (0,) if there are none; impulses (C, m) [N s]; velocities at the
    beginning and the end of the step.
    """
    v, velocity = 0.5 * (before.free + after.free), 0.5 * (before.support + after.support)
    friction, impact, base_work = 0.0, 0.0, 0.0
    for c in range(impulse.shape[0]):
        motion, base = velocity_between(rows.bodies, rows.geometry, c, v), support_velocity(rows, c, velocity)
        for i in range(impulse.shape[1]):
            if not (len(elastic) and elastic[c]):
                if i == 0:
                    impact -= impulse[c, i] * (motion[i] + base[i])
                else:
                    friction -= impulse[c, i] * (motion[i] + base[i])
            base_work -= impulse[c, i] * base[i]
    begin, end, lifted, a = weights.begin, weights.end, weights.lifted, weights.acceleration
    work, lifting = 0.0, 0.0
    for b in range(len(begin)):
        x, y, z = end[b, 0] - begin[b, 0], end[b, 1] - begin[b, 1], end[b, 2] - begin[b, 2]
        if len(lifted):
            x, y, z = x - lifted[b, 0], y - lifted[b, 1], z - lifted[b, 2]
            lifting += weights.mass[b] * (lifted[b, 0] * a[0] + lifted[b, 1] * a[1] + lifted[b, 2] * a[2])
        work += weights.mass[b] * (x * a[0] + y * a[1] + z * a[2])
    return friction, impact, base_work, work, lifting
