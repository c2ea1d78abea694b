"""What masonry, and what shakes and loads it, has: ranges beyond which a value of a scene is doubted, each with its reason.

A value outside of its range is not refused: scale models, proof loads and parametric studies go there on purpose. It draws one line
(:mod:`masonry_cd.app.doubts`), which names the unit in which it would lie inside. Zero is never doubted: it leaves something out.
"""

from __future__ import annotations

from dataclasses import dataclass

G = 9.80665  # [m/s2], in which accelerations are often given
WEIGHT = 1000.0 / G  # [kg] that weigh a kilonewton

MPA, GPA, KPA = ("MPa", 1e6), ("GPa", 1e9), ("kPa", 1e3)


@dataclass(frozen=True)
class Range:
    """Values that are usual."""

    low: float  # in the unit, or in that of what is compared
    high: float
    unit: str  # of the key
    others: tuple[tuple[str, float], ...]  # units that are easily meant instead, and their size in the unit of the key
    reason: str

    def holds(self, value: float) -> bool:
        """Whether a value is usual, or zero."""
        return value == 0.0 or self.low <= abs(value) <= self.high


_SPEED = (("cm/s", 0.01), ("mm/s", 1e-3), ("km/h", 1.0 / 3.6))
_GROUND = (("g", G), ("cm/s2", 0.01))
_SMALL = (("mm", 1e-3), ("cm", 1e-2))
_FORCE = (("kN", 1e3), ("MN", 1e6))

RANGES = {
    "ag": Range(0.6, 10.0, "m/s2", _GROUND, "hazard maps give 0.6 to 10 m/s2 (0.06 to 1 g) where masonry is checked"),
    "target_pga": Range(0.6, 2.0 * G, "m/s2", _GROUND, "0.6 m/s2 (0.06 g) harms hardly any masonry, and few records exceed 2 g"),
    "sine": Range(0.05, 2.0 * G, "m/s", _SPEED, "2 pi frequency times it, its PGA, is usually 0.005 to 2 g"),
    "scaled": Range(0.05, 2.0 * G, "", (), "records of interest have 0.005 to 2 g; are units and scale those of the file?"),
    "settlement": Range(0.0, 0.1, "m", _SMALL, "what stands settles by a few hundredths of its height at the most"),  # over the height
    "spreading": Range(0.0, 0.25, "m", _SMALL, "few arches stand a quarter of their span"),  # over the largest extent
    "speed": Range(0.0, 0.5, "m", (), "supports that move faster than 0.5 m/s strike what stands on them; a longer duration?"),  # [m/s]
    "force": Range(0.05, float("inf"), "N", _FORCE, "a force below a twentieth of its block's weight changes little"),  # over that weight
    "pressure": Range(0.0, 3e7, "N", (), "hardly any masonry bears 30 MPa"),  # of a force on the mean section of its block [Pa]
    "gravity": Range(9.5, 10.5, "m/s2", _GROUND, "gravity on earth is 9.81 m/s2"),  # its size
    "density": Range(400.0, 3500.0, "kg/m3", (("t/m3", 1e3), ("kN/m3", WEIGHT)), "masonry has 400 (foamed) to 3500 kg/m3 (basalt)"),
    "friction": Range(0.0, 1.2, "", (), "dry joints have 0.3 to 1.2; an angle is given by its tangent"),
    "young": Range(1e7, 2.5e11, "Pa", (MPA, GPA), "from adobe, 0.01 GPa, to steel, 210 GPa"),
    "tie_modulus": Range(1e9, 5e11, "Pa", (MPA, GPA), "timber has 10 GPa, steel 210 GPa, carbon fibre at most 500"),
    "stiffness": Range(1e8, 1e15, "N/m3", (("N/mm3", 1e9), ("MN/m3", 1e6), ("kN/m3", 1e3)), "joints of masonry have 1e8 to 1e13 N/m3"),
    "compression": Range(1e5, 5e8, "Pa", (MPA, KPA), "from rubble, 0.1 MPa, to the hardest stone, 500"),
    "bond": Range(1e3, 2e7, "Pa", (MPA, KPA), "mortar and bricks have 0.001 to 20 MPa"),
    "diameter": Range(3e-4, 0.4, "m", _SMALL, "from wires of 0.3 mm to beams of 0.4 m"),
    "side": Range(3e-4, 0.6, "m", _SMALL, "from strips of 0.3 mm to beams of 0.6 m"),
    "section": Range(1e-7, 0.25, "m2", (("cm2", 1e-4), ("mm2", 1e-6)), "from wires of 0.1 mm2 to beams of 0.25 m2"),
    "yielding": Range(2e-5, 2e-2, "N", _FORCE, "ties and anchorages yield at stretches of 2e-5 to 2e-2"),  # over E A
    "tension": Range(1e-6, 2e-2, "N", _FORCE, "a tenth of a degree of warmth stretches a tie by 1e-6"),  # over E A
    "areal_mass": Range(15.0, 3000.0, "kg/m2", (("kN/m2", WEIGHT), ("t/m2", 1e3)), "roofs and floors have 15 to 3000 kg/m2"),
}  # fmt: skip

# Keys whose value itself is compared: patterns of their paths, without the numbers of tables in lists.
PLAIN = {
    "*.ag": "ag",
    "*.target_pga": "target_pga",
    "material.density": "density",
    "material.masonry.density": "density",
    "material.masonry.E": "young",
    "material.masonry.G": "young",
    "material.masonry.compressive_strength": "compression",
    "material.masonry.bed_strength": "bond",
    "material.friction*": "friction",
    "material.young*": "young",
    "material.compressive_strength*": "compression",
    "material.joints*_stiffness": "stiffness",
    "material.joints*tension": "bond",
    "material.joints*cohesion": "bond",
    "structure.core_density": "density",
    "structure.roof_mass": "areal_mass",
    "structure.floors.mass": "areal_mass",
    "structure.ties.modulus": "tie_modulus",
    "structure.ties.diameter": "diameter",
    "structure.ties.area": "section",
    "structure.floors.anchors.modulus": "tie_modulus",
    "structure.floors.anchors.diameter": "diameter",
    "loads.modulus": "tie_modulus",
    "loads.diameter": "diameter",
    "loads.area": "section",
}
