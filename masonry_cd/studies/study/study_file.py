# SPDX-License-Identifier: GPL-3.0-or-later
"""The study file: a TOML text that says what runs there are.

scene = "arch.toml"                  # relative to this file; or [scene] with the scene's tables
design = "stripes"                   # grid | sample | stripes | ida | cloud | ensemble
seed = 1
[records]       folder, pattern ...  # motions, see records.py
[intensity]     measure, levels      # what they are scaled to
[vary]          "material.friction" = ...
[limit_states]  collapse = {quantity = "collapsed_blocks", above = 0}
[adaptive]      theta, beta, runs    # how well a fragility is to be known: of the stripes only the telling runs
[run]           workers, timeout, keep
[[observations]]                     # of a calibration, see masonry_cd/studies/calibrate
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator

from loads.signal.directions import Rule
from masonry_cd.analysis.calibration.observations import Observation
from masonry_cd.analysis.fragility.limits import LimitStateTable
from masonry_cd.app.scene import Origin, Scene, read_scene, scene_of
from masonry_cd.app.scene_text import dump_toml, parse_toml, read_text
from masonry_cd.app.scene_units import scene_in_si, unit_of_key
from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.foundation.fields import Count, Number, Table
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.solvers.options import LARGEST_SEED
from masonry_cd.studies.study.record_tables import RecordsTable
from masonry_cd.studies.study.study_units import study_in_si
from masonry_cd.studies.study.varied import KeyCorrelation, Varied, read_varied

FORMAT = 1
MASONRY = "material.masonry."  # beginning of its keys
OWNERS = {  # designs to which keys belong
    "samples": ("sample", "calibrate"), "ida": ("ida",), "adaptive": ("stripes",), "ensemble": ("ensemble",),
    "observations": ("calibrate",), "calibration": ("calibrate",), "modal": ("calibrate",),
}  # fmt: skip
CLOUDS = ("cloud", "sample", "grid")  # designs whose runs have intensities of their own, so that a line is put through them
MOST_SECONDS = 1e8  # of a run: three years
Positive = Annotated[Number, Field(gt=0)]


class IntensityTable(Table):
    """The table ``[intensity]``."""

    measure: str = "PGA"
    """Intensity measure, "PGA", "Sa(0.5)", "AvgSA(0.1,1.0)"; with ``key``, any word for the column."""
    of: Rule = "x"
    """Component "x", "y" or "z"; or both horizontal ones by "geometric_mean", "larger", "rotd50" or "rotd100"."""
    levels: list[Positive] | None = None
    """Levels of stripes and grids, in the unit of the measure, SI."""
    also: list[str] = Field(default_factory=list)
    """Further measures that become columns."""
    key: str | None = None
    """Key of the scene that a level is put in, where there are no records to scale: "loads[0].ag"."""

    @field_validator("levels")
    @classmethod
    def _each_once(cls, value: list[float] | None) -> list[float] | None:
        if value is not None and (not value or len(set(value)) < len(value)):
            raise ValueError("should be levels, each once")
        return value


class IdaTable(Table):
    """The table ``[ida]``: hunt and fill (Vamvatsikos & Cornell, EESD 31(3), 2002)."""

    limit_state: str = "collapse"
    """Limit state that ends the search."""
    start: Positive
    """First level, in the unit of the measure."""
    step: Positive
    """From the first to the second level."""
    growth: Annotated[Number, Field(ge=0)] = 0.0
    """Factor by which each step is longer than the one before."""
    resolution: Annotated[Number, Field(gt=0, lt=1)] = 0.1
    """Resolution of the level of collapse, as a share of it."""
    runs: Annotated[Count, Field(ge=3, le=1000)] = 12
    """At most, for each motion."""
    fill: Annotated[Count, Field(ge=0, le=1000)] = 2
    """Runs that halve the widest gaps below the collapse."""


class AdaptiveTable(Table):
    """The table ``[adaptive]``: of stripes only the runs from which most is learnt about a fragility."""

    limit_state: str = "collapse"
    """Limit state whose fragility is sought."""
    theta: Annotated[Number, Field(gt=0, lt=1)] = 0.1
    """Standard deviation of ln theta at which the study ends ..."""
    beta: Annotated[Number, Field(gt=0, lt=1)] = 0.2
    """Standard deviation of ln beta that is required as well."""
    runs: Annotated[Count, Field(ge=1)] | None = None
    """Runs at most; every motion at every level when not given."""
    batch: Annotated[Count, Field(ge=1, le=12)] = 8
    """Runs that are chosen, and made, at once."""


class EnsembleTable(Table):
    """The table ``[ensemble]``: the same scene under tiny perturbations."""

    members: Annotated[Count, Field(ge=2, le=1_000_000)] = 20
    """Number of members; the first is the scene itself."""
    perturb: Literal["loads", "friction", "velocities"] = "loads"
    """Perturbed quantity: the size of the loads, the friction, or the initial velocities of the blocks."""
    size: Annotated[Number, Unit("m/s"), Field(ge=1e-12, le=1e-3)] = 1e-9
    """Largest relative change; of velocities, the largest in each direction."""


class RunTable(Table):
    """The table ``[run]`` of a study: how its runs are made."""

    workers: Annotated[Count, Field(ge=1, le=10_000)] | None = None
    """Processes of this machine, one thread each; as many as there are cores when not given."""
    timeout: Annotated[Number, Unit("s"), Field(gt=0, le=MOST_SECONDS)] = 3600.0
    """Elapsed time that the steps of a run may take; beyond it the run ends after its step and counts as failed."""
    grace: Annotated[Number, Unit("s"), Field(gt=0, le=MOST_SECONDS)] = 300.0
    """A run that takes longer than the timeout and this, set-up included, hangs: its worker is ended, and it counts as failed."""
    keep: Literal["none", "summary", "all"] = "none"
    """Files kept of each run in addition to its row: none, its summary and joints.csv, or its whole folder."""
    memory: Annotated[Positive, Unit("GB")] | None = None
    """Memory of each worker at most; its share of the machine's when not given."""


class CalibrationTable(Table):
    """The table ``[calibration]``: how far a posterior is sampled."""

    rounds: Annotated[Count, Field(ge=1, le=100)] = 6
    """Rounds of ``samples`` each at most."""
    wanted: Positive = 100.0
    """Effective number of samples at which it ends."""
    least: Annotated[Number, Field(ge=2)] = 30.0
    """Effective number below which there is no answer."""


class StudyTables(Table):
    """The top level of the file."""

    format: Annotated[int, Field(strict=True, ge=1, le=FORMAT)] = FORMAT
    """Format of the keys of this file."""
    title: str | None = None
    """Title of pictures and closing lines; that of the scene when not given."""
    scene: str | dict[str, Any]
    """A scene file, relative to this one, or the tables of a scene."""
    design: Literal["grid", "sample", "stripes", "ida", "cloud", "ensemble", "calibrate"]
    """Which runs there are; "calibrate" is for masonry-cd calibrate."""
    asks: Literal["run", "limit"] = "run"
    """Computation made of each scene: a run, or a limit analysis as its table [limit] asks for it."""
    seed: Annotated[Count, Field(ge=0, le=LARGEST_SEED)] = 0
    """Seed of everything that is drawn."""
    samples: Annotated[Count, Field(ge=1, le=10_000_000)] | None = None
    """Samples of the design "sample"; of each round of "calibrate"."""
    records: RecordsTable | None = None
    """The motions; or the name of a file with this table, as masonry-cd select writes it."""
    intensity: IntensityTable | None = None
    """Intensity that motions are scaled to or measured by."""
    vary: dict[str, Any] = Field(default_factory=dict)
    """Keys of the scene that vary."""
    correlation: list[KeyCorrelation] = Field(default_factory=list)
    """Correlations of keys that vary."""
    limit_states: dict[str, LimitStateTable] = Field(default_factory=dict)
    """Limit states that are judged for each run."""
    loss_ratios: dict[str, Annotated[Number, Field(ge=0.0, le=1.0)]] = Field(default_factory=dict)
    """Cost of repair over that of reconstruction of limit states by name, for vulnerability.xml and the mean annual loss."""
    ida: IdaTable | None = None
    """Search of the design "ida"."""
    adaptive: AdaptiveTable | None = None
    """Choice of the runs of the design "stripes" in batches."""
    ensemble: EnsembleTable | None = None
    """Ensemble of the design "ensemble"."""
    observations: list[Observation] = Field(default_factory=list)
    """Observations of the design "calibrate", [[observations]] each."""
    calibration: CalibrationTable | None = None
    """Extent of the sampling of its posterior."""
    modal: dict[str, Any] = Field(default_factory=dict)
    """Options of masonry-cd modal for frequencies and shapes that were observed: method = "joints" or "continuum", mesh_size, restraint."""
    run: RunTable = Field(default_factory=RunTable)
    """How the runs are made."""


@dataclass(frozen=True, eq=False)
class ReadStudy:
    """A study file whose tables are checked."""

    path: Path
    text: str
    tables: StudyTables
    scene: Scene
    scene_tables: dict[str, Any]  # as they stand in the file of the scene, in SI units
    scene_name: str
    varied: Varied
    origin: Origin

    @property
    def title(self) -> str:
        """The title."""
        return self.tables.title or self.scene.title

    @property
    def folder(self) -> Path:
        """Folder from which the paths of the study are read."""
        return self.path.parent

    def locating(self) -> AbstractContextManager[None]:
        """Give the faults of the body, which lie in keys of this file, its name and line."""
        return self.origin.locating()


def read_study(path: Path | str) -> ReadStudy:
    """Read and check a study file and its scene.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a value out of range; names file, line and key.
    """
    path = Path(path)
    return parse_study(_study_text(path), path)


def parse_study(text: str, path: Path, called: str = "") -> ReadStudy:
    """Check the text of a study and its scene.

    Args:
        text: TOML.
        path: of its file, there or not; paths in the study are relative to its folder.
        called: how messages call it where no user wrote the file; they then name no line.

    Raises:
        InputError: see :func:`read_study`.
    """
    origin = Origin("" if called else text, Path(called) if called else path)
    tables = parse_toml(text, origin.path)
    scene = _scene(tables.get("scene"), path, origin)

    def unit(key: str) -> str:
        return unit_of_key({} if scene is None else scene.tables, key)

    with origin.locating():
        if isinstance(tables.get("records"), str):
            tables["records"] = _records(path.parent / tables["records"])
        top = parse_table(StudyTables, study_in_si(tables, unit), "")
        _check_design(top)
        varied = read_varied(top.vary, top.correlation, unit, path.parent, {} if scene is None else _ranges(scene))
    assert scene is not None
    with scene.locating():
        own = scene_in_si(scene.tables)  # runs change some of them, and compute with others
    if any(key.startswith(MASONRY) for key in varied.columns) and isinstance(own["material"].get("masonry"), str):
        own["material"] = {**own["material"], "masonry": {"kind": own["material"]["masonry"]}}
    return ReadStudy(path, text, top, scene, own, top.scene if isinstance(top.scene, str) else path.name, varied, origin)


def _scene(given: object, path: Path, origin: Origin) -> Scene | None:
    """The scene of a study, a file or a table; None of something else, which its table refuses."""
    if isinstance(given, str):
        file = path.parent / given
        with origin.locating():
            if not is_file(file):
                raise InputError("scene", f"{file}: no such scene file")
        return read_scene(file)
    return (
        scene_of(given, dump_toml(given), path, Origin(origin.text, origin.path, within="scene.")) if isinstance(given, Mapping) else None
    )


def _records(file: Path) -> dict[str, Any]:
    """The table [records] of a file of its own, whose folder is then seen from anywhere.

    Raises:
        InputError: no such file, or a wrong key in it.
    """
    if not is_file(file):
        raise InputError("records", f"{file}: no such file")
    text = read_text(file)
    table = parse_toml(text, file).get("records")
    if not isinstance(table, dict):
        raise InputError("records", f"{file}: has no table [records]")
    with Origin(text, file).locating():
        parse_table(RecordsTable, table, "records")
    return table | {key: str(file.parent.resolve() / table[key]) for key in ("folder",) if key in table}


def _ranges(scene: Scene) -> dict[str, tuple[float, float]]:
    """The ranges of the kind of masonry of a scene, by key."""
    masonry = scene.material.masonry
    return {} if masonry is None else {f"{MASONRY}{name}": (one.least, one.largest) for name, one in masonry.ranges().items()}


def _study_text(path: Path) -> str:
    """The text of the file."""
    if not path.exists():
        raise InputError(path, "no such study file")
    return read_text(path)


def _check_design(top: StudyTables) -> None:
    """Check that a design has what it needs, and nothing that it does not use.

    Raises:
        InputError: names the key.
    """
    design, intensity = top.design, top.intensity
    if top.asks == "limit":
        if design not in ("grid", "sample"):
            raise InputError("asks", f'limit analyses vary over a "grid" or a "sample", and this design is "{design}"')
        stray = [key for key in ("records", "intensity", "limit_states") if getattr(top, key)]
        if stray:
            raise InputError(stray[0], "belongs to runs, and this study asks for limit analyses")
    levels = intensity is not None and intensity.levels is not None
    needs = {
        "sample": [("samples", top.samples is not None), ("vary", bool(top.vary))],
        "calibrate": [
            ("samples", top.samples is not None),
            ("vary", bool(top.vary or top.records)),
            ("observations", bool(top.observations)),
        ],
        "stripes": [("intensity.levels", levels), ("records", top.records is not None)],
        "cloud": [("records", top.records is not None)],
        "ida": [("records", top.records is not None), ("intensity", intensity is not None), ("ida", top.ida is not None)],
    }
    for key, there in needs.get(design, []):
        if not there:
            raise InputError(key, f'missing, the design "{design}" needs it')
    for key, owners in OWNERS.items():
        if getattr(top, key) and design not in owners:
            raise InputError(key, f'belongs to the design "{owners[0]}", and this one is "{design}"')
    if top.limit_states and design == "calibrate":
        raise InputError("limit_states", "a calibration asks none; [[observations]] has quantities of a run")
    if levels and design in ("ida", "cloud", "ensemble"):
        raise InputError("intensity.levels", f'the design "{design}" takes none')
    if design not in CLOUDS:
        for name, state in top.limit_states.items():
            if state.least_demand is not None:
                raise InputError(f"limit_states.{name}.least_demand", f'is of the regression of a cloud, which "{design}" has none of')
    for key, table in (("ida", top.ida), ("adaptive", top.adaptive)):
        if table is not None and table.limit_state not in top.limit_states:
            none = f'there is no "{table.limit_state}" in [limit_states]{suggest(table.limit_state, top.limit_states)}'
            raise InputError(f"{key}.limit_state", none)
    for name in top.loss_ratios:
        if name not in top.limit_states:
            raise InputError(f"loss_ratios.{name}", f"there is no such limit state{suggest(name, top.limit_states)}")
    of_files = top.records is not None and top.records.folder is not None
    if intensity is not None and (intensity.key is None) != of_files:
        if of_files:
            raise InputError("intensity.key", "motions of a folder are scaled by their measure; leave it out")
        raise InputError(
            "intensity.key", "missing; there are no motions of a folder to measure, so a level is the value of a key of the scene"
        )
