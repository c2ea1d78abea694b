# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.signal.measures against closed forms and against scipy: by name, for one component and for both."""

from __future__ import annotations

import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from hostile import refused_at
from scipy.integrate import cumulative_trapezoid, trapezoid
from scipy.signal import StateSpace, butter, lsim, sosfilt

from loads.motion import STANDARD_GRAVITY
from loads.signal.baseline import GroundHistory, integrate
from loads.signal.directions import rotated
from loads.signal.measures import FAMILIES, parse

STEP = 0.01
HALF_SINE = integrate(3.0 * np.sin(np.pi * np.linspace(0.0, 1.0, 1001)), 0.001)  # 3 m/s2, 1 s long


def shaking(seed: int = 0, count: int = 400) -> GroundHistory:
    """Noise that swells and fades; samples unlike one another."""
    envelope = np.sin(np.pi * np.linspace(0.0, 1.0, count)) ** 2
    return integrate(envelope * np.random.default_rng(seed).normal(size=count), STEP)


def measured(text: str, x: GroundHistory, y: GroundHistory | None = None) -> float:
    return parse(text).value({"x": x} if y is None else {"x": x, "y": y})


@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        ("PGA", 3.0),
        ("PGV", 3.0 * 2.0 / np.pi),
        ("PGD", 3.0 / np.pi),
        ("CAV", 3.0 * 2.0 / np.pi),
        ("Arias", np.pi / (2.0 * STANDARD_GRAVITY) * 9.0 / 2.0),
    ],
)
def test_a_half_sine(text: str, wanted: float) -> None:
    """a = A sin(pi t): v ends at 2 A / pi and d at A / pi after 1 s; the integral of a^2 is A^2 / 2."""
    assert measured(text, HALF_SINE) == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize("samples", [2, 3, 8, 11])
def test_cav_of_a_ramp_through_zero_is_exact_at_any_sampling(samples: int) -> None:
    """a from -1 to 2 m/s2 in 3 s: two triangles, 1/2 + 2."""
    ramp = integrate(np.linspace(-1.0, 2.0, samples), 3.0 / (samples - 1))
    assert measured("CAV", ramp) == pytest.approx(2.5, rel=1e-14)


def test_cav_of_whole_cycles_converges_with_the_square_of_the_step() -> None:
    """int |sin| over a period of 2 s is 4 / pi; samples that miss the zeros and the peaks."""
    errors = []
    for count in (50, 100, 200):
        t = np.linspace(0.0, 2.0, count + 1)
        errors.append(abs(measured("CAV", integrate(np.sin(np.pi * t + 0.3), t[1])) - 4.0 / np.pi))
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.1)
    assert errors[2] < 1e-3


@pytest.mark.parametrize("text", ["Arias", "PGV", "PGD", "FIV3(0.4)", "Sa(0.4)"])
def test_a_smooth_motion_converges_with_the_square_of_the_step(text: str) -> None:
    """Against a step of a 16th: chords of waves of w <= 9 + 3 pi rad/s are off by about (w h)^2 / 6; the peak in Sa may be 0.3 % low."""

    def at(count: int) -> float:
        t = np.linspace(0.0, 2.0, count + 1)
        return measured(text, integrate(np.sin(np.pi * t) ** 3 * np.cos(9.0 * t), t[1]))

    exact = at(6400)
    errors = [abs(at(count) - exact) / exact for count in (100, 200, 400)]
    chords = ((9.0 + 3.0 * np.pi) * 2.0 / 400) ** 2 / 6.0
    if text.startswith("Sa"):
        assert errors[2] < chords + 3e-3
    else:
        assert errors[2] < chords
        assert errors[0] > 8.0 * errors[2]


def test_cav_of_values_too_small_to_be_multiplied() -> None:
    assert measured("CAV", integrate(np.array([1e-200, -1e-200, 1.0, 1.0]), 1.0)) == pytest.approx(1.5)


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.2])
def test_sa_of_a_step_is_that_of_the_textbook(damping: float) -> None:
    """Constant a: the peak is (1 + exp(-pi xi / sqrt(1 - xi^2))) a (Chopra, sec. 4.3), for every period; so is the average's."""
    steady = integrate(np.full(501, 2.0), STEP)
    wanted = 2.0 * (1.0 + np.exp(-np.pi * damping / np.sqrt(1.0 - damping**2)))
    assert measured(f"Sa(0.5, {damping})", steady) == pytest.approx(wanted, rel=4e-3)
    assert measured(f"AvgSA(0.2, 2.0, 5, {damping})", steady) == pytest.approx(wanted, rel=4e-3)


def test_sa_in_resonance_grows_to_its_steady_state() -> None:
    """A harmonic at its own period, a / (2 xi) once the start has died away."""
    t = STEP * np.arange(4001)
    assert measured("Sa(1.0, 0.05)", integrate(np.sin(2.0 * np.pi * t), STEP)) == pytest.approx(10.0, rel=5e-3)


def test_average_is_the_geometric_mean_at_periods_evenly_spaced() -> None:
    motion = shaking()
    singles = [measured(f"Sa({period})", motion) for period in (0.1, 0.4, 0.7, 1.0)]
    assert measured("AvgSA(0.1, 1.0, 4)", motion) == pytest.approx(math.prod(singles) ** 0.25, rel=1e-12)
    assert measured("AvgSA(0.1, 1.0)", motion) == measured("AvgSA(0.1, 1.0, 10, 0.05)", motion)
    assert measured("AvgSA(0.1, 1.0)", integrate(np.zeros(20), STEP)) == 0.0


def test_housner_of_a_step_is_the_area_under_a_straight_line() -> None:
    """Constant a without damping: Sv = 2 a T / (2 pi), so the area from 0.1 to 2.5 s is a (2.5^2 - 0.1^2) / (2 pi)."""
    steady = integrate(np.full(601, 2.0), STEP)
    assert measured("Housner(0)", steady) == pytest.approx(2.0 * (2.5**2 - 0.1**2) / (2.0 * np.pi), rel=3e-3)


def test_one_direction_seen_from_all_around() -> None:
    """A motion along x is |cos| of itself elsewhere: median cos 45 degrees, largest 1, whichever way it points."""
    motion = shaking()
    for angle in (0.0, np.radians(30.0), np.radians(90.0)):
        x, y = rotated(motion, motion.scaled(0.0), angle), rotated(motion.scaled(0.0), motion, angle)
        for text in ("PGA", "PGV", "PGD", "CAV", "Sa(0.3)", "Sa(0)", "AvgSA(0.1,0.5)", "Housner", "FIV3(0.3)"):
            assert measured(f"{text}:rotd50", x, y) == pytest.approx(measured(text, motion) * np.sqrt(0.5), rel=1e-9)
            assert measured(f"{text}:rotd100", x, y) == pytest.approx(measured(text, motion), rel=1e-9)


def test_rotation_of_the_axes_changes_no_rotd() -> None:
    first, second = shaking(1), shaking(2)
    turn = np.radians(37.0)
    x, y = rotated(first, second, turn), rotated(first, second, turn + np.pi / 2.0)
    for text in ("PGA", "Arias", "D5-95", "CAV", "Sa(0.2)", "AvgSA(0.1,0.6)", "FIV3(0.3)"):
        for rule in ("rotd50", "rotd100"):
            assert measured(f"{text}:{rule}", x, y) == pytest.approx(measured(f"{text}:{rule}", first, second), rel=1e-9)
    assert measured("Sa(0.2)", x) != pytest.approx(measured("Sa(0.2)", first), rel=0.01)


def test_rotated_responses_are_those_to_the_rotated_motion() -> None:
    x, y = shaking(3), shaking(4)
    around = [parse("Sa(0.25)").value({"x": rotated(x, y, np.radians(k))}) for k in range(180)]
    assert measured("Sa(0.25):rotd50", x, y) == pytest.approx(np.median(around), rel=1e-12)
    assert measured("Sa(0.25):rotd100", x, y) == pytest.approx(max(around), rel=1e-12)


def test_rotd_of_an_average_is_taken_period_by_period() -> None:
    x, y = shaking(5), shaking(6)
    singles = [measured(f"Sa({period}):rotd50", x, y) for period in (0.1, 0.55, 1.0)]
    assert measured("AvgSA(0.1,1.0,3):rotd50", x, y) == pytest.approx(math.prod(singles) ** (1.0 / 3.0), rel=1e-12)


def test_a_circular_motion_is_alike_in_all_directions() -> None:
    t = STEP * np.arange(1001)
    x, y = integrate(np.cos(2 * np.pi * t), STEP), integrate(np.sin(2 * np.pi * t), STEP)
    for rule in ("rotd50", "rotd100", "larger", "geometric_mean"):
        assert measured(f"PGA:{rule}", x, y) == pytest.approx(1.0, rel=1e-3)


def test_both_components_and_each() -> None:
    x = shaking(7)
    motion = {"x": x, "y": x.scaled(4.0), "z": x.scaled(0.5)}
    one = parse("PGV").value(motion)
    wanted = {"x": 1.0, "y": 4.0, "z": 0.5, "geometric_mean": 2.0, "larger": 4.0}
    assert {rule: parse("PGV", rule=rule).value(motion) / one for rule in wanted} == pytest.approx(wanted)


@pytest.mark.parametrize(
    "text", ["PGA", "PGV", "PGD", "Arias:larger", "CAV", "Sa(0.4):rotd50", "AvgSA(0.1,1):geometric_mean", "Housner", "FIV3(0.4)"]
)
def test_a_factor_scales_a_motion_to_a_level(text: str) -> None:
    motion = {"x": shaking(8), "y": shaking(9)}
    measure = parse(text)
    factor = measure.factor(0.7, motion)
    assert measure.value({axis: history.scaled(factor) for axis, history in motion.items()}) == pytest.approx(0.7)


def test_a_name_is_read_back_and_travels_to_other_processes() -> None:
    motion = {"x": shaking(10), "y": shaking(11)}
    for text in ("PGA", " Sa( 0.5 ) : rotd50 ", "AvgSA(0.1, 1.0,20,0.02)", "Housner(0.2):larger", "FIV3(0.5,0.7,0.85)", "D5-95", "Arias"):
        measure = parse(text)
        assert parse(measure.name).value(motion) == measure.value(motion)
        assert pickle.loads(pickle.dumps(measure)).value(motion) == measure.value(motion)
    assert parse("Sa(0.50):rotd50").name == "Sa(0.5):rotd50"
    assert parse("PGA", rule="larger").name == "PGA:larger"
    assert {family.unit for family in FAMILIES.values()} == {"m/s2", "m/s", "m", "s"}


STEP_SCIPY, SAMPLES = 0.005, 3000


@pytest.fixture(scope="module")
def motion() -> GroundHistory:
    """Noise between 0.3 and 12 Hz that swells and fades, as an earthquake does."""
    random = np.random.Generator(np.random.PCG64(7))
    t = STEP_SCIPY * np.arange(SAMPLES)
    noise = sosfilt(butter(4, [0.3, 12.0], "bandpass", fs=1.0 / STEP_SCIPY, output="sos"), random.standard_normal(SAMPLES))
    return integrate(10.0 * noise * np.exp(-(((t - 5.0) / 3.0) ** 2)), STEP_SCIPY)


def oscillator(motion: GroundHistory, period: float, damping: float) -> np.ndarray:
    """Displacement of an oscillator on the moving base (N,) [m]; exact between samples that are joined by straight lines."""
    w = 2.0 * math.pi / period
    system = StateSpace([[0.0, 1.0], [-w * w, -2.0 * damping * w]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]])
    _, x, _ = lsim(system, motion.acceleration, STEP_SCIPY * np.arange(len(motion.acceleration)), interp=True)
    return np.asarray(x)


@pytest.mark.parametrize(("period", "damping"), [(0.05, 0.05), (0.3, 0.05), (1.0, 0.02), (2.0, 0.10)])
def test_sa_is_that_of_an_oscillator_of_scipy(motion: GroundHistory, period: float, damping: float) -> None:
    wanted = (2.0 * math.pi / period) ** 2 * np.abs(oscillator(motion, period, damping)).max()
    assert parse(f"Sa({period},{damping})").value({"x": motion}) == pytest.approx(wanted, rel=1e-8)


def test_the_average_and_the_spectrum_intensity_are_made_of_oscillators_of_scipy(motion: GroundHistory) -> None:
    periods = np.linspace(0.2, 1.0, 10)
    sa = [(2.0 * math.pi / T) ** 2 * np.abs(oscillator(motion, T, 0.05)).max() for T in periods]
    assert parse("AvgSA(0.2,1.0)").value({"x": motion}) == pytest.approx(float(np.exp(np.mean(np.log(sa)))), rel=1e-8)
    periods = np.linspace(0.1, 2.5, 49)
    sv = [2.0 * math.pi / T * np.abs(oscillator(motion, T, 0.05)).max() for T in periods]
    assert parse("Housner").value({"x": motion}) == pytest.approx(trapezoid(sv, periods), rel=1e-5)  # which looks between samples as well


def test_integrals_over_the_motion_are_those_of_scipy(motion: GroundHistory) -> None:
    """On samples so fine that the rules of integration do not tell."""
    t = STEP_SCIPY * np.arange(SAMPLES)
    fine = np.linspace(0.0, t[-1], 20 * (SAMPLES - 1) + 1)
    a = np.interp(fine, t, motion.acceleration)
    built = math.pi / (2.0 * STANDARD_GRAVITY) * cumulative_trapezoid(a * a, fine, initial=0.0)
    span = float(np.interp(0.95 * built[-1], built, fine) - np.interp(0.05 * built[-1], built, fine))
    velocity = cumulative_trapezoid(a, fine, initial=0.0)
    wanted = {
        "PGA": np.abs(a).max(),
        "PGV": np.abs(velocity[::20]).max(),
        "PGD": np.abs(cumulative_trapezoid(velocity, fine, initial=0.0)[::20]).max(),
        "Arias": built[-1],
        "CAV": trapezoid(np.abs(a), fine),
        "D5-95": span,
    }
    tolerance = {"Arias": 1e-3, "D5-95": STEP_SCIPY / span} | dict.fromkeys(("PGA", "PGV"), 1e-12)
    for name, value in wanted.items():
        assert parse(name).value({"x": motion}) == pytest.approx(value, rel=tolerance.get(name, 1e-4)), name


@pytest.mark.parametrize(
    ("place", "measure"),
    [
        ("D5-95:x", lambda: parse("D5-95").factor(1.0, {"x": shaking()})),
        ("PGA:x", lambda: parse("PGA").factor(1.0, {"x": shaking().scaled(0.0)})),
        ("PGA:rotd50", lambda: measured("PGA:rotd50", shaking())),
        ("PGA:larger", lambda: measured("PGA:larger", shaking(), shaking(count=300))),
    ],
)
def test_what_cannot_be_measured_or_scaled_is_named(place: str, measure: Callable[[], float]) -> None:
    with refused_at(place):
        measure()
