# SPDX-License-Identifier: GPL-3.0-or-later
"""Building models in IFC 4, made by ifcopenshell: boxes and prisms in millimetres, in storeys."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

Point = Sequence[float]


class Model:
    """A model with one building; lengths are given in metres."""

    def __init__(self) -> None:
        import ifcopenshell
        import ifcopenshell.guid

        self.guid = ifcopenshell.guid.new
        self.file: Any = ifcopenshell.file(schema="IFC4")
        unit = self.file.create_entity("IfcSIUnit", UnitType="LENGTHUNIT", Prefix="MILLI", Name="METRE")
        self.context = self.file.create_entity(
            "IfcGeometricRepresentationContext", ContextType="Model", CoordinateSpaceDimension=3, Precision=1e-5,
            WorldCoordinateSystem=self.axes((0, 0, 0)),
        )  # fmt: skip
        self.file.create_entity(
            "IfcProject", GlobalId=self.guid(), Name="made", RepresentationContexts=[self.context],
            UnitsInContext=self.file.create_entity("IfcUnitAssignment", Units=[unit]),
        )  # fmt: skip
        self.storeys: dict[str, Any] = {}

    def axes(self, origin: Point, x: Point = (1.0, 0.0, 0.0)) -> Any:
        point = self.file.create_entity("IfcCartesianPoint", Coordinates=[1000.0 * float(c) for c in origin])
        z, along = (self.file.create_entity("IfcDirection", DirectionRatios=[float(c) for c in d]) for d in ((0, 0, 1), x))
        return self.file.create_entity("IfcAxis2Placement3D", Location=point, Axis=z, RefDirection=along)

    def prism(self, outline: Sequence[Point], depth: float) -> Any:
        """An outline of the plan, drawn upwards."""
        points = [self.file.create_entity("IfcCartesianPoint", Coordinates=[1000.0 * float(c) for c in p]) for p in (*outline, outline[0])]
        curve = self.file.create_entity("IfcPolyline", Points=points)
        profile = self.file.create_entity("IfcArbitraryClosedProfileDef", ProfileType="AREA", OuterCurve=curve)
        up = self.file.create_entity("IfcDirection", DirectionRatios=(0.0, 0.0, 1.0))
        return self.file.create_entity(
            "IfcExtrudedAreaSolid", SweptArea=profile, Position=self.axes((0, 0, 0)), ExtrudedDirection=up, Depth=1000.0 * depth
        )

    def faces(self, points: Sequence[Point], loops: Sequence[Sequence[int]]) -> Any:
        """A closed shell by its corners and faces."""
        at = [self.file.create_entity("IfcCartesianPoint", Coordinates=[1000.0 * float(c) for c in p]) for p in points]
        made = []
        for loop in loops:
            bound = self.file.create_entity("IfcPolyLoop", Polygon=[at[k] for k in loop])
            made.append(
                self.file.create_entity("IfcFace", Bounds=[self.file.create_entity("IfcFaceOuterBound", Bound=bound, Orientation=True)])
            )
        return self.file.create_entity("IfcFacetedBrep", Outer=self.file.create_entity("IfcClosedShell", CfsFaces=made))

    def add(self, kind: str, name: str, item: Any, storey: str = "ground", origin: Point = (0, 0, 0), x: Point = (1, 0, 0)) -> Any:
        """An element with one shape."""
        body = "Brep" if item.is_a("IfcFacetedBrep") else "SweptSolid"
        shape = self.file.create_entity(
            "IfcShapeRepresentation", ContextOfItems=self.context, RepresentationIdentifier="Body", RepresentationType=body, Items=[item]
        )
        made = self.file.create_entity(
            kind, GlobalId=self.guid(), Name=name,
            ObjectPlacement=self.file.create_entity("IfcLocalPlacement", RelativePlacement=self.axes(origin, x)),
            Representation=self.file.create_entity("IfcProductDefinitionShape", Representations=[shape]),
        )  # fmt: skip
        if storey not in self.storeys:
            place = self.file.create_entity("IfcBuildingStorey", GlobalId=self.guid(), Name=storey)
            self.storeys[storey] = self.file.create_entity(
                "IfcRelContainedInSpatialStructure", GlobalId=self.guid(), RelatedElements=[made], RelatingStructure=place
            )
        else:
            relation = self.storeys[storey]
            relation.RelatedElements = [*relation.RelatedElements, made]
        return made

    def wall(self, name: str, start: Point, end: Point, thickness: float, base: float, height: float, storey: str = "ground") -> Any:
        """A wall by the middle line of its body."""
        length = float(sum((b - a) ** 2 for a, b in zip(start, end, strict=True)) ** 0.5)
        x = [(b - a) / length for a, b in zip(start, end, strict=True)]
        half = 0.5 * thickness
        body = self.prism([(0, -half), (length, -half), (length, half), (0, half)], height)
        return self.add("IfcWall", name, body, storey, (*start, base), (*x, 0.0))

    def opening(self, wall: Any, outline: Sequence[Point], origin: Point, depth: float, x: Point = (1, 0, 0)) -> None:
        """An opening by its outline along its wall and upwards, drawn out by a depth across it from its origin."""
        n = len(outline)
        points = [(s, t, z) for t in (0.0, depth) for s, z in outline]
        loops = [[*range(n)], [*range(2 * n - 1, n - 1, -1)], *([(k + 1) % n, k, n + k, n + (k + 1) % n] for k in range(n))]
        made = self.add("IfcOpeningElement", "opening", self.faces(points, loops), "openings", origin, x)
        self.file.create_entity("IfcRelVoidsElement", GlobalId=self.guid(), RelatingBuildingElement=wall, RelatedOpeningElement=made)

    def write(self, path: Path) -> None:
        self.file.write(str(path))


def house() -> Model:
    """Two storeys of 6 x 4 m with a floor between them, a gable, a door, a round window, a slab and a stair."""
    model = Model()
    for storey, base, high in (("ground", 0.0, 2.7), ("upper", 3.0, 2.6)):
        south = model.wall(f"south {storey}", (0.0, 0.2), (6.0, 0.2), 0.4, base, high, storey)
        model.wall(f"north {storey}", (0.0, 3.8), (6.0, 3.8), 0.4, base, high, storey)
        model.wall(f"west {storey}", (0.2, 0.4), (0.2, 3.6), 0.4, base, high, storey)
        if storey == "ground":
            model.wall("east", (5.8, 0.4), (5.8, 3.6), 0.4, base, high, storey)
            model.opening(south, [(0, 0), (1.0, 0), (1.0, 2.1), (0, 2.1)], (2.5, -0.1, 0.0), 0.6)
        else:
            side = [(0.0, 3.0), (3.2, 3.0), (3.2, 5.6), (1.6, 6.8), (0.0, 5.6)]
            points = [(x, 0.4 + s, z) for x in (5.6, 6.0) for s, z in side]
            loops = [[4, 3, 2, 1, 0], [5, 6, 7, 8, 9], *([k, (k + 1) % 5, 5 + (k + 1) % 5, 5 + k] for k in range(5))]
            model.add("IfcWall", "gable", model.faces(points, loops), storey)
            model.opening(south, [(0, 0), (0.8, 0), (0.8, 1.2), (0, 1.2)], (1.0, -0.1, 3.9), 0.6)
    model.add("IfcSlab", "floor", model.prism([(0.4, 0.4), (5.6, 0.4), (5.6, 3.6), (0.4, 3.6)], 0.3), "ground", (0, 0, 2.7))
    model.add("IfcStair", "stair", model.prism([(1, 1), (2, 1), (2, 2), (1, 2)], 1.0))
    return model
