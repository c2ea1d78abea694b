# SPDX-License-Identifier: GPL-3.0-or-later
"""The JSON schema of the scene file, put together from the tables that read it.

Editors complete and check scenes by it (taplo, Even Better TOML). Kinds of structure and of load are alternatives, chosen by ``kind``.
Those of installed packages are among them, so that their modules are imported. The file ``scene.schema.json`` next to this one is what
``masonry-cd schema`` prints without any.
"""

from __future__ import annotations

import inspect
import sys
from pathlib import Path

from masonry_cd.analysis.hazard.table import HazardTable
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.output_table import OutputTable
from masonry_cd.app.scene import SceneTables
from masonry_cd.foundation.plugins import load, names
from masonry_cd.foundation.table_schema import DRAFT, Schema, as_text, table_schema
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.ground_table import GroundTable
from masonry_cd.mechanics.model.link_table import LinkTable
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report

TITLE = "Scene of masonry_cd"
FILE = Path(__file__).with_name("scene.schema.json")
PLAN_FILE = FILE.with_name("plan.schema.json")  # what ``masonry-cd schema --plan`` prints
REFUSED = "additionalProperties"  # set to false where unknown keys are


def scene_schema() -> Schema:
    """The schema of a scene file."""
    from loads import KINDS as LOADS
    from masonry_cd.app.events import EventTable
    from masonry_cd.app.strengthen_table import StrengthenTable
    from structures import KINDS as STRUCTURES

    top = table_schema(SceneTables)
    keys = top["properties"]
    structures, loads = [*STRUCTURES, *names("structures")], [*LOADS, *names("loads")]
    keys["structure"] |= {"oneOf": [structure_schema(kind) for kind in structures]}
    keys["structures"]["items"] = {"type": "object", "oneOf": [placed_schema(kind) for kind in structures]}
    keys["loads"]["items"] = {"type": "object", "required": ["kind"], "oneOf": [load_schema(kind) for kind in loads]}
    keys["events"]["items"] = table_schema(EventTable)
    keys["links"]["items"] = table_schema(LinkTable)
    keys["ground"]["items"] = table_schema(GroundTable)
    keys["material"] |= table_schema(Material)
    keys["run"] |= table_schema(Run)
    keys["report"] |= table_schema(Report)
    keys["limit"] |= limit_schema()
    keys["hazard"] = table_schema(HazardTable) | {"description": keys["hazard"]["description"]}
    keys["assess"] |= table_schema(AssessTable)
    keys["strengthen"] |= table_schema(StrengthenTable)
    keys["output"] |= table_schema(OutputTable)
    for table in ("structure", "material", "run", "report", "limit", "assess", "strengthen", "output"):
        if keys[table].get(REFUSED) is True:
            del keys[table][REFUSED]
    keys["structure"]["required"] = ["kind"]
    file = {"properties": {"kind": {"enum": [kind for kind in STRUCTURES if STRUCTURES[kind].own_densities]}}}
    of_file = {"properties": {"structure": file, "structures": {"items": file}}}
    either = [{"required": ["density"]}, {"required": ["masonry"]}]
    density = {"properties": {"material": {"anyOf": either}}}  # only blocks of a file may bring their own
    one = [{"required": ["structure"]}, {"required": ["structures"]}]
    run = [{"required": ["run"]}, {"required": ["limit"]}]
    return {"$schema": DRAFT, "title": TITLE, **top, "oneOf": one, "anyOf": run, "if": of_file, "else": density}


def limit_schema() -> Schema:
    """The schema of ``[limit]``."""
    from masonry_cd.app.limit_table import LimitTable

    return table_schema(LimitTable)


def structure_schema(kind: str) -> Schema:
    """The schema of ``[structure]`` for a kind: its own keys, and those of every kind.

    Raises:
        InputError: a package that cannot be imported.
    """
    from structures import kind_of
    from structures.tables import CommonTable

    made = kind_of(kind)
    own: Schema = {"type": "object", "properties": {}} if made.table is None else table_schema(made.table)
    about: Schema = {"const": kind, "description": _first_sentence(made.build.__module__)}
    own["properties"] = {"kind": about} | own["properties"] | table_schema(CommonTable)["properties"]
    own["required"] = ["kind", *own.get("required", [])]
    return own


def placed_schema(kind: str) -> Schema:
    """The schema of ``[[structures]]`` for a kind: that of ``[structure]``, with its place."""
    from structures.site import PlaceTable

    own, place = structure_schema(kind), table_schema(PlaceTable)
    own["properties"] = {**place["properties"], **own["properties"]}
    own["required"] = [*place["required"], *own["required"]]
    return own


def load_schema(kind: str) -> Schema:
    """The schema of ``[[loads]]`` for a kind.

    Raises:
        InputError: a package that cannot be imported.
    """
    from loads import KINDS

    table = (KINDS[kind] if kind in KINDS else load("loads", kind)).table
    own = table_schema(table)
    about: Schema = {"const": kind, "description": _first_sentence(table.__module__)}
    own["properties"] = {**own["properties"], "kind": about}
    own["required"] = ["kind", *(name for name in own.get("required", []) if name != "kind")]
    return own


def schema_text() -> str:
    """The schema as a file."""
    return as_text(scene_schema())


def plan_schema_text() -> str:
    """The schema of a building's plan in JSON as a file: the keys of its table but those by which a drawing is read."""
    from structures.building.table import BuildingTable
    from structures.plans.json_plan import OF_A_FILE
    from structures.plans.keys import PlanKeys

    made = table_schema(BuildingTable)
    of_drawings = ("plan", "storeys", *PlanKeys.model_fields)
    keys: Schema = {"units": {"const": "m", "description": "of all lengths"}, **{key: {"type": "string"} for key in OF_A_FILE}}
    made["properties"] = keys | {key: value for key, value in made["properties"].items() if key not in of_drawings}
    made["properties"]["walls"] |= {"minItems": 1}
    return as_text({"$schema": DRAFT, "title": "Plan of a building for masonry_cd", **made, "required": ["walls"]})


def _first_sentence(module: str) -> str:
    """The first sentence of the docstring of an imported module."""
    said = inspect.getdoc(sys.modules[module]) or ""
    return " ".join(said.partition("\n\n")[0].split()).partition(". ")[0].rstrip(".")
