# SPDX-License-Identifier: GPL-3.0-or-later
"""How far joint forces and damage vary over sweep orders: the forces of rigid blocks are not unique where a structure is hyperstatic.

The same scene is run with several seeds of the random sweep order of Gauss-Seidel. Each seed leads to another set of contact forces that
holds the same weight, and every set is a correct answer of the model; which of them a building has is a matter of its making. Forces are
means over the frames of the run, so that one jolt does not stand for a joint; openings and slidings the largest over all steps.
What must not vary is the total on the supports, which equilibrium fixes as long as the motion is the same: it is reported, as a check.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from masonry_cd.analysis.outputs import SUMMARY, lengths_in
from masonry_cd.app.scene import read_scene
from masonry_cd.io.results import Results

LENGTHS = lengths_in(SUMMARY)
MEASURES = ("normal_force", "shear_force", "opening", "sliding")  # [N], [N], [m], [m]
LOADED = 0.01  # joints with less than this share of the largest mean normal force are not reported as the most varying
ORDERED = "nlgs"  # the solver whose answer depends on the order of its sweeps


@dataclass(frozen=True, eq=False)
class SeedStudy:
    """Measures of J joints over N seeds."""

    solver: str
    seeds: tuple[int, ...]
    joints: list[str]
    blocks: list[tuple[str, str]]
    values: dict[str, np.ndarray]  # (N, J) by MEASURES
    on_supports: np.ndarray  # (N,) summed mean normal force of the joints with supports [N]
    damage: dict[str, list[float]]  # numbers of the summaries, N each

    def spread(self, measure: str) -> np.ndarray:
        """Largest less smallest over the seeds, (J,)."""
        return np.asarray(np.ptp(self.values[measure], axis=0))

    def rows(self) -> list[dict[str, Any]]:
        """The table: a row per joint with the least, mean and largest of each measure and their spread."""
        out = []
        for j, (name, (a, b)) in enumerate(zip(self.joints, self.blocks, strict=True)):
            row: dict[str, Any] = {"joint": name, "block_a": a, "block_b": b}
            for measure in MEASURES:
                v = self.values[measure][:, j]
                low, high = float(v.min()), float(v.max())
                row |= {f"{measure}_min": low, f"{measure}_mean": float(v.mean()), f"{measure}_max": high, f"{measure}_spread": high - low}
            out.append(row)
        return out


def study_seeds(path: Path, overrides: Sequence[str], count: int, say: Callable[[str], None]) -> SeedStudy:
    """Run a scene with the seeds 0 .. count - 1 of Gauss-Seidel.

    Args:
        path: scene file.
        overrides: changes to it, ``key=value``.
        count: of seeds, two at least.
        say: called with a line before each run.

    Raises:
        InputError: a scene that is wrong.
    """
    from masonry_cd.app.case import prepare
    from masonry_cd.app.run_case import run_case

    runs: list[dict[str, Any]] = []
    for seed in range(count):
        say(f"seed {seed + 1} of {count}: {ORDERED}")
        scene = read_scene(path, [*overrides, f'run.solver="{ORDERED}"', f"run.seed={seed}"])
        with TemporaryDirectory() as folder:
            summary = run_case(prepare(scene), Path(folder))
            with Results.open(Path(folder) / "result.h5") as results:
                runs.append(_measured(results) | {"summary": summary})
                names, joints, fixed = [b.name for b in results.blocks], results.joints, [b.fixed for b in results.blocks]
    ends = list(zip(joints.block_a.tolist(), joints.block_b.tolist(), strict=True))
    support = np.array([fixed[a] or fixed[b] for a, b in ends], dtype=bool)
    values = {measure: np.array([run[measure] for run in runs]) for measure in MEASURES}
    keys = (*LENGTHS, "joints_opened", "joints_slid", "joints_separated", "collapsed_blocks")
    missed = [float(run["summary"]["solver"]["steps_missed"]) for run in runs]
    return SeedStudy(
        solver=ORDERED,
        seeds=tuple(range(count)),
        joints=[str(j) for j in range(joints.count)],
        blocks=[(names[a], names[b]) for a, b in ends],
        values=values,
        on_supports=values["normal_force"][:, support].sum(axis=1),
        damage={key: [float(run["summary"][key]) for run in runs] for key in keys} | {"steps_missed": missed},
    )


def _measured(results: Results) -> dict[str, np.ndarray]:
    """The measures of one run, (J,) each. The first frame comes before the first step and has no forces."""
    forces = {name: results.joint_history(name)[1:].mean(axis=0) for name in ("normal_force", "shear_force")}
    return forces | {name: results.peaks[name] for name in ("opening", "sliding")}


def seed_lines(study: SeedStudy) -> list[str]:
    """The summary, in words."""
    from masonry_cd.foundation.quantities import length

    force, mean = study.spread("normal_force"), study.values["normal_force"].mean(axis=0)
    loaded = mean > LOADED * mean.max(initial=0.0)
    head = f"{len(study.seeds)} seeds of {study.solver}"
    if not loaded.any():
        return [f"{head}: no joint carries a force"]
    share = np.where(loaded, force / np.where(loaded, mean, 1.0), 0.0)
    j = int(np.argmax(share))
    a, b = study.blocks[j]
    where = f'joint {study.joints[j]} between "{a}" and "{b}"'
    lines = [
        f"{head}: mean normal forces of joints vary by {_percent(float(np.median(share[loaded])))} (median of {int(loaded.sum())} that "
        f"carry), at most by {_percent(share[j])}: {where}, {_force(study.values['normal_force'][:, j])}",
        f"their sum on the supports varies by {_percent(float(np.ptp(study.on_supports) / study.on_supports.mean()))}"
        if study.on_supports.any()
        else "no joint of a support carries",
    ]
    damage = study.damage
    lines += [f"{number.name}: {length(min(damage[key]))} to {length(max(damage[key]))}" for key, number in LENGTHS.items()]
    counts = (("joints_opened", "opened"), ("joints_slid", "slid"), ("joints_separated", "separated"))
    lines.append("joints: " + ", ".join(f"{_counts(damage[key])} {word}" for key, word in counts))
    return lines


def seed_warnings(study: SeedStudy) -> list[str]:
    """What makes the spread doubtful."""
    missed = study.damage["steps_missed"]
    if not any(missed):
        return []
    runs = sum(count > 0 for count in missed)
    return [
        f"{runs} of {len(missed)} runs with other seeds missed the tolerance, in up to {max(missed):g} steps: part of the spread is error"
    ]


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %"


def _counts(values: list[float]) -> str:
    return f"{min(values):g} to {max(values):g}" if min(values) < max(values) else f"{min(values):g}"


def _force(values: np.ndarray) -> str:
    return f"{values.min() / 1e3:.4g} to {values.max() / 1e3:.4g} kN"
