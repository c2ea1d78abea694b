# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts that come out: messages of one line, cells that no spreadsheet takes for a program, names that no figure takes for a formula."""

from __future__ import annotations

import copy
import csv
import io
import pickle
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_run import at_rest, box, write_run
from places import ROOT

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import joint_damage
from masonry_cd.foundation.csv_files import unguarded, write_csv
from masonry_cd.foundation.errors import LINE, MOST_LINES, Fault, Faults, InputError, WrongKeys, of_each, one_line
from masonry_cd.foundation.figures import blank
from masonry_cd.io.results import Results
from reports.damage import write_joints_csv
from reports.paraview import export
from structures.geometry.checks import Unsound


@pytest.mark.parametrize("value", ["a" * 10_000, 'a": {"' * 2_000, "a b " * 3_000, "\x1b[31m" * 2_000])
def test_long_values_are_cut_and_what_is_said_about_them_stays(value):
    shown = one_line(f'modes.csv: unknown column "{value}"; known: mode, frequency_hz')
    assert len(shown) <= LINE + 5
    assert shown.startswith("modes.csv: unknown column ") and shown.endswith("known: mode, frequency_hz")
    assert shown.isprintable()


def test_an_error_has_a_place_and_a_text():
    error = InputError("run.dt", "must be above 0 s, got -1")
    assert (error.place, error.faults, str(error)) == (
        "run.dt",
        (Fault("run.dt", "must be above 0 s, got -1"),),
        "run.dt: must be above 0 s, got -1",
    )
    assert str(error.under("loads[0]")) == "loads[0]: run.dt: must be above 0 s, got -1"
    assert str(InputError("", "no run is open")) == "no run is open"


def test_a_source_stands_before_its_place_and_goes_with_unsourced():
    located = InputError("run.dt", "missing").each(lambda fault: fault._replace(source="a.toml:3"))
    assert str(located) == "a.toml:3: run.dt: missing"
    assert (located.place, str(located.unsourced())) == ("run.dt", "run.dt: missing")


@pytest.mark.parametrize(
    "error",
    [
        InputError("run.dt", "missing"),
        InputError.of([Fault("a", "wrong"), Fault("b", "wrong", "s.toml:1")]),
        WrongKeys([("a", 0)], [Fault("a[0]", "wrong")]),
        Unsound('block "b"', "open", ["b"]),
    ],
)
def test_an_error_survives_the_way_to_another_process(error):
    for same in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(same) is type(error)
        assert (same.faults, str(same)) == (error.faults, str(error))
    assert pickle.loads(pickle.dumps(Unsound("b", "open", ["b"]))).faulty == ("b",)


def test_faults_come_together_each_once_and_a_few_of_many():
    faults = Faults()
    for place in ("a", "b", "a"):
        with faults.of("wall"):
            raise InputError(place, "wrong")
    with pytest.raises(InputError) as caught:
        faults.refuse()
    assert caught.value.lines == ("wall: a: wrong", "wall: b: wrong")
    with pytest.raises(InputError) as many:
        of_each(lambda k: (_ for _ in ()).throw(InputError(f"loads[{k}]", "wrong")), range(40))
    assert len(many.value.faults) == 40 and len(many.value.lines) == MOST_LINES + 1
    assert of_each(lambda k: k * k, range(3)) == [0, 1, 4]
    Faults().refuse()


EVIL = "=cmd|'/c calc'!A1"


def without_guard(cell: str) -> str:
    """A cell as it was, by the rule that masonry_cd/foundation/csv_files.py states."""
    return cell[1:] if re.match(r"''*[=+\-@\t\r\n]", cell) else cell


def read_back(path: Path) -> list[list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


@pytest.mark.parametrize(
    ("cell", "written"),
    [
        ("pier1.3", "pier1.3"),
        (EVIL, "\"'=cmd|'/c calc'!A1\""),
        ("+1+1", "'+1+1"),
        ("-2+3", "'-2+3"),
        ("@SUM(A1)", "'@SUM(A1)"),
        ("+x", "+x"),
        ("+x1", "'+x1"),
        ("\tx", '"\'\tx"'),
        ("a;=1+1", '"a;=1+1"'),
        ("'=1", "''=1"),
        ("'quoted'", "'quoted'"),
        (-1.5, "-1.5"),
        ("-1.5e-09", "-1.5e-09"),
        ("-inf", "-inf"),
        ('say "x", y', '"say ""x"", y"'),
        ("", ""),
    ],
)
def test_cells(tmp_path: Path, cell: object, written: str) -> None:
    write_csv(tmp_path / "t.csv", ("a", "b"), [(cell, 1)])
    assert (tmp_path / "t.csv").read_bytes() == f"a,b\n{written},1\n".encode()
    assert without_guard(read_back(tmp_path / "t.csv")[1][0]) == str(cell)
    assert unguarded(read_back(tmp_path / "t.csv")[1][0]) == str(cell)


@given(name=st.text(st.characters(codec="utf-8", exclude_characters="\0\r"), max_size=12) | st.sampled_from(["'", "''=", "'-", EVIL]))
def test_any_text_comes_back(name: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.mktemp("csv") / "t.csv"
    write_csv(path, ("a", "b"), [(name, "x")])
    (_, (cell, other)) = read_back(path)
    assert (without_guard(cell), other) == (name, "x")
    assert unguarded(cell) == name
    assert not cell.startswith(("=", "@", "\t"))


def test_names_of_blocks_in_the_tables_of_a_run(tmp_path: Path) -> None:
    blocks = [box("@base", (-2, -1, -0.5), (2, 1, 0), "=1+1", fixed=True), box(EVIL, (-0.5, -0.5, 0), (0.5, 0.5, 1), "+g")]
    with Results.open(write_run(tmp_path / "run.h5", blocks, [at_rest(blocks)] * 2)) as results:
        write_joints_csv(joint_damage(results, Thresholds()), tmp_path / "joints.csv")
        export(results, tmp_path / "paraview", "vtkhdf", Thresholds())
    for path in (tmp_path / "joints.csv", tmp_path / "paraview" / "names.csv"):
        cells = [cell for row in read_back(path) for cell in row]
        assert not [cell for cell in cells if cell[:1] in "=+@" and cell]
        assert {"@base", EVIL} <= set(map(without_guard, cells))


NAMES = ["$R_{$", "$a$", r"\frac{$^_$", "a_b^c", "100 $ and 200 $", r"$\nonsense$"]


@pytest.mark.parametrize("name", NAMES)
def test_text_of_the_user_is_no_formula(name: str) -> None:
    figure = blank((4.0, 3.0), layout="constrained")
    axes = figure.subplots()
    axes.plot([1.0, 2.0], [1.0, 2.0], label=name)
    axes.set(title=name, xlabel=name, ylabel=name)
    axes.set_yticks([1.0, 2.0], [name, name])
    axes.annotate(name, (1.0, 1.0))
    drawn = [axes.title, axes.xaxis.label, axes.yaxis.label, *axes.legend().get_texts(), *axes.texts]
    figure.suptitle(name)
    figure.savefig(io.BytesIO(), format="png")
    for text in [*drawn, *axes.get_yticklabels()]:
        assert (text.get_text(), text.get_parse_math()) == (name, False)


def test_powers_of_ten_of_an_axis_stay_formulas() -> None:
    figure = blank((4.0, 3.0))
    axes = figure.subplots()
    axes.loglog([1e-3, 1e3], [1e-3, 1e3])
    figure.savefig(io.BytesIO(), format="png")
    labels = [text for text in axes.get_xticklabels() if text.get_text()]
    assert labels and all(text.get_parse_math() for text in labels)


def test_every_figure_begins_there() -> None:
    """A figure made past it would take two dollar signs in a name for a formula, after the whole run."""
    makers = ("Figure(figsize", "FigureCanvasAgg(")
    files = [file for package in ("masonry_cd", "reports", "loads", "structures") for file in sorted((ROOT / package).rglob("*.py"))]
    named = [str(Path(file).relative_to(ROOT)) for file in files if any(maker in file.read_text(encoding="utf-8") for maker in makers)]
    assert named == ["masonry_cd/foundation/figures.py"]
