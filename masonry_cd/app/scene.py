"""The scene file: a TOML text that says what stands, what shakes it, how it is computed and what is reported.

    title = "Arch under a sine"       # optional
    [structure]  kind = "arch" ...    # checked by the room structures
    [material]   density, friction
    [[loads]]    kind = "sinusoidal"  # checked by the room loads
    [run]        dt, duration ...
    [report]     crack_map

A run is a pure function of its scene, so the text of the scene, with what ``--set`` changed in it, goes into the results.
All quantities are in SI units.
"""

from __future__ import annotations

import json
import math
import re
import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict, field_validator, model_validator

from masonry_cd.errors import InputError, parse_table

Number = Annotated[float, Strict(), Field(allow_inf_nan=False)]
Count = Annotated[int, Strict()]
Flag = Annotated[bool, Strict()]
MOST_STEPS = 1e8  # of a run: more than years of computing, and gigabytes of loads
SolverName = Literal["auto", "nlgs", "admm", "newton", "interior"]


def _three_numbers(value: object) -> object:
    """Say what is expected of a vector before pydantic speaks of tuples."""
    if isinstance(value, Sequence) and not isinstance(value, str) and len(value) == 3:
        return tuple(value)
    raise ValueError("should be three numbers [x, y, z]")


def _list_of_numbers(value: object) -> object:
    """A list as a tuple; anything else is told for what it should be."""
    if isinstance(value, list):
        return tuple(value)
    raise ValueError("should be a list of numbers, [1.0, 2.5]")


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class JointLaw(_Table):
    """The law of a joint, a table ``[material.joints]`` or ``[material.joints.arch-base]``."""

    normal_stiffness: Annotated[Number, Field(gt=0)] | None = None
    """Elastic force per area and shortening [N/m3]; rigid when not given."""
    tangential_stiffness: Annotated[Number, Field(gt=0)] | None = None
    """Elastic force per area and slip [N/m3]; the normal one over 2.4, as of a material with Poisson's ratio 0.2, when not given."""
    cohesion: Annotated[Number, Field(ge=0)] = 0.0
    """Shear strength without compression, of a joint that has not broken yet [Pa]."""
    tension: Annotated[Number, Field(ge=0)] | None = None
    """Tensile strength of a joint that has not broken yet [Pa]; when not given, cohesion / friction, where Mohr-Coulomb's line ends."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.6
    """Of the spring over the time step: 0.5 does not damp; above, a mode of frequency f is damped by (2 theta - 1) pi f dt."""

    @model_validator(mode="after")
    def _both_stiffnesses_or_none(self) -> JointLaw:
        if self.tangential_stiffness is not None and self.normal_stiffness is None:
            raise ValueError("tangential_stiffness needs normal_stiffness beside it")
        if self.tension is not None and self.normal_stiffness is None:
            raise ValueError(
                "tension needs normal_stiffness: how a rigid joint spreads its stress is not unique, it parts at cohesion / friction"
            )
        return self

    @property
    def stiffness(self) -> tuple[float, float]:
        """Normal and tangential [N/m3]; zeros stand for a rigid joint."""
        normal = self.normal_stiffness or 0.0
        return normal, self.tangential_stiffness or normal / 2.4


class Material(_Table):
    """The table ``[material]``."""

    density: Number
    """Of every block that brings none of its own [kg/m3]."""
    friction: Number | dict[str, Number]
    """Coefficient of friction: one value, or values by pair of groups, ``friction.arch-base = 0.7``, and ``default``."""
    joints: dict[str, JointLaw] = {}
    """Laws of the joints by pair of groups, ``[material.joints.arch-base]``, and ``default``, which plain keys stand for. A joint
    without a law is rigid and dry."""

    @field_validator("density")
    @classmethod
    def _density_in_kg_per_m3(cls, value: float) -> float:
        if not 30 <= value <= 30000:
            raise ValueError("should be between 30 and 30000 kg/m3")
        return value

    @field_validator("joints", mode="before")
    @classmethod
    def _laws(cls, value: Any) -> Any:
        """One law for all joints is the default of the pairs."""
        if not isinstance(value, Mapping):
            raise ValueError("should be a table: keys of one law, or tables by pair of groups")
        plain = [key for key, law in value.items() if not isinstance(law, Mapping)]
        if plain and len(plain) < len(value):
            raise ValueError(f'holds keys of one law ("{plain[0]}") and tables by pair; put the keys under [material.joints.default]')
        return {"default": value} if plain else value

    @field_validator("friction", mode="before")
    @classmethod
    def _coefficients(cls, value: Any) -> Any:
        pairs = value if isinstance(value, Mapping) else {"": value}
        if not pairs:
            raise ValueError("gives no value")
        for pair, mu in pairs.items():
            name = f'"{pair}": ' if pair else ""
            if isinstance(mu, bool) or not isinstance(mu, (int, float)):
                raise ValueError(f"{name}should be a number")
            if not 0 <= mu <= 20:
                raise ValueError(
                    f"{name}a coefficient of friction (no angle) should be between 0 and 20" + (f", got {mu:g}" if pair else "")
                )
        return {pair: float(mu) for pair, mu in pairs.items()} if isinstance(value, Mapping) else float(pairs[""])


class Run(_Table):
    """The table ``[run]``: time, solver and output."""

    dt: Annotated[Number, Field(gt=0, le=0.1)]
    """Time step [s]."""
    duration: Annotated[Number, Field(gt=0)]
    """How long to compute [s]."""
    theta: Annotated[Number, Field(ge=0.5, le=1)] = 0.5
    """Of the Moreau-Jean step: 0.5 keeps the energy of a free motion, 1 damps it."""
    solver: SolverName = "auto"
    """Of the friction problem of each step."""
    tolerance: Annotated[Number, Field(gt=0, lt=1)] = 1e-8
    """Natural map error that each step has to reach."""
    max_iterations: Annotated[Count, Field(ge=1)] | None = None
    """Iterations of each island after which a step counts as missed; the solver's own limit when not given."""
    seed: Annotated[Count, Field(ge=0)] = 0
    """Of the order in which contacts are swept."""
    threads: Annotated[Count, Field(ge=1)] = 1
    """Cores to use."""
    frames_per_second: Annotated[Number, Field(gt=0)] = 50.0
    """Frames written per second of the simulated time [1/s]."""
    checkpoint_every: Annotated[Number, Field(ge=0)] = 10.0
    """Time of the clock between two checkpoints [s]."""
    planar: Flag = True
    """Solve a scene that moves in its plane with half the contacts and three unknowns per block; the answer is the same."""
    islands: Flag = True
    """Solve by itself what touches the rest only through supports, and let it sleep while it rests; the answer is the same."""
    settle: Flag = True
    """Let elastic joints take up the weight before the run begins; else it comes upon them at once, and they swing."""
    gravity: Annotated[tuple[Number, Number, Number], BeforeValidator(_three_numbers)] = (0.0, 0.0, -9.81)
    """[m/s2]."""

    @model_validator(mode="after")
    def _at_least_a_step(self) -> Run:
        if self.duration < self.dt:
            raise ValueError(f"duration {self.duration:g} s is shorter than one step dt {self.dt:g} s")
        if self.duration > MOST_STEPS * self.dt:
            raise ValueError(
                f"duration {self.duration:g} s takes {self.duration / self.dt:.2g} steps of dt {self.dt:g} s; at most {MOST_STEPS:g}"
            )
        return self

    @property
    def steps(self) -> int:
        """Steps N that cover the duration."""
        return math.ceil(self.duration / self.dt - 1e-6)

    @property
    def frame_every(self) -> int:
        """Steps between two frames."""
        return max(1, round(1.0 / (self.frames_per_second * self.dt)))


class Report(_Table):
    """The table ``[report]``: what is drawn after the run."""

    crack_map: Flag = False
    """Draw crack_map.png."""
    view: Literal["auto", "front", "back", "side", "top", "isometric"] = "auto"
    """From where."""
    scale: Annotated[Number, Field(gt=0)] | None = None
    """Amplification of the displacements in it; picked so that they are visible when not given."""
    opened: Annotated[Number, Field(gt=0)] = 1e-4
    """Smallest opening of a joint that counts as opened [m]."""
    slid: Annotated[Number, Field(gt=0)] = 1e-4
    """Smallest sliding of a joint that counts as slid [m]."""
    damage: Flag = False
    """Write the damage by part: damage.csv, damage_history.csv, hinges.csv, drift.csv, damage.json."""
    grades: dict[str, Any] = {}
    """Thresholds and labels of the grades D0 to D5; checked by the room reports."""
    largest: Annotated[Number, Field(gt=0)] = 0.05
    """Where the last class of the crack map's colours begins [m]."""
    cut: str = ""
    """Plane by which the crack map is cut: "y=1.5" [m], or "y" for the middle."""
    thrust: Flag = False
    """Draw the line of thrust in it."""
    times: Annotated[tuple[Annotated[Number, Field(ge=0)], ...], BeforeValidator(_list_of_numbers)] = ()
    """Draw crack maps at these times as well [s]."""
    animation: Flag = False
    """Draw crack_map.gif."""
    html: Flag = False
    """Write report.html, a page that shows the run."""

    @property
    def asks(self) -> bool:
        """Whether anything is to be written beside joints.csv."""
        return self.damage or self.crack_map or bool(self.times) or self.animation or self.html


class _Tables(_Table):
    """The top level of the file."""

    title: str | None = None
    structure: dict[str, Any]
    material: dict[str, Any]
    loads: list[dict[str, Any]] = []
    run: dict[str, Any]
    report: dict[str, Any] = {}

    @field_validator("title")
    @classmethod
    def _is_plain(cls, value: str | None) -> str | None:
        if value is not None and "\0" in value:  # result files take none
            raise ValueError("holds a NUL character")
        return value

    @field_validator("structure", "material", "run", "report", mode="before")
    @classmethod
    def _is_table(cls, value: object) -> object:
        if not isinstance(value, Mapping):
            raise ValueError("should be a table of its own")
        return value

    @field_validator("loads", mode="before")
    @classmethod
    def _is_list_of_tables(cls, value: object) -> object:
        if not isinstance(value, list) or not all(isinstance(item, Mapping) for item in value):
            raise ValueError("every load is a table of its own, headed [[loads]]")
        return value


@dataclass(frozen=True)
class Scene:
    """A scene file whose own tables are checked; ``structure`` and ``loads`` are checked by their rooms."""

    title: str
    structure: dict[str, Any]
    material: Material
    loads: tuple[dict[str, Any], ...]
    run: Run
    report: Report
    text: str  # what the results keep: the file's text, or that of the changed tables when --set was used
    path: Path

    @property
    def folder(self) -> Path:
        """Folder from which relative paths in the scene are read."""
        return self.path.parent

    def at_fault(self, error: InputError) -> InputError:
        """The same error with file and line before it, where it begins with a key of this scene."""
        message = str(error)
        key = re.match(r"((?:structure|material|loads|run|report|title)[^\s:]*)(?::| )", message)
        return InputError(f"{_place(self.text, key.group(1), self.path)}: {message}") if key else error


def read_scene(path: Path | str, overrides: Sequence[str] = ()) -> Scene:
    """Read and check a scene file.

    Args:
        path: the TOML file.
        overrides: changes as ``key=value``, e.g. ``run.dt=1e-3`` or ``loads[0].amplitude=0.3``; values are TOML, or else text.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a value out of range; names file, line and key.
    """
    path = Path(path)
    text = _read_text(path)
    tables = _parse_toml(text, path)
    for override in overrides:
        _override(tables, override)
    if overrides:
        text = f"# {path.name} with {' '.join(f'--set {change}' for change in overrides)}\n" + dump_toml(tables)
    try:
        top = parse_table(_Tables, tables, "")
        return Scene(
            title=top.title or path.stem,
            structure=top.structure,
            material=parse_table(Material, top.material, "material"),
            loads=tuple(top.loads),
            run=parse_table(Run, top.run, "run"),
            report=parse_table(Report, top.report, "report"),
            text=text,
            path=path,
        )
    except InputError as error:
        key = str(error).partition(":")[0]
        raise InputError(f"{path}: {error}" if overrides else f"{_place(text, key, path)}: {error}") from None


def report_of(text: str, **changes: object) -> Report:
    """The table ``[report]`` of the scene's text that results keep, with the changes that are not None."""
    table = tomllib.loads(text).get("report", {})
    return parse_table(Report, table | {key: value for key, value in changes.items() if value is not None}, "report")


def _read_text(path: Path) -> str:
    """The text of a file, or one line on why there is none."""
    try:
        return path.read_text(encoding="utf-8-sig")  # some editors begin a file with a mark of its encoding
    except FileNotFoundError:
        raise InputError(f"{path}: no such scene file") from None
    except IsADirectoryError:
        raise InputError(f"{path}: is a folder, not a scene file") from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file in UTF-8") from None
    except OSError as failure:
        raise InputError(f"{path}: {failure.strerror}") from None


def _parse_toml(text: str, path: Path) -> dict[str, Any]:
    """Parse TOML; a syntax error names file and line."""
    try:
        return _load_toml(text, str(path))
    except tomllib.TOMLDecodeError as failure:
        message = re.match(r"(.*?) \(at (?:line (\d+), column \d+|end of document)\)", str(failure))
        what, line = (message.group(1), message.group(2)) if message else (str(failure), None)
        raise InputError(f"{path}:{line or text.count(chr(10)) + 1}: not valid TOML: {what[0].lower()}{what[1:]}") from None


def _load_toml(text: str, where: str) -> dict[str, Any]:
    """Parse TOML; what Python's parser cannot hold is an InputError that names ``where``, other syntax errors are left to the caller."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        raise
    except ValueError:  # of a number that Python does not convert
        raise InputError(f"{where}: a number of more than {sys.get_int_max_str_digits()} digits") from None
    except RecursionError:
        raise InputError(f"{where}: lists or tables nested too deep") from None


def _override(tables: dict[str, Any], override: str) -> None:
    """Apply one ``key=value`` to the tables, in place."""
    key, equals, value = (part.strip() for part in override.partition("="))
    parts: list[str | int] = [
        int(index) if index else (quoted or bare) for index, quoted, bare in re.findall(r'\[(\d+)\]|"([^"]+)"|([^.\[\]"]+)', key)
    ]
    if not equals or not parts or isinstance(parts[-1], int):
        raise InputError(f"--set {override}: write key=value, e.g. run.dt=1e-3 or loads[0].amplitude=0.3")
    place: Any = tables
    for part, following in pairwise(parts):
        if isinstance(part, str) and isinstance(place, dict):
            place = place.setdefault(part, [] if isinstance(following, int) else {})
        elif isinstance(part, int) and isinstance(place, list) and part < len(place):
            place = place[part]
        else:
            raise InputError(f"--set {override}: there is no {key[: key.rfind('.')]} in the scene")
    if not isinstance(place, dict):
        raise InputError(f"--set {override}: {key[: key.rfind('.')]} is no table; a list is addressed as loads[0].amplitude")
    place[str(parts[-1])] = _toml_value(key, value)


def parse_change(change: str) -> tuple[str, Any]:
    """Split ``key=value`` as --set takes it; the value is TOML, or else text.

    Raises:
        InputError: no key, or no equals sign.
    """
    key, equals, value = (part.strip() for part in change.partition("="))
    if not key or not equals:
        raise InputError(f"--set {change}: write key=value")
    return key, _toml_value(key, value)


def _toml_value(key: str, value: str) -> Any:
    """The TOML value given for a key, or the bare text where it is none."""
    try:
        parsed = _load_toml(f"value = {value}", f"--set {key}")
    except tomllib.TOMLDecodeError:
        return value
    return parsed["value"] if len(parsed) == 1 else value


def dump_toml(tables: Mapping[str, Any]) -> str:
    """Write tables as TOML: plain values first, then ``[table]`` and ``[[table]]`` sections; deeper tables inline."""
    lines = [f"{_toml_key(key)} = {_toml_text(value)}" for key, value in tables.items() if not _is_section(value)]
    for key, value in tables.items():
        if _is_section(value):
            for section in [value] if isinstance(value, Mapping) else value:
                head = _toml_key(key)
                lines += ["", f"[{head}]" if isinstance(value, Mapping) else f"[[{head}]]"]
                lines += [f"{_toml_key(name)} = {_toml_text(item)}" for name, item in section.items()]
    return "\n".join(lines) + "\n"


def _is_section(value: object) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and bool(value) and all(isinstance(item, Mapping) for item in value))


def _toml_key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else json.dumps(key, ensure_ascii=False)


def _toml_text(value: object) -> str:
    """One value in TOML's notation."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_toml_key(key)} = {_toml_text(item)}" for key, item in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_toml_text, value)) + "]"
    if isinstance(value, (str, bool)):
        return json.dumps(value, ensure_ascii=False)
    return str(value)  # numbers, inf and nan; dates print as TOML writes them


def _place(text: str, key: str, path: Path) -> str:
    """``file:line`` of a key such as ``loads[0].amplitude``; of the innermost table that is there where it is missing; else the file."""
    wanted, best, at = _key_path(key), 0, None
    here: list[tuple[str, int]] = []
    seen: dict[str, int] = {}  # tables so far of each [[list]]
    for number, line in enumerate(text.splitlines(), start=1):
        head = re.match(r"\s*(\[{1,2})\s*([^\]]+?)\s*\]", line)
        word = re.match(r'\s*("?[\w-]+"?(?:\s*\.\s*"?[\w-]+"?)*)\s*=', line)
        if head:
            here = _key_path(head.group(2))
            name = ".".join(part for part, _ in here)
            seen[name] = seen.get(name, -1) + (head.group(1) == "[[")
            here = [(part, max(0, seen.get(".".join(p for p, _ in here[: i + 1]), 0))) for i, (part, _) in enumerate(here)]
        elif not word:
            continue
        found = here + (_key_path(word.group(1)) if word and not head else [])
        shared = next((i for i, (a, b) in enumerate(zip(found, wanted, strict=False)) if a != b), min(len(found), len(wanted)))
        if shared > best:
            best, at = shared, number
    return f"{path}:{at}" if at else str(path)


def _key_path(key: str) -> list[tuple[str, int]]:
    """``loads[1].amplitude`` as [("loads", 1), ("amplitude", 0)]."""
    parts = re.findall(r'"?([\w-]+)"?(?:\[(\d+)\])?', key)
    return [(name, int(index or 0)) for name, index in parts]
