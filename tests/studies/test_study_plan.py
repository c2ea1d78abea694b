# SPDX-License-Identifier: GPL-3.0-or-later
"""The plan of a study: which runs each design has, what they are called, and what changes when it grows."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from scipy.stats import lognorm, norm, truncnorm
from studied import GRID, RECORDS, SCENE, STEP, wave, write_records, write_scene, write_study

from loads.signal.baseline import correct, integrate
from masonry_cd.analysis.fragility.limits import LimitStateTable
from masonry_cd.analysis.run_row import RunRow
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.study.checks import bound_doubts, scene_of_run
from masonry_cd.studies.study.designs import next_level
from masonry_cd.studies.study.plan import StudyPlan
from masonry_cd.studies.study.record_tables import RecordsTable
from masonry_cd.studies.study.records import matched
from masonry_cd.studies.study.study_case import plan_of
from masonry_cd.studies.study.study_file import IdaTable
from masonry_cd.studies.study.varied import Distribution, KeyCorrelation, Varied

FRICTION = '[vary]\n"material.friction" = {distribution = "lognormal", median = 0.4, beta = 0.15}\n'


def planned(folder: Path, text: str, **changes: str) -> StudyPlan:
    """The plan of a study in a folder."""
    return plan_of(write_study(folder, text, **changes))


def with_records(folder: Path, text: str = RECORDS, **changes: str) -> StudyPlan:
    """The plan of a study over the three motions."""
    if not (folder / "records").exists():
        write_records(folder)
    return planned(folder, text, **changes)


# --- designs ------------------------------------------------------------------------------------------------------------------------


def test_a_grid_has_all_combinations_in_order(tmp_path: Path) -> None:
    plan = planned(tmp_path, GRID)
    found = [tuple(run.asked.values.values()) for run in plan.runs]
    assert found == [(a, mu) for a in (0.3, 0.4, 0.6) for mu in (0.2, 0.4)]
    scene = plan.maker.tables(plan.runs[3].asked)
    assert (scene["loads"][0]["amplitude"], scene["material"]["friction"]) == (0.4, 0.4)
    assert len({run.name for run in plan.runs}) == 6


def test_ranges_are_even_and_whole_where_they_are_written_so(tmp_path: Path) -> None:
    ranges = {
        '"loads[0]': '"loads[0].amplitude" = {from = 0.1, to = 0.4, count = 4}',
        '"material': '"run.seed" = {from = 1, to = 3, count = 3}',
    }
    plan = planned(tmp_path, GRID, **ranges)
    assert np.allclose([run.asked.values["loads[0].amplitude"] for run in plan.runs[::3]], [0.1, 0.2, 0.3, 0.4])
    assert [run.asked.values["run.seed"] for run in plan.runs[:3]] == [1, 2, 3]


def test_values_levels_and_bounds_may_state_their_unit(tmp_path: Path) -> None:
    keys = '"loads[0].start" = {from = "10 ms", to = "40 ms", count = 4}\n"loads[0].amplitude" = ["30 cm/s", 0.4]\n'
    keys += '"material.density" = {distribution = "uniform", low = "1.9 t/m3", high = 2100.0}'
    text = RECORDS.replace("levels = [1.0, 2.0, 4.0]", 'levels = ["0.1 g", "200 cm/s2"]').replace("above = 1e-3", 'above = "5 mm"')
    assert text.count("0.1 g") == text.count("5 mm") == 1
    plan = with_records(tmp_path, f"{text}\n[vary]\n{keys}\n")
    study, first = plan.maker.study, plan.runs[0].asked
    assert study.tables.intensity is not None
    assert study.tables.intensity.levels == [0.980665, 2.0]
    assert study.tables.limit_states["slid"].above == 0.005
    assert study.varied.lists == {"loads[0].start": pytest.approx([0.01, 0.02, 0.03, 0.04]), "loads[0].amplitude": [0.3, 0.4]}
    assert study.varied.random["material.density"].low == 1900.0
    assert plan.maker.tables(first)["loads"][0]["amplitude"] == 0.3


def test_a_scene_with_units_is_varied_and_perturbed_as_numbers(tmp_path: Path) -> None:
    study = write_study(tmp_path, 'scene = "scene.toml"\ndesign = "ensemble"\n[ensemble]\nmembers = 2\n')
    write_scene(tmp_path, SCENE.replace("amplitude = 0.4", 'amplitude = "40 cm/s"').replace("dt = 1e-2", 'dt = "10 ms"'))
    made = plan_of(study)
    assert [made.maker.tables(run.asked)["loads"][0]["amplitude"] for run in made.runs] == pytest.approx([0.4, 0.4], rel=1e-8)
    assert made.runs[0].weight == 50.0


def test_stripes_are_all_motions_at_all_levels(tmp_path: Path) -> None:
    plan = with_records(tmp_path)
    assert [(run.asked.motion, run.asked.level) for run in plan.runs] == [
        (motion, level) for motion in ("far_c", "quake_a", "quake_b") for level in (1.0, 2.0, 4.0)
    ]
    for run in plan.runs:
        measures = plan.maker.measures(run.asked)
        assert measures["PGA"] == run.asked.level
        (load,) = plan.maker.tables(run.asked)["loads"][1:]
        assert Path(load["path"]).name == f"{run.asked.motion}_{'H1' if run.asked.motion == 'quake_b' else 'NS'}.acc"


def test_a_motion_is_measured_as_it_shakes_the_base(tmp_path: Path) -> None:
    plan = with_records(tmp_path)
    run = next(run for run in plan.runs if run.asked.motion == "quake_a" and run.asked.level == 2.0)
    shaken = correct(integrate(wave(0), STEP), 2)
    factor = 2.0 / np.abs(shaken.acceleration).max()
    measures, (load,) = plan.maker.measures(run.asked), plan.maker.tables(run.asked)["loads"][1:]
    assert load["scale"] == pytest.approx(factor, rel=1e-6)
    assert measures["PGV"] == pytest.approx(factor * np.abs(shaken.velocity).max(), rel=1e-5)
    a, b = shaken.acceleration[:-1], shaken.acceleration[1:]
    assert measures["Arias"] == pytest.approx(factor**2 * np.pi / 2 / 9.80665 * STEP / 3 * (a * a + a * b + b * b).sum(), rel=1e-5)


def test_a_level_of_both_components_scales_them_by_one_factor(tmp_path: Path) -> None:
    text = RECORDS.replace('measure = "PGA"', 'measure = "PGV"\nof = "geometric_mean"').replace('shake = ["x"]', "")
    plan = with_records(tmp_path, text)
    run = plan.runs[0]
    loads = plan.maker.tables(run.asked)["loads"][1:]
    assert [load["direction"] for load in loads] == ["x", "y", "z"]
    assert len({load["scale"] for load in loads}) == 1
    peaks = [np.abs(correct(integrate(wave(6 + i), STEP), 2).velocity).max() for i in range(2)]  # far_c is the third that is written
    assert loads[0]["scale"] * np.sqrt(peaks[0] * peaks[1]) == pytest.approx(1.0, rel=1e-5)


@pytest.mark.parametrize("shake", ['["x"]', '["x", "y"]'])
def test_a_turned_pair_shakes_by_both_components(tmp_path: Path, shake: str) -> None:
    from loads import build

    plan = with_records(tmp_path, RECORDS.replace('shake = ["x"]', f"shake = {shake}\nrotate = 30.0"))
    run = plan.runs[0]
    loads = plan.maker.tables(run.asked)["loads"][1:]
    motion = build(loads, 0.01, 99, (0, 0, -9.81), tmp_path).support_velocity[:, 0]
    x, y = (correct(integrate(wave(6 + i), STEP), 2).velocity for i in range(2))
    c, s = np.cos(np.radians(30.0)), np.sin(np.radians(30.0))
    factor = motion[:, 0].max() / (c * x - s * y).max()
    assert np.allclose(motion[:, 0], factor * (c * x - s * y), atol=1e-6)
    assert np.allclose(motion[:, 1], factor * (s * x + c * y) if "y" in shake else 0.0, atol=1e-6)


def test_a_motion_is_trimmed_where_its_arias_intensity_builds_up(tmp_path: Path) -> None:
    plan = with_records(
        tmp_path, RECORDS.replace("dt = 0.01", "dt = 0.01\ntrim = {arias = [0.05, 0.95], before = 0.02, after = 0.1}\nrest = 0.3")
    )
    run = next(run for run in plan.runs if run.asked.motion == "quake_a")
    raw = correct(integrate(wave(0), STEP), 2)
    built = np.cumsum(raw.acceleration**2)
    begin, end = (STEP * float(np.argmax(built >= share * built[-1])) for share in (0.05, 0.95))
    tables = plan.maker.tables(run.asked)
    window = tables["loads"][1]["window"]
    assert window == pytest.approx([begin - 0.02, end + 0.1], abs=2 * STEP)
    assert tables["run"]["duration"] == pytest.approx(window[1] - window[0] + 0.3)


def test_a_cloud_takes_motions_as_they_are(tmp_path: Path) -> None:
    text = RECORDS.replace("stripes", "cloud").replace("levels = [1.0, 2.0, 4.0]", "")
    plan = with_records(tmp_path, text)
    assert [run.asked.motion for run in plan.runs] == ["far_c", "quake_a", "quake_b"]
    peaks = [plan.maker.measures(run.asked)["PGA"] for run in plan.runs]
    assert peaks == pytest.approx([np.abs(correct(integrate(wave(k), STEP), 2).acceleration).max() for k in (6, 0, 3)], rel=1e-6)
    assert all(plan.maker.tables(run.asked)["loads"][1]["scale"] == 1.0 for run in plan.runs)


def test_a_sample_is_a_latin_hypercube(tmp_path: Path) -> None:
    text = GRID.replace('"grid"', '"sample"\nsamples = 8').replace("[0.2, 0.4]", '{distribution = "uniform", low = 0.2, high = 0.6}')
    plan = planned(tmp_path, text)
    friction = np.sort([run.asked.values["material.friction"] for run in plan.runs])
    assert np.array_equal(np.floor((friction - 0.2) / 0.4 * 8), np.arange(8))  # one in each stripe
    assert {run.asked.values["loads[0].amplitude"] for run in plan.runs} == {0.3, 0.4, 0.6}
    assert list(plan.runs[0].asked.values) == ["loads[0].amplitude", "material.friction"]


@pytest.mark.parametrize(
    ("perturb", "get"), [("loads", lambda t: t["loads"][0]["amplitude"] / 0.4), ("friction", lambda t: t["material"]["friction"] / 0.4)]
)
def test_members_of_an_ensemble_differ_by_next_to_nothing(tmp_path: Path, perturb: str, get) -> None:
    text = f'scene = "scene.toml"\ndesign = "ensemble"\n[ensemble]\nmembers = 5\nperturb = "{perturb}"\nsize = 1e-8\n'
    plan = planned(tmp_path, text)
    changes = [get(plan.maker.tables(run.asked)) - 1.0 for run in plan.runs]
    assert changes[0] == 0.0
    assert len(set(changes)) == 5
    assert 1e-9 < max(map(abs, changes)) <= 1e-8
    assert [run.asked.member for run in plan.runs] == [0, 1, 2, 3, 4]


def test_members_begin_with_velocities_of_their_own(tmp_path: Path) -> None:
    text = 'scene = "scene.toml"\ndesign = "ensemble"\n[ensemble]\nmembers = 3\nperturb = "velocities"\nsize = 1e-8\n'
    plan = planned(tmp_path, text)
    scenes = [scene_of_run(plan.maker.tables(run.asked)) for run in plan.runs]
    assert [scene.run.first_velocities and scene.run.first_velocities.model_dump() for scene in scenes] == [
        None, {"size": 1e-8, "seed": 1}, {"size": 1e-8, "seed": 2}
    ]  # fmt: skip
    assert len({run.name for run in plan.runs}) == 3
    assert all("first_velocities = { size = 1e-08" in scene.text for scene in scenes[1:])  # what is kept of a run makes it again


# --- names and growth ---------------------------------------------------------------------------------------------------------------


def test_more_levels_and_motions_leave_the_names_and_draws_of_the_others(tmp_path: Path) -> None:
    small = with_records(tmp_path, RECORDS.replace("dt = 0.01", 'dt = 0.01\nexclude = ["far_*"]') + FRICTION, levels="levels = [2.0]")
    large = with_records(tmp_path, RECORDS + FRICTION)
    there = {run.name: run.asked.values for run in large.runs}
    assert len(small.runs) == 2
    assert len(large.runs) == 9
    for run in small.runs:
        assert there[run.name] == run.asked.values
    assert len({run.asked.values["material.friction"] for run in large.runs}) == 9


def test_names_follow_from_content_not_from_places(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    one, other = with_records(tmp_path / "a"), with_records(tmp_path / "b")
    assert [run.name for run in one.runs] == [run.name for run in other.runs]
    file = tmp_path / "b" / "records" / "far_c_NS.acc"
    file.write_text(file.read_text().replace("0.0", "0.1", 1))
    again = with_records(tmp_path / "b")
    assert [run.name == old.name for run, old in zip(again.runs, one.runs, strict=True)] == [
        run.asked.motion != "far_c" for run in again.runs
    ]


def test_drawing_changes_no_name(tmp_path: Path) -> None:
    names = [run.name for run in planned(tmp_path, GRID).runs]
    write_scene(tmp_path, SCENE + "[report]\ncrack_map = true\n")
    assert [run.name for run in plan_of(tmp_path / "study.toml").runs] == names
    write_scene(tmp_path, SCENE + "[report]\nopened = 1e-3\n")
    assert not set(names) & {run.name for run in plan_of(tmp_path / "study.toml").runs}


def test_an_inline_scene_is_the_same_study(tmp_path: Path) -> None:
    names = [run.name for run in planned(tmp_path, GRID).runs]
    inline = SCENE.replace("[[loads]]", "[[scene.loads]]").replace("title", "[scene]\ntitle").replace("[structure]", "[scene.structure]")
    inline = inline.replace("[material]", "[scene.material]").replace("[run]", "[scene.run]")
    path = tmp_path / "inline.toml"
    path.write_text(GRID.partition("\n")[2] + inline)
    assert [run.name for run in plan_of(path).runs] == names


# --- distributions ------------------------------------------------------------------------------------------------------------------

U = (0.001, 0.2, 0.5, 0.93)


@pytest.mark.parametrize(
    ("keys", "expected"),
    [
        ({"distribution": "uniform", "low": -1.0, "high": 3.0}, lambda u: -1.0 + 4.0 * u),
        ({"distribution": "normal", "mean": 2.0, "std": 0.5}, lambda u: norm.ppf(u, 2.0, 0.5)),
        ({"distribution": "lognormal", "median": 0.6, "beta": 0.15}, lambda u: lognorm.ppf(u, 0.15, scale=0.6)),
        ({"distribution": "normal", "mean": 2.0, "std": 0.5, "low": 1.5}, lambda u: truncnorm.ppf(u, -1.0, np.inf, 2.0, 0.5)),
        ({"distribution": "normal", "mean": 2.0, "std": 0.5, "low": 1.5, "high": 2.25}, lambda u: truncnorm.ppf(u, -1.0, 0.5, 2.0, 0.5)),
        ({"distribution": "lognormal", "median": 1.0, "beta": 1.0, "high": 1.0}, lambda u: np.exp(truncnorm.ppf(u, -np.inf, 0.0))),
    ],
)
def test_quantiles(keys: dict, expected) -> None:
    found = Distribution.model_validate(keys)
    assert [found.quantile(u) for u in U] == pytest.approx([float(expected(u)) for u in U], rel=1e-9)


def test_correlated_keys_vary_together() -> None:
    plain = Distribution(distribution="normal", mean=0.0, std=1.0)
    varied = Varied({}, {"a": plain, "b": plain, "c": plain}, [KeyCorrelation(keys=["a", "c"], rho=0.8)])
    random = np.random.default_rng(1)
    drawn = np.array([list(varied.draw(random.random(3)).values()) for _ in range(4000)])
    assert np.allclose(np.corrcoef(drawn.T), [[1, 0, 0.8], [0, 1, 0], [0.8, 0, 1]], atol=0.05)
    assert np.allclose(drawn.std(axis=0), 1.0, atol=0.05)


# --- hunt and fill --------------------------------------------------------------------------------------------------------------------


def hunted(table: IdaTable, capacity: float) -> list[float]:
    """The levels, in the order in which they are run, of a structure that collapses from a level on."""
    found: dict[float, bool | None] = {}
    level: float | None = table.start
    while level is not None:
        found[level] = level >= capacity
        level = next_level(table, found)
    return list(found)


def test_the_hunt_steps_up_then_closes_in_then_fills() -> None:
    levels = hunted(IdaTable(start=0.1, step=0.1, growth=0.05, resolution=0.1, fill=2, runs=20), 0.62)
    assert levels[:5] == pytest.approx([0.1, 0.2, 0.35, 0.55, 0.8])  # steps of 0.1, 0.15, 0.2, 0.25
    collapsed, safe = min(x for x in levels if x >= 0.62), max(x for x in levels if x < 0.62)
    assert collapsed - safe <= 0.1 * collapsed
    assert levels[-2:] == pytest.approx([0.45, 0.275])  # the widest gaps below
    assert len(levels) == len(set(levels))


def test_a_hunt_ends_with_its_runs_or_a_run_without_data() -> None:
    table = IdaTable(start=0.1, step=0.1, runs=5)
    assert len(hunted(table, 9.0)) == 5
    assert next_level(table, {0.1: False, 0.2: None}) is None


def test_a_collapse_at_the_first_level_is_bracketed_from_nothing() -> None:
    levels = hunted(IdaTable(start=1.0, step=1.0, resolution=0.2, fill=0, runs=20), 0.05)
    assert min(levels) < 0.05 < max(x for x in levels if x >= 0.05)


def test_the_runs_of_an_ida_do_not_depend_on_the_order_in_which_they_end(tmp_path: Path) -> None:
    text = RECORDS.replace("stripes", "ida").replace("levels = [1.0, 2.0, 4.0]", "") + FRICTION
    text += '[ida]\nlimit_state = "slid"\nstart = 1.0\nstep = 1.0\n'
    capacity = {"far_c": 3.3, "quake_a": 7.1, "quake_b": 0.4}

    def ended(take: int) -> list[str]:
        """The names of all runs, when of those that wait it is always the first, or the last, that ends."""
        plan = with_records(tmp_path, text)
        waiting = list(plan.runs)
        while waiting:
            run = waiting.pop(take)
            assert run.asked.level is not None
            sliding = 1.0 if run.asked.level >= capacity[run.asked.motion] else 0.0
            waiting += plan.after(run, RunRow("done", numbers={"max_sliding": sliding}))
        assert len({run.asked.values["material.friction"] for run in plan.runs}) == 3  # one of each motion
        return [run.name for run in plan.ordered()]

    assert ended(0) == ended(-1)
    assert len(ended(0)) > 20


ADAPTIVE = '[adaptive]\nlimit_state = "slid"\nbatch = 2\n'


@pytest.mark.parametrize("keys", ["", "theta = 0.9\nbeta = 0.9\n", "runs = 5\n"])
def test_the_runs_of_adaptive_stripes_do_not_depend_on_the_order_in_which_they_end(tmp_path: Path, keys: str) -> None:
    capacity = {"far_c": 1.5, "quake_a": 3.0, "quake_b": 1.2}

    def ended(take: int, known: dict[str, RunRow]) -> StudyPlan:
        plan = with_records(tmp_path, RECORDS + FRICTION + ADAPTIVE + keys)
        waiting = list(plan.runs)
        while waiting:
            run = waiting.pop(take)
            assert run.asked.level is not None
            sliding = 1.0 if run.asked.level >= capacity[run.asked.motion] else 0.0
            lost = run.asked.motion == "quake_b" and run.asked.level == 4.0
            row = RunRow("failed") if lost else RunRow("done", numbers={"max_sliding": sliding})
            known[run.name] = row
            waiting += plan.after(run, row)
        return plan

    rows: list[dict[str, RunRow]] = [{}, {}]
    first, last = ended(0, rows[0]), ended(-1, rows[1])
    assert rows[0] == rows[1]
    assert [run.name for run in first.ordered()] == [run.name for run in last.ordered()]
    assert len({run.name for run in first.runs}) == len(first.runs)  # none twice, those that failed included
    assert first.adaptive is not None
    count = 5 if "runs" in keys else 9 if not keys else len(first.runs)
    assert len(first.runs) == len(rows[0]) == count
    assert ("are wanted" in first.adaptive.line) == ("0.9" not in keys)
    if "0.9" in keys:
        assert max(first.adaptive.spread) <= 0.9
        assert len(first.runs) < 9
    stripes = {run.name for run in with_records(tmp_path, RECORDS + FRICTION).runs}
    assert {run.name for run in first.runs} <= stripes  # so that either continues in the folder of the other


def test_adaptive_stripes_refuse_lists_and_limit_states_that_are_not_there(tmp_path: Path) -> None:
    write_records(tmp_path)
    lists = '[vary]\n"material.friction" = [0.3, 0.4]\n'
    with pytest.raises(InputError, match=r'vary\."material\.friction": \[adaptive\] takes distributions'):
        planned(tmp_path, RECORDS + lists + ADAPTIVE)
    with pytest.raises(InputError, match=r'adaptive\.limit_state: there is no "slidd" in \[limit_states\]'):
        planned(tmp_path, RECORDS + ADAPTIVE.replace("slid", "slidd"))
    with pytest.raises(InputError, match='adaptive: belongs to the design "stripes"'):
        planned(tmp_path, GRID + ADAPTIVE)


# --- bad input ----------------------------------------------------------------------------------------------------------------------


def test_a_pattern_of_too_many_brackets_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        with_records(tmp_path, RECORDS, pattern=f"pattern = '{'(' * 2000}a{')' * 2000}'")
    assert refused.value.place == "records.pattern"


@pytest.mark.parametrize(
    ("quantity", "above", "said"), [("max_opening", 5.0, "5 mm"), ("max_opening", 0.005, ""), ("collapsed_blocks", 5, "")]
)
def test_a_bound_of_a_limit_state_in_mm_draws_a_line(quantity: str, above: float, said: str) -> None:
    found = bound_doubts({"cracked": LimitStateTable(quantity=quantity, above=above)})
    assert [line.startswith("limit_states.cracked.above") and said in line for line in found] == [True] * bool(said)


NAMES = ["AQV_x.acc", "notes.txt", "città_y.acc"]


def test_names_give_motions_and_components() -> None:
    pattern = RecordsTable.model_fields["pattern"].default
    assert matched(pattern, NAMES) == [("AQV_x.acc", "AQV", "x"), ("città_y.acc", "città", "y")]


@pytest.mark.parametrize("pattern", [r"(?P<motion>(\w+)+)!(?P<component>x)", r"(?P<motion>(.|[^_])*)!(?P<component>x)"])
def test_one_that_backtracks_for_ever_is_refused(pattern: str) -> None:
    with refused_at("records.pattern"):
        matched(pattern, [60 * "a"], longest=0.5)
