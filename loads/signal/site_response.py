# SPDX-License-Identifier: GPL-3.0-or-later
r"""From the motion of a rock outcrop to that of the ground surface: vertical shear waves through horizontal layers on a half-space.

In layer i, with z down from its top, u = (A_i exp(i k_i z) + B_i exp(-i k_i z)) exp(i w t), where k_i = w sqrt(rho_i / G*_i). At the
surface A = B; displacement and stress go on at each interface, with the ratio of impedances a_i = sqrt(rho_i G*_i / (rho_i+1 G*_i+1)):

    2 A_i+1 = A_i (1 + a_i) exp(i k_i h_i) + B_i (1 - a_i) exp(-i k_i h_i)
    2 B_i+1 = A_i (1 - a_i) exp(i k_i h_i) + B_i (1 + a_i) exp(-i k_i h_i)

and the surface moves by 1 / A of the half-space times the outcrop (Kramer, Geotechnical Earthquake Engineering, 1996, ch. 7). The complex
modulus G* = G (sqrt(1 - 4 D^2) + 2 i D) has the size G and the damping ratio D (Dormieux & Canou, 1990).

A layer with a plasticity index is **equivalent-linear** (Schnabel, Lysmer & Seed, EERC 72-12, 1972): G and D are those of 0.65 of its
largest shear strain, recomputed until they change by less than 0.1 %. Their curves are those of Darendeli (Univ. of Texas at Austin, 2001),
at 1 Hz and 10 cycles, by the mean effective stress s' in atmospheres, with horizontal stresses half the vertical one:

    G / G_max = 1 / (1 + (g / g_r)^0.919),    g_r = (0.0352 + 0.0010 PI OCR^0.3246) s'^0.3483  [%]
    D = 0.6198 (G / G_max)^0.1 D_M + D_min,   D_min = (0.8005 + 0.0129 PI OCR^-0.1069) s'^-0.2889  [%]

with Masing's damping D_M of the hyperbola corrected by three coefficients. Layers are cut so that each part is at most a fifth of the
wave length at 25 Hz. One strain stands for all of the shaking, so the method is refused above 1 % in a layer.
"""

from __future__ import annotations

import cmath
import math
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from pydantic import BaseModel, Field, model_validator

from loads.motion import STANDARD_GRAVITY, Positive, strict
from loads.signal.baseline import GroundHistory, correct, integrate
from masonry_cd.foundation import libm
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.quantities import per_cent
from masonry_cd.foundation.units import Unit, Usual

EFFECTIVE = 0.65  # of the largest strain, for G and D
CHANGE, MOST = 1e-3, 60  # of G and D from one iteration to the next, and how many there may be
LARGEST = 0.01  # shear strain
HIGHEST, PARTS = 25.0, 5.0  # frequency that layers are cut for [Hz], parts of its wave length
ATMOSPHERE, WATER = 101325.0, 1000.0  # [Pa], [kg/m3]
AT_REST = 0.5  # horizontal over vertical effective stress
CURVED, SCALED = 0.919, 0.6198  # exponent of the strain, factor on Masing's damping: 0.6329 - 0.0057 ln(10 cycles)
MASING = (  # coefficients of Masing's damping and its powers
    0.2523 + 1.8618 * CURVED - 1.1143 * CURVED**2,
    -0.0095 - 0.0710 * CURVED + 0.0805 * CURVED**2,
    0.0003 + 0.0002 * CURVED - 0.0005 * CURVED**2,
)
RINGING = 0.05  # of the surface's PGA, after the record has ended

Velocity = Annotated[Positive, Unit("m/s"), Usual(50.0, 3500.0, "soils have 100 to 800 m/s, rock up to 3500")]
Density = Annotated[Positive, Unit("kg/m3"), Usual(1000.0, 3000.0, "soils have 1500 to 2200 kg/m3, rock up to 2800", ("t/m3", "kN/m3"))]
Ratio = Annotated[float, Field(ge=0.0, le=0.2)]


class SoilLayer(BaseModel):
    """One of the layers of ``site``, from the surface down."""

    model_config = strict

    thickness: Annotated[Positive, Unit("m"), Usual(0.2, 500.0, "layers are 1 to 100 m thick", ("mm", "cm"))]
    """Thickness of the layer."""
    shear_velocity: Velocity
    """Velocity of shear waves at small strain."""
    density: Density
    """Density of the soil, with its water."""
    damping: Ratio | None = None
    """Damping ratio, at small strain where the layer has a plasticity index, whose curves give it when not given."""
    plasticity_index: Annotated[float, Field(ge=0.0, le=100.0)] | None = None
    """Plasticity index in per cent, 0 for sand and gravel: the layer softens and damps with its strain. Without it the layer is linear."""
    overconsolidation: Annotated[float, Field(ge=1.0, le=32.0)] = 1.0
    """Overconsolidation ratio, for the curves."""

    @model_validator(mode="after")
    def _has_damping(self) -> Self:
        if self.damping is None and self.plasticity_index is None:
            raise ValueError("give damping, or plasticity_index, whose curves have it")
        return self


class Bedrock(BaseModel):
    """The half-space below the layers, on whose outcrop the record was taken."""

    model_config = strict

    shear_velocity: Velocity
    """Velocity of shear waves in the rock."""
    density: Density
    """Density of the rock."""
    damping: Ratio = 0.0
    """Damping ratio of the rock."""


class SiteTable(BaseModel):
    """The table ``site`` of a record."""

    model_config = strict

    layers: Annotated[tuple[SoilLayer, ...], Field(strict=False, min_length=1, max_length=100)]
    """Layers from the surface down, a table each."""
    bedrock: Bedrock
    """Half-space below the layers."""
    water_depth: Annotated[float, Unit("m"), Field(ge=0.0)] | None = None
    """Depth of the water table; below all layers when not given."""


class Site(NamedTuple):
    """The parts of the layers, then the half-space: n + 1 of them."""

    layer: np.ndarray  # (n,) which of the layers
    thickness: np.ndarray  # (n,) [m]
    density: np.ndarray  # (n + 1,) [kg/m3]
    modulus: np.ndarray  # (n + 1,) at small strain [Pa]
    damping: np.ndarray  # (n + 1,) at small strain
    reference: np.ndarray  # (n,) strain g_r; infinite where the layer is linear


class SiteMotion(NamedTuple):
    """The motion of the surface and how it came about."""

    history: GroundHistory
    facts: dict[str, Any]
    lines: list[str]
    warnings: list[str]


def surface_motion(table: SiteTable, rock: GroundHistory, order: int, where: str) -> SiteMotion:
    """Carry the motion of a rock outcrop to the surface; it is as long as the record.

    Args:
        table: the site.
        rock: motion of the outcrop.
        order: of the correction of the baseline, by which the motion of the surface ends at rest as well.
        where: the record in messages.

    Raises:
        InputError: a layer shears by more than the method is good for, or floats.
    """
    count, key = len(rock.acceleration), f"{where}.site"
    site = _parts(table, key)
    length = 1 << (2 * count - 1).bit_length()  # zeros behind, in which the ground comes to rest
    spectrum, omega = np.fft.rfft(rock.acceleration, length), 2.0 * np.pi * np.fft.rfftfreq(length, rock.step)
    softer, damping, change, turns = np.ones(len(site.layer)), site.damping[:-1], math.inf, 0
    while change >= CHANGE and turns < MOST:
        turns += 1
        gain, strain = _response(site, softer, damping, omega)
        peaks = np.array([np.abs(np.fft.irfft(_times(row, spectrum), length)).max() for row in strain])
        new_softer, new_damping = _curves(site, EFFECTIVE * peaks)
        change = float(max(np.abs(new_softer / softer - 1.0).max(), np.abs(new_damping - damping).max() / max(new_damping.max(), 1e-9)))
        if change >= CHANGE:
            softer, damping = new_softer, new_damping
    if not np.isfinite(peaks).all():
        raise InputError(key, f"waves at {0.5 / rock.step:g} Hz do not come through the layers: resample the record to a longer time step")
    if peaks.max() > LARGEST:
        worst = int(site.layer[peaks.argmax()])
        raise InputError(
            f"{key}.layers[{worst}]",
            f"shears by {per_cent(float(peaks.max()))}, beyond {per_cent(LARGEST)}: one modulus does not stand for soil that yields; "
            "a nonlinear analysis of the site is needed",
        )
    whole = np.fft.irfft(_times(gain, spectrum), length)
    facts = _facts(site, peaks, softer, damping) | {"iterations": turns, "change": change, "converged": change < CHANGE}
    history, size = correct(integrate(whole[:count], rock.step), order), np.sqrt(gain.real**2 + gain.imag**2)
    rock_pga, pga = (float(np.abs(one.acceleration).max()) for one in (rock, history))
    most = int(size.argmax())
    facts |= {"rock_pga": rock_pga, "pga_ratio": pga / rock_pga, "frequency": float(omega[most] / (2.0 * np.pi)), "gain": float(size[most])}
    return SiteMotion(history, facts, _lines(facts, pga, where), _warnings(facts, float(np.abs(whole[count:]).max()) / pga, where))


def _parts(table: SiteTable, key: str) -> Site:
    """The layers cut so that waves are resolved."""
    rows, depth, weight = [], 0.0, 0.0  # weight: total vertical stress above [Pa]
    water = np.inf if table.water_depth is None else table.water_depth
    for number, layer in enumerate(table.layers):
        parts = int(np.ceil(layer.thickness * PARTS * HIGHEST / layer.shear_velocity))
        thick, index = layer.thickness / parts, layer.plasticity_index
        for middle in thick * (np.arange(parts) + 0.5):
            pressed = weight + STANDARD_GRAVITY * layer.density * middle
            pressed -= STANDARD_GRAVITY * WATER * max(0.0, depth + middle - water)
            if pressed <= 0.0:
                raise InputError(f"{key}.layers[{number}].density", f"is too small: at {depth + middle:.3g} m the water bears all above it")
            stress = pressed * (1.0 + 2.0 * AT_REST) / 3.0 / ATMOSPHERE
            damped, reference = layer.damping or 0.0, np.inf
            if index is not None:
                plastic, ocr = index, layer.overconsolidation
                reference = 0.01 * (0.0352 + 0.0010 * plastic * ocr**0.3246) * stress**0.3483
                damped = layer.damping or 0.01 * (0.8005 + 0.0129 * plastic * ocr**-0.1069) * stress**-0.2889
            rows.append((number, thick, layer.density, layer.density * layer.shear_velocity**2, damped, reference))
        depth, weight = depth + layer.thickness, weight + STANDARD_GRAVITY * layer.density * layer.thickness
    columns, rock = [np.array(column) for column in zip(*rows, strict=True)], table.bedrock
    below = {2: rock.density, 3: rock.density * rock.shear_velocity**2, 4: rock.damping}
    return Site(*(np.append(column, below[k]) if k in below else column for k, column in enumerate(columns)))


def _response(site: Site, softer: np.ndarray, damping: np.ndarray, omega: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Surface over outcrop (F,), and shear strains at mid-height of the n parts over its acceleration (n, F) [s2/m].

    Args:
        site: its n parts.
        softer: (n,) moduli over those at small strain.
        damping: (n,) ratios.
        omega: (F,) from zero on, evenly spaced [rad/s].
    """
    damped, moduli = np.append(damping, site.damping[-1]), site.modulus * np.append(softer, 1.0)
    modulus = [g * complex(math.sqrt(1.0 - 4.0 * d**2), 2.0 * d) for g, d in zip(moduli.tolist(), damped.tolist(), strict=True)]
    number = [cmath.sqrt(rho / g) for rho, g in zip(site.density.tolist(), modulus, strict=True)]  # wave number over omega [s/m]
    impedance = [cmath.sqrt(rho * g) for rho, g in zip(site.density.tolist(), modulus, strict=True)]
    up = down = np.ones(len(omega), dtype=complex)
    strains = []
    for i, thick in enumerate(site.thickness.tolist()):
        turn = cmath.exp(0.5j * thick * number[i] * float(omega[1]))
        half, back = _powers(turn, len(omega)), _powers(1.0 / turn, len(omega))
        up, down = _times(up, half), _times(down, back)
        strains.append(_times(1j * number[i], up - down))
        ratio, up, down = impedance[i] / impedance[i + 1], _times(up, half), _times(down, back)
        more, less = 0.5 * (1.0 + ratio), 0.5 * (1.0 - ratio)
        up, down = _times(more, up) + _times(less, down), _times(less, up) + _times(more, down)
    fall, gain = np.zeros(len(omega)), (up.real - 1j * up.imag) / (up.real**2 + up.imag**2)
    fall[1:] = -0.5 / omega[1:]
    return gain, np.stack([_times(strain, fall * gain) for strain in strains])


def _times(a: complex | np.ndarray, b: np.ndarray) -> np.ndarray:
    """Products of complex numbers, part by part: others round by the processor."""
    return np.asarray(a.real * b.real - a.imag * b.imag + 1j * (a.real * b.imag + a.imag * b.real))


def _powers(base: complex, count: int) -> np.ndarray:
    """The powers 0 to count - 1 of a number, by doubling."""
    out = np.ones(1, dtype=complex)
    while len(out) < count:
        out, base = np.concatenate([out, _times(base, out)]), base * base
    return out[:count]


def _curves(site: Site, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """G over that at small strain, and damping ratios (n,), at effective strains (n,)."""
    x = np.maximum(strain / site.reference, 1e-4)  # below which nothing changes
    softer = 1.0 / (1.0 + libm.exp(CURVED * libm.log(x)))
    hyperbola = 100.0 / np.pi * (4.0 * (x - libm.log(1.0 + x)) * (1.0 + x) / x**2 - 2.0)
    masing = MASING[0] * hyperbola + MASING[1] * hyperbola**2 + MASING[2] * hyperbola**3
    linear = np.isinf(site.reference)
    more = 0.01 * SCALED * libm.exp(0.1 * libm.log(softer)) * masing
    return np.where(linear, 1.0, softer), site.damping[:-1] + np.where(linear, 0.0, more)


def _facts(site: Site, peaks: np.ndarray, softer: np.ndarray, damping: np.ndarray) -> dict[str, Any]:
    """Largest strain of each layer, its least modulus over that at small strain, and largest damping ratio."""
    layers = [site.layer == number for number in range(int(site.layer[-1]) + 1)]
    return {
        "layers": [
            {"strain": float(peaks[own].max()), "modulus": float(softer[own].min()), "damping": float(damping[own].max())} for own in layers
        ]
    }


def _lines(facts: dict[str, Any], pga: float, where: str) -> list[str]:
    """What the layers did to the motion, on two lines."""
    strains = ", ".join(f"{100.0 * layer['strain']:.2g} %" for layer in facts["layers"])
    least = min(layer["modulus"] for layer in facts["layers"])
    return [
        f"{where}   site: PGA {facts['rock_pga']:.4g} m/s2 on rock, {pga:.4g} at the surface, {facts['pga_ratio']:.3g} times as much; "
        f"{facts['gain']:.3g} times at {facts['frequency']:.3g} Hz",
        f"{where}   site: layers shear by up to {strains}; moduli down to {per_cent(least)}, after {facts['iterations']} iterations",
    ]


def _warnings(facts: dict[str, Any], ringing: float, where: str) -> list[str]:
    lines = []
    if not facts["converged"]:
        lines.append(f"{where}.site is not solved: after {MOST} iterations moduli and damping still change by {per_cent(facts['change'])}")
    if ringing > RINGING:
        lines.append(f"{where}.site: the ground still shakes at {per_cent(ringing)} of its PGA where the record ends, and is cut off there")
    return lines
