# SPDX-License-Identifier: GPL-3.0-or-later
"""Vehicles in limit analysis: the worst place, the four-hinge mechanism by hand, and what the fill adds."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from masonry_cd.app.limit_structure import limit_structure
from masonry_cd.app.scene import Scene, parse_scene
from masonry_cd.foundation.errors import InputError
from masonry_cd.limit.case import limit_case
from masonry_cd.limit.files import write
from masonry_cd.limit.vehicle import at_worst

COUNT = 10
TEXT = """
title = "Like Prestwood"
[structure]
kind = "bridge"
width = 3.8
cover = 0.165
[[structure.spans]]
span = 6.55
rise = 1.428
thickness = 0.22
voussoirs = 10
[structure.fill]
passive = 0.0
[material]
density = 2000.0
friction = 5.0
[[loads]]
kind = "vehicle"
axles = [1e3]
across = "line"
position = 1.6
[limit]
live = [0]
"""


def scene(*changes: str, text: str = TEXT) -> Scene:
    return parse_scene(text, Path("prestwood.toml"), list(changes))


def by_hand(given: Scene) -> float:
    """The least factor over all mechanisms of four hinges, by the work of weights and of the load: at their rates of rotation about their
    centres, of the three parts between hinges at joints i < j < k < l, which lie on intrados and extrados in turn."""
    made = limit_structure(given)
    loads, assembly = made.loads(), made.assembly
    numbers = [assembly.names.index(f"arch1.v{k + 1}") for k in range(COUNT)]
    dead, live = loads.gravity[numbers] + loads.constant[numbers], loads.live[numbers]
    centre = assembly.centre[numbers]
    corners = [assembly.blocks[b].vertices[assembly.blocks[b].vertices[:, 1] < 0.0][:, [0, 2]] for b in numbers]
    crown = np.array([3.275, -3.0])
    lines: dict[str, list[np.ndarray]] = {"in": [], "out": []}
    for k in range(COUNT + 1):
        shared = corners[k] if k == 0 else corners[k - 1]
        left = sorted(shared, key=lambda p: np.arctan2(p[1] - crown[1], p[0] - crown[0]))
        pair = left[2:] if k == 0 else left[:2]  # of a voussoir, the joint at the left, or that at the right
        pair.sort(key=lambda p: float(np.hypot(*(p - crown))))
        lines["in"].append(pair[0])
        lines["out"].append(pair[1])

    def work(wrench: np.ndarray, part: range, about: np.ndarray, rate: float) -> float:
        """Return the work of forces and moments on blocks that turn about a point, counter-clockwise seen from the front."""
        arm = centre[part][:, [0, 2]] - about
        return rate * float(np.sum(arm[:, 0] * wrench[part, 2] - arm[:, 1] * wrench[part, 0] - wrench[part, 4]))

    best = np.inf
    for hinges in combinations(range(COUNT + 1), 4):
        for sides in (("in", "out", "in", "out"), ("out", "in", "out", "in")):
            a, b, c, d = (lines[side][h] for side, h in zip(sides, hinges, strict=True))
            matrix = np.stack([b - a, c - d], axis=1)
            if abs(np.linalg.det(matrix)) < 1e-9:
                continue
            s, t = np.linalg.solve(matrix, d - a)
            middle = a + s * (b - a)  # where both lines through the hinges meet
            for first in (1.0, -1.0):
                second = first / (1.0 - s)  # B moves alike with both: first (B - A) = second (B - I), B - I = (1 - s) (B - A)
                third = second * (1.0 + t)  # and C with the second and the third: I = D - t (C - D)
                turns = [first, second - first, third - second, -third]  # relative rotations at the hinges
                opens = [turn * (1.0 if side == "out" else -1.0) for turn, side in zip(turns, sides, strict=True)]
                # a joint that hinges at its outer end opens at the inner one where what follows turns counter-clockwise
                if min(opens) < -1e-12:
                    continue
                parts = ((range(hinges[0], hinges[1]), a, first), (range(hinges[1], hinges[2]), middle, second),
                         (range(hinges[2], hinges[3]), d, third))  # fmt: skip
                own, other = (sum(work(w, *part) for part in parts) for w in (live, dead))
                if own > 1e-9:
                    best = min(best, -other / own)
    return float(best)


@pytest.mark.parametrize("place", [1.2, 1.6, 2.6])
def test_least_factor_is_that_of_the_four_hinge_mechanism_by_hand(place: float) -> None:
    given = scene(f"loads[0].position={place}")
    case = limit_case(given)
    assert case.whole.collapse.mechanism.count("hinge") == 4
    assert case.whole.analysis.associated.factor == pytest.approx(by_hand(given), rel=1e-6)


def test_fill_that_resists_bears_more_and_more_of_it_bears_more_still() -> None:
    shares = (0.0, 1.0 / 3.0, 1.0)
    factors = [limit_case(scene(f"structure.fill.passive={m}", "limit.starts=0")).whole.analysis.associated.factor for m in shares]
    assert factors[0] < factors[1] < factors[2]
    share = limit_case(scene("structure.fill.passive=1.0", "structure.fill.passive_shaken=0.0", "limit.starts=0"))
    assert share.whole.analysis.associated.factor == pytest.approx(factors[2])
    pushed = [
        limit_case(
            scene("structure.fill.passive=1.0", f"structure.fill.passive_shaken={m}", "limit={push='x'}")
        ).whole.analysis.associated.factor
        for m in (0.0, 0.3)
    ]
    assert pushed[0] < pushed[1]  # a push has the share of an earthquake


def test_the_worst_place_is_found_and_no_place_is_worse(tmp_path: Path) -> None:
    text = TEXT.replace("position = 1.6\n", "")
    case = limit_case(scene("limit.starts=0", "limit.positions=20", text=text))
    found = case.crossing
    assert found is not None
    least, place = found.factor[found.worst], found.position[found.worst]
    assert case.whole.analysis.associated.factor == pytest.approx(least, rel=1e-9)
    for other in (1.0, 1.6, 3.3, 5.1):
        assert limit_case(scene(f"loads[0].position={other}", "limit.starts=0")).whole.analysis.associated.factor >= least * (1.0 - 1e-3)
    mirrored = limit_case(scene(f"loads[0].position={6.55 - place}", "limit.starts=0")).whole.analysis.associated.factor
    assert mirrored == pytest.approx(least, rel=1e-6)  # the bridge is its own mirror image
    write(case, tmp_path, pictures=False)
    rows = (tmp_path / "crossing.csv").read_text().splitlines()
    assert rows[0] == "position_m,factor"
    assert len(rows) == len(found.position) + 1
    assert '"critical_position"' in (tmp_path / "limit.json").read_text()


def test_a_vehicle_alone_needs_no_pattern_and_one_that_stands_next_to_a_push_is_constant() -> None:
    text = TEXT[: TEXT.index("[limit]")] + "[run]\ndt = 1e-3\nduration = 1.0\n"
    whole = limit_case(scene(text=text)).whole
    assert whole is not None and whole.loads.kind == "live"
    pushed = limit_case(scene("loads[0].axles=[50e3]", "limit={push='x'}"))
    bare = limit_case(scene("loads[0].axles=[1.0]", "limit={push='x'}"))
    assert pushed.whole.analysis.associated.factor != pytest.approx(bare.whole.analysis.associated.factor, rel=1e-3)


def test_two_vehicles_have_no_one_worst_place() -> None:
    text = TEXT.replace("position = 1.6\n", "") + '[[loads]]\nkind = "vehicle"\nname = "single"\n'
    with pytest.raises(InputError, match="worst place of one vehicle"):
        limit_case(scene("limit.live=[0,1]", text=text))


def test_the_places_of_a_vehicle_say_how_long_they_still_take(capsys, monkeypatch: pytest.MonkeyPatch) -> None:
    """On standard error, now and then; nothing where it is quiet, as in studies."""
    from masonry_cd.app import progress

    monkeypatch.setattr(progress, "LINE_SECONDS", 0.0)
    asked = limit_structure(scene("limit.positions=3", text=TEXT.replace("position = 1.6\n", "")))
    at_worst(asked, quiet=False)
    assert "place of the vehicle 2 of 3 (67 %)" in capsys.readouterr().err
    at_worst(asked)
    assert not capsys.readouterr().err
