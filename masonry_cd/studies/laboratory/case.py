# SPDX-License-Identifier: GPL-3.0-or-later
"""A laboratory case, and how its tests are run: scene files in a folder, which are what a user copies."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from masonry_cd.analysis.distributions import by_chance, distance
from masonry_cd.analysis.limit.analysis import LimitOptions, analyse
from masonry_cd.analysis.pushover import PushCurve, require_pushes
from masonry_cd.app.case import prepare
from masonry_cd.app.limit_table import limit_table
from masonry_cd.app.progress import Interrupted
from masonry_cd.app.run_case import RESULTS, run_case
from masonry_cd.app.scene import Scene, read_scene
from masonry_cd.app.scene_text import dump_toml
from masonry_cd.app.static_loads import static_loads
from masonry_cd.foundation import own_files
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.blocks import Block
from structures.files.blockfile import write as write_blocks

BLOCKS, SCENE = "blocks.json", "scene.toml"
Curve = tuple[str, np.ndarray, np.ndarray]  # name, abscissa, ordinate


class CaseRow(NamedTuple):
    """A line of the table: what was measured, and what the program gives with rigid and with elastic joints."""

    quantity: str
    unit: str
    measured: float
    rigid: float | None
    elastic: float | None


class Sample(NamedTuple):
    """Values of repeated tests or of many motions, and those that the program gives; infinite where a structure fell."""

    quantity: str
    unit: str
    measured: Sequence[float]
    computed: Sequence[float]

    def as_dict(self) -> dict[str, Any]:
        """Count, median, quartiles and share fallen of both, the distance of their distributions, and how likely it is by chance."""
        pair = [np.array(values, dtype=float) for values in (self.measured, self.computed)]
        even = [np.full(len(values), 1.0 / len(values)) for values in pair]
        apart = distance(pair[0], even[0], pair[1], even[1])
        chance = by_chance(apart, len(self.measured), len(self.computed))
        found: dict[str, Any] = {"quantity": self.quantity, "unit": self.unit, "distance": apart, "probability": chance}
        for name, values in zip(("measured", "computed"), pair, strict=True):
            ends = [q if np.isfinite(q) else None for q in np.sort(values)[-(-np.array([1, 2, 3]) * len(values) // 4) - 1].tolist()]
            found[name] = {"count": len(values), "fallen": float(np.mean(np.isinf(values))), "quartiles": ends}
        return found

    @property
    def line(self) -> str:
        """Both as text."""
        found = self.as_dict()
        sides = [f"{name} {shown_quartiles(found[name])}, {100 * found[name]['fallen']:.3g} % fell" for name in ("measured", "computed")]
        return f"{self.quantity}: {'; '.join(sides)}; distance {found['distance']:.3f}, probability {found['probability']:.2g}"


def shown_quartiles(side: Mapping[str, Any]) -> str:
    """The median with the quartiles of a sample, as text."""
    low, middle, high = (f"{q:.3g}" if q is not None else "fallen" for q in side["quartiles"])
    return f"{middle} ({low} to {high})"


@dataclass
class CaseResults:
    """Results of the tests of a case."""

    rows: list[CaseRow] = field(default_factory=list)
    samples: list[Sample] = field(default_factory=list)
    measured: list[Curve] = field(default_factory=list)
    points: list[Curve] = field(default_factory=list)  # measured, one by one, with no line between
    computed: list[Curve] = field(default_factory=list)
    axes: tuple[str, str] = ("displacement [mm]", "force [kN]")


@dataclass(frozen=True)
class LaboratoryCase:
    """A case of the page."""

    name: str
    title: str
    source: str
    assumed: str
    unknown: str
    verdict: str  # what agrees, what does not, and why
    compute: Callable[[Path, Callable[[str], object]], CaseResults]  # in a folder, saying how far it is


def elastic(law: Mapping[str, Any] | None) -> dict[str, Any]:
    """The keys of ``[material]`` for joints of a law; none for rigid ones."""
    return {"joints": {"default": dict(law)}} if law else {}


def threshold(falls: Callable[[float], bool], low: float, high: float, halvings: int) -> float:
    """The load between those under which a structure stands and those under which it falls, by halving a range."""
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if falls(middle) else (middle, high)
    return 0.5 * (low + high)


def scene_in(folder: Path, blocks: Sequence[Block], tables: Mapping[str, Any]) -> Scene:
    """Write a scene and its blocks into a folder, and read it."""
    own_files.begin(folder, (BLOCKS,))  # a search for a threshold writes them again and again
    write_blocks(folder / BLOCKS, blocks)
    (folder / SCENE).write_text(dump_toml({**tables, "structure": {"kind": "file", "path": BLOCKS}}), encoding="utf-8")
    return read_scene(folder / SCENE)


def run_in(folder: Path, blocks: Sequence[Block], tables: Mapping[str, Any]) -> Results:
    """Run a scene in a folder and open its results.

    Raises:
        Interrupted: by a signal; half a run is not a result of a case.
    """
    summary = run_case(prepare(scene_in(folder, blocks, tables)), folder)
    if summary.signal:
        raise Interrupted(summary.signal)
    return Results.open(folder / RESULTS)


def pushed(folder: Path, blocks: Sequence[Block], tables: Mapping[str, Any]) -> PushCurve:
    """The push of a scene."""
    with run_in(folder, blocks, tables) as results:
        return require_pushes(results)[0]


def limit_factor(folder: Path, blocks: Sequence[Block], tables: Mapping[str, Any], live: Sequence[int]) -> float:
    """The least factor on some of the loads of a scene by limit analysis, rigid and without dilation where it is found."""
    run = {"run": {"dt": 1e-3, "duration": 1e-2}, "quiet_checks": ["loads"]}
    case = prepare(scene_in(folder, blocks, {**tables, **run}))
    loads = static_loads(case.scene.loads, limit_table({"live": list(live)}), case.scene.run.gravity, folder, case.assembly)
    found = analyse(case.assembly, case.joints, loads.at(), LimitOptions(starts=2))
    return float(found.associated.factor if found.least is None else found.least.optimum.factor)


def at(curve: PushCurve, displacement: float) -> float:
    """The force of the first push at a displacement [N]."""
    u, f = curve.envelope()
    return float(np.interp(displacement, u, f))
