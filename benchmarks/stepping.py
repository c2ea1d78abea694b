# SPDX-License-Identifier: GPL-3.0-or-later
"""Cost of stepping a scene from Python, compared with the run that writes its results: seconds of the processor, by turns.

    python -m benchmarks.stepping examples/arch.toml --seconds 2

``run`` is ``masonry_cd.run`` without what comes before the first step and without pictures, ``stepped`` calls ``Simulation.step`` for each
step, ``followed`` has a function called after each as well, ``looked at`` reads state, contacts and reactions after each.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import masonry_cd as mc


def stepped(sim: mc.Simulation) -> None:
    """Step by step to the end."""
    while not sim.done:
        sim.step()


def followed(sim: mc.Simulation) -> None:
    """With a function after each step."""
    sim.on("step", lambda sim: None)
    stepped(sim)


def looked_at(sim: mc.Simulation) -> None:
    """With what Python reads of each step."""
    while not sim.done:
        sim.step()
        sim.state, sim.contacts, sim.reactions()


def recorded(sim: mc.Simulation) -> None:
    """As a run, with its results written."""
    with tempfile.TemporaryDirectory() as folder:
        sim.record(Path(folder) / "run", progress=False)


WAYS: dict[str, Callable[[mc.Simulation], None]] = {"run": recorded, "stepped": stepped, "followed": followed, "looked at": looked_at}


def main() -> None:
    """Print the table."""
    asked = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    asked.add_argument("scene", nargs="?", default="examples/arch.toml")
    asked.add_argument("--seconds", type=float, default=2.0, help="of the scene's time")
    asked.add_argument("--turns", type=int, default=3)
    given = asked.parse_args()
    scene = mc.scene(given.scene, f"run.duration={given.seconds}", "run.until_still=false", "run.threads=1", "report={}")
    best = dict.fromkeys(WAYS, float("inf"))
    steps = 1
    for _ in range(given.turns):
        for name, way in WAYS.items():
            sim = mc.Simulation(scene)
            begin = time.process_time()
            way(sim)
            best[name], steps = min(best[name], time.process_time() - begin), sim.steps
    print("| | us of the processor per step | over run |\n|---|---|---|")
    for name, seconds in best.items():
        print(f"| {name} | {1e6 * seconds / steps:.0f} | {seconds / best['run']:.2f} |")


if __name__ == "__main__":
    main()
