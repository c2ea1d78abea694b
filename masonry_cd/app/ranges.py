# SPDX-License-Identifier: GPL-3.0-or-later
"""What masonry, and what shakes and loads it, has: ranges beyond which a value of a scene is doubted, each with its reason.

A value outside of its range is not refused: scale models, proof loads and parametric studies go there on purpose. It draws one line
(:mod:`masonry_cd.app.doubts`), which says how it is written with the unit in which it would lie inside. Zero is never doubted: it leaves
something out. The unit of a value is that of its key, which its field declares.
"""

from __future__ import annotations

from dataclasses import dataclass
from fnmatch import fnmatchcase

G = 9.80665  # [m/s2], in which accelerations are often given
WEIGHTS = {"kN/m3": 1000.0 / G, "kN/m2": 1000.0 / G}  # that are given for masses, which they are over g [kg/m3, kg/m2]


@dataclass(frozen=True)
class Range:
    """Values that are usual."""

    low: float  # in the unit of the key, or in that of what is compared
    high: float
    others: tuple[tuple[str, float], ...]  # units that are easily meant instead, and their size in the unit of the key
    reason: str
    keys: tuple[str, ...] = ()  # whose value itself is compared: patterns of their paths, without the numbers of tables in lists
    unit: str = ""  # all keys that have it are compared, too: there is one rule for whatever is such a quantity

    def holds(self, value: float) -> bool:
        """Whether a value is usual, or zero."""
        return value == 0.0 or self.low <= abs(value) <= self.high

    def meant(self, value: float, per: float) -> str:
        """How a value would be written that is meant in another unit, ``if g is meant: "0.25 g"``; in each in which it is usual."""
        said = []
        for name, size in self.others:
            if self.holds(value * size / per):
                written = f"{value:g} {name}" if name not in WEIGHTS else f"{value * size:.4g} {name.replace('kN', 'kg')}"
                said.append(f'if {name} is meant: "{written}"')
        return "; ".join(said)


_PA, _GROUND, _FORCE = (("MPa", 1e6), ("GPa", 1e9)), (("g", G), ("cm/s2", 0.01)), (("kN", 1e3), ("MN", 1e6))
_STRENGTH, _SMALL, _SPEED = (
    (("MPa", 1e6), ("kPa", 1e3)),
    (("mm", 1e-3), ("cm", 1e-2)),
    (("cm/s", 0.01), ("mm/s", 1e-3), ("km/h", 1.0 / 3.6)),
)
_DENSITY, _AREAL = (("t/m3", 1e3), ("kN/m3", WEIGHTS["kN/m3"])), (("kN/m2", WEIGHTS["kN/m2"]), ("t/m2", 1e3))
_STIFFNESS, _AREA = (("N/mm3", 1e9), ("MN/m3", 1e6), ("kN/m3", 1e3)), (("cm2", 1e-4), ("mm2", 1e-6))

RANGES = {
    # what shakes
    "ag": Range(0.6, 10.0, _GROUND, "hazard maps give 0.6 to 10 m/s2 (0.06 to 1 g) where masonry is checked", ("*.ag",)),
    "corner": Range(0.05, 2.0, (("ms", 1e-3),), "T*_C is 0.1 to 1 s", ("*.tc_star",)),
    "target_pga": Range(0.6, 2.0 * G, _GROUND, "0.6 m/s2 (0.06 g) harms hardly any masonry, and few records exceed 2 g", ("*.target_pga",)),
    "pulse": Range(0.3, 50.0 * G, _GROUND, "0.3 m/s2 (0.03 g) harms no masonry, blows beyond 50 g are rare", ("loads.acceleration",)),
    "sine": Range(0.05, 2.0 * G, _SPEED, "2 pi frequency times it, its PGA, is usually 0.005 to 2 g"),
    "scaled": Range(0.05, 2.0 * G, (), "records of interest have 0.005 to 2 g; are units and scale those of the file?"),
    "gravity": Range(9.5, 10.5, _GROUND, "gravity on earth is 9.81 m/s2"),  # its size
    "behaviour": Range(
        1.0, 2.0, (), "codes give local mechanisms and parts 2 at the most", ("limit.check.behaviour_factor",),
    ),
    # supports that give way
    "settlement": Range(0.0, 0.1, _SMALL, "what stands settles by a few hundredths of its height at the most"),  # over the height
    "spreading": Range(0.0, 0.25, _SMALL, "few arches stand a quarter of their span"),  # over the largest extent
    "apart": Range(0.0, 1.0, _SMALL, "supports that part by more than the depth of a joint leave what stood on it without a bearing"),
    "speed": Range(0.0, 0.5, (), "supports that move faster than 0.5 m/s strike what stands on them; a longer duration?"),  # [m/s]
    "pushed": Range(0.0, 0.25, _SMALL, "what is pushed by a quarter of its structure's height has long come down"),  # over that height
    "bound": Range(0.0, 0.5, _SMALL, "openings, slips and displacements of limit states are below half a metre"),  # of a study
    # what is carried
    "force": Range(0.05, float("inf"), _FORCE, "a force below a twentieth of its block's weight changes little"),  # over that weight
    "pressure": Range(0.0, 3e7, (), "hardly any masonry bears 30 MPa"),  # of a force on the mean section of its block [Pa]
    "overload": Range(0.0, 200.0, (), "even proof loads are a few tens of times the weight of what bears them"),  # over that of all blocks
    "axle": Range(500.0, 1e6, _FORCE, "axles weigh 0.5 kN (a cart) to 1 MN (heavy transport)", ("loads.axles",)),
    "crossing": Range(0.0, 45.0, (("km/h", 1.0 / 3.6),), "vehicles cross bridges of masonry at up to 45 m/s, 160 km/h", ("loads.speed",)),
    "areal_mass": Range(15.0, 3000.0, _AREAL, "roofs and floors have 15 to 3000 kg/m2", unit="kg/m2"),
    "carried": Range(0.0, 1.0, (), "roofs and floors weigh less than the masonry that bears them"),  # over its mass
    # masonry
    "density": Range(
        400.0, 3500.0, _DENSITY, "masonry has 400 (foamed) to 3500 kg/m3 (basalt)", unit="kg/m3",
    ),
    "friction": Range(
        0.0, 1.2, (), "dry joints have 0.3 to 1.2; an angle is given by its tangent", ("material.friction*", "assess.friction*"),
    ),
    "young": Range(
        1e7, 2.5e11, _PA, "from adobe, 0.01 GPa, to steel, 210 GPa",
        ("material.young*", "material.masonry.E", "material.masonry.G", "assess.young"),
    ),
    "stiffness": Range(1e8, 1e15, _STIFFNESS, "joints of masonry have 1e8 to 1e13 N/m3", unit="N/m3"),
    "compression": Range(
        1e5, 5e8, _STRENGTH, "from rubble, 0.1 MPa, to the hardest stone, 500",
        ("material.compressive_strength*", "material.masonry.compressive_strength", "material.joints*compressive_strength"),
    ),
    "bond": Range(
        1e3, 2e7, _STRENGTH, "mortar and bricks have 0.001 to 20 MPa",
        ("material.joints*tension", "material.joints*cohesion", "material.masonry.bed_strength"),
    ),
    "damping": Range(
        0.0, 0.5, (), "a share of critical is given, 0.05 for 5 %, and masonry has 0.01 to 0.1",
        ("material.damping", "material.damping.*", "material.joints*damping", "assess.damping"),
    ),
    "thickness": Range(
        0.003, 12.0, _SMALL, "walls, vaults and slabs are 3 mm (a model) to 12 m (a fortress) thick",
        ("structure.*thickness",),
    ),
    "height": Range(
        0.003, 200.0, _SMALL, "masonry is at most some 170 m high", ("structure.*height",),
    ),
    "cover": Range(0.0, 10.0, _SMALL, "fill covers crowns by up to a few metres", ("structure.cover",)),
    "angle": Range(10.0, 60.0, (("rad", 57.29577951308232),), "fill has 20 to 50 degrees", ("structure.fill.friction_angle",)),
    # ties
    "tie_modulus": Range(
        1e9, 5e11, _PA, "timber has 10 GPa, steel 210 GPa, carbon fibre at most 500",
        ("structure.ties.modulus", "structure.floors.anchors.modulus", "loads.modulus"),
    ),
    "diameter": Range(
        3e-4, 0.4, _SMALL, "from wires of 0.3 mm to beams of 0.4 m",
        ("structure.ties.diameter", "structure.floors.anchors.diameter", "loads.diameter"),
    ),
    "spacing": Range(
        0.1, 30.0, _SMALL, "ties and anchors are 0.3 to 10 m apart", ("structure.ties.spacing", "structure.floors.anchors.spacing"),
    ),
    "side": Range(3e-4, 0.6, _SMALL, "from strips of 0.3 mm to beams of 0.6 m"),
    "section": Range(1e-7, 0.25, _AREA, "from wires of 0.1 mm2 to beams of 0.25 m2", unit="m2"),
    "yielding": Range(2e-5, 2e-2, _FORCE, "ties and anchorages yield at stretches of 2e-5 to 2e-2"),  # over E A
    "tension": Range(1e-6, 2e-2, _FORCE, "a tenth of a degree of warmth stretches a tie by 1e-6"),  # over E A
}  # fmt: skip


def range_of(path: str, unit: str) -> str:
    """The name of the range with which the value of a key is compared itself; empty where there is none.

    Args:
        path: of the key, without the numbers of tables in lists.
        unit: of the key; empty where it has none.
    """
    named = next((name for name, one in RANGES.items() if any(fnmatchcase(path, pattern) for pattern in one.keys)), "")
    return named or next((name for name, one in RANGES.items() if unit and unit == one.unit), "")
