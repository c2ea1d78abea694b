# SPDX-License-Identifier: GPL-3.0-or-later
"""analysis.damage.crack_pattern: shares of length found and false, on lines whose shares follow by hand."""

import math

import numpy as np
import pytest

import masonry_cd as mc
from masonry_cd.analysis.damage.crack_pattern import agreement
from masonry_cd.foundation.errors import InputError
from masonry_cd.studies.laboratory.cases.dry_walls import WALL, crack_maps

BED = np.array([[[0.0, 0.0], [1.0, 0.0]]])


def test_a_parallel_crack_is_found_within_the_distance_and_false_beyond():
    near, far = agreement(BED, [[(0.0, 0.09), (1.0, 0.09)]], 0.1), agreement(BED, [[(0.0, 0.11), (1.0, 0.11)]], 0.1)
    assert (near.found, far.found, far.false) == (pytest.approx(1.0), 0.0, 1.0)
    assert (near.drawn_length, near.computed_length) == (1.0, 1.0)


def test_a_longer_crack_is_found_up_to_the_distance_beyond_the_end():
    """A line of 2 m over a computed one of 1 m: the first metre, and w about its end; none of the computed length is false."""
    made = agreement(BED, [[(0.0, 0.0), (2.0, 0.0)]], 0.1)
    assert (made.found, made.false) == (pytest.approx(1.1 / 2.0), 0.0)
    back = agreement(np.array([[[0.0, 0.0], [2.0, 0.0]]]), [[(0.0, 0.0), (1.0, 0.0)]], 0.1)
    assert (back.found, back.false) == (pytest.approx(1.0), pytest.approx(0.9 / 2.0))


def test_a_crack_across_another_is_found_over_the_width_of_the_strip():
    made = agreement(BED, [[(0.2, -1.0), (0.8, 1.0)]], 0.1)
    assert made.found == pytest.approx(0.2 / 2.0)  # the strip is 0.2 m high, whatever the slope
    assert made.drawn_length == pytest.approx(math.hypot(0.6, 2.0))


def test_lines_drawn_twice_count_once():
    assert agreement(BED, [[(0.0, 0.0), (1.0, 0.0)], [(0.5, 0.0), (1.0, 0.0)]], 0.1).drawn_length == 1.0


def test_no_computed_crack_is_no_false_one():
    assert agreement(np.zeros((0, 2, 2)), [[(0.0, 0.0), (1.0, 0.0)]], 0.1)[:2] == (0.0, 0.0)


@pytest.mark.parametrize(("drawn", "within", "place"), [([], 0.1, "drawn"), ([[(0, 0)]], 0.1, "drawn"), ([[(0, 0), (1, 0)]], 0, "within")])
def test_no_line_or_no_distance_is_refused(drawn, within, place):
    with pytest.raises(InputError) as refused:
        agreement(BED, drawn, within)
    assert refused.value.faults[0].place == place


def test_a_run_knows_its_cracks(tmp_path):
    """Two drums of which the upper one is lifted: one crack, in the bed at z = 1 m."""
    tables = {
        "structure": {"kind": "column", "height": 2.0, "diameter": 1.0, "drums": 2, "sides": 4},
        "material": {"density": 2000.0, "friction": 0.6},
        "loads": [{"kind": "point", "block": "drum2", "force": [0.0, 0.0, 3e4], "ramp": 0.05}],
        "run": {"dt": 2e-3, "duration": 0.2},
        "quiet_checks": ["loads[0].force"],
    }
    run = mc.run(mc.scene(tables), tmp_path / "out", progress=False)
    made = run.crack_agreement([[(-0.5, 1.0), (0.5, 1.0)]], 0.25)
    assert made.computed_length > 0.5
    assert made.found == pytest.approx(1.0, abs=0.02)


def test_every_drawn_line_of_the_dry_walls_lies_in_the_wall():
    maps = crack_maps()
    assert [stress for stress, _ in maps] == [0.15, 0.15, 0.5, 0.5, 1.0, 1.0, 1.25]
    points = np.array([point for _, lines in maps for line in lines for point in line])
    assert (points >= 0.0).all()
    assert (points <= [WALL.length, WALL.course * WALL.courses]).all()
