# SPDX-License-Identifier: GPL-3.0-or-later
r"""From the series of a file to accelerations: which quantity it is, in which unit, and its derivative where it is another.

File and user have to agree. What the file says first is its unit, then its heading; a channel code or a comment is a hint, which the key
``quantity`` overrules. A series that is not an acceleration is differentiated only where that key asks for it. Nothing is guessed.

**Derivative.** The samples are taken for those of a quintic spline, whose slope at the knots is

    h v'_k = 10/24 (c_{k+1} - c_{k-1}) + 1/24 (c_{k+2} - c_{k-2}),

with c the coefficients of its B-splines, found by recursive filters (Unser, IEEE Signal Processing Magazine 16(6), 1999). Up to half the
Nyquist frequency it is right to 0.6 %, where the difference of two neighbours is a third too small. The series goes on as its point
reflection beyond its ends. A recorded displacement is differentiated twice.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from loads.readers import RawRecord
from loads.readers.quantity import Stated
from loads.readers.units import UNITS, measured_by
from masonry_cd.foundation.errors import InputError

DERIVATIVES = {"acceleration": 0, "velocity": 1, "displacement": 2}
REACH = 32  # samples beyond an end that its slope depends on: 0.43^32 is 2e-12
SHORTEST, LONGEST = 1e-6, 10.0  # step [s]: no digitiser is faster, and no shaking is left in what is slower
LARGEST = 1e12  # [m/s2]: beyond it squares and sums of samples lose their sense; counts of 32 bit in g are below


class Keys(NamedTuple):
    """Statements of the user about the values of a file."""

    quantity: str | None = None
    units: str | None = None
    calibration: float | None = None


def accelerations(raw: RawRecord, keys: Keys, where: str, path: str) -> tuple[np.ndarray, str]:
    """The accelerations of a series [m/s2], and which quantity it was.

    Args:
        raw: as read.
        keys: of the user.
        where: the table of these keys in messages.
        path: the file in messages.

    Raises:
        InputError: the quantity or the unit is missing, file and keys contradict each other, a step or a value that no motion has.
    """
    found = _quantity(raw, keys, where, path)
    size = _size(raw, found, keys.units, where, path)
    if raw.counts and keys.calibration is None:
        raise InputError(
            f"{where}.calibration",
            f"missing, and {path} holds whole numbers, as counts of a digitiser; what one means, in units; "
            "calibration = 1 where they are no counts",
        )
    if not SHORTEST <= raw.step <= LONGEST:
        raise InputError(f"{where}.path", f"{path}: a time step of {raw.step:.4g} s; records have {SHORTEST:g} to {LONGEST:g} s")
    if len(raw.values) < 2:
        raise InputError(f"{where}.path", f"{path}: {len(raw.values)} samples are no record")
    with np.errstate(over="ignore", invalid="ignore"):  # what overflows is beyond LARGEST
        values = raw.values * size
        for _ in range(DERIVATIVES[found]):
            values = derivative(values, raw.step)
    worst = float(np.abs(values).max(initial=0.0))
    if not worst <= LARGEST:
        raise InputError(f"{where}.path", f"{path}: an acceleration of {worst:.4g} m/s2, at most {LARGEST:g} is allowed")
    return values, found


def derivative(values: np.ndarray, step: float) -> np.ndarray:
    """The slope of a series (n,) at its samples, see the head of this file.

    Args:
        values: at least two.
        step: [s].
    """
    from scipy import ndimage  # takes a while to load

    longer = np.pad(values, REACH, mode="reflect", reflect_type="odd")
    c = ndimage.spline_filter1d(longer, order=5, mode="mirror")
    k = np.arange(REACH, REACH + len(values))
    return np.asarray((10.0 * (c[k + 1] - c[k - 1]) + (c[k + 2] - c[k - 2])) / (24.0 * step))


def _quantity(raw: RawRecord, keys: Keys, where: str, path: str) -> str:
    """Return the quantity of the series."""
    asked, units = keys.quantity, keys.units
    by_key = _by_unit(units, f'units = "{units}"')
    if units is not None and by_key is None:
        known = "; ".join(f"{', '.join(sizes)} of {quantity}" for quantity, sizes in UNITS.items())
        raise InputError(f"{where}.units", f'unknown unit "{units}"; known: {known}')
    firm = _firm(raw, path)
    if firm and asked not in (None, firm.quantity):
        raise InputError(
            f"{where}.quantity", f'"{asked}", but {path} says {firm.quantity} ({firm.by}); leave the key out or correct the file'
        )
    hint = None if raw.stated is None or raw.stated.firm else raw.stated
    if firm is None and asked is None and hint is not None and hint.quantity != "acceleration":
        raise InputError(f"{where}.quantity", _asking(hint, path, overrule=True))
    if asked is not None:
        found = Stated(asked, f'quantity = "{asked}"', firm=True)
    else:
        found = firm or hint or by_key or Stated("acceleration", "", firm=False)
    if by_key and by_key.quantity != found.quantity:
        raise InputError(f"{where}.units", f'"{units}" is a unit of {by_key.quantity}, but {path} is one of {found.quantity} ({found.by})')
    if asked is None and found.quantity != "acceleration":
        raise InputError(f"{where}.quantity", _asking(found, path, overrule=False))
    return found.quantity


def _firm(raw: RawRecord, path: str) -> Stated | None:
    """Return the quantity that the file itself states beyond doubt."""
    unit = None if raw.unit is None else _by_unit(raw.unit, f'its unit "{raw.unit}"')
    heading = raw.stated if raw.stated is not None and raw.stated.firm else None
    if unit and heading and unit.quantity != heading.quantity:
        both = f"of {heading.quantity} by {heading.by}, of {unit.quantity} by {unit.by}"
        raise InputError(path, f"contradicts itself: {both}; correct the file")
    return heading or unit


def _by_unit(unit: str | None, by: str) -> Stated | None:
    known = None if unit is None else measured_by(unit)
    return Stated(known[0], by, firm=True) if known else None


def _asking(claim: Stated, path: str, overrule: bool) -> str:
    """That the user has to say what the series is."""
    start = f"missing, and {path} is "
    if not claim.quantity:
        return f'{start}of {claim.by}; say which, "acceleration", "velocity" or "displacement"'
    asks = f'quantity = "{claim.quantity}" differentiates it'
    if overrule:
        asks += '; quantity = "acceleration" where its samples have been made accelerations'
    return f"{start}a record of {claim.quantity} ({claim.by}), where one of acceleration is needed; {asks}"


def _size(raw: RawRecord, quantity: str, units: str | None, where: str, path: str) -> float:
    """Size of the record's unit in SI."""
    given = None if units is None else measured_by(units)
    written = None if raw.unit is None else measured_by(raw.unit)
    if given is not None and written is not None and not np.isclose(given[1], written[1], atol=0.0):
        raise InputError(f"{where}.units", f'"{units}", but {path} says "{raw.unit}"; leave the key out or correct the file')
    found = given or written
    if found is None:
        says = f'says "{raw.unit}", which is not a known unit' if raw.unit else "does not name its unit"
        raise InputError(f"{where}.units", f"missing, and {path} {says}; give one of {', '.join(UNITS[quantity])}")
    return found[1]
