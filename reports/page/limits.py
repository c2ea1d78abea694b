# SPDX-License-Identifier: GPL-3.0-or-later
"""Assumptions of the analysis and what it leaves out, in sentences drawn from the scene; and the meaning of the grades of damage."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from masonry_cd.analysis.damage.grades import DESCRIPTIONS, LABELS, NAMES, REFERENCE, Grades, percent
from masonry_cd.analysis.modal.left_out import left_out_lines
from masonry_cd.analysis.stress.peaks import largest_pressure
from masonry_cd.foundation.errors import parse_table, table_in_si
from masonry_cd.foundation.quantities import counted
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.joint_laws import law_in_words
from masonry_cd.mechanics.model.joint_laws.friction import LISTED, friction_in_words
from masonry_cd.mechanics.model.materials import Material
from masonry_cd.mechanics.model.stones import stones_in_words
from reports.drawing.figure import in_metres
from reports.page.document import Badge
from reports.page.section import Section
from reports.page.words import PageContext, number

PLANE = (
    "The structure and its loads are symmetric about one plane: motion across that plane, such as that of a wall out of its plane, cannot "
    "occur in this run."
)


def limits(context: PageContext) -> Mapping[str, Any]:
    """Return the assumptions and what is not modelled, a sentence or two each."""
    results, kinds, moving = context.results, [str(load.get("kind")) for load in context.tables.get("loads", [])], context.moving_axes
    stands = [context.tables.get("structure", {}), *context.tables.get("structures", [])]
    return {
        "assumed": assumptions(context),
        "settles": bool({"settlement", "spreading", "motion"} & set(kinds)),
        "lines": left_out_lines(context.summary),
        "moving": moving,
        "vertical": "z" in moving,
        "tied": "tie" in kinds or bool(results.ties),  # these are of [[loads]] and of the structure
        "floors": any(table.get("floors") for table in stands),
        "stress": results.has_stress,
        "pressure": None if results.has_stress else _pressure(results),
        "points": counted(count, "point load") if (count := kinds.count("point")) else "",
    }


def assumptions(context: PageContext) -> list[str]:
    """Return the assumptions of the model."""
    material = context.tables.get("material")
    found = parse_table(Material, material, "material") if material else None
    return [
        _blocks(context, found),
        *([friction_in_words(found.friction), *_joints(found)] if found else []),
        "Blocks collide without rebound: impacts are perfectly plastic and do not damage the blocks.",
        _base(context),
        *_gravity(context),
        *([PLANE] if context.summary.planar else []),
    ]


def _pressure(results: Results) -> dict[str, str] | None:
    """Return the pressures to compare with the strength of the masonry; None where the file does not give them."""
    found = largest_pressure(results)
    if found is None:
        return None
    pressure, joint, time = found
    first, second = (results.blocks[int(side[joint])].name for side in (results.joints.block_a, results.joints.block_b))
    most = number(pressure / 1e6, "MPa", digits=2)
    return {"most": most, "joint": str(joint), "first": first, "second": second, "time": number(time, "s")}


def _blocks(context: PageContext, material: Material | None) -> str:
    """The blocks and their density."""
    free = [block for block in context.results.blocks if not block.fixed]
    densities = [block.density for block in free] or [math.nan]
    low, high = min(densities), max(densities)
    density = number(low) if low == high else f"{number(low)} to {number(high)}"
    return (
        f"The {len(free)} free blocks are {_kind(context, material)}, of uniform density ({density} kg/m³); they touch, slide, rock and "
        "separate only at their faces. Cracks form only in joints, between the blocks that the scene defines"
        f"{', and along planes through stones' if any(block.stone for block in free) else ''}."
    )


def _kind(context: PageContext, material: Material | None) -> str:
    """Describe the free blocks: rigid, elastic, or some of them."""
    groups = sorted({block.group for block in context.results.blocks if not block.fixed})
    every = sorted({block.group for block in context.results.blocks})
    laws = {} if material is None else {group: law for group in groups if (law := material.of_group(group, every))}
    if not laws:
        return "rigid"
    kinds = {group: "meshed" if law.mesh_size else "with one strain each" for group, law in laws.items()}
    if len(laws) == len(groups) and len(set(kinds.values())) == 1:
        return f"elastic, {kinds[groups[0]]}"
    parts = []
    for kind in dict.fromkeys(kinds.values()):
        own = ", ".join(group for group in groups if kinds.get(group) == kind)
        parts.append(f"elastic, {kind}, where they belong to {own}")
    return "; ".join(parts) + ("" if len(laws) == len(groups) else "; the others are rigid")


def _joints(material: Material) -> list[str]:
    """Dry joints, or the mortar of each pair of groups."""
    laws, otherwise, stones = material.joint_laws, _otherwise(material), stones_in_words(material.stones)
    dry = f"are {otherwise} and dry: they have no tensile strength, no cohesion, and unlimited compressive strength."
    if not laws:
        return [f"Joints {dry}", *stones]
    named = [(pair, law) for pair, law in laws.items() if pair != "default"][:LISTED]
    lines = [f"Joints of {pair}: {law_in_words(law, otherwise)}." for pair, law in named]
    if "default" in laws:
        others = "Joints" if len(laws) == 1 else "All other joints"
        return [*lines, f"{others}: {law_in_words(laws['default'], otherwise)}.", *stones]
    return [*lines, f"All other joints {dry}", *stones]


def _otherwise(material: Material) -> str:
    """Describe the joints without a stiffness of their own."""
    moduli = material.joint_moduli
    if moduli is None or material.masonry is None:
        return "rigid"
    young, shear = (number(modulus / 1e9, "GPa", digits=3) for modulus in moduli)
    return f"elastic, as stiff as masonry of E {young} and G {shear} ({material.masonry.kind})"


def _base(context: PageContext) -> str:
    """How the supports move."""
    count, moving = int(context.solids.fixed.sum()), context.moving_axes
    if not count:
        return "No block is a support."
    supports = "The support is rigid" if count == 1 else f"The {count} supports are rigid"
    base = context.summary.loads.base
    turn = f"turn{'s' if count == 1 else ''} by up to {number(base.peak_rotation, 'degrees', digits=3)}" if base.peak_rotation else ""
    if not moving:
        return f"{supports} and {turn or 'at rest'}."
    differ = base.largest_difference
    turning = f", and {turn}" if turn else ""
    together = "" if count == 1 else ", all alike" if not differ else f", with relative displacements of up to {in_metres(differ)}"
    return f"{supports} and {'moves' if count == 1 else 'move'} as prescribed along {' and '.join(moving)}{together}{turning}."


def _gravity(context: PageContext) -> list[str]:
    """Gravity, where it is not that of the earth, straight down."""
    gravity = table_in_si((Run,), context.tables.get("run", {}), "run").get("gravity", [0.0, 0.0, -9.81])
    down = gravity[:2] == [0.0, 0.0] or gravity[:2] == [0, 0]
    if down and abs(gravity[2] + 9.81) < 0.02:
        return []
    return [f"Gravity is ({', '.join(f'{value:.4g}' for value in gravity)}) m/s²."]


def grades(context: PageContext) -> Mapping[str, Any]:
    """Return the meaning of D0 to D5: the words of EMS-98, and the numbers of this report."""
    settings = context.parts.settings.grades if context.parts is not None else Grades()
    measures = ((settings.width, in_metres), (settings.drift, percent), (settings.lost, percent))
    rows = [
        [
            Badge.grade(name),
            label,
            DESCRIPTIONS[k] if label == LABELS[k] else "",
            *(_bound(values, text, k) for values, text in measures),
        ]
        for k, (name, label) in enumerate(zip(NAMES, settings.labels, strict=True))
    ]
    return {"rows": rows, "reference": REFERENCE}


def _bound(values: Sequence[float], text: Callable[[float], str], grade: int) -> str:
    """From where on a measure gives a grade."""
    if grade == 0 or math.isinf(values[grade - 1]):
        return "–"
    return "any" if values[grade - 1] <= 1e-6 else text(values[grade - 1])


SECTIONS = {"limits": Section("Assumptions and limits", limits, 10), "grades": Section("Grades of damage", grades, 30)}
