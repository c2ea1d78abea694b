# SPDX-License-Identifier: GPL-3.0-or-later
"""A text with a unit is a number in the unit that the field of its key declares; what is none is refused by key, in one line."""

from __future__ import annotations

from typing import Annotated, Any

import pytest
from pydantic import BaseModel, ConfigDict, Field, model_validator

from masonry_cd.foundation.errors import InputError, parse_table
from masonry_cd.foundation.table_schema import key_texts, rows, table_schema
from masonry_cd.foundation.units import COMMON, KINDS, Unit, UnitError, declared_at, number_in

READ = [
    ("30 mm", "m", 0.03), ("30mm", "m", 0.03), (" 3e1 mm ", "m", 0.03), ("-.5 cm", "m", -0.005), ("1 ft", "m", 0.3048),
    ("0.25 g", "m/s2", 0.25 * 9.80665), ("25 Gal", "m/s2", 0.25), ("25 gal", "m/s2", 0.25), ("20 cm/s²", "m/s2", 0.2),
    ("400 kN", "N", 400e3), ("1.9 t/m3", "kg/m3", 1900.0), ("1.9 g/cm^3", "kg/m3", 1900.0), ("0.15 t m-2", "kg/m2", 150.0),
    ("1.5 GPa", "Pa", 1.5e9), ("5 N/mm2", "Pa", 5e6), ("10 N/mm**3", "N/m3", 1e10), ("10 MPa/mm", "N/m3", 1e10), ("7 cm2", "m2", 7e-4),
    ("5 ms", "s", 0.005), ("2 min", "s", 120.0), ("0.1 1/s", "1/s", 0.1), ("20 mm/s", "m/s", 0.02), ("30 deg", "degrees", 30.0),
    ("1e-99999999999999999999 m", "m", 0.0),
    ("0.5 turn", "degrees", 180.0), ("4 GB", "GB", 4.0), ("0 mm", "m", 0.0), ("35 mm", "m", 0.035), ("0.3 kN·s/s", "N", 300.0),
]  # fmt: skip
REFUSED = [
    ("30 kN", "m", '"kN" is not a unit of a length; write a number in m, or one with its unit, "30 mm"'),
    ("17 kN/m3", "kg/m3", '"kN/m3" is of a weight, not of a density; over g = 9.80665 m/s2 that is "1733.5 kg/m3"'),
    ("1.2 kN/m2", "kg/m2", '"kN/m2" is of a weight, not of a mass per area; over g = 9.80665 m/s2 that is "122.37 kg/m2"'),
    ("30", "m", '"30" states no unit; write a number in m, or one with its unit, "30 mm"'),
    ("0,3 m", "m", '"0,3 m" is not a number with a unit; write a number in m, or one with its unit, "30 mm", with a decimal point'),
    ("3 furlong/fortnight2/foo", "m", '"foo" is not a known unit'),
    ("5 Mpa", "Pa", '"Mpa" is not a known unit (did you mean "MPa"?)'),
    ("5 kn", "N", '"kn" is not a unit of a force (did you mean "kN"?)'),  # to pint they are knots
    ("0.25 G", "m/s2", '"G" is not a unit of an acceleration (did you mean "g"?)'),
    ("6 rad/s", "Hz", '"rad/s" is not a unit of a frequency'),
    ("6 rpm", "Hz", '"rpm" is not a unit of a frequency'),
    ("20 degC", "m", '"degC" is not a unit of a length'),
    ("20 degC/m", "m", '"degC/m" is not a unit of a length'),
    ("20 dB", "Hz", '"dB" is not a unit of a frequency'),
    ("3 %", "m", '"%" is not a known unit'),
    ("2 m/", "m", '"m/" is not a known unit'),
    ("1 m**9999", "m", '"m^9999" is not a known unit'),
    ("1 __class__", "m", '"__class__" is not a known unit'),
    ("1 (((((", "m", '"(((((" is not a known unit'),
    ("1 " + "m" * 500, "m", "is not a known unit"),
    ("1e999 m", "m", "is beyond the range of numbers"),
    ("1e-300 m", "m", "is beyond the range of numbers"),
]


@pytest.mark.parametrize(("text", "unit", "value"), READ)
def test_a_text_is_the_number_that_it_says_to_the_bit(text: str, unit: str, value: float) -> None:
    assert number_in(text, unit) == value


@pytest.mark.parametrize(("text", "unit", "said"), REFUSED, ids=[text[:20] for text, _, _ in REFUSED])
def test_what_is_no_number_in_the_unit_is_refused_in_a_line(text: str, unit: str, said: str) -> None:
    with pytest.raises(UnitError) as fault:
        number_in(text, unit)
    assert said in str(fault.value)


def test_the_examples_in_messages_and_the_units_that_are_suggested_are_themselves_read() -> None:
    assert [number_in(kind.example, unit) for unit, kind in KINDS.items()]
    for name in COMMON:
        with pytest.raises(UnitError, match="is not a unit of a size of memory"):
            number_in(f"1 {name}", "GB")


class Inner(BaseModel):
    """A table in a table."""

    model_config = ConfigDict(extra="forbid", strict=True)

    force: Annotated[float, Unit("N"), Field(gt=0)] = 1.0


class Outer(BaseModel):
    """A table of keys of all sorts."""

    model_config = ConfigDict(extra="forbid", strict=True)

    length: Annotated[float, Unit("m"), Field(gt=0, le=1.0)] | None = Field(None, description="of it")
    places: tuple[Annotated[float, Unit("m")], ...] = Field((), strict=False)
    strength: Annotated[float | dict[str, float], Unit("Pa")] = 0.0
    step: Annotated[float | str, Unit("s")] = "auto"
    name: str = ""
    inner: Inner | None = None
    laws: dict[str, Inner] = {}
    later: list[dict[str, Any]] = Field([], json_schema_extra=rows(Inner))

    @model_validator(mode="before")
    @classmethod
    def _numbers(cls, given: dict[str, Any]) -> dict[str, Any]:
        assert given.get("length") != "30 cm"  # validators see numbers
        return given


def test_keys_of_a_table_are_read_wherever_their_numbers_stand() -> None:
    given = {
        "length": "30 cm", "places": [0.5, "50 mm"], "strength": {"arch": "5 MPa"}, "step": "auto", "name": "3 stones",
        "inner": {"force": "2 kN"}, "laws": {"a-b": {"force": "3 kN"}}, "later": [{"force": "4 kN"}],
    }  # fmt: skip
    found = parse_table(Outer, given, "outer")
    assert (found.length, found.places, found.strength, found.step, found.name) == (0.3, (0.5, 0.05), {"arch": 5e6}, "auto", "3 stones")
    assert found.inner is not None
    assert (found.inner.force, found.laws["a-b"].force, found.later) == (2e3, 3e3, [{"force": 4e3}])
    assert given["length"] == "30 cm"


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"length": "30 kN"}, 'outer.length: "kN" is not a unit of a length; '),
        ({"length": "3 m"}, "outer.length: input should be less than or equal to 1, got 3.0 m"),
        ({"places": [0.5, "3 s"]}, 'outer.places[1]: "s" is not a unit of a length; '),
        ({"strength": {"arch": "5 m"}}, 'outer.strength.arch: "m" is not a unit of a stress; '),
        ({"laws": {"a-b": {"force": "3"}}}, 'outer.laws.a-b.force: "3" states no unit; '),
        ({"later": [{"force": "4 m"}]}, 'outer.later[0].force: "m" is not a unit of a force; '),
        ({"length": "wide"}, "outer.length: input should be a valid number, got 'wide'"),
    ],
)
def test_what_is_wrong_is_said_of_its_key(table: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as failure:
        parse_table(Outer, table, "outer")
    assert str(failure.value).startswith(said)


def test_schema_and_texts_have_the_unit_of_the_field() -> None:
    schema = table_schema(Outer)["properties"]
    assert key_texts(Outer)["length"] == schema["length"]["description"] == "of it [m]"
    assert schema["length"]["type"] == ["number", "string"]
    assert schema["length"]["maximum"] == 1.0
    assert schema["places"]["items"]["type"] == ["number", "string"]
    assert schema["strength"]["anyOf"][1]["additionalProperties"]["type"] == ["number", "string"]
    assert schema["later"]["items"]["properties"]["force"]["type"] == ["number", "string"]


def test_the_unit_of_a_key_is_found_by_its_path() -> None:
    paths = {("length",): "m", ("places", 1): "m", ("strength", "arch"): "Pa", ("laws", "a-b", "force"): "N", ("later", 0, "force"): "N"}
    assert {path: declared_at((Outer,), path).unit for path in paths} == paths
    assert [declared_at((Outer,), path).unit for path in (("name",), ("nothing",), ("inner", "nothing"))] == ["", "", ""]
