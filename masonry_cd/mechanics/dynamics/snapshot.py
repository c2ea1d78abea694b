# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of a checkpoint: the motion of the last step, and the memories of detector and solver by their prefixes."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from masonry_cd.foundation.arrays import Stored
from masonry_cd.mechanics.dynamics.bonds import BondMemory
from masonry_cd.mechanics.dynamics.energy_terms import ENERGIES
from masonry_cd.mechanics.dynamics.joint_law import JointMemory
from masonry_cd.mechanics.dynamics.system import NO_APPROACH, NO_BONDS, EnergyBalance, MotionState, System
from masonry_cd.mechanics.model.state import State


def prefixed(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Put arrays under ``prefix/name``."""
    return {f"{prefix}/{name}": array for name, array in arrays.items()}


def part(prefix: str, arrays: Mapping[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays under ``prefix/``, without it."""
    head = prefix + "/"
    return {name.removeprefix(head): array for name, array in arrays.items() if name.startswith(head)}


def motion_arrays(motion: MotionState, load_step: int) -> dict[str, np.ndarray]:
    """A motion, after ``load_step`` steps of the loads, as arrays."""
    m = motion
    out = {name: getattr(m.state, name) for name in ("position", "orientation", "velocity")}
    out |= {"angular_momentum": m.angular_momentum, "v": m.v, "impulse": m.impulse, "false_slip": m.false_slip}
    out["yielded"] = m.yielded
    out["steps"] = np.array([m.steps, load_step, m.ticks, m.span])
    out["energy"] = np.array([m.energy.changed, m.energy.begun, *(m.energy.totals[name] for name in ENERGIES)])
    if len(m.state.strain):
        out["strain"] = m.state.strain
    if m.carried_impulse is not None:
        out["carried_impulse"] = m.carried_impulse
    if len(m.approach):
        out["approach"] = m.approach
    return out | prefixed("joints", m.joints._asdict())


def check_motion(stored: Stored, system: System, motion: MotionState, contacts: int) -> None:
    """Check what :func:`restored_motion` takes: arrays of a run whose motions are of the shapes of ``motion``, with some contacts.

    Raises:
        InputError: an array that no run of this scene leaves.
    """
    blocks, (free, unknowns) = system.assembly.count, motion.v.shape
    stored.real("position", blocks, 3)
    stored.real("velocity", blocks, 6)
    stored.real("angular_momentum", blocks, 3)
    if np.abs((stored.real("orientation", blocks, 4) ** 2).sum(axis=1) - 1.0).max(initial=0.0) > 1e-6:
        stored.refuse("orientation", "not unit quaternions")
    if system.strains is not None:
        stored.real("strain", *motion.state.strain.shape)
    stored.real("v", free, unknowns)
    stored.real("impulse", max(1, contacts), system.rows)
    stored.real("false_slip", max(1, contacts), system.rows - 1)
    if stored.holds("carried_impulse"):
        stored.real("carried_impulse", free, unknowns)
    if stored.holds("approach"):
        stored.real("approach", max(1, contacts))
    steps, load_step, ticks, span = stored.whole("steps", 4, high=len(system.loads.acceleration)).tolist()
    if not (steps <= ticks <= load_step and span in system.settings.spans):
        stored.refuse("steps", "out of range")
    stored.real("yielded", len(motion.tensions))
    stored.real("energy", 2 + len(ENERGIES), finite=False)
    joints = stored.part("joints")
    remembered = 1 if system.laws is None else max(1, contacts)
    joints.real("slip", remembered, 3)
    joints.flags("bonded", remembered)
    joints.real("area", remembered)
    joints.real("place", remembered, 3)
    joints.check_all_read()


def restored_motion(arrays: Mapping[str, np.ndarray], tick: float, tensions: np.ndarray) -> tuple[MotionState, int]:
    """The motion of :func:`motion_arrays` and the step of the loads, with ticks of some length [s] and tensions of the ties (T,) [N]."""
    steps, load_step, ticks, span = map(int, arrays["steps"])
    changed, begun, *energies = arrays["energy"].tolist()
    strain = arrays.get("strain", np.zeros((0, 6)))
    bonds = part("bonds", arrays)
    motion = MotionState(
        state=State(ticks * tick, arrays["position"], arrays["orientation"], arrays["velocity"], strain),
        angular_momentum=arrays["angular_momentum"],
        v=arrays["v"],
        impulse=arrays["impulse"],
        carried_impulse=arrays.get("carried_impulse"),
        false_slip=arrays["false_slip"],
        joints=JointMemory(**part("joints", arrays)),
        tensions=tensions,
        yielded=arrays["yielded"],
        energy=EnergyBalance(dict(zip(ENERGIES, energies, strict=True)), begun, bool(changed)),
        steps=steps,
        ticks=ticks,
        span=span,
        approach=arrays.get("approach", NO_APPROACH),
        bonds=BondMemory(**bonds) if bonds else NO_BONDS,
    )
    return motion, load_step
