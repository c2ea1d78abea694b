# SPDX-License-Identifier: GPL-3.0-or-later
"""How often each joint opened, slid or was lost over the runs of a study, and the median of its largest opening.

The share of n runs in which a joint passed a threshold estimates a probability with a standard error of sqrt(p (1 - p) / n), at most
0.5 / sqrt(n). Runs over levels of an intensity are a sample of none: there the maps are drawn level by level as well. Only runs on the same
joints are counted, by the digest ``shape`` of each; where the geometry varies, the others are left out, which a warning says. The maps
have the look of a crack map without displacements: what many runs did has no shape of its own.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.fragility.folder import StudyResults
from masonry_cd.analysis.fragility.joint_runs import JointRuns, median, read_joint_runs
from masonry_cd.analysis.fragility.measures import with_unit
from masonry_cd.foundation.csv_files import write_csv
from masonry_cd.foundation.quantities import length
from masonry_cd.io.results import Results
from reports.damage import thresholds_of
from reports.drawing import palette
from reports.drawing.figure import Sheet, layout_of
from reports.drawing.parts import RULER, ColourClasses, KeyPanel, Scale, Sign
from reports.drawing.render import Canvas
from reports.maps.crack_map import at_rest
from reports.maps.framing import MapStyle
from reports.settings import report_of

SHARES = (0.005, 0.05, 0.1, 0.25, 0.5, 0.75, 0.9)  # lower bounds of the classes of a probability
LEVELS = 3  # that have maps of their own, at most
LARGEST = 0.05  # where the last class of the median opening begins [m]
TABLE = "joint_probabilities.csv"
REFERENCE = "reference/result.h5"


@dataclass(frozen=True, eq=False)
class JointStudy:
    """Joints of a study."""

    study: StudyResults
    runs: JointRuns
    thresholds: Thresholds  # from which on a joint counts as opened, or slid
    pairs: list[tuple[str, str]]  # the two blocks of each

    @property
    def table(self) -> dict[str, np.ndarray | list[str]]:
        """The columns of joint_probabilities.csv, (J,) each."""
        runs = self.runs
        return {
            "block_a": [a for a, _ in self.pairs],
            "block_b": [b for _, b in self.pairs],
            "runs": np.full(len(self.pairs), len(runs.rows)),
            "opened": runs.opened(self.thresholds).mean(axis=0),
            "slid": runs.slid.mean(axis=0),
            "lost": runs.lost.mean(axis=0),
            "median_opening": median(runs.opening),
        }

    @property
    def style(self) -> MapStyle:
        """Return the style of the maps."""
        thresholds = self.thresholds
        return MapStyle(thresholds=thresholds, largest=max(LARGEST, 10.0 * max(thresholds.opened, thresholds.slid)))

    def maps(self, every_level: bool = False) -> dict[str, JointValues]:
        """The maps that show anything, by the names of their files: opened, slid, lost, the median opening, and opened level by level.

        Of levels these are a few, evenly spread, or every one.
        """
        study, runs, thresholds, count = self.study, self.runs, self.thresholds, len(self.runs.rows)
        title, share, opened = str(study.asked.title), ColourClasses(SHARES, palette.SHARES, 100.0), runs.opened(thresholds)
        over = f"over {count} runs, at rest · standard error {50.0 / np.sqrt(count):.2g} % at most"
        shares = (
            ("probability_opened.png", "how often joints opened", opened, f"opened by {length(thresholds.opened)} or more, or lost"),
            ("probability_slid.png", "how often joints slid", runs.slid, f"slid by {length(thresholds.slid)} or more, not lost"),
            ("probability_lost.png", "how often joints were lost", runs.lost, "separated for good at the end"),
        )
        out = [
            JointValues(study.folder / name, f"{title}: {words}", f"{meaning} · {over}", hits.mean(axis=0), share, "share of the runs [%]")
            for name, words, hits, meaning in shares
        ]
        middle, scale = median(runs.opening), Scale(thresholds.opened, self.style.largest, palette.OPENING)
        facts = f"half of {count} runs open a joint by more than this; a joint that is lost counts as wide open"
        words = f"{title}: median of the largest opening"
        out.append(JointValues(study.folder / "median_opening.png", words, facts, middle, scale, "median of the largest opening [mm]"))
        level, name = study.numbers("level")[runs.rows], str(study.asked.measure or "level")
        most = 0 if study.asked.design == "ida" else study.count if every_level else LEVELS
        for one in _levels(level, most):
            here = level == one
            at = f"at {name} {with_unit(one, name)}"
            facts = f"opened by {length(thresholds.opened)} or more, or lost · {int(here.sum())} runs {at}, at rest"
            path, words = study.folder / f"probability_opened_at_{one:g}.png", f"{title}: how often joints opened {at}"
            out.append(JointValues(path, words, facts, opened[here].mean(axis=0), share, "share of the runs [%]"))
        return {one.path.name: one for one in out if one.drawn.any()}

    def draw(self, maps: Iterable[JointValues]) -> list[Path]:
        """Draw some of them; return their paths."""
        with Results.open(self.study.folder / REFERENCE) as results:
            return draw_joint_values(results, maps, self.style)


def joint_study(study: StudyResults) -> JointStudy | None:
    """The joints of a study; None where it has no runs with joints.

    Raises:
        InputError: a broken file.
    """
    reference = study.folder / REFERENCE
    if not reference.exists() or not (study.folder / "joints").is_dir():
        return None
    with Results.open(reference) as results:
        thresholds = thresholds_of(report_of(results.tables)) if results.scene else Thresholds()
        joints, names = results.joints, [block.name for block in results.blocks]
        pairs = [(names[a], names[b]) for a, b in zip(joints.block_a, joints.block_b, strict=True)]
    runs = read_joint_runs(study, len(pairs), thresholds)
    return None if runs is None or not pairs else JointStudy(study, runs, thresholds, pairs)


def draw_joint_maps(study: StudyResults) -> tuple[list[Path], list[str], list[str]]:
    """Draw the maps that the runs allow, and write their table.

    Returns:
        the files, closing lines, and warnings.

    Raises:
        InputError: a broken file; no off-screen OpenGL.
    """
    found = joint_study(study)
    if found is None:
        return [], [], []
    written = found.draw(found.maps().values())
    out_of, lacking = int(study.done.sum()), int(study.done.sum()) - len(found.runs.rows) - found.runs.left_out
    warnings = [f"{found.runs.left_out} runs are left out because their joints differ from those of the first run"] * bool(
        found.runs.left_out
    )
    warnings += [f"{lacking} of {out_of} runs have no file in the folder joints, or exceed the memory limit"] * bool(lacking)
    warnings = [f"joint maps: {words}" for words in warnings]
    rows = ((j, *cells) for j, cells in enumerate(zip(*found.table.values(), strict=True)))
    write_csv(study.folder / TABLE, ("joint", *found.table), rows, digits=6)
    return [*written, study.folder / TABLE], _lines(found.runs, found.thresholds, found.pairs), warnings


def _levels(level: np.ndarray, most: int) -> list[float]:
    """Levels with maps of their own, evenly spread over those that there are."""
    found = np.unique(level[np.isfinite(level)])
    if len(found) < 2 or not most:
        return []
    places = np.unique(np.round(np.linspace(0, len(found) - 1, min(most, len(found)))).astype(int))
    return [float(value) for value in found[places]]


def _lines(runs: JointRuns, thresholds: Thresholds, pairs: list[tuple[str, str]]) -> list[str]:
    """Which joint opened most often."""
    share = runs.opened(thresholds).mean(axis=0)
    often = int(np.argmax(share))
    if share[often] == 0:
        return [f"no joint opened by {length(thresholds.opened)} in any of {len(runs.rows)} runs"]
    many = int((share >= 0.5).sum())
    return [
        f"the joint of {pairs[often][0]} and {pairs[often][1]} opened most often, in {100 * share[often]:.0f} % of {len(runs.rows)} runs; "
        f"{many} of {len(share)} joints opened in half of them or more"
    ]


@dataclass(frozen=True, eq=False)
class JointValues:
    """Values of joints in a map."""

    path: Path  # of the PNG
    title: str
    facts: str
    values: np.ndarray  # (J,)
    scale: ColourClasses  # joints whose value lies below its first bound are not drawn
    name: str  # of the scale, with the unit

    @property
    def drawn(self) -> np.ndarray:
        """(J,) bool."""
        return self.values >= self.scale.bounds[0]

    @property
    def key(self) -> list[KeyPanel]:
        """The scale, the joints coloured, and the scale bar."""
        coloured = Sign("band", f"joints coloured: {int(self.drawn.sum())} of {len(self.values)}", (self.scale.middle,))
        return [KeyPanel(scale=(self.name, self.scale), wide=2), KeyPanel([coloured]), RULER]


def draw_joint_values(results: Results, maps: Iterable[JointValues], style: MapStyle) -> list[Path]:
    """Draw maps on the structure at rest, all in one framing and on one canvas."""
    scene, written = at_rest(results, style), []
    assert scene.joints is not None
    with Canvas(scene.view, layout_of(scene).pixels) as canvas:
        for one in maps:
            hues = one.scale(one.values)
            joints = replace(scene.joints, shown=one.drawn, colours=(hues, hues))
            drawn = replace(scene, joints=joints, title=one.title, facts=one.facts, key=one.key)
            Sheet.drawn_on(canvas, drawn).save(one.path)
            written.append(one.path)
    return written
