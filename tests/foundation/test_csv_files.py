# SPDX-License-Identifier: GPL-3.0-or-later
"""Tables that no spreadsheet takes for a program."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_run import at_rest, box, write_run

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.joint_damage import joint_damage
from masonry_cd.foundation.csv_files import unguarded, write_csv
from masonry_cd.io.results import Results
from reports.damage import write_joints_csv
from reports.paraview import export

EVIL = "=cmd|'/c calc'!A1"


def without_guard(cell: str) -> str:
    """A cell as it was, by the rule that masonry_cd/foundation/csv_files.py tells."""
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
