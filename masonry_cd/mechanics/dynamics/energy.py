"""Account: the energy balance of a run, closed in each step.

With mean velocities over the step, v = (v_old + v_new) / 2, it is exact for theta = 1/2 up to the turning of the inertia:

    kinetic + elastic + friction + impact + damping  =
        work of the supports + work of gravity + work of point loads and ties  (+ balance, what is left over)

The kinetic energy changes by p . H v, which is the relative motion of the contacts (lost in friction and impacts) less the part of the
supports' own motion (work of the base). What a tie stores in its stretch counts as work until it gives it back. elastic is the energy of
the springs of elastic joints and of blocks that deform, damping what these lost to their dashpots, to their theta, in breaking and where a
joint passes to another face, whose springs begin without force.
correction is the work of lifting blocks out of overlaps, beside the balance.
"""

from __future__ import annotations

import numpy as np

from masonry_cd.foundation.jit import entry
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows, Velocities
from masonry_cd.mechanics.dynamics.new_state import Update
from masonry_cd.mechanics.dynamics.relative_velocity import of_bodies, of_supports
from masonry_cd.mechanics.dynamics.step_problem import StepProblem
from masonry_cd.mechanics.dynamics.system import EnergyBalance, Motion, System
from masonry_cd.mechanics.model.state import State

ENERGIES = (
    "kinetic", "elastic", "friction", "impact", "damping", "base_work", "gravity_work", "force_work", "correction", "balance",
)  # fmt: skip
WORKS = ("base_work", "gravity_work", "force_work")  # what is put in
NONE_ELASTIC = np.zeros(0, dtype=np.bool_)
LOSSES = ("kinetic", "elastic", "friction", "impact", "damping")  # where it went


def at_start(system: System, state: State, angular_momentum: np.ndarray) -> EnergyBalance:
    """The account of a run that begins in a state with angular momenta (B, 3): all totals zero."""
    velocity = state.velocity[system.free]
    linear = np.sum(system.assembly.mass[system.free] * (velocity[:, :3] ** 2).sum(axis=1))
    kinetic = 0.5 * float(linear + np.sum(angular_momentum[system.free] * velocity[:, 3:]))
    return EnergyBalance(dict.fromkeys(ENERGIES, 0.0), kinetic)


def account(system: System, last: Motion, made: StepProblem, impulse: np.ndarray, new: Update) -> EnergyBalance:
    """Add the work and the losses of a step to the account of the run; ``impulse`` (C, m) is that of the step [N s]."""
    predicted, loads, totals, begun = made.predicted, made.predicted.loads, dict(last.energy.totals), last.energy.begun
    elastic = NONE_ELASTIC if made.springs is None else made.springs.elastic
    before, after = Velocities(last.v, loads.support_before), Velocities(new.motion.v, loads.support_after)
    friction, impact, base = dissipation(made.rows, elastic, impulse, before, after)
    if predicted.carried_impulse is not None:
        impact -= 0.5 * float(np.sum(predicted.carried_impulse * (last.v + new.motion.v)))
    if system.laws is not None:
        begun += new.springs.before if last.steps == 0 else 0.0
        _book_springs(totals, new, totals["elastic"] - new.strains.before if last.steps else new.springs.before)
    totals["elastic"] = new.springs.after + new.strains.elastic
    totals["damping"] += new.strains.lost
    begun += new.strains.before if last.steps == 0 else 0.0
    moved = new.motion.state.position - last.state.position
    if new.lifted is not None:
        moved = moved - new.lifted
        totals["correction"] -= work_of_weight(system.assembly.mass, new.lifted, loads.acceleration)
    totals["kinetic"] = new.kinetic
    totals["friction"] += friction
    totals["impact"] += impact
    totals["base_work"] += base
    totals["gravity_work"] += work_of_weight(system.free_mass, moved, loads.acceleration)
    if predicted.force_impulse is not None:
        totals["force_work"] += 0.5 * float(np.sum(predicted.force_impulse * (last.v + new.motion.v)))
    totals["balance"] = begun + sum(totals[name] for name in WORKS) - sum(totals[name] for name in LOSSES)
    return EnergyBalance(totals, begun)


def _book_springs(totals: dict[str, float], new: Update, elastic: float) -> None:
    """Book what the springs did; ``elastic`` is their energy before the step [J]."""
    work = new.springs
    totals["friction"] += work.friction
    totals["damping"] += work.taken - work.friction - (work.after - elastic)


@entry()
def work_of_weight(mass: np.ndarray, moved: np.ndarray, acceleration: np.ndarray) -> float:
    """Work [J] of a body acceleration (3,) on masses (B,) that are moved by (B, 3) [m]."""
    work = 0.0
    for b in range(len(mass)):
        work += mass[b] * (moved[b, 0] * acceleration[0] + moved[b, 1] * acceleration[1] + moved[b, 2] * acceleration[2])
    return work


@entry()
def dissipation(
    rows: ContactRows, elastic: np.ndarray, impulse: np.ndarray, before: Velocities, after: Velocities
) -> tuple[float, float, float]:
    """What rigid contacts lost in friction and in impacts, and the work of the supports, over a step: three numbers [J].

    elastic (C,) bool: springs, whose losses are not counted here, (0,) if there are none; impulses (C, m) [N s]; velocities at the
    beginning and the end of the step.
    """
    bodies, supports, jacobian, frame = rows.bodies, rows.supports, rows.jacobian, rows.frame
    v, velocity = 0.5 * (before.free + after.free), 0.5 * (before.support + after.support)
    friction, impact, base_work = 0.0, 0.0, 0.0
    for c in range(impulse.shape[0]):
        for i in range(impulse.shape[1]):
            motion = of_bodies(bodies, jacobian, c, i, v, 0.0)
            base = of_supports(supports, frame, c, i, velocity, 0.0)
            if not (len(elastic) and elastic[c]):
                if i == 0:
                    impact -= impulse[c, i] * (motion + base)
                else:
                    friction -= impulse[c, i] * (motion + base)
            base_work -= impulse[c, i] * base
    return friction, impact, base_work
