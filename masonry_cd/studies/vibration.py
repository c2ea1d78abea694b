# SPDX-License-Identifier: GPL-3.0-or-later
r"""The model of a run itself in small vibration, against the modes of rigid blocks on the same elastic joints.

A run whose joints are elastic has frequencies of its own. Two ways to find them, both from the state at rest under the weight:

    free     every mode gets a small kick, 1/1000 g / omega_i; its coordinate q_i = phi_i^T M x of the run's displacements x(t)
             swings at the frequency of the run, read from the peak of its spectrum
    sweep    the base moves by v(t) = C sin(2 pi f t), one run per frequency; the largest displacement of a block relative to the base
             over the last cycles, against that of the linear modes with the numerical damping of the joints

The run opens joints that are neither bonded nor pressed together; the linear model never does. So where they differ in small vibration,
joints without compression are at work, and in a strong one opening and sliding: the peak bends to lower frequencies.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from operator import itemgetter
from pathlib import Path
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from masonry_cd.analysis.modal.elastic_joints import joint_modes
from masonry_cd.analysis.modal.shapes import RigidShapes
from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result
from masonry_cd.app.scene import Scene
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import write_rows
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.pair_stiffness import stiffness_of_joints
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly, refuse_spheres
from masonry_cd.studies.joints_at_rest import at_rest_lines, at_rest_summary, joints_at_rest
from reports.drawing.figure import FAINT, INK, format_axes, save
from reports.drawing.plots import add_legend, colour, sheet

STEPS = 40  # of the highest mode's period, at least: the scheme lengthens a period by (2 pi / 40)^2 / 12 = 0.2 %
PERIODS = 20  # of the lowest mode, in free vibration
CYCLES, JUDGED = 14, 4  # of the base in a sweep, and the last of them over which the amplitude is taken
SMALL = 1e-3  # acceleration of a small vibration, as a share of gravity
RATIOS = np.union1d(np.linspace(0.3, 2.0, 18), np.linspace(0.85, 1.15, 13)).round(6)  # of a sweep, to the frequency of its mode
MODES = 12  # of the linear model under a sweep, at least
HEAD = ("free vibration of the run, and rigid blocks on the same elastic joints:", "  mode     run [Hz]   linear [Hz]   difference")
OUTPUTS = ("vibration.json", "vibration.csv", "sweep.csv", "sweep.png")


class VibrationOptions(BaseModel):
    """Options of the command."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    modes: Annotated[int, Field(ge=1, le=500)] = 6
    """Modes to compare."""
    sweep: Literal["x", "y", "z"] | None = None
    """Direction of the base in a sweep; none when not given."""
    velocity: Annotated[float, Unit("m/s"), Field(gt=0, allow_inf_nan=False)] | None = None
    """C of the sweep; when not given, what makes 1/1000 g at the mode that moves most in its direction."""


@dataclass(frozen=True, eq=False)
class Companion:
    """Rigid blocks on the elastic joints of a scene, linear: n modes with phi^T M phi = 1 over B blocks."""

    frequencies: np.ndarray  # (n,) [Hz]
    shapes: np.ndarray  # (n, B, 6) translation and rotation; zero for supports
    weighted: np.ndarray  # (n, B, 6) M phi
    participation: np.ndarray  # (n, 3) share of the mass

    def coordinates(self, displacement: np.ndarray) -> np.ndarray:
        """Modal coordinates (n,) of displacements (B, 6)."""
        return np.einsum("nbi,bi->n", self.weighted, displacement)


class ModeRow(NamedTuple):
    """A mode: its frequencies in the run and in the linear model, and the share of the mass that it moves in each direction."""

    mode: int
    linear_hz: float
    nscd_hz: float
    difference_percent: float
    mass_x: float
    mass_y: float
    mass_z: float

    @property
    def line(self) -> str:
        """As text, below the head of the table."""
        return f"  {self.mode:4d}  {self.nscd_hz:11.4f}  {self.linear_hz:12.4f}  {self.difference_percent:+9.2f} %"


class SweepRow(NamedTuple):
    """A frequency of the base: amplitudes of it and of a block relative to it, in the run and in the linear model."""

    frequency_hz: float
    base_amplitude_m: float
    nscd_amplitude_m: float
    linear_amplitude_m: float
    nscd_ratio: float
    linear_ratio: float


def vibration(scene: Scene, options: Mapping[str, Any], folder: Path, force: bool = False) -> Result[dict[str, Any]]:
    """Run ``masonry-cd modal --nscd``: free vibration, and a sweep where asked, written into a folder.

    Args:
        scene: whose joints all are elastic.
        options: keys of :class:`VibrationOptions`.
        folder: created if missing.
        force: overwrite the files that are there.

    Returns:
        what vibration.json holds, ``lines`` and ``warnings`` among it.

    Raises:
        InputError: a wrong option or scene, or a joint that is rigid.
    """
    from masonry_cd.app.case import make_structures
    from masonry_cd.foundation.json_files import write_json

    asked = parse_table(VibrationOptions, options, "modal")
    free_folder(folder, OUTPUTS, force)
    scene.refuse_static()
    scene.refuse_tables("the modal check", "links", "events", "ground")
    blocks = make_structures(scene).blocks
    with scene.locating():
        refuse_spheres(blocks, "structure", "the modal check")
        assembly = Assembly.from_blocks(blocks, scene.material)
        companion = linear_modes(assembly, max(asked.modes, MODES if asked.sweep else 0))
        assembly = replace(assembly, laws=assembly.laws.damped_at(float(companion.frequencies[0])))
        rows = free_vibration(assembly, scene.run, companion, asked.modes)
        rest = at_rest_summary(joints_at_rest(_at_rest(assembly, scene.run, scene.run.dt, np.zeros((2, 1, 3)))))
        found: dict[str, Any] = {"title": scene.title, "modes": [row._asdict() for row in rows], "joints_at_rest": rest}
        found |= {"lines": [*HEAD, *(row.line for row in rows)], "warnings": at_rest_lines(rest)}
        if asked.sweep:
            swept = _swept(assembly, scene, companion, asked)
            found |= swept | {"lines": [*found["lines"], _sweep_line(swept)]}
    own_files.begin(folder, OUTPUTS)
    own_files.remove(folder, OUTPUTS)
    write_json(folder / "vibration.json", found)
    write_rows(folder / "vibration.csv", found["modes"])
    if asked.sweep:
        write_rows(folder / "sweep.csv", found["sweep"])
        draw_sweep(found, folder / "sweep.png")
    written = [folder / name for name in OUTPUTS if (folder / name).exists()]
    return Result(found, found["lines"], found["warnings"], written)


def linear_modes(assembly: Assembly, count: int) -> Companion:
    """The modes of rigid blocks on the joints' own stiffness.

    Raises:
        InputError: a joint without stiffness, blocks that deform, or a block tied to no support.
    """
    if assembly.deformation is not None:
        raise InputError("material.deformable", 'these modes are those of rigid blocks on elastic joints; set it to "rigid" for them')
    joints, group = find_joints(assembly), assembly.group_of
    normal, tangential = stiffness_of_joints(assembly, joints)
    rigid = np.flatnonzero(normal == 0.0)
    if len(rigid):
        a, b = (assembly.groups[int(group[side[rigid[0]]])] for side in (joints.block_a, joints.block_b))
        raise InputError("material.joints", f"joints {a}-{b} are rigid, a vibration needs elastic ones: give normal_stiffness, or masonry")
    free = np.flatnonzero(~assembly.fixed)
    found = joint_modes(assembly.blocks, np.ones(assembly.count), 0.0, min(count, 6 * len(free)), stiffness=(normal, tangential))
    field = found["field"]
    assert isinstance(field, RigidShapes)
    shapes = np.zeros((len(field.translation), assembly.count, 6))
    shapes[:, free] = np.concatenate([field.translation, field.rotation], axis=2)
    weighted = np.zeros_like(shapes)
    weighted[..., :3] = assembly.mass[:, None] * shapes[..., :3]
    weighted[..., 3:] = np.einsum("bij,nbj->nbi", assembly.inertia, shapes[..., 3:])
    return Companion(np.asarray(found["frequencies"]), shapes, weighted, np.asarray(found["participation"]))


def free_vibration(assembly: Assembly, settings: Run, companion: Companion, count: int) -> list[ModeRow]:
    """Frequencies of the run against those of the linear modes, one row for each of the first ``count`` modes."""
    frequencies, gravity = companion.frequencies[:count], _gravity(settings)
    dt = min(settings.dt, 1.0 / (STEPS * float(frequencies[-1])))
    steps = int(np.ceil(PERIODS / (float(frequencies[0]) * dt)))
    machine = _at_rest(assembly, settings, dt, np.zeros((steps + 1, 1, 3)))
    linear, turning = (np.linalg.norm(part, axis=2) for part in np.split(companion.shapes[:count], 2, axis=2))
    size = (linear + np.cbrt(assembly.volume) * turning).max(axis=1)  # of the shapes, rotations over the width of the blocks
    speed = SMALL * gravity / (2.0 * np.pi * frequencies) / size
    machine.kick(np.einsum("n,nbi->bi", speed, companion.shapes[:count]))
    history = _history(machine, steps, lambda moved: companion.coordinates(moved)[:count])
    rows = []
    for k, (frequency, q) in enumerate(zip(frequencies, history.T, strict=True)):
        own = _peak(q, dt)
        rows.append(ModeRow(k + 1, float(frequency), own, 100.0 * (own / float(frequency) - 1.0), *companion.participation[k].tolist()))
    return rows


def sweep(assembly: Assembly, settings: Run, companion: Companion, axis: int, velocity: float, frequencies: np.ndarray) -> list[SweepRow]:
    """Amplitudes of the block that moves most in the first mode of a direction, relative to the base, by frequency of the base.

    Args:
        assembly: with elastic joints.
        settings: of the run.
        companion: its linear modes.
        axis: 0, 1 or 2: direction of the base.
        velocity: C [m/s].
        frequencies: (F,) [Hz].
    """
    leading = int(companion.participation[:, axis].argmax())
    block = int(np.abs(companion.shapes[leading, :, axis]).argmax())
    rows = []
    for f in frequencies:
        dt = min(settings.dt, 1.0 / (STEPS * max(float(f), float(companion.frequencies[leading]))))
        steps = round(CYCLES / (f * dt))
        shaking = np.zeros((steps + 1, 1, 3))
        shaking[:, 0, axis] = velocity * np.sin(2.0 * np.pi * f * dt * np.arange(steps + 1))
        machine = _at_rest(assembly, settings, dt, shaking)
        base = int(np.argmax(assembly.fixed))
        moved = _history(machine, steps, itemgetter(((block, base), axis)))
        history = moved[:, 0] - moved[:, 1]
        linear = _linear_response(assembly, companion, axis, block, shaking[:, 0, axis], dt)
        last = -round(JUDGED / (f * dt))
        own, reference = (float(np.abs(values[last:]).max()) for values in (history, linear))
        base_amplitude = velocity / (2.0 * np.pi * float(f))
        rows.append(SweepRow(float(f), base_amplitude, own, reference, own / base_amplitude, reference / base_amplitude))
    return rows


def _swept(assembly: Assembly, scene: Scene, companion: Companion, asked: VibrationOptions) -> dict[str, Any]:
    """The sweep that the options ask for."""
    axis = "xyz".index(asked.sweep or "x")
    leading = int(companion.participation[:, axis].argmax())
    near = float(companion.frequencies[leading])
    velocity = asked.velocity or SMALL * _gravity(scene.run) / (2.0 * np.pi * near)
    rows = [row._asdict() for row in sweep(assembly, scene.run, companion, axis, velocity, near * RATIOS)]
    block = assembly.names[int(np.abs(companion.shapes[leading, :, axis]).argmax())]
    return {"sweep": rows, "direction": asked.sweep, "velocity": velocity, "block": block}


def _sweep_line(swept: Mapping[str, Any]) -> str:
    """The outcome of a sweep as text."""
    own, linear = (max(swept["sweep"], key=itemgetter(name)) for name in ("nscd_ratio", "linear_ratio"))
    return (
        f"sweep along {swept['direction']} with C {swept['velocity']:.3g} m/s: block {swept['block']} moves most at "
        f"{own['frequency_hz']:.4g} Hz, {own['nscd_ratio']:.3g} times the base; in the linear model at {linear['frequency_hz']:.4g} Hz, "
        f"{linear['linear_ratio']:.3g} times"
    )


def _gravity(settings: Run) -> float:
    """Magnitude of gravity [m/s2].

    Raises:
        InputError: there is none, and dry joints without weight do not hold together.
    """
    size = float(np.linalg.norm(settings.gravity))
    if size == 0.0:
        raise InputError("run.gravity", "a vibration needs the weight that presses the joints together")
    return size


def _at_rest(assembly: Assembly, settings: Run, dt: float, shaking: np.ndarray) -> Stepper:
    """A stepper in the state at rest under the weight, its base to be moved by velocities (N + 1, 1, 3)."""
    pull = np.tile(np.asarray(settings.gravity, dtype=float), (len(shaking), 1))
    across = bool(np.any(shaking))  # free vibration has modes out of every plane
    machine = Stepper(assembly, shaking, pull, settings.model_copy(update={"dt": dt, "planar": settings.planar and across}))
    settle(machine)
    return machine


def _history(machine: Stepper, steps: int, measure: Callable[[np.ndarray], Any]) -> np.ndarray:
    """Return a measure of the displacements (B, 6) since now, after each step, (N, ...)."""
    position, orientation = machine.state.position.copy(), machine.state.orientation.copy()
    out = []
    for _ in range(steps):
        machine.step()
        moved = np.concatenate([machine.state.position - position, 2.0 * (machine.state.orientation - orientation)[:, 1:]], axis=1)
        out.append(measure(moved))
    return np.array(out)


def _peak(values: np.ndarray, dt: float) -> float:
    """Frequency of the largest peak of a spectrum [Hz]: Hann window, and a parabola through the logarithms about the largest line."""
    window = np.hanning(len(values))
    spectrum = np.log(np.abs(np.fft.rfft((values - values.mean()) * window)) + 1e-300)
    k = int(np.clip(spectrum[1:-1].argmax() + 1, 1, len(spectrum) - 2))
    low, mid, high = spectrum[k - 1 : k + 2]
    return float((k + 0.5 * (low - high) / (low - 2.0 * mid + high)) / (len(values) * dt))


def _linear_response(assembly: Assembly, companion: Companion, axis: int, block: int, velocity: np.ndarray, dt: float) -> np.ndarray:
    """Displacement of a block relative to the base [m] by the linear modes, damped as theta and dashpots of the joints do, (N,)."""
    from scipy.signal import lsim

    laws, elastic = assembly.laws, assembly.laws.elastic
    per_omega = (laws.theta[elastic].mean() - 0.5) * dt + 0.5 * laws.retardation[elastic].mean()  # [s]
    time, out = dt * np.arange(len(velocity)), np.zeros(len(velocity))
    push = -np.gradient(velocity, dt)
    for f, shape, weighted in zip(companion.frequencies, companion.shapes, companion.weighted, strict=True):
        omega = 2.0 * np.pi * f
        damping = per_omega * omega
        gain = weighted[:, axis].sum() * shape[block, axis]
        out += gain * lsim(([1.0], [1.0, 2.0 * damping * omega, omega**2]), push, time)[1]
    return out[1:]


def draw_sweep(found: Mapping[str, Any], path: Path) -> None:
    """Draw what :func:`masonry_cd.studies.vibration.vibration` found in a sweep into a PNG.

    Raises:
        InputError: a file that cannot be written.
    """
    rows, axis = found["sweep"], found["direction"]
    f, own, linear = (np.array([row[key] for row in rows]) for key in ("frequency_hz", "nscd_ratio", "linear_ratio"))
    facts = f"block {found['block']} along {axis}; base moved by v(t) = C sin(2 pi f t), C = {found['velocity']:.3g} m/s"
    figure, (axes,) = sheet(f"Sweep: {found['title']}", facts, size=(11.0, 6.4))
    axes.plot(f, linear, color=FAINT, linewidth=1.6, label="linear: rigid blocks on the same elastic joints, never open")
    axes.plot(f, own, color=colour(0), linewidth=1.2, marker="o", markersize=5, label="run: joints that open and slide")
    axes.set_yscale("log")
    axes.set_xlim(0.0, 1.03 * f[-1])
    for row in found["modes"]:
        if row["linear_hz"] <= f[-1] and row[f"mass_{axis}"] > 0.01:
            axes.axvline(row["linear_hz"], color=FAINT, linewidth=0.8, linestyle=":")
            words, place = f"mode {row['mode']}: {row['linear_hz']:.4g} Hz\nrun {row['nscd_hz']:.4g} Hz", (row["linear_hz"], 0.03)
            axes.annotate(words, place, (5, 0), ("data", "axes fraction"), "offset points", fontsize=10, color=INK)
    format_axes(axes, "largest displacement relative to the base,\nover that of the base", "frequency of the base [Hz]")
    add_legend(axes, 2)
    save(figure, path)
