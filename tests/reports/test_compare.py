# SPDX-License-Identifier: GPL-3.0-or-later
"""Comparison of runs: what differs between the scenes is found, and the numbers are those of each run."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from made_run import at_rest, box, shifted, write_run

from masonry_cd.foundation.errors import InputError
from reports.compare import comparison
from reports.drawing.palette import GRADES
from reports.page.document import filled

BASE = box("base", (-3, -1, -0.5), (3, 1, 0), "base", fixed=True)
PIER = [BASE, *(box(f"p{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1), "pier") for k in range(2))]
SCENE = """\
[structure]
kind = "file"
[material]
friction = {mu}
[[loads]]
kind = "sinusoidal"
amplitude = {a}
[run]
dt = 1e-3
[report]
{r}
"""


def made(folder: Path, slip: float, mu: float = 0.6, a: float = 0.2, r: str = "") -> Path:
    """A run whose upper block has slid, and its scene."""
    folder.mkdir()
    rest = at_rest(PIER)
    states = [rest, shifted(rest, 2, (2 * slip, 0, 0)), shifted(rest, 2, (slip, 0, 0))]
    write_run(folder / "result.h5", PIER, states, scene=SCENE.format(mu=mu, a=a, r=r), ended=True)
    (folder / "summary.json").write_text(json.dumps({"solver": {"name": "nlgs", "error_max": 1e-9, "steps_missed": 3}}))
    return folder


def test_what_differs_and_what_came_of_it(tmp_path: Path) -> None:
    found = comparison.compare([made(tmp_path / "weak", 0.006), made(tmp_path / "strong", 0.030, a=0.5)])
    rows = {name: values for name, _, values in found.rows}
    assert found.header == ["", "unit", "weak", "strong"]
    assert rows["loads[0].amplitude"] == [0.2, 0.5]
    assert "material.friction" not in rows and "run.dt" not in rows
    assert rows["residual sliding"] == pytest.approx([0.006, 0.030])
    assert rows["largest sliding"] == pytest.approx([0.012, 0.060])
    assert rows["highest block, largest"] == pytest.approx([0.012, 0.060])
    assert rows["highest block, residual"] == pytest.approx([0.006, 0.030])
    assert rows["grade"] == ["D2", "D4"]
    assert rows["part pier"] == ["D2 sliding", "D4 sliding"]
    assert rows["steps missed"] == [3, 3]
    assert rows["first opening"][0] is None or np.isnan(rows["first opening"][0])


def test_the_thresholds_of_the_first_run_judge_all(tmp_path: Path) -> None:
    one, two = made(tmp_path / "one", 0.006, r="slid = 0.1"), made(tmp_path / "two", 0.006)
    assert {name: values for name, _, values in comparison.compare([one, two]).rows}["joints slid"] == [0, 0]
    assert {name: values for name, _, values in comparison.compare([two, one]).rows}["joints slid"] == [1, 1]


def test_the_table_as_csv_markdown_and_picture(tmp_path: Path) -> None:
    found = comparison.compare([made(tmp_path / "a", 0.006), made(tmp_path / "b", 0.030, mu=0.7)])
    paths = comparison.write_comparison(found, tmp_path / "out")
    with paths[0].open() as file:
        table = {row[0]: row[2:] for row in csv.reader(file)}
    assert table["material.friction"] == ["0.6", "0.7"]
    assert [float(cell) for cell in table["residual sliding"]] == pytest.approx([0.006, 0.030], rel=1e-8)
    lines = paths[1].read_text().splitlines()
    assert len({len(line) for line in lines}) == 1 and all(line.count("|") == 5 for line in lines)
    assert "| material.friction " in paths[1].read_text()
    (sliding,) = (line.replace(" ", "") for line in lines if line.startswith("| residual sliding"))
    assert sliding == "|residualsliding|mm|6|30|"
    import matplotlib.image

    image = matplotlib.image.imread(paths[2])
    assert image.shape[1] == 1300 and image[..., :3].std() > 0.05


def test_lengths_are_rounded_to_sense(tmp_path: Path) -> None:
    (run,) = comparison.compare([made(tmp_path / "a", 0.006), made(tmp_path / "b", 0.03)]).runs[:1]
    values = (1.93e-9, 0.0, 0.000189, -0.0049, 4.55, None)
    table = comparison.markdown(comparison.Comparison([run], [("opening", "m", [value]) for value in values]))
    assert [line.split("|")[3].strip() for line in table.splitlines()[2:]] == ["<0.001", "0", "0.189", "-4.9", "4550", "–"]


def test_folders_of_equal_names_are_distinguished(tmp_path: Path) -> None:
    (tmp_path / "x").mkdir()
    (tmp_path / "y").mkdir()
    found = comparison.compare([made(tmp_path / "x" / "run", 0.001), made(tmp_path / "y" / "run", 0.002)])
    assert found.header[2:] == ["x/run", "y/run"]


def test_nested_tables_get_the_keys_that_users_write() -> None:
    table = {"material": {"friction": {"default": 0.6, "a-b": 0.7}}, "loads": [{"kind": "x"}, {"kind": "y"}], "title": "t"}
    assert comparison.flat(table) == {
        "material.friction.default": 0.6,
        "material.friction.a-b": 0.7,
        "loads[0].kind": "x",
        "loads[1].kind": "y",
        "title": "t",
    }


def test_bad_folders_are_one_line(tmp_path: Path) -> None:
    good = made(tmp_path / "good", 0.001)
    (tmp_path / "empty").mkdir()
    with refused_at("empty/result.h5"):
        comparison.compare([good, tmp_path / "empty"])
    with refused_at("compare"):
        comparison.compare([good])
    with pytest.raises(InputError, match=r"is named twice$"):
        comparison.compare([good, tmp_path / "empty" / ".." / "good"])
    other = made(tmp_path / "other", 0.001)
    (other / "summary.json").write_text('{"steps": 1')
    with refused_at("other/summary.json"):
        comparison.compare([good, other])


def test_counts_have_whole_ticks_and_grades_the_colours_of_the_page(tmp_path):
    from matplotlib.figure import Figure

    folders = [tmp_path / "one", tmp_path / "two"]
    blocks = [box("base", (0, 0, -0.2), (1, 1, 0), "base", fixed=True), box("stone", (0, 0, 0), (1, 1, 0.5), "pier")]
    for folder in folders:
        folder.mkdir()
        write_run(folder / "result.h5", blocks, [at_rest(blocks), shifted(at_rest(blocks), 1, (0.01, 0, 0))])
    axes = Figure().subplots()
    comparison.draw_states(axes, comparison.compare(folders).runs)
    assert all(tick == round(tick) for tick in axes.get_yticks())
    assert f".grade.D3 {{ background: {GRADES['D3']}; }}" in filled("style.css")
