# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of blocks and joints on the page: tables of the largest, against the strength, and colours for the model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from masonry_cd.analysis.stress.elements import element_peaks
from masonry_cd.analysis.stress.peaks import StressPeaks, principal, stress_peaks
from masonry_cd.analysis.stress.summary import share_in_words, stress_lines, stress_summary
from masonry_cd.foundation.quantities import length, pressure
from masonry_cd.io.results import Results
from reports.drawing.parts import hexed
from reports.maps.stress_map import StressScale
from reports.page.section import Section
from reports.page.words import PageContext, number
from reports.settings import report_of

ROWS = 8  # of a table at most


def colours(results: Results, frames: np.ndarray) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """For the model: the classes of the compression, and the class of each block at some frames (F, B) and over the run (B,).

    Classes count from one; 0 is none, as of supports. Nothing where the run kept no stress.
    """
    if not results.has_stress:
        return {}, {}
    peaks = stress_peaks(results, report_of(results.tables).opened)
    scale = StressScale(float(np.nan_to_num(peaks.compression).max(initial=0.0)))

    def classes(compression: np.ndarray) -> np.ndarray:
        ranks = np.searchsorted(scale.bounds, np.nan_to_num(compression), side="right").clip(1)
        return np.where(np.isnan(compression), 0, ranks).astype(np.uint8)

    of_frames = np.array([classes(-principal(np.asarray(results.stress[frame], dtype=float))[:, 2]) for frame in frames.tolist()])
    facts = {
        "unit": scale.unit,
        "bounds": [bound * scale.factor for bound in scale.bounds],
        "colours": [hexed(colour) for colour in scale.colours],
    }
    return {"compression": facts}, {"pressed": np.ascontiguousarray(of_frames), "pressed_most": classes(peaks.compression)}


def stress(context: PageContext) -> Mapping[str, Any]:
    """The largest stresses; nothing where the run kept none."""
    results = context.results
    if not results.has_stress:
        return {}
    peaks = stress_peaks(results, report_of(results.tables).opened)
    found = stress_summary(results, peaks)
    if found is None:
        return {}
    return {
        "lines": stress_lines(found),
        "blocks": _blocks(results, peaks),
        "joints": _joints(results, peaks),
        "interval": length(peaks.interval, "s"),
        "compared": peaks.compared,
        "meshed": results.meshes is not None,
    }


def _blocks(results: Results, peaks: StressPeaks) -> list[dict[str, str]]:
    """The blocks with the largest compression, those nearest to their strength first where it is given: rows by their columns."""
    measure, elements = np.nan_to_num(peaks.block_ratio if peaks.compared else peaks.compression), element_peaks(results)
    within = None if elements is None else elements.of_blocks(len(results.blocks))
    rows = []
    for b in [b for b in np.argsort(-measure, kind="stable")[:ROWS].tolist() if measure[b] > 0.0]:
        row = {
            "block": results.blocks[b].name,
            "largest mean compression": pressure(float(peaks.compression[b])),
            "at [s]": number(peaks.compression_time[b], digits=3),
            "largest mean tension": pressure(float(peaks.tension[b])) if peaks.pulled[b] else "–",
        }
        if peaks.compared:
            row["share of strength"] = number(peaks.block_ratio[b], digits=3)
        if within is not None:
            row["largest compression of an element"] = "–" if np.isnan(within[b]) else pressure(float(within[b]))
        rows.append(row)
    return rows


def _joints(results: Results, peaks: StressPeaks) -> list[dict[str, str]]:
    """The joints with the largest compression at their edge; where a strength is given, those of which a force takes most first."""
    order = np.nan_to_num(peaks.crushed_share if peaks.compared else peaks.force / peaks.area)
    measure = np.where(peaks.open_above, 1e9 + order, np.nan_to_num(np.where(np.isinf(peaks.edge), 0.0, peaks.edge)) / 1e12)
    rows, joints = [], results.joints
    for j in [j for j in np.argsort(-measure, kind="stable")[:ROWS].tolist() if peaks.edge[j] > 0.0]:
        row = {
            "joint": " – ".join(results.blocks[int(block[j])].name for block in (joints.block_a, joints.block_b)),
            "largest edge compression": "force at the edge" if np.isinf(peaks.edge[j]) else pressure(float(peaks.edge[j])),
            "above while": "open" if peaks.open_above[j] else "closed" if peaks.closed_above[j] else "–",
            "at [s]": number(peaks.edge_time[j], digits=3),
            "largest mean pressure": pressure(float(peaks.force[j] / peaks.area[j])),
        }
        if peaks.compared:
            row["taken at strength"] = share_in_words(float(peaks.crushed_share[j]))
        rows.append(row)
    return rows


SECTIONS = {"stress": Section("Stress", stress, -10)}
