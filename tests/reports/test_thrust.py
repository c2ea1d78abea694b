# SPDX-License-Identifier: GPL-3.0-or-later
"""The line of thrust: where a run's forces cross its joints, against statics, and the ribbons through these points."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from made_run import at_rest, box, shifted, turned, write_run
from models import stepper
from solids import build

from masonry_cd.analysis.damage.definitions import Thresholds
from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.deformed import Pose, Solids
from masonry_cd.app.run_loop import RunPlan, run
from masonry_cd.io.result_writer import ResultWriter
from masonry_cd.io.results import Results
from masonry_cd.mechanics.contact.find_joints import find_joints
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.state import State
from reports.drawing.figure import Sheet
from reports.drawing.palette import THRUST
from reports.drawing.parts import Surface, view_named
from reports.maps.crack_map import crack_scene
from reports.maps.framing import MapStyle, framing
from reports.maps.thrust import WIDEST, drawn_points, ribbons

BASE = box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True)
STACK = [BASE, *(box(f"s{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(2))]
MIDDLES = [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0]]
PIXEL = 0.01


def computed(folder: Path, blocks: list[Block], steps: int = 3, **settings: object) -> tuple[np.ndarray, np.ndarray]:
    """Normal forces (J,) and force points (J, 3) of blocks under gravity."""
    machine = stepper(blocks, steps, **settings)
    joints = find_joints(machine.assembly)
    with ResultWriter(folder / "result.h5", machine.assembly, joints) as writer:
        run(machine, joints, writer, RunPlan(steps))
    with Results.open(folder / "result.h5") as results:
        return results.joint_history("normal_force")[-1], results.joint_history("force_point")[-1]


@pytest.mark.parametrize("planar", [True, False])
def test_an_eccentric_column_carries_its_load_where_statics_says(tmp_path: Path, planar: bool) -> None:
    """Three blocks, each set off from the one below: the force crosses a joint under the centre of mass of all that is above it."""
    offsets, height = [0.0, 0.08, -0.05], 0.4
    blocks = [BASE, *(box(f"s{k}", (x - 0.25, -0.3, height * k), (x + 0.25, 0.3, height * (k + 1))) for k, x in enumerate(offsets))]
    force, point = computed(tmp_path, blocks, planar=planar)
    above = [np.mean(offsets[k:]) for k in range(3)]
    assert point[:, 0] == pytest.approx(above, abs=1e-9)
    assert point[:, 1] == pytest.approx(0.0, abs=1e-9)
    assert point[:, 2] == pytest.approx([0.0, height, 2 * height], abs=1e-6)
    assert force == pytest.approx(2000.0 * 9.81 * 0.5 * 0.6 * height * np.array([3, 2, 1]), rel=1e-6)


def test_a_block_that_pushes_moves_the_point_as_far_as_the_moment_asks(tmp_path: Path) -> None:
    """A horizontal body force of lambda times the weight shifts the point by lambda times the height of the centre of mass."""
    pull = np.tile([0.2 * 9.81, 0.0, -9.81], (4, 1))
    _, point = computed(tmp_path, STACK[:2], acceleration=pull)
    assert point[0] == pytest.approx([0.2 * 0.5, 0.0, 0.0], abs=1e-6)


def test_the_line_of_an_arch_lies_within_it_is_symmetric_and_balances_its_halves(tmp_path: Path) -> None:
    blocks = build("arch", span=4.0, thickness=0.6, voussoirs=17)
    force, point = computed(tmp_path, blocks, solver="admm", tolerance=1e-9)
    radius = np.linalg.norm(point[:, [0, 2]], axis=1)
    assert ((radius > 2.0 * np.cos(np.pi / 34)) & (radius < 2.6)).all()  # straight-edged stones reach within the circle
    order = np.argsort(np.arctan2(point[:, 2], point[:, 0]))
    assert radius[order] == pytest.approx(radius[order][::-1], abs=1e-4)
    assert force[order] == pytest.approx(force[order][::-1], rel=1e-4)
    # half of the arch between springing and crown stone: moments about the springing's point, H (z_c - z_s) + V (...) = sum m g (x_s - x)
    assembly = stepper(blocks, 1).assembly
    right = ~assembly.fixed & (assembly.centre[:, 0] > 1e-6)
    springing, crown = point[order[0]], point[order[8]]  # the right-hand joint of the crown stone
    middle = assembly.mass[~assembly.fixed & (np.abs(assembly.centre[:, 0]) < 1e-6)].sum() * 9.81 / 2
    weight = assembly.mass[right] * 9.81
    shoving = (weight @ (springing[0] - assembly.centre[right, 0]) + middle * (springing[0] - crown[0])) / (crown[2] - springing[2])
    angle = np.pi / 2 - np.pi / 34
    # the crown's joint carries the thrust H and half the crown stone's weight: its normal part
    assert force[order[8]] == pytest.approx(shoving * np.sin(angle) + middle * np.cos(angle), rel=1e-3)


def test_every_joint_of_bent_blocks_has_a_force_of_its_own(tmp_path: Path) -> None:
    """Stones on a groin touch a neighbour with two parts, in two joints: each has its force, within its own polygon."""
    force, point = computed(tmp_path, build("vault", form="cross", voussoirs=7), solver="auto", tolerance=1e-6)
    with Results.open(tmp_path / "result.h5") as results:
        joints = results.joints
    pairs = np.stack([joints.block_a, joints.block_b], axis=1)
    assert len(np.unique(pairs, axis=0)) < joints.count  # some blocks share two joints
    off = np.einsum("ji,ji->j", point - joints.polygon[joints.polygon_start[:-1]], joints.normal)
    assert np.nanmax(np.abs(off)) < 1e-5  # each point lies in the plane of its joint
    assert np.isfinite(point).all() == bool((force > 0).all())
    assert (force > 0).mean() > 0.9


def drawn(
    path: Path, state: State, force: tuple[float, float] | None, points: object = MIDDLES, factor: float = 1.0
) -> tuple[Surface, float, np.ndarray]:
    """Ribbons of the stack in a state, with forces and their points as a run would write them."""
    given = {} if force is None else {"normal_force": np.array([force]), "force_point": np.array([points])}
    run_file = write_run(path / "run.h5", STACK, [state], histories=given)
    with Results.open(run_file) as results:
        solids = Solids.from_blocks(results.blocks)
        pose, snapshot = Pose.of(results, solids, 0), DamageSnapshot.at(results, 0, Thresholds())
        made = ribbons(results, solids, pose, snapshot, 0, factor, view_named("front"), PIXEL)
        return *made, drawn_points(results, solids, pose, 0, factor)


def widths(surface: Surface) -> np.ndarray:
    corners = surface.points.reshape(-1, 4, 3)
    return np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1)


def test_ribbons_are_as_wide_as_the_force(tmp_path: Path) -> None:
    surface, largest, _ = drawn(tmp_path, at_rest(STACK), (2000.0, 1000.0))
    assert largest == 2000.0
    np.testing.assert_allclose(surface.points.reshape(-1, 4, 3).mean(axis=1)[:, :2], 0.0, atol=1e-9)
    assert sorted(set(np.round(widths(surface) / PIXEL, 6))) == [WIDEST / 2, WIDEST]


def test_ribbons_go_through_the_points_of_the_forces(tmp_path: Path) -> None:
    surface, _, _ = drawn(tmp_path, at_rest(STACK), (2000.0, 2000.0), [[0.1, 0.0, 0.0], [0.4, 0.0, 1.0]])
    ends = surface.points[:, [0, 2]]
    for point in ([0.1, 0.0], [0.4, 1.0]):
        assert np.abs(ends - point).sum(axis=1).min() < 0.12  # a ribbon ends there, up to its own width


def test_points_follow_the_base_and_the_amplification(tmp_path: Path) -> None:
    """The whole stack has ridden 0.3 m with its base, and the upper block has slid 2 mm, drawn tenfold."""
    state = shifted(shifted(at_rest(STACK), slice(None), (0.3, 0.0, 0.0)), 2, (0.002, 0.0, 0.0))
    _, _, points = drawn(tmp_path, state, (2000.0, 2000.0), [[0.3, 0.0, 0.0], [0.401, 0.0, 1.0]], factor=10.0)
    np.testing.assert_allclose(points[0], 0.0, atol=1e-12)
    np.testing.assert_allclose(points[1], [0.101 + 9.0 * 0.001, 0.0, 1.0], atol=1e-12)  # halfway between the two blocks


def test_a_hinge_keeps_its_point_at_the_edge(tmp_path: Path) -> None:
    _, _, points = drawn(tmp_path, turned(at_rest(STACK), 2, (0.5, 0.0, 1.0), 1.0), (2000.0, 2000.0), [[0.5, 0, 0], [0.5, 0, 1]], 20.0)
    np.testing.assert_allclose(points[1], [0.5, 0.0, 1.0], atol=1e-9)  # the edge about which it turns does not move


def test_forces_too_small_to_see_and_supports_draw_nothing(tmp_path: Path) -> None:
    surface, _, _ = drawn(tmp_path, at_rest(STACK), (2000.0, 1.0))
    assert len(surface.points) == 0  # the upper joint's is too thin, and the lower stone is then left with a single joint


def test_a_file_without_forces_is_reported(tmp_path: Path) -> None:
    with refused_at("thrust"):
        drawn(tmp_path, at_rest(STACK), None)


@pytest.mark.parametrize("view", ["front", "isometric"])
def test_the_line_in_the_plane_of_a_cut_is_seen_from_wherever(tmp_path: Path, view: str) -> None:
    """A stack whose forces run exactly in the plane y = 0 by which it is cut: the ribbons are as many pixels as without the cut."""
    computed(tmp_path, STACK)

    def seen(cut: str) -> int:
        style = MapStyle(view=view, cut=cut, thrust=True)
        with Results.open(tmp_path / "result.h5") as results:
            frame = results.frames - 1
            pixels = Sheet.drawn(crack_scene(results, frame, framing(results, [frame], style))).pixels()
        left, bottom, width, height = framing_box(pixels)
        return int((pixels[bottom:height, left:width] == [int(THRUST[i : i + 2], 16) for i in (1, 3, 5)]).all(axis=2).sum())

    whole = seen("")
    assert whole > 500
    assert seen("y=0") > 0.9 * whole


def framing_box(pixels: np.ndarray) -> tuple[int, int, int, int]:
    """The part of a sheet (left, first row, right, last row) without its key below or next to it."""
    return 0, 0, int(0.74 * pixels.shape[1]), int(0.8 * pixels.shape[0])
