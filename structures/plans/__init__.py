# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans of buildings from files: drawings in DXF, models in IFC, and tables in JSON, as tables of ``kind = "building"``.

:func:`open_plan` says what a file holds and what of it was not understood.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    import numpy as np

    from masonry_cd.foundation.errors import Fault
    from structures.plans.keys import PlanKeys
    from structures.plans.recognised import Left, Recognised

METRES = {"m": 1.0, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}
UNITS_OF_CODE = {1: "in", 2: "ft", 4: "mm", 5: "cm", 6: "m"}  # $INSUNITS
FAR = 1000.0  # m: a plan further from the origin, as in the coordinates of a country, is brought near it
SMALL, LARGE = 2.0, 500.0  # extent of a plan outside of which its unit is doubted [m]


class FilePlan(NamedTuple):
    """A building as a file describes it."""

    tables: dict[str, Any]  # walls with their openings, junctions, vaults, columns ... as in [structure]
    notes: list[str]  # lines for the user: what was assumed, what is left
    left: list[Left]  # entities of a drawing that are not understood
    faults: dict[str, Fault]  # what walls lack that the drawing should say, by wall
    origin: tuple[float, float]  # of the structure, in the coordinates of the drawing [m]
    entries: dict[str, list[tuple[str, int]]]  # by list of the tables, the file, and storey, of each entry and its number there
    floors: list[tuple[str, dict[str, Any]]]  # of storeys: key that asks for each, and its keys

    @classmethod
    def of(cls, name: str, tables: dict[str, Any]) -> FilePlan:
        """All that a file of a name says."""
        lists = {key: value for key, value in tables.items() if isinstance(value, list)}
        return cls(tables, [], [], {}, (0.0, 0.0), {key: [(name, i) for i in range(len(value))] for key, value in lists.items()}, [])


def open_plan(path: Path, keys: Mapping[str, Any], origin: tuple[float, float] | None = None) -> FilePlan:
    """Read a plan.

    Args:
        path: of a .dxf, .ifc or .json file.
        keys: of the scene's [structure]; those of :class:`.keys.PlanKeys` say how to read a drawing.
        origin: of the structure, in the coordinates of a drawing; by default where the drawing lies [m].

    Raises:
        InputError: no such file, none that can be read, or no wall in it.
    """
    from masonry_cd.foundation.errors import InputError, parse_table
    from masonry_cd.foundation.files import is_file
    from structures.plans.json_plan import read_json
    from structures.plans.keys import PlanKeys

    asked = parse_table(PlanKeys, {key: keys[key] for key in PlanKeys.model_fields if key in keys}, "structure")
    suffix = path.suffix.lower()
    if suffix not in (".dxf", ".ifc", ".json"):
        hint = "; save it as DXF" if suffix == ".dwg" else ""
        raise InputError("structure.plan", f"{path.name} is not a plan; plans are read from .dxf, .ifc and .json{hint}")
    if not is_file(path):
        raise InputError("structure.plan", f'no file "{path.name}" in {path.parent}')
    if suffix == ".dxf":
        return _drawing(path, asked, origin)
    for key in ("units", "layers"):
        if key in asked.model_fields_set:
            raise InputError(f"structure.{key}", f"belongs to a drawing; {path.name} is in metres and has no layers")
    return _model(path) if suffix == ".ifc" else FilePlan.of(path.name, read_json(path))


def _model(path: Path) -> FilePlan:
    """The plan of an IFC."""
    from structures.files import foreign
    from structures.plans.ifc_model import element_of, read_model

    elements, _, unread = foreign.read("structures.plans.ifc_file:read", path, of=element_of)
    return _plan(path.name, [*unread], read_model(elements, path.name), "elements")


def _drawing(path: Path, keys: PlanKeys, origin: tuple[float, float] | None) -> FilePlan:
    """The plan of a DXF."""
    from masonry_cd.foundation.errors import InputError
    from structures.files import foreign
    from structures.plans.entities import entity_of
    from structures.plans.places import drawn_about
    from structures.plans.recognised import recognise

    entities, figures, unread = foreign.read("structures.plans.dxf_file:read", path, of=entity_of)
    stated = UNITS_OF_CODE.get(int(figures[0]))
    unit = keys.units or stated
    if unit is None:
        raise InputError("structure.units", f"missing; {path.name} does not state its unit ($INSUNITS), so take one of {', '.join(METRES)}")
    notes = [*([f"{path.name}: is damaged; what could be read of it was"] if figures[1] else []), *unread]
    if keys.units and stated and keys.units != stated:
        notes.append(f'{path.name}: units "{keys.units}" as the scene says, where the file has "{stated}"')
    scaled = [e.scaled(METRES[unit]) for e in entities]
    drawn = [e.points[:, :2] for e in scaled if keys.layers.role(e.layer) in ("walls", "axes")]
    if keys.units is None:
        _doubt_unit(drawn, unit, path.name)
    origin = origin or _corner(drawn)
    if any(origin):
        notes.append(f"{path.name}: its place ({origin[0]:.0f}, {origin[1]:.0f}) m is the origin of the structure")
        scaled = [e.scaled(1.0, origin) for e in scaled]
    with drawn_about(origin):
        found = recognise(scaled, keys, path.name)
    return _plan(path.name, notes, found, "entities")._replace(origin=origin)


def _plan(name: str, notes: Sequence[str], found: Recognised, what: str) -> FilePlan:
    """The plan of a file of which some was recognised, with what there is to say of it before."""
    from structures.plans.recognised import counted

    left = [f"{name}: {len(found.left)} {what} are not understood:", *(f"  {line}" for line in counted(found.left))]
    said = [*notes, *found.notes, *(left if found.left else [])]
    return FilePlan.of(name, found.tables)._replace(notes=said, left=found.left, faults=found.faults)


def _doubt_unit(places: Sequence[np.ndarray], unit: str, name: str) -> None:
    """Ask for the unit of a drawing whose walls (n, 2) are too small or too large for a building [m].

    Raises:
        InputError: they are.
    """
    import numpy as np

    from masonry_cd.foundation.errors import InputError

    every = np.concatenate([np.zeros((0, 2)), *places])
    extent = float(np.ptp(every, axis=0).max()) if len(every) else 0.0
    if extent and not SMALL <= extent <= LARGE:
        fit = [f'"{other}" ({extent * size / METRES[unit]:.3g} m)' for other, size in METRES.items()]
        fit = [one for one, size in zip(fit, METRES.values(), strict=True) if SMALL <= extent * size / METRES[unit] <= LARGE]
        likely = f"; likely {' or '.join(fit)}" if fit else ""
        wide = f'walls of {name} are {extent:.4g} m across in its unit, "{unit}", buildings are {SMALL:g} to {LARGE:g} m'
        raise InputError("structure.units", f"{wide}: say the unit{likely}")


def _corner(places: Sequence[np.ndarray]) -> tuple[float, float]:
    """Lower left corner of some places (n, 2) in whole metres, where it is far from the origin; else the origin [m]."""
    import numpy as np

    x, y = np.floor(np.concatenate([np.zeros((0, 2)), *places]).min(axis=0, initial=np.inf)).tolist()
    return (x, y) if FAR < max(abs(x), abs(y)) < np.inf else (0.0, 0.0)
