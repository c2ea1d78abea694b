# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene file: a TOML text that says what stands, what shakes it, how it is computed and what is reported.

    format = 1                        # optional: of these keys, should they ever change
    title = "Arch under a sine"       # optional
    [structure]  kind = "arch" ...    # checked by structures; or several of them, [[structures]], side by side
    [material]   density, friction
    [[loads]]    kind = "sinusoidal"  # checked by loads
    [[links]]    kind, blocks ...     # optional: hinges, sliders and rigid links
    [[ground]]   shear_wave_velocity ...  # optional: supports on springs and dashpots of the soil
    [run]        dt, duration ...
    [report]     crack_map
    [limit]      push = "x"           # optional, of masonry-cd limit
    [hazard]     return_period, ag ... # optional, of the site: limit analysis and studies read it
    [assess]     friction = [0.5, 0.7]  # optional, ranges for masonry-cd assess
    [strengthen] factor = 0.2         # optional, of masonry-cd strengthen
    [[output.point]]  block, corner   # optional, what is kept in every step
    [[events]]   at, remove ...       # optional, what changes in the middle of a run; checked by app/events.py
    quiet_checks = ["limit.check.ag"] # optional: values that are meant as they are, however unusual

A run is a pure function of its scene, so the text of the scene, with what ``--set`` changed in it, goes into the results.
A number is in the SI unit of its key; a text may state another, "30 mm" (:mod:`masonry_cd.foundation.units`).
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, ValidationInfo, field_validator

from masonry_cd.analysis.hazard.table import HazardTable, hazard_of
from masonry_cd.app.assess_table import AssessTable
from masonry_cd.app.output_table import OutputTable
from masonry_cd.app.scene_text import dump_toml, is_within, keys_of, override, parse_toml, place_of, read_text
from masonry_cd.foundation.errors import Fault, Faults, InputError, parse_table, suggest
from masonry_cd.foundation.fields import Table
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.ground_table import GroundTable
from masonry_cd.mechanics.model.link_table import LinkTable
from masonry_cd.mechanics.model.materials import Material
from reports.settings import Report

if TYPE_CHECKING:
    from masonry_cd.analysis.hazard.curve import Hazard
    from masonry_cd.app.strengthen_table import StrengthenTable
    from structures.kind import StructureKind

LONGEST_VALUE = 60  # characters of a --set that messages repeat
STATIC = {"dt": 0.1, "duration": 1.0}  # in place of [run], of which limit analysis reads gravity and seed only; prepare() refuses it
FORMAT = 1  # of the keys of a scene; raised when an older program would misread them


class SceneTables(Table):
    """The top level of the file."""

    format: Annotated[int, Field(strict=True, ge=1)] = FORMAT
    """Format of the keys of this file."""
    title: str | None = None
    """Title of pictures and closing lines; the name of the file when not given."""
    structure: dict[str, Any] | None = None
    """The structure."""
    structures: list[dict[str, Any]] = Field(default_factory=list)
    """Or several structures side by side, [[structures]] each: the keys of [structure], and name, at, rotate."""
    material: dict[str, Any]
    """The material of blocks and joints."""
    loads: list[dict[str, Any]] = Field(default_factory=list)
    """Loads, [[loads]] each; they add up. Gravity acts in full without one."""
    links: list[dict[str, Any]] = Field(default_factory=list)
    """Hinges, sliders and rigid links between two blocks, [[links]] each, in the place of whatever joint these have."""
    ground: list[dict[str, Any]] = Field(default_factory=list)
    """Soil below supports, [[ground]] each: they become footings on its springs and dashpots. Supports move as prescribed without one."""
    run: dict[str, Any] | None = None
    """How it is computed. A scene with [limit] needs none for limit analysis, which has no time step."""
    report: dict[str, Any] = Field(default_factory=dict)
    """Pictures and tables that are written after the run."""
    limit: dict[str, Any] = Field(default_factory=dict)
    """Loads that masonry-cd limit multiplies until the structure gives way; a run does not read it."""
    hazard: dict[str, Any] | None = None
    """How often the site shakes how strongly: checks of limit analysis and studies read it, a run does not."""
    assess: dict[str, Any] = Field(default_factory=dict)
    """Ranges that masonry-cd assess varies instead of its own; a run does not read it."""
    strengthen: dict[str, Any] | None = None
    """The target of masonry-cd strengthen, and the ties that may be built in; a run does not read it."""
    output: dict[str, Any] = Field(default_factory=dict)
    """Points, joints, cracks and supports that are kept in every step: [[output.point]] and so on."""
    events: list[dict[str, Any]] = Field(default_factory=list)
    """Changes of the model during a run, one [[events]] each: blocks, supports, ties, props, bonds and materials."""
    quiet_checks: list[str] = Field(default_factory=list)
    """Keys whose unusual values are intended, such as ["limit.check.ag"]: their unit is not questioned."""

    @field_validator("title")
    @classmethod
    def _is_plain(cls, value: str | None) -> str | None:
        if value is not None and "\0" in value:  # result files take none
            raise ValueError("holds a NUL character")
        return value

    @field_validator("format")
    @classmethod
    def _is_known(cls, value: int) -> int:
        if value > FORMAT:
            raise ValueError(f"a newer masonry_cd reads this; this one reads scenes up to format {FORMAT}")
        return value

    @field_validator("structure", "material", "run", "report", "limit", "hazard", "assess", "strengthen", "output", mode="before")
    @classmethod
    def _is_table(cls, value: object) -> object:
        if not isinstance(value, Mapping):
            raise ValueError("should be a table of its own")
        return value

    @field_validator("loads", "structures", "events", "links", "ground", mode="before")
    @classmethod
    def _is_list_of_tables(cls, value: object, info: ValidationInfo) -> object:
        if not isinstance(value, list) or not all(isinstance(item, Mapping) for item in value):
            one = "soil" if info.field_name == "ground" else (info.field_name or "").removesuffix("s")
            raise ValueError(f"every {one} is a table of its own, headed [[{info.field_name}]]")
        return value


@dataclass(frozen=True)
class Origin:
    """Where the keys of a scene come from: a line of its file, or ``--set``."""

    text: str  # of the file; empty where no user wrote one, as of a scene made in Python: messages then name no line
    path: Path
    changes: tuple[str, ...] = ()  # by --set
    within: str = ""  # what keys begin with in that file: "scene." where the scene is a table of a study

    def of(self, key: str) -> str:
        """The place of a key: the last ``--set`` that gave it, or the file and its line, with those that changed something in it."""
        key = self.within + key
        given = [change for change in self.changes if is_within(key, change.partition("=")[0])]
        if given:
            return f"--set {_brief(given[-1])}"
        inside = [change for change in self.changes if is_within(change.partition("=")[0], key)]
        return place_of(self.text, key, self.path) + "".join(f" with --set {_brief(change)}" for change in inside)

    @contextmanager
    def locating(self, tables: Collection[str] | None = None) -> Iterator[None]:
        """Give the faults of the body the file and line of their keys; ``tables``: only those of keys in tables of these names."""
        try:
            yield
        except InputError as error:
            raise error.each(lambda fault: self._located(fault, tables)) from None

    def _located(self, fault: Fault, tables: Collection[str] | None) -> Fault:
        """A fault with the file and line of its key, unless it has them already."""
        key = fault.place.split(" ")[0]
        if fault.source or (tables is not None and re.split(r"[.\[]", key)[0] not in tables):
            return fault
        return fault._replace(source=self.of(key))


def _brief(change: str) -> str:
    """A change as it was typed, a long one by its key."""
    key, _, value = change.strip().partition("=")
    return f"{key}={value}" if len(value) <= LONGEST_VALUE else f"{key}=..."


@dataclass(frozen=True)
class Scene:
    """A scene file whose own tables are checked; ``structure``, ``structures`` and ``loads`` are checked by the packages of these names."""

    title: str
    structure: dict[str, Any]  # empty where there are several
    material: Material
    loads: tuple[dict[str, Any], ...]
    run: Run
    report: Report
    tables: Mapping[str, Any] = field(repr=False)  # as the text gives them, in whatever units; not to be changed
    text: str  # what the results keep: the file's text, or that of the changed tables when --set was used
    path: Path
    origin: Origin  # of its keys, for messages
    limit: dict[str, Any] = field(default_factory=dict)  # checked by loads
    hazard: HazardTable | None = None  # its keys
    strengthen: StrengthenTable | None = None
    assess: AssessTable = field(default_factory=AssessTable)
    quiet_checks: tuple[str, ...] = ()  # keys whose unusual values are intended
    structures: tuple[dict[str, Any], ...] = ()  # side by side; none where there is one
    output: OutputTable = field(default_factory=OutputTable)
    events: tuple[dict[str, Any], ...] = ()  # checked by app/events.py
    links: tuple[LinkTable, ...] = ()
    ground: tuple[GroundTable, ...] = ()
    static: bool = False  # there is no [run]: for limit analysis, modal analysis and pictures alone

    @property
    def folder(self) -> Path:
        """Folder from which relative paths in the scene are read."""
        return self.path.parent

    @property
    def kind(self) -> StructureKind | None:
        """The kind of the structure; None where there are several.

        Raises:
            InputError: no such kind.
        """
        from structures import kind_of

        return None if self.structures else kind_of(str(self.structure.get("kind")), self.folder)

    @cached_property
    def site(self) -> Hazard | None:
        """The hazard of the site; None without a table of it.

        Raises:
            InputError: a file of it that cannot be read, or holds none.
        """
        with self.locating():
            return None if self.hazard is None else hazard_of(self.hazard, self.folder)

    @property
    def until_still(self) -> bool:
        """Return True if the run goes on until its blocks are still: by default where damage is graded by what remains."""
        graded = self.report.damage or self.report.html
        return graded if self.run.until_still is None else self.run.until_still

    @property
    def stress(self) -> bool:
        """Return True if the run keeps stress: where a report is requested, or a strength to compare it with is given."""
        return self.report.stress or self.material.compressive_strength is not None

    def refuse_static(self) -> None:
        """Refuse a scene without [run] where it is run.

        Raises:
            InputError: there is none.
        """
        if self.static:
            raise InputError(self.origin.path, "run: missing: a run needs dt and duration; masonry-cd limit takes this scene as it is")

    def refuse_tables(self, what: str, *tables: str) -> None:
        """Refuse a scene with ``links``, ``events`` or ``ground`` where something, such as "limit analysis", knows none.

        Raises:
            InputError: there are some.
        """
        with self.locating():
            for name in tables:
                if getattr(self, name):
                    raise InputError(name, f"{what} knows none: it is of all blocks as built; --set {name}=[] leaves them out")

    def locating(self) -> AbstractContextManager[None]:
        """Give the faults of the body that lie in keys of this scene their file and line."""
        return self.origin.locating(SceneTables.model_fields)


def read_scene(path: Path | str, overrides: Sequence[str] = ()) -> Scene:
    """Read and check a scene file.

    Args:
        path: the TOML file.
        overrides: changes as ``key=value``, e.g. ``run.dt=1e-3`` or ``loads[0].amplitude=0.3``; values are TOML, or else text.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a value out of range; names file, line and key.
    """
    path = Path(path)
    return parse_scene(read_text(path), path, overrides)


def parse_scene(text: str, path: Path, overrides: Sequence[str] = (), called: str = "") -> Scene:
    """Check the text of a scene.

    Args:
        text: TOML.
        path: of its file, there or not; paths in the scene are relative to its folder.
        overrides: see :func:`read_scene`.
        called: how messages call it where no user wrote the file; they then name no line.

    Raises:
        InputError: see :func:`read_scene`.
    """
    origin = Origin("" if called else text, Path(called) if called else path, tuple(overrides))
    tables = parse_toml(text, origin.path)
    for change in overrides:
        override(tables, change)
    if overrides:
        text = f"# {path.name} with {' '.join(f'--set {change}' for change in overrides)}\n" + dump_toml(tables)
    return scene_of(tables, text, path, origin)


def scene_of(tables: Mapping[str, Any], text: str, path: Path, origin: Origin) -> Scene:
    """Check the tables of a scene.

    Args:
        tables: as read from TOML.
        text: what the results keep of it.
        path: the scene file, from whose folder relative paths are read.
        origin: where its keys come from.

    Raises:
        InputError: an unknown or missing key, a value out of range; names file, line and key.
    """
    with origin.locating():
        top = parse_table(SceneTables, tables, "")
        _check_structures(top, path.parent)
        if top.run is None and not top.limit:
            raise InputError("run", "missing")
        _check_quiet(tables, top.quiet_checks)
        faults, read = Faults(), dict[str, Any]()
        for name, model, table in (
            ("material", Material, top.material),
            ("run", Run, STATIC if top.run is None else top.run),
            ("report", Report, top.report),
            ("assess", AssessTable, top.assess),
            ("output", OutputTable, top.output),
        ):
            with faults.of():
                read[name] = parse_table(model, table, name)
        if top.hazard is not None:
            with faults.of():
                read["hazard"] = parse_table(HazardTable, top.hazard, "hazard")
        if top.strengthen is not None:
            from masonry_cd.app.strengthen_table import StrengthenTable  # its keys are those of ties, which bring the loads

            with faults.of():
                read["strengthen"] = parse_table(StrengthenTable, top.strengthen, "strengthen")
        several: Sequence[tuple[str, type[Table], list[dict[str, Any]]]] = (
            ("links", LinkTable, top.links),
            ("ground", GroundTable, top.ground),
        )
        for name, each, tables_of in several:
            for i, table in enumerate(tables_of):
                with faults.of():
                    read[name] = (*read.get(name, ()), parse_table(each, table, f"{name}[{i}]"))
        faults.refuse()
    return Scene(
        title=top.title or path.stem,
        structure=top.structure or {},
        structures=tuple(top.structures),
        loads=tuple(top.loads),
        events=tuple(top.events),
        tables=tables,
        text=text,
        path=path,
        origin=origin,
        limit=top.limit,
        quiet_checks=tuple(top.quiet_checks),
        static=top.run is None,
        **read,
    )


def _check_quiet(tables: Mapping[str, Any], quiet: Sequence[str]) -> None:
    """Refuse names in quiet_checks that are no keys of the scene: they would silence nothing.

    Raises:
        InputError: names the first of them.
    """
    keys = [key for key, _ in keys_of(tables)] if quiet else []
    for name in quiet:
        if not any(is_within(key, name) for key in keys):
            raise InputError("quiet_checks", f'"{name}" is not a key of the scene{suggest(name, keys)}')


def _check_structures(top: SceneTables, folder: Path) -> None:
    """Refuse a scene of no structure, one that gives them in two ways, and one without a density that it needs.

    Raises:
        InputError: names the key.
    """
    from structures import kind_of

    if top.structure is None and not top.structures:
        raise InputError("structure", "missing")
    if top.structure is not None and top.structures:
        raise InputError("structures", "there is a [structure] as well; where there are several, each is headed [[structures]]")
    every = top.structures or [top.structure or {}]
    stated = {"density", "masonry"} & top.material.keys()
    if not stated and not all("kind" in table and kind_of(str(table["kind"]), folder).own_densities for table in every):
        raise InputError("material.density", "missing")
