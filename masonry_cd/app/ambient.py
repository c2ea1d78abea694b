# SPDX-License-Identifier: GPL-3.0-or-later
"""An ambient record of a modal check: the modes identified from it as numbers, text and files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.analysis.modal.ambient import AmbientRecord, Identification, identify
from masonry_cd.analysis.modal.ambient_records import read_ambient
from masonry_cd.analysis.modal.measured_modes import MeasuredMode, shape_rows
from masonry_cd.foundation.csv_files import write_rows


@dataclass(frozen=True, eq=False)
class Ambient:
    """An ambient record with what was identified from it."""

    record: AmbientRecord
    found: Identification

    @property
    def modes(self) -> list[MeasuredMode]:
        """The modes as those read from a file, at the places of the sensors."""
        record, out = self.record, []
        for number, mode in enumerate(self.found.modes, start=1):
            shape = np.full((len(record.names), 3), np.nan)
            shape[record.sensor, record.axis] = mode.shape
            out.append(MeasuredMode(number, mode.frequency, record.points, shape, record.places))
        return out

    def facts(self) -> dict[str, Any]:
        """Return what modal.json holds of it."""
        found = self.found
        return {
            "frequency_hz": [mode.frequency for mode in found.modes],
            "damping": [mode.damping for mode in found.modes],
            "frequency_scatter": [mode.scatter for mode in found.modes],
            "orders_stable": [mode.orders for mode in found.modes],
            "orders": found.orders,
            "further_modes": found.left,
            "block_rows": found.rows,
            "rate_hz": found.rate,
            "band_hz": list(found.band),
            "duration_s": len(self.record.values) * self.record.step,
        }

    def lines(self) -> list[str]:
        """Return the modes as text, and what was chosen to find them."""
        found, record = self.found, self.record
        lines = [
            f"ambient: {len(record.values) * record.step:.4g} s of {record.values.shape[1]} channels at {found.rate:.4g} Hz, "
            f"{found.band[0]:.4g} to {found.band[1]:.4g} Hz, {found.rows} block rows, orders 2 to {2 * found.orders}",
            "  mode  frequency  scatter  damping   stable orders",
        ]
        for k, mode in enumerate(found.modes, start=1):
            share = f"{100 * mode.scatter:5.2f} %  {100 * mode.damping:5.2f} %"
            lines.append(f"  {k:4d} {mode.frequency:8.4g} Hz  {share}   {mode.orders} of {found.orders}")
        return lines + [f"  {found.left} more, of higher frequency: modal.modes has them"] * bool(found.left)

    def write(self, folder: Path, title: str, picture: bool) -> None:
        """Write ambient.csv and, where pictures are wanted, stabilisation.png into a folder."""
        modes = self.modes
        frequencies, shapes = [mode.frequency for mode in modes], [mode.shape for mode in modes]
        write_rows(folder / "ambient.csv", shape_rows(frequencies, self.record.names, self.record.points, shapes))
        if picture:
            from reports.stabilisation import draw_stabilisation

            draw_stabilisation(self.found, self.record, folder / "stabilisation.png", title)


def ambient_of(path: Path | None, sensors: Path | None, modes: int, band: tuple[float | None, float | None]) -> Ambient | None:
    """Read an ambient record, where there is one, and identify its lowest ``modes`` in a band of frequencies [Hz].

    Raises:
        InputError: a file that is wrong, or a record that shows no mode there.
    """
    if path is None or sensors is None:
        return None
    record = read_ambient(path, sensors)
    return Ambient(record, identify(record, modes, *band))
