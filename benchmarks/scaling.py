# SPDX-License-Identifier: GPL-3.0-or-later
r"""Cost against size: the same structure, larger and larger.

    python -m benchmarks.scaling wall arcade --blocks 500 2000 20000
    python -m benchmarks.scaling courses --courses 10 30 100
    python -m benchmarks.scaling wall church --parts --blocks 500 5000 20000

Families: `wall`, twice as long as high in blocks; `arcade`, more spans; `church`, in space, of ever smaller blocks; `courses`, a wall of 50
units in ever more courses, whose first step from rest shows how fast an impulse propagates upwards. Shaken, each size in a process of its
own. A method whose iterations grow with height, or bookkeeping that is not linear, shows as a growing cost per block; with `--parts` it
shows where: then whole runs are measured, their results written, part by part (see ``benchmarks.parts``).
"""

from __future__ import annotations

import argparse
from typing import Any

import numpy as np

from benchmarks.parts import run_parts, table
from benchmarks.sitting import head, run_ours, sitting

HEAD = head(
    *("scene", "blocks", "contacts", "first step [ms]", "its iterations", "ms: median", "mean", "iterations"),
    *("us/step/block", "us/step/contact", "detection", "error"),
)


CHURCH_SURFACE = 1700.0  # number of blocks times the square of their length, about [m2]


def names(family: str, blocks: list[int], courses: list[int]) -> list[str]:
    """The scenes of a family, of about the given numbers of blocks."""
    if family == "courses":
        return [f"wall50x{count}" for count in courses]
    if family == "arcade":
        return [f"arcade{max(1, round((count - 9) / 20))}" for count in blocks]
    if family == "church":
        return [f"church{round(1e3 * np.sqrt(CHURCH_SURFACE / count))}" for count in blocks]
    high = [max(2, round(np.sqrt(count / 2))) for count in blocks]
    return [f"wall{round(count / courses)}x{courses}" for count, courses in zip(blocks, high, strict=True)]


def line(name: str, x: dict[str, Any]) -> str:
    """One line of the table."""
    cells = [name, x["blocks"], f"{x['contacts']:.0f}", f"{x['first_ms']:.3g}", x["first_iterations"]]
    cells += [f"{x['median_ms']:.3g}", f"{x['mean_ms']:.3g}", f"{x['iterations']:.0f}"]
    cells += [f"{1e3 * x['mean_ms'] / x['blocks']:.2f}", f"{1e3 * x['mean_ms'] / x['contacts']:.2f}"]
    cells += [f"{100 * x['detection_share']:.0f} %", f"{x['error_max']:.1e}{' missed' if x['missed'] else ''}"]
    return "| " + " | ".join(map(str, cells)) + " |"


def growth(rows: list[dict[str, Any]]) -> str:
    """How much the cost grew from the smallest to the largest."""
    first, last = rows[0], rows[-1]
    per_block = (last["mean_ms"] / last["blocks"]) / (first["mean_ms"] / first["blocks"])
    per_contact = (last["mean_ms"] / last["contacts"]) / (first["mean_ms"] / first["contacts"])
    return (
        f"from {first['blocks']} to {last['blocks']} blocks: cost per block x {per_block:.2f}, per contact x {per_contact:.2f}; "
        f"iterations x {last['iterations'] / max(1.0, first['iterations']):.2f}, "
        f"of the first step x {last['first_iterations'] / max(1, first['first_iterations']):.2f}"
    )


def options(given: argparse.Namespace) -> list[str]:
    """Options of each run in addition to its scene and its steps."""
    limit = [] if given.max_iterations is None else ["--max-iterations", str(given.max_iterations)]
    return limit + ["--threads", str(given.threads)] + (["--space"] if given.space else [])


def totals_table(given: argparse.Namespace) -> None:
    """Print a table of whole steps, line by line as it grows, and how much they grew."""
    print(HEAD, flush=True)
    ends = []
    for family in given.families:
        rows = []
        for name in names(family, given.blocks, given.courses):
            rows.append(run_ours(name, given.steps, given.solver, given.tolerance, options(given)))
            print(line(name, rows[-1]), flush=True)
        ends.append(f"{family}: {growth(rows)}")
    print("", *ends, sep="\n")


def parts_tables(given: argparse.Namespace) -> None:
    """Print a table of the parts for each family."""
    for family in given.families:
        sizes = names(family, given.blocks, given.courses)
        print(*table([run_parts(name, given.steps, options(given)) for name in sizes]), "", sep="\n", flush=True)


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Cost of a step against the size of the structure.")
    parser.add_argument("families", nargs="*", default=["wall", "arcade"], help="wall, arcade, church, courses")
    parser.add_argument("--blocks", type=int, nargs="+", default=[500, 1000, 2000, 5000, 10_000, 20_000])
    parser.add_argument("--courses", type=int, nargs="+", default=[10, 20, 50, 100])
    parser.add_argument("--steps", type=int, default=20)
    parser.add_argument("--solver", default="auto")
    parser.add_argument("--tolerance", type=float, default=1e-8)
    parser.add_argument("--max-iterations", type=int, help="of each solve")
    parser.add_argument("--threads", type=int, default=1, help="of each run")
    parser.add_argument("--space", action="store_true", help="all three dimensions, also where a plane would do")
    parser.add_argument("--parts", action="store_true", help="what each part of a run costs")
    given = parser.parse_args()
    if wrong := set(given.families) - {"wall", "arcade", "church", "courses"}:
        parser.error(f"no family {', '.join(wrong)}; known: wall, arcade, church, courses")
    print(sitting(), "", sep="\n", flush=True)
    try:
        parts_tables(given) if given.parts else totals_table(given)
    except RuntimeError as failed:
        parser.exit(2, f"{failed}\n")


if __name__ == "__main__":
    main()
