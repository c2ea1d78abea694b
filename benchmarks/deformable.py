r"""When rigid blocks are enough: motion and cost of rigid blocks, of elastic joints and of blocks that deform, over Young's modulus.

    python -m benchmarks.deformable [arch] [pier] [aqueduct] [wall] [--young 1e8 1e9 1e10] [--out TABLE.md]

**arch, pier** and the demo **aqueduct** move in a plane, **wall** across its own. Each runs with rigid blocks on rigid joints; then, for
each modulus E, with rigid blocks on elastic joints as soft as the blocks beside them (1 / k is the sum of height / E of both halves, the
median over the joints, Poisson's ratio 0.2), with blocks of uniform strain and with blocks of as few elements as they can have, on rigid
joints; what is elastic has 5 % of critical damping at 10 Hz. Largest displacement, opening and sliding are those of all steps. The cost is
in milliseconds of the processor per step, and beside it that over the rigid row's, so run it on an idle machine.

Where the motion is sensitive to the last digit (``docs/accuracy.md``), differences of a row are within the spread of an ensemble.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.sitting import HERE, head, sitting
from masonry_cd.app.case import prepare, structure_of
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.studies.discarded import run_and_discard
from reports.modal.elastic_joints import joint_stiffness

POISSON = 0.2
DAMPED = ("damping=0.05", "damping_frequency=10.0")  # of what is elastic
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
    summary: Mapping[str, Any]

    @property
    def cost(self) -> float:
        """Milliseconds of the processor per step, files included."""
        return 1e3 * float(self.summary["processor"]) / int(self.summary["steps"])


def scene(name: str, *changes: str) -> Scene:
    """A scene with changes as of ``--set``."""
    return parse_scene(SCENES[name], EXAMPLE.with_name(f"{name}.toml"), changes)


def runs(name: str, moduli: list[float]) -> Iterator[Row]:
    """All runs of a scene, the rigid one first."""
    rigid = scene(name)
    yield Row("rigid", np.inf, run_and_discard(prepare(rigid)))
    made = structure_of(rigid)
    unit = float(np.median(joint_stiffness(made.assembly, made.joints, np.ones(made.assembly.count), POISSON)[0]))
    for young in moduli:
        joints = (f"normal_stiffness={young * unit:.4g}", *DAMPED)
        yield Row("elastic joints", young, run_and_discard(prepare(scene(name, *(f"material.joints.{each}" for each in joints)))))
        blocks = ("deformable=uniform", f"young={young}", f"poisson={POISSON}", *DAMPED)
        yield Row("uniform strain", young, run_and_discard(prepare(scene(name, *(f"material.{each}" for each in blocks)))))
        meshed = ("deformable=tetrahedra", f"mesh_size={COARSE}", *blocks[1:])
        yield Row("tetrahedra", young, run_and_discard(prepare(scene(name, *(f"material.{each}" for each in meshed)))))


def table(name: str, moduli: list[float]) -> list[str]:
    """The lines of a scene's table, shown as they come."""
    lines = [
        head(
            "blocks", "E [GPa]", "displacement [mm]", "opening [mm]", "sliding [mm]", "joints opened", "missed", "ms per step", "over rigid"
        )
    ]
    print(f"\n{name}\n\n{lines[0]}", flush=True)
    first = None
    for row in runs(name, moduli):
        first, s = first or row, row.summary
        largest = [f"{1e3 * s[key]:.2f}" for key in ("displacement_max", "opening_max", "sliding_max")]
        stiff = "rigid" if np.isinf(row.young) else f"{1e-9 * row.young:g}"
        missed = s["solver"]["steps_missed"]
        cells = [row.name, stiff, *largest, s["joints_opened"], missed, f"{row.cost:.2f}", f"{row.cost / first.cost:.1f}"]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
        print(lines[-1], flush=True)
    return lines


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", help=f"of {', '.join(SCENES)}; all when none is given")
    parser.add_argument("--young", nargs="+", type=float, default=[1e8, 1e9, 1e10], help="Young's moduli [Pa]")
    parser.add_argument("--out", type=Path, help="file for the tables")
    asked = parser.parse_args()
    names = asked.scenes or list(SCENES)
    if unknown := [name for name in names if name not in SCENES]:
        parser.error(f"no scene {unknown[0]}; scenes: {', '.join(SCENES)}")
    print(sitting())
    tables = {name: table(name, asked.young) for name in names}
    if asked.out:
        asked.out.write_text("\n\n".join(f"**{name}**\n\n" + "\n".join(lines) for name, lines in tables.items()) + "\n")


if __name__ == "__main__":
    main()
