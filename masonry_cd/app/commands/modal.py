# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal check of a scene: both models, the measured modes next to them, and the files that say so.

modal.json            everything below, and the size of the models
modal.csv             one row per model and mode: frequency, participating masses, measured frequency, error, MAC
shapes_<model>.csv    shapes at the centroids of the blocks, in the form in which measured modes are read
modes_<model>.png     pictures of the first modes
ambient.csv           modes identified from an ambient record, in that form too; stabilisation.png shows how
mesh_convergence.csv  frequencies of the continuum by size of the elements, where requested
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from masonry_cd.analysis.modal.measured_modes import MeasuredMode, ModePair, fit_factor, mac, pair, read_measured, shape_rows, turned_like
from masonry_cd.analysis.modal.modes import METHODS, Modes
from masonry_cd.analysis.modal.modes import modal as modes_of
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.app.ambient import Ambient, ambient_of
from masonry_cd.app.folders import free_folder
from masonry_cd.app.result import Result
from masonry_cd.foundation import own_files
from masonry_cd.foundation.csv_files import write_rows
from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.units import Unit
from masonry_cd.mechanics.model.blocks import Assembly, Block, refuse_spheres
from masonry_cd.mechanics.model.materials import Material

if TYPE_CHECKING:
    from masonry_cd.app.case import BuiltStructure
    from masonry_cd.app.scene import Scene
    from masonry_cd.mechanics.model.footings import Footings

JointStiffness = tuple[float, float] | tuple[np.ndarray, np.ndarray]
Positive = Annotated[float, Field(gt=0, allow_inf_nan=False)]
START = 1e9  # modulus from which a fit starts where none is given [Pa]
ALIKE = 0.8  # MAC below which a pair is reported as doubtful
OUTPUTS = files_of("modal")


class ModalOptions(BaseModel):
    """Options of the command."""

    model_config = ConfigDict(extra="forbid", frozen=True, use_attribute_docstrings=True)

    young: Annotated[Positive | dict[str, Positive], Unit("Pa")] | None = None
    """Modulus of the masonry, or moduli by group of blocks and ``default``; that of the scene's masonry when not given."""
    poisson: Annotated[float, Field(ge=0, lt=0.5)] = 0.2
    """Poisson's ratio."""
    method: Literal["both", "continuum", "joints"] = "both"
    """Which model."""
    modes: Annotated[int, Field(ge=1, le=500)] = 6
    """Modes to compute; as many more as are measured."""
    mesh_size: Annotated[Positive, Unit("m")] | None = None
    """Size of the tetrahedra; about the thickness of the structure when not given."""
    convergence: Annotated[tuple[Positive, ...], Unit("m")] = ()
    """Sizes of tetrahedra to compare."""
    normal_stiffness: Annotated[Positive, Unit("N/m3")] | None = None
    """Normal stiffness of all joints, instead of E / block length."""
    tangential_stiffness: Annotated[Positive, Unit("N/m3")] | None = None
    """Tangential stiffness of all joints; k_n / (2 (1 + nu)) when not given."""
    restraint: dict[str, str] = {}
    """Directions that supports hold, by group; all when not given."""
    reference: Path | None = None
    """CSV file of measured modes."""
    ambient: Path | None = None
    """CSV file of accelerations under ambient noise, from which modes are identified and taken as measured."""
    sensors: Path | None = None
    """CSV file of the places of the sensors of ``ambient``."""
    lowest: Annotated[Positive, Unit("Hz")] | None = None
    """Lowest frequency to identify; 1/50 of the highest when not given."""
    highest: Annotated[Positive, Unit("Hz")] | None = None
    """Highest frequency to identify; 0.4 of the rate when not given."""
    fit: bool = False
    """Fit the modulus to the first measured frequency."""
    pictures: Annotated[int, Field(ge=0)] = 6
    """Modes to draw; 0 for none."""
    view: Literal["front", "back", "side", "left", "top", "isometric"] = "isometric"
    """View of the picture."""

    @model_validator(mode="after")
    def _fit_needs_measured(self) -> ModalOptions:
        if self.fit and self.reference is None and self.ambient is None:
            raise ValueError("fit needs the measured modes: give reference or ambient")
        if self.reference is not None and self.ambient is not None:
            raise ValueError("reference and ambient both give the measured modes: give one of them")
        if (self.ambient is None) != (self.sensors is None) or (self.ambient is None and (self.lowest or self.highest)):
            raise ValueError("give ambient (a record) and sensors (the positions of its sensors) together; lowest and highest need both")
        if self.tangential_stiffness is not None and self.normal_stiffness is None:
            raise ValueError("tangential_stiffness needs normal_stiffness as well")
        return self

    @property
    def joint_stiffness(self) -> tuple[float, float] | None:
        """k_n and k_t [Pa/m], where they are given."""
        if self.normal_stiffness is None:
            return None
        return self.normal_stiffness, self.tangential_stiffness or self.normal_stiffness / (2.0 * (1.0 + self.poisson))


@dataclass(frozen=True, eq=False)
class ModelComparison:
    """The modes of one model next to the measured ones."""

    modes: Modes
    pairs: tuple[ModePair, ...] = ()
    factor: float = 1.0  # on the modulus given, from the fit


def modal(
    source: Scene | Sequence[Block],
    options: Mapping[str, Any],
    folder: Path | None = None,
    force: bool = False,
    title: str = "Modes",
) -> Result[dict[str, Any]]:
    """The modal check of a scene.

    Args:
        source: a scene, or blocks.
        options: keys of :class:`ModalOptions`.
        folder: where files are written, created if missing; nothing is written without one.
        force: overwrite the files that are there.
        title: of blocks, which have none of a scene.

    Returns:
        what modal.json holds, ``lines`` and ``warnings`` among them.

    Raises:
        InputError: a wrong option, scene, or file of measured modes or of an ambient record.
    """
    from masonry_cd.app.case import structure_of
    from masonry_cd.app.doubts import structure_doubts
    from masonry_cd.app.scene import Scene

    if folder is not None:
        free_folder(folder, OUTPUTS, force)
    asked, unusual = parse_table(ModalOptions, options, "modal"), []
    ambient = ambient_of(asked.ambient, asked.sensors, asked.modes, (asked.lowest, asked.highest))
    measured, footings = read_measured(asked.reference) if asked.reference else ambient.modes if ambient else [], None
    aside: list[str] = []
    if isinstance(source, Scene):
        source.refuse_tables("the modal check", "links", "events")
        made, title, material = structure_of(source), source.title, source.material
        unusual = structure_doubts(source, made.blocks)
        if source.ground:
            asked, made, aside = _on_ground(source, asked, made)
        blocks, footings = made.blocks, made.assembly.footings
    else:
        blocks, material = list(source), None
    refuse_spheres(blocks, "structure", "the modal check")
    asked, stiffness = _of_masonry(asked, blocks, material, footings)
    methods = METHODS if asked.method == "both" else (asked.method,)
    results = [_result(blocks, method, asked, measured, stiffness, footings) for method in methods]
    results = [results[0], *(ModelComparison(turned_like(r.modes, results[0].modes), r.pairs, r.factor) for r in results[1:])]
    young = results[0].modes.young if asked.method != "joints" else asked.young or START
    table = convergence(blocks, young, asked) if asked.convergence else []
    out = _summary(title, results, table)
    if ambient:
        out["ambient"] = ambient.facts()
        out["lines"] = ambient.lines() + out["lines"]
    out["lines"] += aside
    out["warnings"] += unusual
    written = [] if folder is None else _write(results, folder, blocks, out, asked, ambient)
    return Result(out, out["lines"], out["warnings"], written)


def _on_ground(scene: Scene, asked: ModalOptions, structure: BuiltStructure) -> tuple[ModalOptions, BuiltStructure, list[str]]:
    """Return the options of a scene whose supports stand on ground, its structure with footings, and a line on the model left out.

    Raises:
        InputError: the continuum is requested, which knows no ground.
    """
    from masonry_cd.app.case import on_ground

    if asked.method == "continuum":
        raise InputError("modal.method", 'the continuum needs fixed supports; use the method "joints", or --set ground=[]')
    if any(table.uplift for table in scene.ground):
        raise InputError("ground.uplift", "modes need footings that do not lift off; add --set ground[0].uplift=false")
    left = ["continuum: left out; it needs fixed supports, and those of this scene stand on [[ground]]"] if asked.method == "both" else []
    return asked.model_copy(update={"method": "joints"}), on_ground(scene, structure), left


def _of_masonry(
    asked: ModalOptions, blocks: Sequence[Block], material: Material | None, footings: Footings | None
) -> tuple[ModalOptions, JointStiffness | None]:
    """Return the options, with the modulus of the scene's masonry where none is given, and then also the stiffness of its joints.

    Raises:
        InputError: there is no modulus at all.
    """
    if asked.young is not None or material is None or material.joint_moduli is None:
        if asked.young is None and not asked.fit:
            raise InputError(
                "modal", "the modulus of elasticity is missing: give young, name material.masonry, or fit it to measured modes"
            )
        return asked, asked.joint_stiffness
    from masonry_cd.mechanics.contact.find_joints import find_joints
    from masonry_cd.mechanics.dynamics.pair_stiffness import stiffness_of_joints

    assembly = replace(Assembly.from_blocks(blocks, material), deformation=None, footings=footings)
    asked = asked.model_copy(update={"young": material.joint_moduli[0]})
    return asked, asked.joint_stiffness or stiffness_of_joints(assembly, find_joints(assembly))


def _result(
    blocks: Sequence[Block],
    method: str,
    asked: ModalOptions,
    measured: Sequence[MeasuredMode],
    stiffness: JointStiffness | None,
    footings: Footings | None,
) -> ModelComparison:
    """Compute one model, fit it where asked, and pair it with what was measured; ``stiffness`` of the joints where it is not by E."""
    spare = 4 if any(mode.has_shape for mode in measured) else 0  # a measured mode may answer to a higher one
    modes = modes_of(
        blocks,
        asked.young if asked.young is not None else START,
        asked.poisson,
        method=method,
        modes=max(asked.modes, max((mode.mode for mode in measured), default=0) + spare),
        size=asked.mesh_size,
        stiffness=stiffness,
        restraint=asked.restraint,
        footings=footings,
    )
    factor = fit_factor(modes, measured) if asked.fit else 1.0
    modes = modes.scaled(factor) if asked.fit else modes
    return ModelComparison(modes, tuple(pair(modes, measured)), factor)


def convergence(blocks: Sequence[Block], young: float | Mapping[str, float], asked: ModalOptions) -> list[dict[str, Any]]:
    """Frequencies of the continuum by size of the elements, coarse to fine, with their distance from the finest in per cent."""
    rows: list[dict[str, Any]] = []
    for size in sorted(asked.convergence, reverse=True):
        modes = modes_of(blocks, young, asked.poisson, modes=asked.modes, size=size, restraint=asked.restraint)
        facts = {key: modes.facts[key] for key in ("element_size_m", "elements", "unknowns", "seconds")}
        rows.append(facts | {f"f{k + 1}_hz": float(value) for k, value in enumerate(modes.frequencies)})
    for row in rows:
        row |= {
            key.replace("_hz", "_above_finest_percent"): 100.0 * (value / rows[-1][key] - 1.0)
            for key, value in list(row.items())
            if key.endswith("_hz") and key in rows[-1]
        }
    return rows


def _summary(title: str, results: Sequence[ModelComparison], table: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the contents of modal.json."""
    from masonry_cd import __version__

    models = {result.modes.method: _model(result) for result in results}
    out: dict[str, Any] = {"title": title, "version": __version__, "models": models, "mesh_convergence": list(table)}
    if len(results) == 2:
        first, second = (result.modes for result in results)
        between = np.array([[mac(a, b) for b in second.shapes] for a in first.shapes])
        out["mac_between_models"] = {"rows": first.method, "columns": second.method, "values": between.round(6).tolist()}
    out["lines"] = [line for result in results for line in _lines(result)]
    out["warnings"] = [line for result in results for line in _warnings(result)]
    return out


def _model(result: ModelComparison) -> dict[str, Any]:
    """One model in numbers."""
    modes = result.modes
    young = dict(modes.young) if isinstance(modes.young, Mapping) else modes.young
    return {
        "young_pa": young,
        "young_fitted": result.factor != 1.0,
        "poisson": modes.poisson,
        "frequency_hz": modes.frequencies.tolist(),
        "participation": {axis: modes.participation[:, k].tolist() for k, axis in enumerate("xyz")},
        "participation_sum": dict(zip("xyz", modes.participation.sum(axis=0).tolist(), strict=True)),
        "measured": [_pair(p) for p in result.pairs],
        **modes.facts,
    }


def _pair(p: ModePair) -> dict[str, Any]:
    known = p.mode is not None
    return {
        "measured_mode": p.measured_mode,
        "measured_hz": p.measured,
        "mode": p.mode,
        "computed_hz": p.computed if known else None,
        "error_percent": p.error_percent if known else None,
        "mac": p.mac if math.isfinite(p.mac) else None,
    }


def _lines(result: ModelComparison) -> list[str]:
    """The modes as text."""
    modes = result.modes
    young = f"{modes.young / 1e9:.4g} GPa" if isinstance(modes.young, (int, float)) else "by group"
    head = f"{modes.method}: E {young}{' (fitted)' if result.factor != 1.0 else ''}, {modes.facts['unknowns']} unknowns"
    lines = [head, "  mode  frequency   mass in x     y     z" + ("   measured   error    MAC" if result.pairs else "")]
    for row in _rows(result):
        share = " ".join(f"{100 * row[f'mass_{axis}']:4.0f} %" for axis in "xyz")
        line = f"  {row['mode']:4d} {row['frequency_hz']:8.4g} Hz    {share}"
        if row["measured_hz"]:
            line += f" {row['measured_hz']:8.4g} Hz {_signed(row['error_percent']):>6} %" + (
                f"  {row['mac']:.3f}" if row["mac"] != "" else ""
            )
        lines.append(line)
    return lines


def _signed(percent: float) -> str:
    """One decimal and a sign; no minus before zero."""
    return f"{round(percent, 1) + 0.0:+.1f}"


def _warnings(result: ModelComparison) -> list[str]:
    """Doubtful pairs, and motions that nothing holds."""
    lines = []
    if result.modes.facts["rigid_motions"]:
        lines.append(
            f"{result.modes.method}: the supports leave {result.modes.facts['rigid_motions']} rigid motions free; they are not listed"
        )
    for p in result.pairs:
        if p.mode is None:
            lines.append(f"{result.modes.method}: no computed mode matches measured mode {p.measured_mode}")
        elif p.mac < ALIKE:
            lines.append(f"{result.modes.method}: measured mode {p.measured_mode} matches computed mode {p.mode} poorly (MAC {p.mac:.2f})")
    return lines


def _write(
    results: Sequence[ModelComparison],
    folder: Path,
    blocks: Sequence[Block],
    summary: dict[str, Any],
    asked: ModalOptions,
    ambient: Ambient | None,
) -> list[Path]:
    """Write modal.json, the tables and the pictures into a folder, which is created if missing.

    Raises:
        InputError: no off-screen OpenGL for the pictures; the tables are written by then.
    """
    from masonry_cd.foundation.json_files import write_json

    own_files.begin(folder, OUTPUTS)
    own_files.remove(folder, OUTPUTS)
    write_json(folder / "modal.json", summary)
    write_rows(folder / "modal.csv", [row for result in results for row in _rows(result)])
    for result in results:
        modes = result.modes
        write_rows(folder / f"shapes_{modes.method}.csv", shape_rows(modes.frequencies, modes.names, modes.points, modes.shapes))
    if ambient:
        ambient.write(folder, summary["title"], bool(asked.pictures))
    if summary["mesh_convergence"]:
        write_rows(folder / "mesh_convergence.csv", summary["mesh_convergence"])
    if asked.pictures:
        from reports.modes_picture import draw_modes

        for result in results:
            path = folder / f"modes_{result.modes.method}.png"
            draw_modes(result.modes, blocks, path, summary["title"], _captions(result), asked.pictures, asked.view)
    return [folder / name for name in OUTPUTS if (folder / name).exists()]


def _rows(result: ModelComparison) -> list[dict[str, Any]]:
    """The rows of modal.csv."""
    modes, by_mode = result.modes, {p.mode: p for p in result.pairs}
    rows = []
    for k in range(modes.count):
        p = by_mode.get(k + 1)
        rows.append(
            {
                "model": modes.method,
                "mode": k + 1,
                "frequency_hz": float(modes.frequencies[k]),
                "period_s": float(1.0 / modes.frequencies[k]),
                **{f"mass_{axis}": float(modes.participation[k, i]) for i, axis in enumerate("xyz")},
                "measured_mode": p.measured_mode if p else "",
                "measured_hz": p.measured if p else "",
                "error_percent": p.error_percent if p else "",
                "mac": p.mac if p and math.isfinite(p.mac) else "",
            }
        )
    return rows


def _captions(result: ModelComparison) -> list[str]:
    """The measured frequency of each mode, as text."""
    out = []
    for row in _rows(result):
        similar = f", MAC {row['mac']:.2f}" if row["mac"] != "" else ""
        measured = row["measured_hz"]
        out.append(f"measured {measured:.4g} Hz, error {_signed(row['error_percent'])} %{similar}" if measured else "")
    return out
