# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.kinds.motion, loads.value_history and loads.turning: supports are where their history says at each step, and turn as it says."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from models import advance, box

import loads
from loads.static import static_tables
from loads.turning import by_velocity
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.state import rotation_matrices

G = (0.0, 0.0, -9.81)
DT = 2e-3
FEET = Assembly.from_blocks(
    [box(f"foot{i}", (x, 0, -1), (x + 1, 1, 0), fixed=True) for i, x in enumerate((0.0, 2.0, 5.0))] + [box("free", (0, 0, 0), (1, 1, 1))],
    0.6,
)
STAGES = {"kind": "motion", "supports": "foot1", "time": [0.0, 0.5, 0.7, 1.5], "displacement": [0.0, 0.01, 0.01, 0.03], "start": 0.1}


def build(*tables: dict[str, Any], folder: Path = Path("."), dt: float = DT, steps: int = 1000) -> loads.Loading:
    return loads.build(tables, dt, steps, G, folder, FEET)


def moved(loading: loads.Loading, dt: float = DT) -> np.ndarray:
    """Displacement of each support by the trapezoidal rule of the step, (N + 1, 3 feet, 3)."""
    v = loading.support_velocity[:, loading.support_of[:3], :3]
    return np.concatenate([np.zeros((1, 3, 3)), np.cumsum(0.5 * dt * (v[1:] + v[:-1]), axis=0)])


def stepped(*tables: dict[str, Any], steps: int = 1000, folder: Path = Path(".")) -> tuple[np.ndarray, np.ndarray]:
    """Displacement (B, 3) and rotation (B, 3, 3) of all blocks after a run without gravity and contacts of note."""
    loading = loads.build(tables, DT, steps, (0.0, 0.0, 0.0), folder, FEET)
    assert loading.support_of is not None
    own = Assembly.from_blocks(FEET.blocks, 0.6)
    own.support_of[:] = loading.support_of
    machine = Stepper(own, loading.support_velocity, loading.acceleration, Run(dt=DT, duration=1.0, solver="nlgs", tolerance=1e-8))
    advance(machine, steps)
    return machine.state.position - FEET.centre, rotation_matrices(machine.state.orientation)


@pytest.mark.parametrize("start", [0.0, 0.1])
@pytest.mark.parametrize("dt", [1e-3, 4e-3])
def test_the_values_are_met_at_their_times_and_not_exceeded_between(dt: float, start: float) -> None:
    loading = build(STAGES | {"start": start}, dt=dt, steps=round(1.8 / dt))
    down = -moved(loading, dt)[:, 1, 2]
    for time, value in zip(STAGES["time"], STAGES["displacement"], strict=True):
        assert down[round((start + time) / dt)] == pytest.approx(value, abs=0.2 * dt * dt)
    assert down[-1] == pytest.approx(0.03, abs=1e-15) and (np.diff(down) > -1e-15).all()
    rest = down[round((start + 0.5) / dt) + 1 : round((start + 0.7) / dt)]
    assert np.ptp(rest) < 1e-15 and not loading.support_velocity[[0, -1]].any()
    assert not moved(loading, dt)[:, [0, 2]].any() and loading.support_velocity.shape[2] == 3


def test_velocities_are_integrated_exactly_and_a_jump_is_said() -> None:
    table = {"kind": "motion", "supports": "*", "direction": "x", "time": [0.0, 0.4, 1.0], "velocity": [0.0, 0.2, 0.0]}
    loading = build(table)
    assert moved(loading)[-1, :, 0] == pytest.approx(0.1, abs=1e-14) and not loading.warnings
    assert loading.support_velocity[100, 0, 0] == pytest.approx(0.1)
    (line,) = build(table | {"velocity": [0.0, 0.2, 0.1]}).warnings
    assert "velocities end at 0.1 m/s at once" in line


TABLE = """\
time [d], foot0.z [mm], foot[12].z [cm], foot2.ry [mrad]
3, 2, 0, 0
5, 2, -0.5, 10
13, -6, -1, 20
"""


def test_a_file_has_a_column_for_each_support_and_component(tmp_path: Path) -> None:
    (tmp_path / "levels.csv").write_text(TABLE)
    table = {"kind": "motion", "path": "levels.csv", "duration": 1.0, "start": 0.5}
    loading = build(table, folder=tmp_path)
    at = moved(loading)
    assert at[-1, :, 2] == pytest.approx([-0.008, -0.01, -0.01], abs=1e-15) and at[round(0.7 / DT), 1, 2] == pytest.approx(-0.005, abs=1e-6)
    assert loading.support_velocity.shape == (1001, 3, 6)
    assert 0.5 * DT * (loading.support_velocity[1:] + loading.support_velocity[:-1]).sum(axis=0)[loading.support_of[2], 4] == pytest.approx(
        0.02
    )
    assert loading.summary["base"]["peak_rotation"] == pytest.approx(np.degrees(0.02)) and loading.acted[0].end == 1.5
    one = {key: value for key, value in table.items() if key != "duration"} | {"supports": ["foot0", "foot2"]}
    (tmp_path / "levels.csv").write_text("t [ms];z [mm];y [mm/s]\n0;0;0\n200;0;50\n400;3;0\n")
    assert moved(build(one, folder=tmp_path))[-1] == pytest.approx(np.array([[0, 0.01, 0.003], [0, 0, 0], [0, 0.01, 0.003]]), abs=1e-12)


def _rodrigues(v: np.ndarray, axis: np.ndarray, angle: float) -> np.ndarray:
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1.0 - np.cos(angle))


def test_a_rotation_ends_at_its_angle_about_the_point_named_or_each_about_its_centre() -> None:
    turn = {"kind": "motion", "supports": ["foot0", "foot2"], "time": [0, 1], "rotation": [0, 30], "axis": [1, 2, 2]}
    axis, angle = np.array([1, 2, 2]) / 3.0, np.radians(30.0)
    wanted = np.array([_rodrigues(unit, axis, angle) for unit in np.eye(3)]).T
    way, rotation = stepped(turn, steps=600)
    assert rotation[[0, 2]] == pytest.approx(np.array([wanted, wanted]), abs=1e-12)
    assert way[:3] == pytest.approx(0.0, abs=1e-15) and rotation[1] == pytest.approx(np.eye(3), abs=1e-15)
    about = np.array([1.0, -2.0, 0.5])
    shifted = {"kind": "motion", "supports": "foot2", "direction": "y", "time": [0, 1], "displacement": [0, 0.2]}
    way, rotation = stepped(turn | {"about": about.tolist()}, shifted, steps=600)
    arms = FEET.centre[[0, 2]] - about
    assert rotation[[0, 2]] == pytest.approx(np.array([wanted, wanted]), abs=1e-12)
    assert way[[0, 2]] == pytest.approx(arms @ wanted.T - arms + [[0, 0, 0], [0, 0.2, 0]], abs=1e-12)


def test_angular_velocities_about_several_axes_compose_as_the_step_turns() -> None:
    """Two quarter turns one after the other: they do not commute."""
    velocity = np.zeros((2001, 3))
    velocity[100:900, 0], velocity[1100:1900, 2] = 0.5 * np.pi / 0.8, 0.5 * np.pi / 0.8
    last = by_velocity(velocity, 1e-3, "here").middles[-1]
    assert last == pytest.approx(np.array([[0, 0, 1], [1, 0, 0], [0, 1, 0]]), abs=1e-12)


def test_limit_analysis_takes_the_way_of_the_corner_that_goes_farthest() -> None:
    grid = loads.RunGrid(1e-12, 1, np.array(G), Path("."), FEET)
    turn = {"kind": "motion", "supports": "foot2", "time": [0, 1], "rotation": [0, -1], "axis": "y", "about": [5, 0.5, 0]}
    (found,) = static_tables([turn], grid)
    assert found.pattern == "settlement" and found.does.velocity is not None
    assert found.does.velocity[2] == pytest.approx(np.array([0.5, 0, 0.5, 0, -1, 0]) / np.sqrt(2.0))  # the corner 1 m across and 1 m down
    assert not found.does.velocity[[0, 1, 3]].any()
    (back,) = static_tables([STAGES | {"displacement": [0.0, 0.01, 0.02, 0.0]}], grid)
    assert back.left_out and not back.pattern


@pytest.mark.parametrize(
    ("text", "place", "words"),
    [
        ("time,foot1.z [mm]\n0,1\n1,2\n", "line 1", '"time" states no unit'),
        ("time [s],foot1.z\n0,1\n1,2\n", "line 1", 'write it behind the name, "foot1.z [mm]"'),
        ("time [s],foot1.z [kg]\n0,1\n1,2\n", "line 1", '"kg" is not a unit of a length'),
        ("time [s],foot1.ry [mm]\n0,1\n1,2\n", "line 1", '"mm" is not a unit of an angle'),
        ("time [s],foot1.rz [deg/s]\n0,1\n1,2\n", "line 1", "is not a unit of an angle"),
        ("time [s],foot1.w [mm]\n0,1\n1,2\n", "line 1", '"foot1.w" ends with no component'),
        ("time [s],z [mm]\n0,1\n1,2\n", "line 1", "names no support"),
        ("hours [h],foot1.z [mm]\n0,1\n1,2\n", "line 1", 'no column "time"'),
        ("time [s],foot7.z [mm]\n0,1\n1,2\n", 'line 1, "foot7.z"', '"foot7" is not a block or group (did you mean'),
        ("time [s],foot*.z [mm],foot1.z [mm/s]\n0,1,2\n1,2,3\n", 'line 1, "foot1.z"', 'gives z of "foot1" a second time'),
        ("time [s],foot1.z [mm]\n0,1\n1,2,3\n", "line 3", "3 columns, where the headings are 2"),
        ("time [s],foot1.z [mm]\n0,1\n1,x\n", "line 3", '"x" where a number belongs'),
        ("time [s]\n0\n1\n", "", "as a CSV file has"),
        ("time [s],foot1.z [mm]\n0,1\n0,2\n", "", "they have to increase"),
    ],
)
def test_a_file_that_is_no_history_is_refused_with_its_line(tmp_path: Path, text: str, place: str, words: str) -> None:
    (tmp_path / "levels.csv").write_text(text)
    with pytest.raises(InputError) as refused:
        build({"kind": "motion", "path": "levels.csv"}, folder=tmp_path)
    assert refused.value.place.endswith(place) and refused.value.place.startswith("loads[0].path") and words in refused.value.faults[0].text
