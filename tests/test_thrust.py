"""The way of the forces: through the middle of closed joints, through the edge of hinges, as wide as the force."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest
from made_run import at_rest, box, turned, write_run

from masonry_cd.errors import InputError
from masonry_cd.results import Results
from reports.damage import Thresholds
from reports.deformed import Pose, Solids
from reports.parts import Moment
from reports.render import Surface, view_named
from reports.thrust import WIDEST, ribbons

BASE = box("base", (-2, -1, -0.5), (2, 1, 0), "base", fixed=True)
STACK = [BASE, *(box(f"s{k}", (-0.5, -0.5, k), (0.5, 0.5, k + 1)) for k in range(2))]
PIXEL = 0.01


def drawn(path: Path, degrees: float, force: tuple[float, float] | None) -> tuple[Surface, float]:
    """Ribbons of a stack whose upper block leans about its right edge."""
    rest = at_rest(STACK)
    run = write_run(path / "run.h5", STACK, [turned(rest, 2, (0.5, 0.0, 1.0), degrees)])
    if force is not None:
        with h5py.File(run, "a") as file:
            file["joints/normal_force"] = np.array([force])
    with Results.open(run) as results:
        solids = Solids.from_blocks(results.blocks)
        moment = Moment.at(results, 0, Thresholds())
        return ribbons(results, solids, Pose.of(results, solids, 0), moment, 0, 1.0, view_named("front"), PIXEL)


def widths(surface: Surface) -> np.ndarray:
    corners = surface.points.reshape(-1, 4, 3)
    return np.linalg.norm(corners[:, 3] - corners[:, 0], axis=1)


def test_closed_joints_carry_the_force_in_their_middle(tmp_path: Path) -> None:
    surface, largest = drawn(tmp_path, 0.0, (2000.0, 1000.0))
    assert largest == 2000.0
    np.testing.assert_allclose(surface.points.reshape(-1, 4, 3).mean(axis=1)[:, :2], 0.0, atol=1e-9)
    assert sorted(set(np.round(widths(surface) / PIXEL, 6))) == [WIDEST / 2, WIDEST]


def test_a_hinge_carries_it_at_its_edge(tmp_path: Path) -> None:
    surface, _ = drawn(tmp_path, 1.0, (2000.0, 2000.0))
    ends = surface.points[:, [0, 2]]
    assert np.abs(ends - [0.5, 1.0]).sum(axis=1).min() < 0.1  # a ribbon ends at the touching edge, up to its own width
    assert np.abs(ends - [0.0, 1.0]).sum(axis=1).min() > 0.2  # and none in the middle of that joint


def test_forces_too_small_to_see_and_supports_draw_nothing(tmp_path: Path) -> None:
    surface, _ = drawn(tmp_path, 0.0, (2000.0, 1.0))
    assert len(surface.points) == 0  # the upper joint's is too thin, and the lower stone is then left with a single joint


def test_a_file_without_forces_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^thrust: this result holds no joint forces$"):
        drawn(tmp_path, 0.0, None)
