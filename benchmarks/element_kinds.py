# SPDX-License-Identifier: GPL-3.0-or-later
r"""Cost of the kinds of blocks, rigid, of uniform strain, cut into tetrahedra: the arcade of 50 spans, and a wall across its plane.

    python -m benchmarks.element_kinds [arcade50] [wall] [--steps 60] [--young 5e9] [--mesh-size 10 0.3]

The same blocks and shaking for each kind; what deforms has 5 % of critical damping at 10 Hz and has settled under its weight. Processor
milliseconds of a step are the mean over the steps after the first twenty, one thread; next to them those over the rigid row's.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from typing import Any

import numpy as np

from benchmarks.scenes import GRAVITY, BenchScene, scene
from benchmarks.sitting import head, sitting
from masonry_cd.mechanics.dynamics.equilibrium import settle
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.materials import Material

SCENES = {"arcade50": "arcade50", "wall": "wall6x6"}
FIRST = 20  # steps that are not counted
DT, FREQUENCY = 1e-3, 2.0  # [s], [Hz]


def machine(made: BenchScene, steps: int, elastic: dict[str, Any], across: bool, tolerance: float) -> Stepper:
    """A stepper of a scene, at rest under its weight; ``across``: the base shakes along y instead of x."""
    time_of = DT * np.arange(steps + 1)
    shaken = np.zeros((steps + 1, 1, 3))
    shaken[:, 0, 1 if across else 0] = made.amplitude * np.sin(2.0 * np.pi * FREQUENCY * time_of)
    pull = np.tile([0.0, 0.0, -GRAVITY], (steps + 1, 1))
    run = Run(dt=DT, duration=steps * DT, solver="auto", tolerance=tolerance, threads=1)
    out = Stepper(Assembly.from_blocks(made.blocks, Material(friction=0.6, **elastic)), shaken, pull, run)
    settle(out)
    return out


def cost(name: str, kind: str, steps: int, young: float, size: float, tolerance: float) -> tuple[int, int, float, float, float, int]:
    """Nodes of a block, unknowns of one, contacts, iterations, processor milliseconds of a step, and the steps that missed."""
    keys = {"deformable": kind, "young": young, "damping": 0.05, "damping_frequency": 10.0}
    elastic = {} if kind == "rigid" else keys | ({"mesh_size": size} if kind == "tetrahedra" else {})
    stepper = machine(scene(SCENES[name]), steps, elastic, name == "wall", tolerance)
    strains = stepper.system.strains
    nodes = max(len(mesh.nodes) for mesh in strains.warps.meshes) if strains is not None and strains.warps is not None else 0
    reports, begin = [], 0.0
    for k in range(steps):
        if k == FIRST:
            begin = time.process_time()
        reports.append(stepper.step())
    spent = 1e3 * (time.process_time() - begin) / (steps - FIRST)
    counted = reports[FIRST:]
    missed = sum(report.error > tolerance for report in counted)
    contacts, iterations = (float(np.mean([getattr(report, key) for report in counted])) for key in ("contacts", "iterations"))
    return nodes, stepper.system.unknowns, contacts, iterations, spent, missed


def main(words: Sequence[str] | None = None) -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}; all when none is given")
    parser.add_argument("--steps", type=int, default=120)
    parser.add_argument("--young", type=float, default=5e9, help="Young's modulus [Pa]")
    parser.add_argument("--mesh-size", type=float, nargs="+", default=[10.0], help="sizes of the elements [m]")
    parser.add_argument("--tolerance", type=float, default=1e-6)
    asked = parser.parse_args(words)
    if unknown := [name for name in asked.scenes if name not in SCENES]:
        parser.error(f"no scene {unknown[0]}; scenes: {', '.join(SCENES)}")
    print(sitting())
    for name in asked.scenes or list(SCENES):
        print(
            f"\n{name}\n\n" + head("blocks", "nodes", "unknowns", "contacts", "iterations", "missed", "ms per step", "over rigid"),
            flush=True,
        )
        rigid = None
        for kind, size in (("rigid", 0.0), ("uniform", 0.0), *(("tetrahedra", size) for size in asked.mesh_size)):
            nodes, unknowns, contacts, iterations, spent, missed = cost(name, kind, asked.steps, asked.young, size, asked.tolerance)
            rigid = rigid or spent
            cells = (kind, nodes or "", unknowns, f"{contacts:.0f}", f"{iterations:.0f}", missed, f"{spent:.2f}", f"{spent / rigid:.1f}")
            print("| " + " | ".join(map(str, cells)) + " |", flush=True)


if __name__ == "__main__":
    main()
