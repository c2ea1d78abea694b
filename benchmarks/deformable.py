# SPDX-License-Identifier: GPL-3.0-or-later
r"""When rigid blocks are enough: motion and cost of rigid blocks, of elastic joints and of blocks that deform, over Young's modulus.

    python -m benchmarks.deformable [arch] [pier] [aqueduct] [wall] [--young 1e8 1e9 1e10]
        [--kinds "uniform strain"] [--out TABLE.md]

**arch, pier** and the demo **aqueduct** move in a plane, **wall** across its own. Each runs with rigid blocks on rigid joints; then, for
each modulus E, with rigid blocks on elastic joints as soft as the blocks next to them (1 / k is the sum of height / E of both halves, the
median over the joints, Poisson's ratio 0.2), with blocks of uniform strain and with blocks of as few elements as they can have, on rigid
joints; what is elastic has 5 % of critical damping at 10 Hz. Largest displacement, drift, opening and sliding are those of all steps, the
drift that of the structure as ``damage.csv`` has it; the first crack is when a joint first opens by more than 0.1 mm. The cost is in
milliseconds of the processor per step, and next to it that over the rigid row's, so run it on an idle machine.

Where the motion is sensitive to the last digit (``docs/accuracy.md``), differences of a row are within the spread of an ensemble.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Collection, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

import numpy as np

from benchmarks.sitting import HERE, head, sitting
from masonry_cd.app.case import prepare, structure_of
from masonry_cd.app.run_case import run_case
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.io.results import Results
from masonry_cd.io.summary import Summary
from masonry_cd.mechanics.model.joint_stiffness import joint_stiffness
from masonry_cd.studies.study.task import numbers_of_run

POISSON = 0.2
DAMPED = ("damping=0.05", "damping_frequency=10.0")  # of what is elastic
KINDS = ("elastic joints", "uniform strain", "tetrahedra")
COARSE = 10.0  # size of the elements of tetrahedra [m]: as few of them as a block can have
EXAMPLE = HERE.parent / "examples/aqueduct_sinusoidal.toml"
TEXT = """
[structure]
{structure}
[material]
density = 2200.0
friction = 0.6
[[loads]]
kind = "sinusoidal"
frequency = 2.0
cycles = 4
{load}
[run]
dt = 1e-3
duration = 3.0
tolerance = 1e-6
until_still = false
"""
WALL = 'kind = "wall"\ncourse_height = 0.4\nunit_length = 0.8\n'
SCENES = {
    "arch": TEXT.format(
        structure='kind = "arch"\nspan = 4.0\nthickness = 0.4\nwidth = 1.0\nvoussoirs = 27', load='direction = "x"\namplitude = 0.25'
    ),
    "pier": TEXT.format(structure=WALL + "length = 1.6\nheight = 4.0\nthickness = 1.0", load='direction = "x"\namplitude = 0.35'),
    "aqueduct": EXAMPLE.read_text(encoding="utf-8"),
    "wall": TEXT.format(structure=WALL + "length = 2.4\nheight = 2.4\nthickness = 0.4", load='direction = "y"\namplitude = 0.15'),
}


class Row(NamedTuple):
    """A run with one kind of blocks and joints."""

    name: str
    young: float  # [Pa]; inf: rigid
    summary: Summary
    drift: float  # the largest, as a share of the height
    first_crack: float  # time of it [s]; NaN: no joint opened
    cost: float  # milliseconds of the processor per step, files included


def row(name: str, young: float, asked: Scene) -> Row:
    """The numbers of a run whose files are thrown away."""
    case, begin = prepare(asked), time.process_time()
    with TemporaryDirectory() as folder:
        summary = run_case(case, Path(folder) / "out")
        spent = time.process_time() - begin
        file = Path(folder) / "out" / "result.h5"
        drift = numbers_of_run(file, summary, asked)[0]["drift"]
        with Results.open(file) as results:
            opened = results.peaks["first_opening_time"]
    first = float(np.nanmin(opened)) if np.isfinite(opened).any() else np.nan
    return Row(name, young, summary, np.nan if drift is None else drift, first, 1e3 * spent / summary.steps)


def scene(name: str, *changes: str) -> Scene:
    """A scene with changes as of ``--set``."""
    return parse_scene(SCENES[name], EXAMPLE.with_name(f"{name}.toml"), changes)


def runs(name: str, moduli: list[float], kinds: Collection[str]) -> Iterator[Row]:
    """All runs of a scene, the rigid one first."""
    rigid = scene(name)
    yield row("rigid", np.inf, rigid)
    made = structure_of(rigid)
    unit = float(np.median(joint_stiffness(made.assembly, made.joints, *np.ones((2, made.assembly.count)))[0]))
    for young in moduli:
        elastic = (f"young={young}", f"poisson={POISSON}", *DAMPED)
        keys = {
            "elastic joints": [f"joints.{each}" for each in (f"normal_stiffness={young * unit:.4g}", *DAMPED)],
            "uniform strain": ["deformable=uniform", *elastic],
            "tetrahedra": ["deformable=tetrahedra", f"mesh_size={COARSE}", *elastic],
        }
        for kind in KINDS:
            if kind in kinds:
                yield row(kind, young, scene(name, *(f"material.{each}" for each in keys[kind])))


def table(name: str, moduli: list[float], kinds: Collection[str]) -> list[str]:
    """The lines of a scene's table, shown as they come."""
    lines = [
        head(
            "blocks",
            "E [GPa]",
            "displacement [mm]",
            "drift [%]",
            "first crack [s]",
            "opening [mm]",
            "sliding [mm]",
            "joints opened",
            "missed",
            "ms per step",
            "over rigid",
        )
    ]
    print(f"\n{name}\n\n{lines[0]}", flush=True)
    first = None
    for found in runs(name, moduli, kinds):
        first, s = first or found, found.summary
        moved, opening, sliding = (f"{1e3 * getattr(s, key):.2f}" for key in ("displacement_max", "opening_max", "sliding_max"))
        stiff = "rigid" if np.isinf(found.young) else f"{1e-9 * found.young:g}"
        times = [
            "" if np.isnan(found.drift) else f"{100.0 * found.drift:.2f}",
            "" if np.isnan(found.first_crack) else f"{found.first_crack:.3f}",
        ]
        joints = [opening, sliding, s.joints_opened, s.solver.steps_missed]
        cells = [found.name, stiff, moved, *times, *joints, f"{found.cost:.2f}", f"{found.cost / first.cost:.1f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
        print(lines[-1], flush=True)
    return lines


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}; all when none is given")
    parser.add_argument("--young", nargs="+", type=float, default=[1e8, 1e9, 1e10], help="Young's moduli [Pa]")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=KINDS, help="elastic kinds, in addition to rigid blocks")
    parser.add_argument("--out", type=Path, help="file for the tables")
    asked = parser.parse_args()
    names = asked.scenes or list(SCENES)
    if unknown := [name for name in names if name not in SCENES]:
        parser.error(f"no scene {unknown[0]}; scenes: {', '.join(SCENES)}")
    print(sitting())
    tables = {name: table(name, asked.young, asked.kinds) for name in names}
    if asked.out:
        asked.out.write_text("\n\n".join(f"**{name}**\n\n" + "\n".join(lines) for name, lines in tables.items()) + "\n")


if __name__ == "__main__":
    main()
