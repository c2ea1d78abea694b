# SPDX-License-Identifier: GPL-3.0-or-later
r"""Order of accuracy in time: a rocking block against Housner, ours and LMGC90's.

    python -m benchmarks.rocking --lmgc90-python PATH/bin/python

A block of width 2 b and height 2 h stands on a base that gives one sine pulse of acceleration, a(t) = A sin(2 pi f t). It lifts off when
|a| > g tan(alpha) and rocks about its corners (Housner, Bull. Seism. Soc. Am. 53, 1963), alpha = atan(b/h), R = sqrt(b^2 + h^2):

    theta'' = -p^2 ( s sin(alpha - s theta) + a/g cos(alpha - s theta) ),    p^2 = 3 g / (4 R),    s = sign(theta),

and at each impact the angular velocity falls to r = 1 - 3/2 sin^2(alpha) of itself, which a plastic impact on both corners reproduces
exactly. The reference is integrated from event to event to 1e-10. Errors: the impact times, the peaks between impacts relative to
their size, and the angle as such (root mean square), all to the last impact compared.
"""

from __future__ import annotations

import argparse
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from benchmarks.ours import stepper
from benchmarks.scenes import GRAVITY, BenchScene, cuboid, ground
from benchmarks.sitting import head, run_lmgc90, sitting

HALF_WIDTH, HALF_HEIGHT = 0.1, 0.4  # b, h [m]
PULSE, FREQUENCY = 2.0, 4.0  # A / (g tan alpha), f [Hz]
IMPACTS = 4  # compared
ALPHA = float(np.arctan2(HALF_WIDTH, HALF_HEIGHT))
AMPLITUDE = PULSE * GRAVITY * float(np.tan(ALPHA))  # A [m/s2]
OMEGA = 2.0 * np.pi * FREQUENCY


@dataclass(frozen=True, eq=False)
class RockingScene(BenchScene):
    """One block on a base that moves by one pulse."""

    def base_velocity(self, steps: int) -> np.ndarray:
        """The integral of the pulse, (N + 1,) [m/s]."""
        t = np.minimum(self.dt * np.arange(steps + 1), 1.0 / FREQUENCY)
        return AMPLITUDE / OMEGA * (1.0 - np.cos(OMEGA * t))


@dataclass(frozen=True, eq=False)
class RockingHistory:
    """Impact times [s], and the peak of |theta| [rad] after each but the last."""

    impacts: np.ndarray
    peaks: np.ndarray


def block_on_base(dt: float) -> RockingScene:
    """The scene."""
    b, h = HALF_WIDTH, HALF_HEIGHT
    return RockingScene(
        "rocking block", (ground(-2.0, 2.0, 0.5), cuboid("block", (-b, -0.2, 0.0), (b, 0.2, 2 * h))), steps=1, friction=1.0, dt=dt
    )


def housner(times: np.ndarray) -> tuple[RockingHistory, np.ndarray]:
    """The reference: impacts and peaks, and the angle at some times [rad] to the last impact compared, NaN after it."""
    radius = float(np.hypot(HALF_WIDTH, HALF_HEIGHT))
    p2, restitution = 0.75 * GRAVITY / radius, 1.0 - 1.5 * np.sin(ALPHA) ** 2

    def pull(t: float) -> float:
        return AMPLITUDE * float(np.sin(OMEGA * t)) if t < 1.0 / FREQUENCY else 0.0

    def motion(t: float, y: np.ndarray, s: float) -> list[float]:
        lean = ALPHA - s * y[0]
        return [y[1], -p2 * (s * np.sin(lean) + pull(t) / GRAVITY * np.cos(lean))]

    def falls(t: float, y: np.ndarray, s: float) -> float:
        return s * y[0]

    falls.terminal, falls.direction = True, -1.0  # type: ignore[attr-defined]
    t, spin, side = float(np.arcsin(1.0 / PULSE)) / OMEGA, 0.0, -1.0  # pushed to +x, the base lets it lean to -x
    angle = np.where(times <= t, 0.0, np.nan)
    impacts: list[float] = []
    peaks: list[float] = []
    while len(impacts) < IMPACTS:
        peak, state = 0.0, np.array([0.0, spin])
        ends = [1.0 / FREQUENCY] if t < 1.0 / FREQUENCY else []  # the pulse ends with a kink
        for end in [*ends, t + 10.0]:
            part = solve_ivp(motion, (t, end), state, args=(side,), events=falls, rtol=1e-10, atol=1e-13, dense_output=True, max_step=0.01)
            inside = (times > t) & (times <= part.t[-1])
            if inside.any():
                angle[inside] = part.sol(times[inside])[0]
            peak = max(peak, float(np.abs(part.sol(np.linspace(t, part.t[-1], 20_001))[0]).max()))
            t, state = float(part.t[-1]), part.y[:, -1]
            if part.status == 1:
                break
        impacts.append(t)
        peaks.append(peak)
        spin = restitution * float(state[1])
        side = float(np.sign(spin))
    return RockingHistory(np.array(impacts), np.array(peaks[1:])), angle


def observed(angle: np.ndarray, dt: float) -> RockingHistory:
    """Impacts and peaks of a computed history of the angle, (N + 1,) at t_k = k dt."""
    rocking = int(np.argmax(np.abs(angle) > 1e-5))  # before lift-off the angle is zero but for rounding
    sign = np.sign(angle)
    through = rocking + np.flatnonzero(sign[rocking + 1 :] * sign[rocking:-1] < 0)
    impacts = dt * (through + angle[through] / (angle[through] - angle[through + 1]))
    peaks = [_peak(np.abs(part)) for part in np.split(angle, through + 1)[1:-1]]
    return RockingHistory(impacts[:IMPACTS], np.array(peaks[: IMPACTS - 1]))


def _peak(size: np.ndarray) -> float:
    """The top of the parabola through the three largest neighbours."""
    k = int(np.argmax(size))
    if k in (0, len(size) - 1):
        return float(size[k])
    left, middle, right = size[k - 1 : k + 2]
    bend = left - 2.0 * middle + right
    return float(middle - (right - left) ** 2 / (8.0 * bend)) if bend < 0.0 else float(middle)


def ours_angle(dt: float, steps: int, solver: str) -> np.ndarray:
    """Our angle (N + 1,) [rad], positive towards +x."""
    machine, angle = stepper(block_on_base(dt), steps, solver, 1e-10), np.zeros(steps + 1)
    for k in range(steps):
        machine.step()
        angle[k + 1] = 2.0 * np.arctan2(machine.state.orientation[1, 2], machine.state.orientation[1, 0])
    return angle


def lmgc90_angle(dt: float, steps: int, python: str) -> np.ndarray:
    """LMGC90's angle (N + 1,) [rad]."""
    with tempfile.TemporaryDirectory() as folder:
        result = run_lmgc90(python, block_on_base(dt), steps, 1e9, Path(folder))
    turn = np.einsum("kji,jl->kil", result["axes"][:, 1], result["axes"][0, 1])
    return np.arctan2(turn[:, 0, 2], turn[:, 2, 2])


def errors(angle: np.ndarray, dt: float) -> tuple[float, float, float]:
    """Largest error of the impact times [s], of the peaks (relative), and the root mean square error of the angle [rad]."""
    reference, exact = housner(dt * np.arange(len(angle)))
    got, known = observed(angle, dt), ~np.isnan(exact)
    rms = float(np.sqrt(np.mean((angle[known] - exact[known]) ** 2)))
    if len(got.impacts) < IMPACTS or len(got.peaks) < IMPACTS - 1:
        return np.nan, np.nan, rms  # it does not rock as it should
    late, low = np.abs(got.impacts - reference.impacts).max(), np.abs(got.peaks / reference.peaks - 1.0).max()
    return float(late), float(low), rms


def order(steps: list[float], found: list[float]) -> float:
    """Slope of log error over log dt, by least squares."""
    return float(np.polyfit(np.log(steps), np.log(found), 1)[0])


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Order of accuracy of a rocking block against Housner.")
    parser.add_argument("--lmgc90-python", help="the Python that has compas_lmgc90; left out: ours alone")
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--dt", type=float, nargs="+", default=[5e-3, 2e-3, 1e-3, 5e-4, 2e-4])
    given = parser.parse_args()
    end = float(housner(np.zeros(1))[0].impacts[-1]) + 0.1
    print(sitting(), head("program", "dt [ms]", "impact times [ms]", "peaks [%]", "angle, rms [rad]"), sep="\n\n")
    programs = ["ours", "LMGC90"] if given.lmgc90_python else ["ours"]
    for program in programs:
        rows = []
        for dt in given.dt:
            steps = round(end / dt)
            angle = ours_angle(dt, steps, given.solver) if program == "ours" else lmgc90_angle(dt, steps, given.lmgc90_python)
            rows.append(errors(angle, dt))
            late, low, rms = rows[-1]
            print(f"| {program} | {1e3 * dt:g} | {1e3 * late:.3f} | {100 * low:.3f} | {rms:.2e} |", flush=True)
        slopes = " | ".join(f"{order(given.dt, list(column)):.2f}" for column in zip(*rows, strict=True))
        print(f"| {program} | order | {slopes} |")


if __name__ == "__main__":
    main()
