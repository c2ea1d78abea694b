# SPDX-License-Identifier: GPL-3.0-or-later
"""Units of keys: each is declared once, in its field, and a text with a unit is read as a number in it.

    height: Annotated[float, Unit("m"), Field(gt=0)]        takes 0.25, "25 cm" and "250 mm"

Next to the unit stands what the key usually has, ``Usual(0.003, 200.0, "masonry is at most some 170 m high", ("mm", "cm"))``.

pint knows the units and is imported when the first text is read. Numbers are multiplied as decimals, so that "30 mm" is 0.03 to the bit.
Whatever reads a table by :func:`masonry_cd.foundation.errors.parse_table` takes such texts; its validators and bounds see numbers.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from functools import cache
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

from pydantic import BaseModel

if TYPE_CHECKING:
    from pint import Unit as BaseUnit
    from pint import UnitRegistry
    from pydantic.fields import FieldInfo

    Models = Sequence[type[BaseModel]]

LONGEST_UNIT = 40  # letters
SMALLEST, LARGEST = 1e-200, 1e200  # of numbers with a unit: in other units, too, they are numbers
PATTERN = r"^\s*[+-]?\.?[0-9].*\S\s*$"  # of such a text, for the JSON schema
_NUMBER = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL)
_FACTOR = re.compile(r"((?:[A-Za-zµμ]+_)*[A-Za-zµμ°]+)\^?(-?[1-9])?")
_RAISED = str.maketrans("⁻¹²³⁴", "-1234")
GRAVITY = "standard_gravity"


@dataclass(frozen=True)
class Unit:
    """The unit of a key, in the annotation of its field; of every number in it where it takes several."""

    name: str


@dataclass(frozen=True)
class Usual:
    """Values that are usual for a key, in the annotation of its field: a value beyond is doubted, and never refused.

    Scale models, proof loads and parametric studies go there on purpose. Zero is never doubted: it leaves something out.
    """

    low: float  # in the unit of the key, or over what it is compared with
    high: float
    reason: str
    others: tuple[str, ...] = ()  # units that are easily meant instead
    over: str = ""  # what the value is compared with, a name that whoever doubts knows; empty: nothing
    size: bool = False  # of a vector: its size is compared

    def holds(self, value: float) -> bool:
        """True for a usual value, and for zero."""
        return value == 0.0 or self.low <= abs(value) <= self.high

    def meant(self, value: float, unit: str, per: float = 1.0) -> str:
        """Ways to write a value in other units in which it is usual, ``for g write "0.25 g"``.

        Args:
            value: of the key, in its own unit.
            unit: of the key.
            per: what the value is compared with.
        """
        said = []
        for name in self.others:
            weight = unit.startswith("kg") and "N" in name  # in place of a mass, which it is over g
            size = float(_in_base(f"{name}/{GRAVITY}" if weight else name, unit)[0] / _in_base(unit, unit)[0])
            if self.holds(value * size / per):
                written = f"{value:g} {name}" if not weight else f"{value * size:.4g} {unit}"
                said.append(f'for {name} write "{written}"')
        return "; ".join(said)


class Key(NamedTuple):
    """A key of a table, whose field says which values are usual."""

    path: str  # "loads[0].ag"
    value: Any  # a number, a vector, or numbers in lists and tables
    table: Mapping[str, Any]  # in which it stands
    unit: str
    usual: tuple[Usual, ...]  # of which the first that does not hold is said


class UnitKind(NamedTuple):
    """The quantity that a unit measures, as messages name it."""

    what: str
    example: str


KINDS = {
    "m": UnitKind("length", "30 mm"),
    "m2": UnitKind("area", "7 cm2"),
    "s": UnitKind("time", "5 ms"),
    "1/s": UnitKind("rate", "0.1 1/s"),
    "Hz": UnitKind("frequency", "10 Hz"),
    "m/s": UnitKind("speed", "20 cm/s"),
    "m/s2": UnitKind("acceleration", "0.25 g"),
    "degrees": UnitKind("angle", "30 deg"),
    "degrees/s": UnitKind("rate of an angle", "0.5 deg/s"),
    "kg": UnitKind("mass", "20 t"),
    "kg/m2": UnitKind("mass per area", "0.15 t/m2"),
    "kg/m3": UnitKind("density", "1.9 t/m3"),
    "N": UnitKind("force", "400 kN"),
    "N m": UnitKind("moment", "5 kN m"),
    "N/m": UnitKind("stiffness, or energy per area", "0.02 N/mm"),
    "N s/m": UnitKind("dashpot", "3 MN s/m"),
    "N m s": UnitKind("dashpot of a turn", "50 MN m s"),
    "N/m3": UnitKind("stiffness per area", "10 N/mm3"),
    "Pa": UnitKind("stress", "1.5 GPa"),
    "GB": UnitKind("size of memory", "4 GB"),
}
"""The units that keys have."""
OF_ACCELERATIONS = {"g": GRAVITY, "gal": "Gal"}  # elsewhere g is a gram and gal a gallon
COMMON = (
    *("mm", "cm", "m", "km", "ft", "mm2", "cm2", "m2", "ms", "s", "min", "h", "Hz", "m/s", "cm/s", "mm/s", "km/h", "m/s2", "cm/s2", "g"),
    *("deg", "rad", "kg", "t", "kg/m3", "t/m3", "kg/m2", "t/m2", "N", "kN", "MN", "Pa", "kPa", "MPa", "GPa", "bar", "N/mm2", "N/mm3"),
)
"""Units that are often given, for what a misspelt one was meant to be."""


class UnitError(ValueError):
    """A text that is not a number in the unit of its key."""

    def __init__(self, message: str, parts: tuple[str | int, ...] = ()) -> None:
        super().__init__(message)
        self.parts = parts  # keys and places that lead to it from the table


class Declared(NamedTuple):
    """A unit, tables and usual values, as the field of a key declares them."""

    unit: str  # empty where it has none
    models: tuple[type[BaseModel], ...]  # of the tables in it
    usual: tuple[Usual, ...] = ()


def in_si(models: Models, table: Mapping[str, Any], parts: tuple[str | int, ...] = ()) -> dict[str, Any]:
    """A table with the texts of all keys that have a unit as numbers in it.

    Args:
        models: of the table; a key is looked for in one after the other.
        table: as read; keys that no model has, and texts that do not begin as a number, stay as they are.
        parts: keys that lead to the table, for messages.

    Raises:
        UnitError: an unknown unit, one of another dimension, or none.
    """
    return {key: _read(value, _declared(models, key, value), (*parts, key)) for key, value in table.items()}


def declared_at(models: Models, parts: Sequence[str | int]) -> Declared:
    """The declaration of the key that is found by following keys and places from a table."""
    here = Declared("", tuple(models))
    for part in parts:
        if isinstance(part, str) and here.models:
            here = _declared(here.models, part, {})
    return here


def usual_keys(models: Models, table: Mapping[str, Any], path: str) -> Iterator[Key]:
    """The keys of a table, and of those in it, whose fields say which values are usual."""
    for name, value in table.items():
        declared, place = _declared(models, name, value), f"{path}.{name}"
        if declared.usual:
            yield Key(place, value, table, declared.unit, declared.usual)
        inner = {place: value} if not isinstance(value, list) else {f"{place}[{i}]": item for i, item in enumerate(value)}
        for where, item in inner.items():
            if isinstance(item, Mapping):
                yield from usual_keys(declared.models, item, where)


def read_values(value: Any, unit: Callable[[], str], parts: tuple[str | int, ...] = ()) -> Any:
    """A value, or values in lists, with texts that begin as numbers read in a unit, which is determined where one is met.

    Raises:
        UnitError: an unknown unit, one of another dimension, or none.
    """
    if isinstance(value, list):
        return [read_values(item, unit, (*parts, i)) for i, item in enumerate(value)]
    if not (isinstance(value, str) and begins_as_number(value)):
        return value
    name = unit()
    return _read(value, Declared(name, ()), parts) if name else value


def number_in(text: str, unit: str) -> float:
    """The number in a unit that a text such as "30 mm" is.

    Raises:
        UnitError: an unknown unit, one of another dimension, or none.
    """
    found = _NUMBER.fullmatch(text)
    if found is None or found.group(2).startswith(","):
        raise UnitError(f'"{text}" is not a number with a unit; {_as_written(unit)}' + (", with a decimal point" if "," in text else ""))
    if not found.group(2):
        raise UnitError(f'"{text}" states no unit; {_as_written(unit)}')
    value = float(found.group(1))
    if len(found.group(2)) > LONGEST_UNIT:
        raise UnitError(f'"{found.group(2)}" is not a known unit; {_as_written(unit)}')
    if value != 0.0 and not SMALLEST <= abs(value) <= LARGEST:
        raise UnitError(f'"{text}" is beyond the range of numbers')
    number = Decimal(found.group(1)) if value else Decimal(0)
    size, dimension = _in_base(found.group(2), unit)
    own, wanted = _in_base(unit, unit)
    if dimension != wanted:
        raise UnitError(_of_another_dimension(number, found.group(2), unit))
    return float(number * size / own)


def begins_as_number(text: str) -> bool:
    """Return True if a text is intended to be a number with a unit."""
    return bool(re.match(r"\s*[+-]?[.,]?\d", text))


def in_brackets(text: str, unit: str) -> str:
    """The text on a key with its unit behind it."""
    return f"{text.rstrip('.')} [{unit}]".strip() if unit else text


def _as_written(unit: str) -> str:
    """How a key with a unit is written."""
    return f'write a number in {unit}, or one with its unit, "{KINDS[unit].example}"'


def _declared(models: Models, key: str, value: object) -> Declared:
    """Return the declaration of a key by the models of a table; tables by name, as joint laws by pair of groups, are such tables."""
    for model in models:
        if key in (fields := _fields(model)):
            return fields[key]
    return Declared("", tuple(models) if isinstance(value, Mapping) else ())


def _read(value: Any, declared: Declared, parts: tuple[str | int, ...]) -> Any:
    """A value with its texts as numbers."""
    if not declared.unit and not declared.models:
        return value
    if isinstance(value, str):
        if not (declared.unit and begins_as_number(value)):
            return value
        try:
            return number_in(value, declared.unit)
        except UnitError as fault:
            raise UnitError(str(fault), parts) from None
    if isinstance(value, Mapping):
        if declared.models:
            return in_si(declared.models, value, parts)
        return {name: _read(item, declared, (*parts, name)) for name, item in value.items()}
    if isinstance(value, (list, tuple)):
        return type(value)([_read(item, declared, (*parts, i)) for i, item in enumerate(value)])
    return value


@cache
def _fields(model: type[BaseModel]) -> dict[str, Declared]:
    """Return the declaration of each key of a model."""
    found = {}
    for name, field in model.model_fields.items():
        models = (*getattr(field.json_schema_extra, "models", ()), *models_in(field.annotation))  # the first: of its JSON schema
        usual = dict.fromkeys(mark for mark in (*field.metadata, *_marks(field.annotation)) if isinstance(mark, Usual))
        found[field.alias or name] = Declared(unit_of(field), models, tuple(usual))
    return found


def unit_of(field: FieldInfo) -> str:
    """The unit of a field; empty where it has none."""
    return next((mark.name for mark in (*field.metadata, *_marks(field.annotation)) if isinstance(mark, Unit)), "")


def _marks(annotation: Any) -> Iterator[Any]:
    """Yield the contents of the ``Annotated`` within an annotation such as ``list[Annotated[float, Unit("m")]] | None``."""
    yield from getattr(annotation, "__metadata__", ())
    for inner in get_args(annotation):
        yield from _marks(inner)


def models_in(annotation: Any) -> Iterator[type[BaseModel]]:
    """The models inside an annotation such as ``list[Opening] | None``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from models_in(inner)


def _of_another_dimension(number: Decimal, given: str, unit: str) -> str:
    """Describe the fault of a number in a unit that does not measure what the key asks for; a weight in place of a mass is divided by g."""
    kind, wanted = KINDS[unit], _in_base(unit, unit)
    size, over_gravity = _in_base(f"{given}/{GRAVITY}", "")
    if unit.startswith("kg") and over_gravity == wanted[1]:
        mass = number * size / wanted[0]
        return f'"{given}" is of a weight, not of a {kind.what}; over g = 9.80665 m/s2 that is "{mass:.5g} {unit}"'
    return f'"{given}" is not a unit of a{"n" if kind.what[0] in "aeiou" else ""} {kind.what}{_twin(given, unit)}; {_as_written(unit)}'


@cache
def _in_base(given: str, unit: str) -> tuple[Decimal, BaseUnit]:
    """Size and dimension of a unit in base units; radians are a dimension here, so that rad/s is not Hz."""
    registry = _registry()
    size, base = registry.get_root_units(registry.parse_units(_expression(given, unit), as_delta=False))
    return Decimal(str(size or 1)), base  # decibels and degrees Celsius have no size, and no key is in such


def _expression(given: str, unit: str) -> str:
    """A unit as pint reads it: kN/m2 as kN/m**2.

    Raises:
        UnitError: it is not a product of known units.
    """
    plain = re.sub(r"\s*([*/·⋅.])\s*|\s+", lambda sign: "/" if sign.group(1) == "/" else "*", given.translate(_RAISED).replace("**", "^"))
    terms = re.split(r"([*/])", plain)
    made = []
    for i, term in enumerate(terms):
        found = _FACTOR.fullmatch(term)
        if i % 2 or (term == "1" and i == 0):
            made.append(term)
        elif found is None or (name := _name(found.group(1), unit)) not in _registry():
            raise UnitError(f'"{term or given}" is not a known unit{_twin(term, unit)}' + (f"; {_as_written(unit)}" if unit else ""))
        else:
            made.append(f"{name}**{found.group(2) or 1}")
    return "".join(made)


def _name(given: str, unit: str) -> str:
    """The name by which pint knows a unit."""
    return OF_ACCELERATIONS.get(given, given) if unit == "m/s2" else given


def _twin(given: str, unit: str) -> str:
    """' (did you mean "kN"?)' where a unit has a twin with other capital letters that measures the same as the key."""
    twin = next((name for name in COMMON if name.lower() == given.lower() and name != given), "")
    return f' (did you mean "{twin}"?)' if twin and unit and _in_base(twin, unit)[1] == _in_base(unit, unit)[1] else ""


@cache
def _registry() -> UnitRegistry[Decimal]:
    """The units that are known."""
    from pint import UnitRegistry

    return UnitRegistry(non_int_type=Decimal)
