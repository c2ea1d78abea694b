# SPDX-License-Identifier: GPL-3.0-or-later
r"""masonry_cd against LMGC90 and Siconos, in one sitting on one machine.

    python -m benchmarks.peers scenes --lmgc90-python PATH/bin/python [wall10x10 arcade3 ...]
    python -m benchmarks.peers files --siconos-python /usr/bin/python3 FILE.npz ...

`scenes`: LMGC90 and we step the same blocks under the same shaking, alternately (A B A B ...), each run a process of its own on one
thread; medians over the runs. `ratio` is LMGC90's time over ours.
We run at two tolerances, 1e-8 and a loose 1e-3, about the error that LMGC90 leaves. Errors are natural
map errors by one measure, ours (see ``lmgc90_error.py``): median and largest over the steps.

`files`: Siconos solves friction problem files (.npz: W_data, W_indices, W_indptr, q, mu), or the problem of a step of a scene
(``wall10x10@50``), each with several of its solvers; so do we. The clock runs around the solve alone.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.lmgc90_error import judge
from benchmarks.problem_files import files_command
from benchmarks.scenes import scene
from benchmarks.sitting import head, run_lmgc90, run_ours, sitting

DEFAULT = ("arch27", "tower50", "wall10x10", "arcade3", "arcade50", "wall40x25")


@dataclass
class Rows:
    """Results of one program in its runs of a scene, run by run."""

    first: list[float] = field(default_factory=list)  # ms of the first step, which starts cold
    median: list[float] = field(default_factory=list)  # ms per step
    mean: list[float] = field(default_factory=list)  # ms per step after the first
    last: dict[str, Any] = field(default_factory=dict)  # of the last run: contacts, iterations, errors

    def add(self, first: float, median: float, mean: float, rest: dict[str, Any]) -> None:
        """Take in one run."""
        self.first.append(first)
        self.median.append(median)
        self.mean.append(mean)
        self.last = rest

    @property
    def ms(self) -> np.ndarray:
        """Medians over the runs: of the first step, of the median and of the mean step, (3,) [ms]."""
        return np.array([np.median(self.first), np.median(self.median), np.median(self.mean)])


def compare(name: str, given: argparse.Namespace) -> dict[str, Rows]:
    """Run one scene alternately with every program; LMGC90's first run sets the number of steps."""
    made = scene(name)
    rows: dict[str, Rows] = {}
    steps = given.steps or made.steps
    for _ in range(given.runs):
        if given.lmgc90_python:
            with tempfile.TemporaryDirectory() as folder:
                result = run_lmgc90(given.lmgc90_python, made, steps, given.seconds, Path(folder))
            steps = len(result["seconds"])
            ms, judged = 1e3 * result["seconds"], judge(made, result)
            rows.setdefault("LMGC90", Rows()).add(
                float(ms[0]),
                float(np.median(ms)),
                float(ms[min(1, len(ms) - 1) :].mean()),
                {
                    "contacts": float(result["contacts"].mean()),
                    "iterations": float(result["sweeps"].mean()),
                    "error_median": float(np.median(judged.errors)),
                    "error_max": float(judged.errors.max()),
                    "error_own": float(np.median(judged.own)),
                    "read_back": judged.residual,
                },
            )
        for tolerance in given.tolerances:
            out = run_ours(name, steps, given.solver, tolerance, ["--space"] if given.space else [])
            rows.setdefault(f"ours, {tolerance:.0e}", Rows()).add(out["first_ms"], out["median_ms"], out["mean_ms"], out)
    for part in rows.values():
        part.last |= {"blocks": len(made.blocks), "steps": steps}
    return rows


HEAD = head(
    *("scene", "blocks", "steps", "program", "contacts", "iterations", "ms: first step", "median", "mean"),
    *("ratio: first", "median", "mean", "error: median", "largest", "missed"),
)


def table_lines(name: str, rows: dict[str, Rows]) -> list[str]:
    """The lines of one scene in the Markdown table."""
    lines = []
    base = rows["LMGC90"].ms if "LMGC90" in rows else None
    for program, part in rows.items():
        x = part.last
        cells = [name, x["blocks"], x["steps"], program, f"{x['contacts']:.0f}", f"{x['iterations']:.0f}"]
        cells += [f"{ms:.3g}" for ms in part.ms]
        cells += [f"{ratio:.1f}" for ratio in base / part.ms] if base is not None and program != "LMGC90" else ["", "", ""]
        cells += [f"{x['error_median']:.1e}", f"{x['error_max']:.1e}", x.get("missed", "")]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return lines


def scenes_command(given: argparse.Namespace) -> None:
    """Print the table of scenes, line by line as it grows, and keep the numbers."""
    print(sitting(), HEAD, sep="\n\n", flush=True)
    kept = {}
    for name in given.scenes or DEFAULT:
        rows = compare(name, given)
        print("\n".join(table_lines(name, rows)), flush=True)
        kept[name] = {program: {"first": p.first, "median": p.median, "mean": p.mean} | p.last for program, p in rows.items()}
    for name, programs in kept.items():
        if "LMGC90" in programs:
            x = programs["LMGC90"]
            print(
                f"\n{name}: LMGC90's motion and reactions agree to {x['read_back']:.1e}; "
                f"median error with the local velocities that it reports {x['error_own']:.1e}",
                end="",
            )
    print()
    if given.json:
        Path(given.json).write_text(json.dumps(kept, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="masonry_cd against its peers, in one sitting.")
    commands = parser.add_subparsers(required=True)
    part = commands.add_parser("scenes", help="whole steps, against LMGC90")
    part.add_argument("scenes", nargs="*", help=f"names of benchmarks/scenes.py; left out: {' '.join(DEFAULT)}")
    part.add_argument("--lmgc90-python", help="the Python that has compas_lmgc90; left out: ours alone")
    part.add_argument("--solver", default="auto")
    part.add_argument("--tolerances", type=float, nargs="+", default=[1e-8, 1e-3])
    part.add_argument("--runs", type=int, default=3, help="of each program; medians are shown")
    part.add_argument("--steps", type=int, help="instead of those of the scene")
    part.add_argument("--seconds", type=float, default=60.0, help="LMGC90 ends after the step during which they have passed, and so do we")
    part.add_argument("--space", action="store_true", help="we too solve all three dimensions, also where a plane would do")
    part.add_argument("--json", help="file for all the numbers")
    part.set_defaults(run=scenes_command)
    part = commands.add_parser("files", help="friction problems, against Siconos")
    part.add_argument("files", nargs="+", help=".npz files, or the step of a scene as SCENE@STEP")
    part.add_argument("--siconos-python", help="the Python that has siconos; left out: ours alone")
    part.add_argument("--siconos-solvers", nargs="+", default=["NSGS", "ADMM", "NSN_AC"])
    part.add_argument("--solvers", nargs="+", default=["auto"])
    part.add_argument("--tolerances", type=float, nargs="+", default=[1e-4, 1e-8])
    part.add_argument("--seconds", type=float, default=10.0, help="of one solve by Siconos, set-up included")
    part.set_defaults(run=files_command)
    given = parser.parse_args()
    try:
        given.run(given)
    except (RuntimeError, ValueError, OSError) as wrong:
        parser.exit(2, f"{wrong}\n")


if __name__ == "__main__":
    main()
