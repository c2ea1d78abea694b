# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/scene_reference.md and docs/study_reference.md: every key of a scene and of a study with its text, default and bounds.

python docs/write_scene_reference.py
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from masonry_cd.app.scene_schema import scene_schema
from masonry_cd.foundation.table_schema import table_schema
from masonry_cd.mechanics.model.masonry_kinds import KINDS, Range
from masonry_cd.mechanics.model.stone_kinds import STONES
from masonry_cd.studies.selection.tables import SelectionTables
from masonry_cd.studies.study.clusters import SlurmTable
from masonry_cd.studies.study.study_file import StudyTables
from structures.site import PlaceTable

SCENE, STUDY = (Path(__file__).with_name(name) for name in ("scene_reference.md", "study_reference.md"))
HEAD = """# Every key of a scene

Written from the JSON schema of the scene file by `python docs/write_scene_reference.py`. A number is in the unit in
brackets; a text may state another, `"30 mm"`, see [Units](scene_file.md#units). *Needed* keys have no default; those without either may be
left out.
"""
STUDY_HEAD = """# Every key of a study

Written from the tables of the study file by `python docs/write_scene_reference.py`. [Studies](studies.md) explains them. *Needed* keys have
no default; those without either may be left out.
"""
SELECTION = "Read by [masonry-cd select](howto/records.md#choose-a-set-for-a-site); `[records]` as of a study.\n"
SITE = """Several structures side by side, in place of `[structure]`: each has the keys of its kind, as above, and those below. Blocks and
groups are named `NAME.block` and `NAME.group`; pairs of groups in `[material]` may be patterns, as `"*arch-*base"`. Structures that touch
pound on one another as any blocks do. Where the grounds of two of them overlap, an upright plane in the middle between the two parts them,
and damage has a row for each structure.
"""
SIGNS = {"minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below"}


def pages() -> dict[Path, str]:
    """The text of each page."""
    study = [STUDY_HEAD, *_section("The study file", table_schema(StudyTables)), *_section("slurm.toml", table_schema(SlurmTable))]
    selection = table_schema(SelectionTables)
    del selection["properties"]["records"]["properties"]  # which stand above
    study += _section("The selection file", selection, SELECTION)
    return {SCENE: _scene(), STUDY: "\n".join(study)}


def _scene() -> str:
    tables = scene_schema()["properties"]
    parts = [HEAD, *_section("[structure]", tables["structure"]), *_section("[[structures]]", table_schema(PlaceTable), SITE)]
    parts += [*_section("[material]", tables["material"]), *_masonry(), *_stones()]
    parts += [*_section("[[loads]]", tables["loads"]["items"]), *_section("[[links]]", tables["links"]["items"])]
    parts += _section("[[ground]]", tables["ground"]["items"])
    parts += [*_section("[run]", tables["run"]), *_section("[report]", tables["report"])]
    parts += [*_section("[limit]", tables["limit"]), *_section("[hazard]", tables["hazard"]), *_section("[assess]", tables["assess"])]
    parts += [*_section("[strengthen]", tables["strengthen"]), *_section("[output]", tables["output"])]
    parts += _section("[[events]]", tables["events"]["items"])
    return "\n".join(parts)


def _masonry() -> Iterator[str]:
    """The kinds of masonry and the values that the tables give them."""
    yield "### Masonry by name\n\nTable C8.5.I of Circolare 21 January 2019 n. 7: least and largest values.\n"
    rows = ["| kind | | w [kN/m3] | E, G [MPa] | f [MPa] | tau_0, f_v0 [MPa] |\n|---|---|---|---|---|---|"]
    for name, kind in KINDS.items():
        cells = ((kind.weight,), (kind.young, kind.rigidity), (kind.compressive,), (kind.shear, kind.sliding))
        rows.append(" | ".join([f"| `{name}`", kind.italian, *(", ".join(_range(one) for one in cell if one) for cell in cells)]) + " |")
    yield "\n".join(rows) + "\n"


def _stones() -> Iterator[str]:
    """The kinds of stone and the values that the table gives them."""
    yield "### Stones by name\n\nDried building stones, National Bureau of Standards: least and largest values.\n"
    rows = ["| kind | tensile_strength [MPa] | young [GPa] |\n|---|---|---|"]
    for name, kind in STONES.items():
        cells = zip(kind.ranges().values(), (1e-6, 1e-9), strict=True)
        rows.append(" | ".join([f"| `{name}`", *(" to ".join(f"{unit * value:.3g}" for value in values) for values, unit in cells)]) + " |")
    yield "\n".join(rows) + "\n"


def _range(values: Range) -> str:
    """Both ends of a range, or the one value of it."""
    return " to ".join(f"{value:g}" for value in dict.fromkeys(values))


def _section(name: str, schema: dict[str, Any], about: str = "") -> Iterator[str]:
    """The headings and tables of a table of the scene, one for each of its kinds."""
    yield f"## {name}\n"
    if about:
        yield about
    kinds = {kind["properties"]["kind"]["const"]: list(_keys(kind, "")) for kind in schema.get("oneOf", [])}
    common = [row for row in next(iter(kinds.values()), []) if all(row in rows for rows in kinds.values())]
    for kind in schema.get("oneOf", []):
        about = kind["properties"]["kind"]
        yield f'### kind = "{about["const"]}"\n\n{about["description"]}.\n'
        yield from _table([row for row in kinds[about["const"]] if row not in common and not row.startswith("| `kind`")])
    if common:
        yield "### Keys of every kind\n"
    if common or not kinds:
        yield from _table(common or list(_keys(schema, "")))


def _table(rows: list[str]) -> Iterator[str]:
    """A table of keys; those of tables inside it by their path."""
    if rows:
        yield "\n".join(["| key | default | |\n|---|---|---|", *rows, ""])


def _keys(schema: dict[str, Any], before: str) -> Iterator[str]:
    for name, key in schema["properties"].items():
        words = [json.dumps(word, ensure_ascii=False) for word in key.get("enum", [])]
        bounds = [f"{sign} {key[bound]:g}" for bound, sign in SIGNS.items() if bound in key]
        said = "; ".join([key["description"].rstrip("."), *([", ".join(words)] if words else bounds)])
        fallback = (
            f"`{json.dumps(key['default'], ensure_ascii=False)}`" if "default" in key else "*needed*" if name in _needed(schema) else ""
        )
        cell = said.replace("|", "\\|").replace("] [", "] \\[")  # two brackets in a row are no link
        yield f"| `{before}{name}` | {fallback} | {cell} |"
        for inner in (key, key.get("items"), *key.get("anyOf", [])):
            if isinstance(inner, dict) and "properties" in inner:
                yield from _keys(inner, f"{before}{name}.")
                break


def _needed(schema: dict[str, Any]) -> list[str]:
    return schema.get("required", [])


if __name__ == "__main__":
    for page, text in pages().items():
        page.write_text(text, encoding="utf-8")
