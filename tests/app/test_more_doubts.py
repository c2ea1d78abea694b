# SPDX-License-Identifier: GPL-3.0-or-later
"""Doubts about records, along another axis, twice, or converted once too often, and about time steps: each by its key and number."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import done
from made_run import at_rest, box, shifted, write_run
from models import box as cuboid
from models import ground, stepper, still
from two_blocks import two_blocks

import masonry_cd as mc
from masonry_cd.app.case import prepare
from masonry_cd.app.time_step_checks import after_run, before_run, dominant_frequency, fastest
from masonry_cd.io.results import Results
from masonry_cd.mechanics.dynamics.moreau_jean import RunStopped
from masonry_cd.mechanics.model.blocks import Assembly, Block

TIME = 0.01 * np.arange(401)
SWELL = np.sin(np.pi * TIME / 4.0) ** 2
NS, EW, UD = (1.5 * SWELL * np.sin(w * TIME + w) for w in (17.0, 22.0, 31.0))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """One station in a table of three channels, in a file each, and in files whose headings alone name the channel."""
    rows = "".join(",".join(f"{v:.9g}" for v in row) + "\n" for row in zip(TIME, NS, EW, UD, strict=True))
    (tmp_path / "three.csv").write_text("time_s,NS_m_s2,EW_m_s2,UD_m_s2\n" + rows)
    (tmp_path / "lettered.csv").write_text("time_s,ax_m_s2,ay_m_s2,az_m_s2\n" + rows)
    (tmp_path / "bearings.csv").write_text("time_s,N08W_m_s2,S82W_m_s2,ch3_m_s2\n" + rows)
    (tmp_path / "plain.csv").write_text("time_s,first_m_s2,second_m_s2,third_m_s2\n" + rows)
    for name, values in (("quake_NS.txt", NS), ("quake_EW.txt", EW), ("quake_UD.txt", UD), ("copy.txt", NS)):
        (tmp_path / name).write_text("".join(f"{t:.2f} {a:.9g}\n" for t, a in zip(TIME, values, strict=True)))
    heading = "PEER\nA QUAKE, 1/1/80, A STATION, {}\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 401, DT= .01 SEC\n"
    for name, values in (("UP", UD), ("090", EW)):
        (tmp_path / f"peer{name}.at2").write_text(heading.format(name) + "\n".join(f"{a / 9.80665:.9g}" for a in values))
    return tmp_path


def doubted(folder: Path, *loads: dict[str, Any], quiet: tuple[str, ...] = ()) -> list[str]:
    """The keys of the lines that loads draw."""
    tables = [{"kind": "record", "path": str(folder / load.pop("file"))} | load if "file" in load else load for load in loads]
    made = mc.scene(two_blocks(), loads=tables, run={"dt": 2e-3, "duration": 5.0}, quiet_checks=[*quiet])
    lines = [line for line in prepare(made.checked).warnings if line.startswith("loads[")]
    return [line.partition(":")[0].partition(" = ")[0] for line in lines]


def one(file: str, direction: Any, column: str | None = None, **keys: Any) -> dict[str, Any]:
    of_text = {"units": "m/s2"} if file.endswith(".txt") else {}
    return {"file": file, "direction": direction, "correction": "none", **({"column": column} if column else {}), **of_text, **keys}


@pytest.mark.parametrize(
    ("loads", "keys"),
    [
        ([one("three.csv", "x", "UD")], ["loads[0].direction"]),
        ([one("three.csv", "z", "NS")], ["loads[0].direction"]),
        ([one("three.csv", [0.2, 0.1, 1.0], "EW")], ["loads[0].direction"]),
        ([one("lettered.csv", "y", "az")], ["loads[0].direction"]),
        ([one("lettered.csv", "-z", "ax")], ["loads[0].direction"]),
        ([one("quake_UD.txt", "x")], ["loads[0].direction"]),
        ([one("peerUP.at2", "x")], ["loads[0].direction"]),
        ([one("peer090.at2", "z")], ["loads[0].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "EW")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "-x", "EW")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "y", "EW", rotate=-90.0)], ["loads[1].direction"]),
        ([one("bearings.csv", "x", "N08W"), one("bearings.csv", "x", "S82W")], ["loads[1].direction"]),
        ([one("plain.csv", "x", "first"), one("plain.csv", "x", "second")], ["loads[1].direction"]),
        ([one("quake_NS.txt", "y"), one("quake_EW.txt", "y")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "NS")], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "NS", scale=0.5, start=1.0)], ["loads[1].direction"]),
        ([one("quake_NS.txt", "x"), one("copy.txt", "x", scale=0.7)], ["loads[1].direction"]),
        ([one("three.csv", "x", "NS"), one("three.csv", "y", "EW"), one("three.csv", "z", "UD")], []),
        ([one("three.csv", "x", "NS"), one("three.csv", "x", "EW", start=4.5)], []),  # after the other
        ([one("three.csv", "x", "NS", rotate=30.0), one("three.csv", "y", "EW", rotate=30.0)], []),
        ([one("quake_NS.txt", "x"), one("plain.csv", "x", "second")], []),  # which may be of another kind of motion
        ([one("plain.csv", "z", "first")], []),
        ([one("bearings.csv", "z", "ch3")], []),
    ],
)  # fmt: skip
def test_channels_along_another_axis_are_doubted(folder: Path, loads: list[dict[str, Any]], keys: list[str]) -> None:
    assert doubted(folder, *[{**load} for load in loads]) == keys
    assert doubted(folder, *[{**load} for load in loads], quiet=tuple(keys)) == []


def test_the_components_of_a_shock_are_judged_alike(folder: Path) -> None:
    def component(direction: str, column: str) -> dict[str, Any]:
        return {"path": str(folder / "three.csv"), "direction": direction, "column": column, "correction": "none"}

    shocks = [{"components": [component("x", "NS"), component("x", "EW")]}, {"components": [component("x", "UD"), component("y", "EW")]}]
    found = doubted(folder, {"kind": "sequence", "rest": 0.1, "shocks": shocks})
    assert found == ["loads[0].shocks[1].components[0].direction", "loads[0].shocks[0].components[1].direction"]


def test_channels_of_traces_are_known_by_their_names() -> None:
    motion = {"kind": "record", "time": TIME, "acceleration": np.column_stack([UD, NS]), "channels": ["HNZ", "HNN"], "correction": "none"}
    made = mc.scene(two_blocks(), loads=[motion])
    assert [line[:18] for line in prepare(made.checked).warnings if "vertical by its name" in line] == ["loads[0].direction"]


@pytest.mark.parametrize("scale", [9.81, 9.80665, 9.8, -9.81, 0.00981, 980.665, 0.01, 100.0, 0.102, 0.001])
def test_a_scale_that_converts_units_once_more_is_doubted(folder: Path, scale: float) -> None:
    assert doubted(folder, one("three.csv", "x", "NS", scale=scale)) == ["loads[0].scale"]
    text = one("quake_NS.txt", "x", scale=scale)
    implausible = not 0.05 <= 1.4 * abs(scale) <= 19.6
    assert doubted(folder, {**text}) == ["loads[0].scale"] * implausible  # the file names no unit: the scale may be what makes it m/s2
    assert doubted(folder, {**text, "units": "gal", "scale": 100.0 * scale}) == ["loads[0].scale"] * (
        implausible or any(abs(100.0 * abs(scale) / size - 1.0) < 2e-3 for size in (1.0e-3 * 9.80665, 980.665, 100.0, 1000.0))
    )


@pytest.mark.parametrize("scale", [0.5, 2.0, 10.0, 0.1, 9.0])
def test_other_scales_are_let_pass(folder: Path, scale: float) -> None:
    assert doubted(folder, one("three.csv", "x", "NS", scale=scale)) == []


PLATE = box("plate", (-2, -2, -1), (2, 2, 0), fixed=True)


def assembly(*sizes: float) -> Assembly:
    """Cubes on a plate, of some edge lengths."""
    cubes = [box(f"cube{k}", (k, 0, 0), (k + size, size, size)) for k, size in enumerate(sizes)]
    return Assembly.from_blocks([PLATE, *cubes], 0.5)


def shaking(frequency: float, step: float, steps: int = 4000) -> np.ndarray:
    velocity = still(steps)
    velocity[:, 0, 0] = 0.1 * np.sin(2 * np.pi * frequency * step * np.arange(steps + 1))
    return velocity


@pytest.mark.parametrize(("frequency", "step"), [(2.0, 1e-3), (12.0, 4e-3), (50.0, 2e-3)])
def test_the_frequency_of_a_sine_is_found(frequency, step):
    assert dominant_frequency(shaking(frequency, step), step) == pytest.approx(frequency, rel=0.02)


def test_the_band_of_a_noise_is_found():
    """White acceleration up to 30 Hz has 95 % of its mean square below 28.5 Hz."""
    rng, step, steps = np.random.default_rng(1), 1e-3, 20_000
    spectrum = np.fft.rfft(rng.normal(size=steps))
    spectrum[np.fft.rfftfreq(steps, step) > 30.0] = 0.0
    velocity = still(steps)
    velocity[1:, 0, 1] = step * np.cumsum(np.fft.irfft(spectrum))
    assert dominant_frequency(velocity, step) == pytest.approx(28.5, rel=0.04)


def test_a_base_that_stands_still_has_no_frequency():
    assert dominant_frequency(still(10), 1e-3) == 0.0
    assert before_run(assembly(1.0), still(10), 9.81, 1e-3) == []


def test_shaking_that_the_step_does_not_follow_is_reported():
    (line,) = before_run(assembly(5.0), shaking(20.0, 1e-2), 9.81, 1e-2)
    assert "below 20 Hz, of which a period has 5 steps; 10 need dt 0.005" in line
    assert before_run(assembly(5.0), shaking(9.0, 1e-2), 9.81, 1e-2) == []


def test_the_block_that_rocks_too_fast_is_named():
    """The smaller cube, R = 0.1 sqrt(3) / 2 m, p = 9.2 1/s."""
    (line,) = before_run(assembly(1.0, 0.1), still(10), 9.81, 5e-3)
    assert 'block "cube1"' in line
    assert "p = 9.22 1/s (R 86.6 mm), p dt is 0.046; 0.03 needs dt 0.003" in line
    assert before_run(assembly(1.0, 0.1), still(10), 9.81, 3e-3) == []


def test_remarks_on_the_step_name_one_step_that_meets_all_of_them():
    remarks = before_run(assembly(1.0, 0.1), shaking(12.0, 1e-2), 9.81, 1e-2)
    assert [line.rsplit(" dt ", 1)[1] for line in remarks] == ["0.003", "0.003"]  # by the shaking alone 0.008
    assert before_run(assembly(1.0, 0.1), shaking(12.0, 3e-3), 9.81, 3e-3) == []


def test_a_block_that_could_pass_through_another_is_named(tmp_path):
    cubes = [box("thin", (0, 0, 0), (0.5, 0.5, 0.02)), box("cube", (1, 0, 0), (1.5, 0.5, 0.5))]
    state = at_rest([PLATE, *cubes])
    state.velocity[2, :3] = (0.0, 3.0, -4.0)
    write_run(tmp_path / "r.h5", [PLATE, *cubes], [at_rest([PLATE, *cubes]), shifted(state, 2, (0, 0, 1))])
    made = Assembly.from_blocks([PLATE, *cubes], 0.6)
    with Results.open(tmp_path / "r.h5") as results:
        (line,) = after_run(made, results, 2e-3)
        assert after_run(made, results, 1e-3) == []
    assert 'block "cube" moves at 5 m/s at 0.1 s, by 0.5 of the width of "thin" (20 mm) in one step' in line
    assert "dt 0.001 is safe" in line


def test_warnings_are_printed_and_kept(block_on_plate, tmp_path):
    scene = block_on_plate(dt="dt = 0.02", amplitude="amplitude = 0.1").read_text().replace("frequency = 2.0", "frequency = 6.0")
    (tmp_path / "scene.toml").write_text(scene)
    result = done("run", tmp_path / "scene.toml", "-o", tmp_path / "out", "-q")
    kept = json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"]
    assert [f"masonry-cd: warning: {line}" for line in kept] == [
        line for line in result.stderr.splitlines() if line.startswith("masonry-cd")
    ]
    assert any("coarse for the shaking" in line for line in kept)


def test_a_run_that_breaks_down_names_step_block_and_contact():
    machine = stepper([ground(), cuboid("low", (0, 0, 0), (1, 1, 1)), cuboid("high", (0, 0, 1), (1, 1, 2))], 10)
    machine.step()
    solve = machine.islands.solver

    def broken(problem, options, start):
        found = solve(problem, options, start)
        found.impulse[-1] = np.nan  # a contact of the upper joint
        return found

    machine.islands.solver = broken
    with pytest.raises(
        RunStopped, match=r'^step 2: the velocity of block "\w+" is not finite; the impulse of a contact between "'
    ) as stopped:
        machine.step()
    assert stopped.match('"high"')


@pytest.mark.parametrize("drop", [box("drop", (3, 0, 0), (3.2, 0.2, 0.2)), Block.sphere("drop", np.array([3.1, 0.1, 0.1]), 0.1)])
def test_what_falls_past_the_supports_is_not_looked_at(drop, tmp_path):
    """A stone and a ball next to the plate fall at 30 m/s: above its lower side they may meet something, far below it nothing."""
    blocks, found = [PLATE, box("stone", (0, 0, 0), (1, 1, 1)), drop], []
    for depth in (0.5, 45.0):
        state = shifted(at_rest(blocks), 2, (0, 0, -depth))
        state.velocity[2, 2] = -30.0
        with Results.open(write_run(tmp_path / "r.h5", blocks, [state])) as results:
            found.append(fastest(Assembly.from_blocks(blocks, 0.5), results)[0])
            assert bool(after_run(Assembly.from_blocks(blocks, 0.5), results, 1e-2)) == (depth < 1.0)
    assert found == [30.0, 0.0]


def test_speeds_are_relative_to_a_support_that_stays(tmp_path):
    """The first of two supports sinks at 2 m/s; the stone on the other stands still, whatever the first does."""
    sinks, stays = box("sinks", (-3, 0, -1), (-2, 1, 0), fixed=True), box("stays", (0, 0, -1), (1, 1, 0), fixed=True)
    blocks = [sinks, stays, box("stone", (0, 0, 0), (1, 1, 1))]
    states = [at_rest(blocks), shifted(at_rest(blocks), 0, (0, 0, -0.2))]
    for state in states:
        state.velocity[0, 2] = -2.0
    path = write_run(tmp_path / "r.h5", blocks, states)
    with Results.open(path) as results:
        assert fastest(Assembly.from_blocks(blocks, 0.5), results) == (0.0, 2, 0.0)
