# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays that come from a file, checked before compiled kernels index with them: names, types, shapes, ranges, finite values."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from masonry_cd.foundation.errors import InputError

LARGEST = 1e15  # magnitude beyond which no number of a run's state is one, in any unit of it


class Stored:
    """Arrays by name.

    Args:
        arrays: as read.
        where: what a message begins with.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], where: str = "") -> None:
        self._arrays, self._where, self._seen = arrays, where, set[str]()

    def part(self, head: str) -> Stored:
        """The arrays under ``head/``, by the rest of their names."""
        found = {name.removeprefix(f"{head}/"): array for name, array in self._arrays.items() if name.startswith(f"{head}/")}
        self._seen.update(f"{head}/{name}" for name in found)
        return Stored(found, f"{self._where}{head}/")

    def names(self) -> list[str]:
        """Names that have not been read yet."""
        return [name for name in self._arrays if name not in self._seen]

    def holds(self, name: str) -> bool:
        """Return True if there is an array of a name."""
        return name in self._arrays

    def real(self, name: str, *shape: int | None, finite: bool = True, kind: type = np.float64) -> np.ndarray:
        """Real numbers of a shape, None for any length; ``finite`` and not beyond LARGEST.

        Raises:
            InputError: missing, or not what it should be.
        """
        array = self._of(name, shape, kind)
        if finite and not (np.abs(array) <= LARGEST).all():
            self.refuse(name, "not finite, or far too large")
        return array

    def whole(self, name: str, *shape: int | None, low: int | np.ndarray = 0, high: int | np.ndarray | None = None) -> np.ndarray:
        """Whole numbers of a shape from ``low`` up to, but not, ``high``.

        Raises:
            InputError: missing, or not what it should be.
        """
        array = self._of(name, shape, np.int64)
        if (array < low).any() or (high is not None and (array >= high).any()):
            self.refuse(name, "out of range")
        return array

    def flags(self, name: str, *shape: int | None) -> np.ndarray:
        """Flags of a shape.

        Raises:
            InputError: missing, or not what it should be.
        """
        return self._of(name, shape, np.bool_)

    def any(self, name: str) -> np.ndarray:
        """An array, whatever it is."""
        self._seen.add(name)
        return self._arrays[name]

    def check_all_read(self) -> None:
        """Refuse arrays that have not been read.

        Raises:
            InputError: names the first.
        """
        for name in self.names():
            self.refuse(name, "unknown")

    def refuse(self, name: str, why: str) -> None:
        """Raise an InputError that names an array."""
        raise InputError(f"{self._where}{name}", str(why))

    def _of(self, name: str, shape: tuple[int | None, ...], kind: type) -> np.ndarray:
        """An array of a type and a shape."""
        self._seen.add(name)
        if name not in self._arrays:
            self.refuse(name, "missing")
        array = self._arrays[name]
        if array.dtype != np.dtype(kind):
            self.refuse(name, f"of type {array.dtype}, not {np.dtype(kind)}")
        if array.ndim != len(shape) or any(want is not None and want != size for want, size in zip(shape, array.shape, strict=True)):
            self.refuse(name, f"of shape {array.shape}, not {tuple('any' if want is None else want for want in shape)}")
        return array
