# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress in the elements of meshed blocks: largest principal stresses of a run, element by element, against the strength of the block.

An element has one stress; at the edge of a bent block the true one is higher, by two thirds of the elements' size over its depth, and near
the place of a concentrated force it grows as the mesh gets finer. Values are means over the time between two frames, as those of blocks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from masonry_cd.analysis.stress.peaks import AT_ONCE, NOTHING, Largest, principal, require_stress, strengths
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.block_arrays import Meshes
from masonry_cd.io.results import Results
from masonry_cd.io.summary_tables import ElementStressSummary

COLUMNS = (
    "block", "element", "x", "y", "z", "volume", "max_compression", "max_compression_time", "max_tension", "max_tension_time",
    "xx", "yy", "zz", "xy", "yz", "xz", "strength", "ratio",
)  # fmt: skip
NAMED = 5  # blocks that the summary names at most


@dataclass(frozen=True, eq=False)
class ElementPeaks:
    """The largest stresses of E elements; NaN in a run without a step.

    Attributes:
        block: (E,) number of the block of each.
        compression: (E,) largest compression, a principal stress, positive [Pa].
        compression_time: (E,) frame of it [s].
        tension: (E,) largest tension [Pa], negative where all principal stresses are compressions at all times.
        tension_time: (E,) [s].
        strength: (E,) of its block, NaN where there is none [Pa].
    """

    block: np.ndarray
    compression: np.ndarray
    compression_time: np.ndarray
    tension: np.ndarray
    tension_time: np.ndarray
    strength: np.ndarray

    @cached_property
    def ratio(self) -> np.ndarray:
        """(E,) largest compression over the strength."""
        return self.compression / self.strength

    def of_blocks(self, count: int) -> np.ndarray:
        """(B,) the largest compression of an element of each block; NaN of blocks that have none [Pa]."""
        out = np.full(count, np.nan)
        np.fmax.at(out, self.block, self.compression)
        return out


def require_meshes(results: Results) -> Meshes:
    """The meshes of a run.

    Raises:
        InputError: the run kept no stress, or has no meshed blocks.
    """
    require_stress(results)
    if results.meshes is None:
        raise InputError(
            results.path, "no block is cut into elements, or the run is of an older version, which kept only the stress of blocks"
        )
    return results.meshes


def element_peaks(results: Results) -> ElementPeaks | None:
    """The largest stresses of the elements of a run; None where no block is meshed, or no stress is kept."""
    meshes = results.meshes
    if meshes is None:
        return None
    compression, tension = Largest(len(meshes.elements)), Largest(len(meshes.elements))
    time = np.asarray(results.time, dtype=float)
    for first in range(1, results.frames, AT_ONCE):  # the first frame is before any step
        last = min(first + AT_ONCE, results.frames)
        values = principal(np.asarray(results.element_stress[first:last], dtype=float))
        compression.take(-values[..., 2], time[first:last])
        tension.take(values[..., 0], time[first:last])
    block = meshes.block_of_element
    return ElementPeaks(block, compression.value, compression.time, tension.value, tension.time, strengths(results)[0][block])


def centres(meshes: Meshes) -> np.ndarray:
    """(E, 3) centres of the elements as built [m]."""
    return np.asarray(meshes.nodes[meshes.elements].mean(axis=1))


def volumes(results: Results, meshes: Meshes) -> np.ndarray:
    """(E,) volumes of the elements [m3]; in a plane they are as thick as their block."""
    spans = meshes.nodes[meshes.elements[:, 1:]] - meshes.nodes[meshes.elements[:, :1]]
    across = np.cross(spans[:, 0], spans[:, 1])
    size = np.linalg.norm(across, axis=1) if spans.shape[1] == 2 else np.abs((across * spans[:, -1]).sum(axis=1))
    block = meshes.block_of_element
    whole = np.bincount(block, size, len(results.blocks))
    return np.asarray(size / whole[block] * np.array([b.mass_properties.volume - b.carried_volume for b in results.blocks])[block])


def element_columns(results: Results, peaks: ElementPeaks) -> dict[str, Any]:
    """The columns of element_stress.csv, (E,) each; elements count from 0 in each block, xx to xz are those of the last frame."""
    meshes = results.meshes
    assert meshes is not None
    first = np.repeat(meshes.element_start[:-1], np.diff(meshes.element_start))
    end = np.asarray(results.element_stress[results.frames - 1], dtype=float)
    values = (
        [results.blocks[b].name for b in peaks.block], np.arange(len(first)) - first, *centres(meshes).T, volumes(results, meshes),
        peaks.compression, peaks.compression_time, peaks.tension, peaks.tension_time, *end.T, peaks.strength, peaks.ratio,
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def element_summary(results: Results, peaks: ElementPeaks | None) -> ElementStressSummary | None:
    """The share of the elements in summary.json; None where there are none, and in a run without a step."""
    if peaks is None or not np.isfinite(peaks.compression).any():
        return None
    names = [block.name for block in results.blocks]
    pressed, pulled = int(np.nanargmax(peaks.compression)), int(np.nanargmax(peaks.tension))
    tension, compared, more = float(peaks.tension[pulled]), np.isfinite(peaks.strength), dict[str, Any]()
    if compared.any():
        above = np.flatnonzero(peaks.ratio > 1.0)
        worst = list(dict.fromkeys(peaks.block[above[np.argsort(-peaks.ratio[above], kind="stable")]].tolist()))
        named = tuple(names[b] for b in worst[:NAMED])
        more = {"compared": int(compared.sum()), "ratio_max": float(np.nanmax(peaks.ratio))}
        more |= {"above": len(above), "blocks_above": len(worst), "blocks_above_names": named}
    return ElementStressSummary(
        count=len(peaks.block),
        compression_max=float(peaks.compression[pressed]),
        compression_max_block=names[peaks.block[pressed]],
        compression_max_time=float(peaks.compression_time[pressed]),
        tension_max=tension if tension > NOTHING * float(peaks.compression[pressed]) else 0.0,
        tension_max_block=names[peaks.block[pulled]],
        tension_max_time=float(peaks.tension_time[pulled]),
        **more,
    )
