# SPDX-License-Identifier: GPL-3.0-or-later
r"""Measured modes: read from a CSV file, paired with computed ones, and compared.

    mode,frequency_hz,point,x_m,y_m,z_m,ux,uy,uz
    1,3.42,A1,0.0,1.0,8.5,0.02,1.00,
    1,,A2,6.0,1.0,8.5,0.03,0.71,
    2,5.10

One row per mode and point; ``mode`` and ``frequency_hz`` (or ``period_s``) suffice where only frequencies are known. A component left
empty was not measured; components need no unit, since a shape is given up to a factor. Lines that begin with # are remarks.

Two shapes are compared by the modal assurance criterion over the measured components (Allemang & Brown, Proc. 1st IMAC, 1982):

    MAC = (phi_m . phi_c)^2 / ((phi_m . phi_m) (phi_c . phi_c)),        1 for the same shape, 0 for orthogonal ones.

Measured modes with a shape are paired with the computed ones so that the sum of the MAC is largest; those without, by their number.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.optimize import linear_sum_assignment

from masonry_cd.analysis.modal.modes import Modes
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.fields import finite_number
from masonry_cd.foundation.files import read_text

LENGTHS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
PLACES = {f"{axis}_{unit}": (axis, factor) for axis in "xyz" for unit, factor in LENGTHS.items()}
COLUMNS = ("mode", "frequency_hz", "period_s", "point", *PLACES, "ux", "uy", "uz")
WITH_UNIT = {"frequency": "frequency_hz", "period": "period_s", "x": "x_m", "y": "y_m", "z": "z_m"}
SLOWEST, FASTEST = 1e-6, 1e9  # frequencies that a structure may have [Hz]
FAR = 0.05  # a measured point may lie this share of the structure's size outside it
COMPONENTS = ("ux", "uy", "uz")


@dataclass(frozen=True, eq=False)
class MeasuredMode:
    """One measured mode; P points, none where only the frequency is known."""

    mode: int
    frequency: float  # [Hz]
    points: np.ndarray  # (P, 3) [m]
    shape: np.ndarray  # (P, 3), NaN where not measured
    places: tuple[str, ...]  # file and line of each point

    @property
    def has_shape(self) -> bool:
        """True where components were measured."""
        return bool(np.isfinite(self.shape).any())


@dataclass(frozen=True)
class ModePair:
    """A measured mode next to the computed one that answers to it."""

    measured_mode: int
    measured: float  # [Hz]
    mode: int | None  # number of the computed mode, from 1; None where too few were computed
    computed: float  # [Hz]
    mac: float  # NaN without a measured shape

    @property
    def error_percent(self) -> float:
        """Computed less measured frequency, over the measured one [%]."""
        return 100.0 * (self.computed / self.measured - 1.0)


def read_measured(path: Path | str) -> list[MeasuredMode]:
    """Read measured modes, by ascending number.

    Raises:
        InputError: no such file, a column that is unknown, missing or without a unit, or a value that is wrong; names file and line.
    """
    path = Path(path)
    header, table = table_rows(path, COLUMNS, f"holds no modes; the first line names the columns: {', '.join(COLUMNS[:3])} ...")
    _check_header(header, path)
    rows: dict[int, list[tuple[str, dict[str, str]]]] = {}
    for where, row in table:
        rows.setdefault(_mode_number(row["mode"], where), []).append((where, row))
    return [_mode(mode, rows[mode]) for mode in sorted(rows)]


def numbered_lines(path: Path, empty: str) -> list[tuple[str, str]]:
    """Return file and line number, and text, of the lines of a table without remarks: the heading and one more, or ``empty`` is said.

    Raises:
        InputError: no such file, not a text, or too few lines.
    """
    try:
        lines = read_text(path, encoding="utf-8-sig").splitlines()
    except OSError as failure:
        raise InputError(path, f"cannot be read, {failure.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(path, "not a text file in UTF-8") from None
    numbered = [(f"{path}:{n}", line) for n, line in enumerate(lines, start=1) if line.strip() and not line.lstrip().startswith("#")]
    if len(numbered) < 2:
        raise InputError(path, empty)
    return numbered


def table_rows(path: Path, columns: Sequence[str], empty: str) -> tuple[list[str], list[tuple[str, dict[str, str]]]]:
    """Return the heading of a table of known columns, and file and line, and cells by column, of each row.

    Raises:
        InputError: as of :func:`numbered_lines`, a column that is unknown, without a unit or there twice, or too many cells.
    """
    (where, heading), *lines = numbered_lines(path, empty)
    header = cells(heading, where)
    for name in header:
        if name in WITH_UNIT and WITH_UNIT[name] in columns:
            raise InputError(path, f'column "{name}" has no unit; write {WITH_UNIT[name]}')
        if name not in columns:
            raise InputError(path, f'unknown column "{name}"{suggest(name, columns)}; known: {", ".join(columns)}')
        if header.count(name) > 1:
            raise InputError(path, f'column "{name}" occurs twice')
    rows = []
    for where, line in lines:
        row = cells(line, where)
        if len(row) > len(header):
            raise InputError(where, f"{len(row)} values under {len(header)} columns")
        rows.append((where, dict(zip(header, row + [""] * (len(header) - len(row)), strict=True))))
    return header, rows


def cells(line: str, where: str) -> list[str]:
    """Return the cells of a line.

    Raises:
        InputError: it is not a line of a table.
    """
    try:
        return [cell.strip() for cell in next(csv.reader([line]))]
    except csv.Error as failure:
        raise InputError(where, f"no line of a table: {failure}") from None


def _check_header(header: Sequence[str], path: Path) -> None:
    """The columns that are needed; places complete."""
    if "mode" not in header:
        raise InputError(path, "column mode: missing")
    if ("frequency_hz" in header) == ("period_s" in header):
        raise InputError(path, "should have one of the columns frequency_hz and period_s")
    axes = [PLACES[name][0] for name in header if name in PLACES]
    moving = [name for name in header if name in COMPONENTS]
    if (axes or moving) and (sorted(axes) != ["x", "y", "z"] or not moving):
        raise InputError(path, "a shape needs the columns x_m, y_m, z_m, each once, and one of ux, uy, uz or more")


def _mode_number(text: str, where: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) < 7 and int(text) >= 1):
        raise InputError(where, f'mode: should be a number from 1, got "{text}"')
    return int(text)


def number(text: str, column: str, where: str) -> float:
    """Return the number in a cell.

    Raises:
        InputError: it is none.
    """
    value = finite_number(text)
    if value is None:
        raise InputError(where, f'{column}: should be a number, got "{text}"')
    return value


def place_of(row: Mapping[str, str], where: str) -> list[float]:
    """Return x, y and z [m] of a row that has them."""
    place = {PLACES[name][0]: number(row[name], name, where) * PLACES[name][1] for name in row if name in PLACES}
    return [place[axis] for axis in "xyz"]


def _mode(mode: int, rows: Sequence[tuple[str, dict[str, str]]]) -> MeasuredMode:
    """One mode from its rows."""
    frequencies, points, shape, places = [], [], [], []
    for where, row in rows:
        for column in ("frequency_hz", "period_s"):
            if row.get(column):
                value = number(row[column], column, where)
                if value <= 0.0:
                    raise InputError(where, f"{column}: must be above 0, got {value:g}")
                frequencies.append(value if column == "frequency_hz" else 1.0 / value)
                if not SLOWEST <= frequencies[-1] <= FASTEST:
                    raise InputError(where, f"{column}: a frequency between {SLOWEST:g} and {FASTEST:g} Hz is needed, got {value:g}")
                if not math.isclose(frequencies[-1], frequencies[0], rel_tol=1e-9):
                    raise InputError(where, f"{column}: mode {mode} has another one before, {value:g}")
        if not any(row.get(name) for name in COMPONENTS):
            continue
        points.append(place_of(row, where))
        shape.append([number(row[name], name, where) if row.get(name) else math.nan for name in COMPONENTS])
        places.append(where)
    if not frequencies:
        raise InputError(rows[0][0], f"mode {mode} has no frequency")
    return MeasuredMode(mode, frequencies[0], np.reshape(points, (-1, 3)), np.reshape(shape, (-1, 3)), tuple(places))


def shape_rows(
    frequencies: Sequence[float] | np.ndarray, names: Sequence[str], points: np.ndarray, shapes: Sequence[np.ndarray] | np.ndarray
) -> list[dict[str, object]]:
    """Return shapes (n, P, 3) at points (P, 3) [m] as rows of a file of measured modes; what is not known is left empty."""
    rows = []
    for k, frequency in enumerate(frequencies):
        for name, point, shape in zip(names, points, shapes[k], strict=True):
            row: dict[str, object] = {"mode": k + 1, "frequency_hz": float(frequency), "point": name}
            row |= {f"{axis}_m": float(point[i]) for i, axis in enumerate("xyz")}
            rows.append(row | {f"u{axis}": "" if math.isnan(shape[i]) else float(shape[i]) for i, axis in enumerate("xyz")})
    return rows


def mac(first: np.ndarray, second: np.ndarray) -> float:
    """Modal assurance criterion of two real shapes of one size, over the entries that are known in both."""
    known = np.isfinite(first) & np.isfinite(second)
    a, b = _scaled(first[known]), _scaled(second[known])
    size = (a @ a) * (b @ b)
    return float((a @ b) ** 2 / size) if size > 0.0 else 0.0


def _scaled(shape: np.ndarray) -> np.ndarray:
    """A shape whose largest entry is 1, so that its square is a number; zeros stay zeros."""
    largest = float(np.abs(shape).max(initial=0.0))
    return shape / largest if largest > 0.0 else shape


def turned_like(modes: Modes, other: Modes) -> Modes:
    """Return the modes, each with the sign of the mode of another model that it resembles most."""
    signs = np.ones(modes.count)
    for k, shape in enumerate(modes.shapes):
        nearest = max(range(other.count), key=lambda i: mac(shape, other.shapes[i]))
        signs[k] = 1.0 if np.sum(shape * other.shapes[nearest]) >= 0.0 else -1.0
    return modes.turned(signs)


def mac_table(modes: Modes, measured: Sequence[MeasuredMode]) -> np.ndarray:
    """MAC of each measured mode with each computed one, (m, n); NaN where no shape was measured.

    Raises:
        InputError: a measured point that lies outside the structure; names its line.
    """
    out = np.full((len(measured), modes.count), np.nan)
    low, high = modes.points.min(axis=0), modes.points.max(axis=0)
    reach = FAR * float(np.linalg.norm(high - low)) + 1e-9
    for row, mode in enumerate(measured):
        if not mode.has_shape:
            continue
        computed, outside = modes.field.at(mode.points)
        if outside.max() > reach:
            worst = int(np.argmax(outside))
            at = ", ".join(f"{value:g}" for value in mode.points[worst])
            raise InputError(mode.places[worst], f"the point ({at}) m lies {outside[worst]:.3g} m outside the structure")
        out[row] = [mac(mode.shape, shape) for shape in computed]
    return out


def pair(modes: Modes, measured: Sequence[MeasuredMode]) -> list[ModePair]:
    """Pair measured modes with computed ones; see the head of this file."""
    table = mac_table(modes, measured)
    shaped = [row for row, mode in enumerate(measured) if mode.has_shape]
    partner: dict[int, int] = {}
    if shaped:
        rows, columns = linear_sum_assignment(table[shaped], maximize=True)
        partner = {shaped[row]: int(column) for row, column in zip(rows, columns, strict=True)}
    for row, mode in enumerate(measured):
        if row not in shaped and mode.mode <= modes.count and mode.mode - 1 not in partner.values():
            partner[row] = mode.mode - 1
    out = []
    for row, mode in enumerate(measured):
        column = partner.get(row)
        if column is None:
            out.append(ModePair(mode.mode, mode.frequency, None, math.nan, math.nan))
        else:
            out.append(ModePair(mode.mode, mode.frequency, column + 1, float(modes.frequencies[column]), float(table[row, column])))
    return out


def fit_factor(modes: Modes, measured: Sequence[MeasuredMode]) -> float:
    """The factor on the modulus with which the first measured frequency is met.

    Raises:
        InputError: no computed mode answers to the first measured one.
    """
    first = pair(modes, measured)[0]
    if first.mode is None:
        raise InputError("modal", f"mode {first.measured_mode} is measured, but only {modes.count} modes are computed; raise modal.modes")
    return (first.measured / first.computed) ** 2
