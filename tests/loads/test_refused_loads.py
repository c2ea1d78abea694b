# SPDX-License-Identifier: GPL-3.0-or-later
"""What is wrong with a table of loads is one line that begins with its key."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bridge_scenes import bridge
from models import box

import loads
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly

PIERS = [box(f"foot{i}", (x, 0, -1), (x + 1, 1, 0), fixed=True) for i, x in enumerate((0.0, 4.0, 10.0))]
PIERS += [box(f"pier{i}", (x, 0, 0), (x + 1, 1, 2)) for i, x in enumerate((0.0, 4.0, 10.0))]
ON_PIERS, (BRIDGE, ON_BRIDGE) = Assembly.from_blocks(PIERS, 0.9), bridge(width=3.0)

SINE = {"kind": "sinusoidal", "direction": "x", "amplitude": 0.2, "frequency": 2.0, "cycles": 4}
TILT, PUSH = {"kind": "tilt", "direction": "x", "rate": 1.0}, {"kind": "push", "direction": "x", "rate": 1.0}
MOVED = {"kind": "push", "control": "displacement", "direction": "x", "blocks": "pier0", "targets": [0.02]}
SETTLES = {"kind": "settlement", "supports": ["foot1"], "displacement": 0.02, "start": 0.5, "duration": 1.5}
BAR = {"kind": "tie", "blocks": ["foot0", "pier1"], "area": 1e-4, "points": [[1, 0.5, -0.5], [4, 0.5, 0.5]]}
POINT = {"kind": "point", "block": "pier0", "force": [0, 0, -600.0]}
RECORD = {"kind": "record", "path": "quake.csv", "direction": "x"}
DRAWN = {"kind": "artificial", "direction": "x", "spectrum": "EC8", "ag": 2.0, "ground": "B"}
AXLE = {"kind": "vehicle", "name": "single", "position": 3.0}
PART, OTHER = {"path": "quake.csv", "direction": "x"}, {"direction": "y", "spectrum": "EC8", "ag": 1.0}


def shock(**keys: Any) -> dict[str, Any]:
    return {"kind": "sequence", "shocks": [{"components": [PART]}, {"components": [PART], **keys}]}


def without(table: dict[str, Any], key: str) -> dict[str, Any]:
    return {name: value for name, value in table.items() if name != key}


REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"direction": "x"}, "loads[0].kind: missing; kinds: artificial, "),
    ({"kind": "sinusiodal"}, 'loads[0].kind: unknown kind "sinusiodal" (did you mean "sinusoidal"?)'),
    (SINE | {"amplitud": 1.0}, 'loads[0].amplitud: unknown key (did you mean "amplitude"?)'),
    (without(SINE, "amplitude"), "loads[0].amplitude: missing"),
    (SINE | {"amplitude": "0.2"}, "loads[0].amplitude: "),
    (SINE | {"amplitude": float("nan")}, "loads[0].amplitude: "),
    (SINE | {"frequency": 0.0}, "loads[0].frequency: "),
    (SINE | {"frequency": 600.0}, "loads[0].frequency: 600 Hz is beyond run.dt 0.001 s"),
    (SINE | {"direction": "north"}, "loads[0].direction: "),
    (SINE | {"direction": [0, 0, 0]}, "loads[0].direction: a vector of finite length"),
    (SINE | {"direction": [1, 0]}, "loads[0].direction: "),
    (SINE | {"duration": 2.0}, "loads[0]: give exactly one of cycles and duration"),
    (SINE | {"ramp": 1.5}, "loads[0]: ramp: "),
    (SINE | {"delay": {"direction": "x"}}, "loads[0].delay: give direction and speed, or seconds"),
    (SINE | {"delay": {"direction": "x", "speed": 9.0, "seconds": {}}}, "loads[0].delay: give direction and speed, or seconds"),
    (SINE | {"delay": {"direction": "x", "speed": 0.0}}, "loads[0].delay.speed: "),
    (SINE | {"delay": {"seconds": {"foot9": 1.0}}}, 'loads[0].delay.seconds: "foot9" is no block or group'),
    (SINE | {"delay": {"seconds": {"foot1": -1.0}}}, "loads[0].delay.seconds.foot1: "),
    ({"kind": "gravity", "ramp": -1.0}, "loads[0].ramp: "),
    ({"kind": "pulse", "direction": "x", "acceleration": 1.0, "duration": 1e-4}, "loads[0].duration: 0.0001 s are less than a step"),
    ({"kind": "tilt", "rate": 1.0}, "loads[0]: give exactly one of direction and axis"),
    (TILT | {"axis": "y"}, "loads[0]: give exactly one of direction and axis"),
    (TILT | {"direction": [1, 0, 1]}, "loads[0].direction: must be level"),
    (without(TILT, "direction") | {"axis": "z"}, "loads[0].axis: must be level"),
    (TILT | {"rate": 0.0}, "loads[0].rate: "),
    (TILT | {"angle": 91.0}, "loads[0].angle: "),
    (TILT | {"angle": 5.0, "initial": 9.0}, "loads[0]: angle: "),
    (PUSH | {"rate": -1.0}, "loads[0].rate: "),
    (PUSH | {"peak": 0.1, "initial": 0.2}, "loads[0]: peak: "),
    (without(PUSH, "rate"), "loads[0]: rate: missing, control"),
    (PUSH | {"speed": 0.1}, 'loads[0]: speed: of no use with control = "force", which takes rate instead; '),
    (without(PUSH, "rate") | {"targets": [0.01]}, 'loads[0]: targets: of no use with control = "force", which takes peak instead; '),
    (MOVED | {"rate": 0.1}, 'loads[0]: rate: of no use with control = "displacement", which takes speed instead; its keys: blocks, '),
    (MOVED | {"control": "force"}, 'loads[0]: blocks: of no use with control = "force"; its keys: rate, initial, peak; '),
    (MOVED | {"target": 0.1}, 'loads[0].target: unknown key (did you mean "targets"?)'),
    (MOVED | {"blocks": "q"}, 'loads[0].blocks: "q" is no block or group'),
    (MOVED | {"blocks": "foot0"}, 'loads[0].blocks: "foot0" is fixed'),
    (MOVED | {"targets": [1.6]}, "loads[0].targets: 1.6 m is beyond the blocks"),
    (MOVED | {"targets": [0.0]}, "loads[0].targets: none is away from 0"),
    (MOVED | {"targets": ["a"]}, "loads[0].targets: "),
    (MOVED | {"speed": 0.4}, "loads[0].speed: at 0.4 m/s the inertia of the blocks is "),
    (MOVED | {"speed": 4.0}, "loads[0].speed: at 4 m/s the leg of 0.02 m takes "),
    (MOVED | {"point": [2.0, 0.5, 1.0]}, "loads[0].point: (2, 0.5, 1) m lies 1 m outside"),
    (MOVED | {"point": [0.5, 0.5, 1.0], "face": "x"}, "loads[0]: give face or point, not both"),
    (SETTLES | {"supports": ["foot7"]}, 'loads[0].supports: "foot7" is no block or group (did you mean "foot'),
    (SETTLES | {"supports": ["pier0"]}, 'loads[0].supports: "pier0" is not fixed; supports: foot0, foot1, foot2'),
    (SETTLES | {"supports": []}, "loads[0].supports: "),
    (SETTLES | {"start": 1e200}, "loads[0].start: "),
    (SETTLES | {"duration": 9e5}, "loads[0].duration: 900000 s take more than 2e+07 steps"),
    (SETTLES | {"duration": 0.005}, "loads[0].duration: 0.005 s are less than 10 steps"),
    (without(SETTLES, "supports"), "loads[0].supports: missing"),
    ({"kind": "spreading", "direction": "y", "displacement": 0.1, "duration": 1.0}, "loads[0].direction: the supports all stand at"),
    (BAR | {"blocks": ["foot0", "piex1"]}, 'loads[0].blocks: "piex1" is no block or group (did you mean "pier'),
    (BAR | {"blocks": ["foot0", "foot0"]}, "loads[0].blocks: "),
    (BAR | {"blocks": ["foot0", "foot1"]}, "loads[0].blocks: both are fixed"),
    (BAR | {"diameter": 0.02}, "loads[0]: give exactly one of diameter and area"),
    (BAR | {"points": [[0, 0, 0]]}, "loads[0].points: must be two points"),
    (BAR | {"points": [[0, 0, 0], [-1e308, 0, 0]]}, "loads[0].points: the ends are 1e+308 m apart"),
    (BAR | {"points": [[0, 0, 0], [1e300, 1e300, 0]]}, "loads[0].points: the ends are 1.41e+300 m apart"),
    (BAR | {"points": [[0, 0, 0], [0, 0, 0]]}, "loads[0].points: both ends are at one point"),
    (BAR | {"points": [[1, 0.5, -0.5], [0, 0, 0]]}, "loads[0].points[1]: "),
    (BAR | {"points": [[-3, 0.5, -0.5], [4, 0.5, 0.5]]}, "loads[0].points[0]: "),
    (BAR | {"modulus": 1e-300}, "loads[0]: its modulus and section make "),
    (BAR | {"modulus": 1e300}, "loads[0]: its modulus and section make "),
    (BAR | {"area": 1.0}, "run.dt: 0.001 s is too long for the "),
    (POINT | {"block": "foot0"}, 'loads[0].block: "foot0" is fixed'),
    (POINT | {"block": "*"}, 'loads[0].block: "*" names 6 blocks'),
    (POINT | {"force": [0, 1]}, "loads[0].force: should be three numbers"),
    (POINT | {"point": [-4, 0, 0]}, 'loads[0].point: (-4, 0, 0) m lies 4 m outside block "pier0", which has x from 0 to 1, y from 0'),
    (POINT | {"hold": 1.0}, "loads[0]: hold: "),
    (POINT | {"stages": [0.0, 0.0]}, "loads[0]: stages: none"),
    (POINT | {"stages": [0.5, 1.0]}, "loads[0]: stages: ramp and hold are 0"),
    (POINT | {"stages": [0.5, "b"]}, "loads[0].stages: "),
    (RECORD | {"scale": 2.0, "target_pga": 1.0}, "loads[0]: give scale or target_pga, not both"),
    (RECORD | {"scale": 0.0}, "loads[0]: scale: must not be zero"),
    (RECORD | {"target_pga": -1.0}, "loads[0].target_pga: "),
    (RECORD | {"window": [5.0, 2.0]}, "loads[0].window: must be [from, to] in seconds"),
    (RECORD | {"window": [5.0]}, "loads[0].window: must be [from, to]"),
    (RECORD | {"window": ["a", 5]}, "loads[0].window: must be [from, to]"),
    (RECORD | {"window": [1.0, 20.0]}, "loads[0].window: [1.0, 20.0] reaches outside the record, 0 to 2 s"),
    (RECORD | {"window": [1.0, 1.02]}, "loads[0]: 3 samples of quake.csv are too few"),
    (RECORD | {"column": 1.5}, "loads[0].column: "),
    (RECORD | {"taper": 6.0}, "loads[0].taper: "),
    (RECORD | {"path": "quack.csv"}, 'loads[0].path: quack.csv: no such file (did you mean "quake.csv"?)'),
    (RECORD | {"correction": "quadratc"}, "loads[0].correction: "),
    (RECORD | {"format": "xls"}, "loads[0].format: "),
    (RECORD | {"start": -1.0}, "loads[0].start: "),
    (RECORD | {"band": [1.0, 60.0]}, "loads[0].band: its upper corner 60 Hz must lie below 50 Hz"),
    (RECORD | {"band": [0.0, 20.0]}, "loads[0].band: must be [from, to] in Hz"),
    (RECORD | {"band": [20.0, 1.0]}, "loads[0].band: must be [from, to] in Hz, from < to"),
    (RECORD | {"band": [1.0, 20.0], "band_order": 0}, "loads[0].band_order: "),
    (RECORD | {"resample": "fast"}, "loads[0].resample: must be a time step above zero"),
    (RECORD | {"resample": -0.01}, "loads[0].resample: must be a time step above zero"),
    (RECORD | {"resample": 0.0141421356}, "loads[0].resample: 0.0141421 s and the record's 0.01 s"),
    (RECORD | {"resample": 1.0}, "loads[0].resample: 3 samples are left"),
    (shock(components=[]), "loads[0].shocks[1].components: "),
    (shock(components=[PART | {"paht": "a"}]), 'loads[0].shocks[1].components[0].paht: unknown key (did you mean "path"?)'),
    (shock(components=[PART, OTHER | {"ag": -1.0}]), "loads[0].shocks[1].components[1].ag: "),
    (shock(components=[{"direction": "x"}]), "loads[0].shocks[1].components[0].path: missing"),
    (shock(components=[PART | {"path": "none.csv"}]), "loads[0].shocks[1].components[0].path: none.csv"),
    (shock(nmae="a"), 'loads[0].shocks[1].nmae: unknown key (did you mean "name"?)'),
    (shock(name="n" * 41), "loads[0].shocks[1].name: "),
    (shock(scale=1.0, target_pga=1.0), "loads[0].shocks[1]: give scale or target_pga, not both"),
    (DRAWN | {"spectrum": "IBC"}, "loads[0].spectrum: "),
    (DRAWN | {"ground": "F"}, "loads[0].ground: "),
    (DRAWN | {"type": 3}, "loads[0].type: "),
    (DRAWN | {"ag": 0.0}, "loads[0].ag: "),
    (DRAWN | {"f0": 2.5}, "loads[0]: f0: does not apply"),
    (DRAWN | {"spectrum": "NTC"}, "loads[0]: f0: missing"),
    (DRAWN | {"spectrum": "NTC", "f0": 2.5, "tc_star": 0.3, "type": 1}, "loads[0]: type: does not apply"),
    (DRAWN | {"period": 0.5, "periods": [0.1, 1.0]}, "loads[0]: give period or periods, not both"),
    (DRAWN | {"period": 5.0}, "loads[0]: period: "),
    (DRAWN | {"periods": [1.0, 0.1]}, "loads[0].periods: must be [from, to] in seconds"),
    (DRAWN | {"duration": 3e4}, "loads[0].duration: "),
    (DRAWN | {"duration": 10.0}, "loads[0]: duration: "),
    (AXLE | {"position": 80.0}, "loads[0].position: the vehicle never stands on the deck, which is from x = -1.5 to 7.5 m"),
    (AXLE | {"position": 8.0, "speed": 2.0}, "loads[0].speed: the vehicle never stands on the deck"),
    (AXLE | {"offset": 1.0}, "loads[0].offset: the vehicle stands beside the road: its wheels from y = -0.05"),
    (without(AXLE, "position"), "loads[0].position: missing"),
    (AXLE | {"start": 9.0}, "loads[0].start: the vehicle never stands on the deck: it is there from 9 s on"),
    ({"kind": "vehicle", "axles": [1e3, 2e3], "position": 1.0}, "loads[0]: spacing: 2 axles have 1 distances, got 0"),
    (AXLE | {"axles": [1e3]}, "loads[0]: give exactly one of name and axles"),
    (AXLE | {"name": "lm3"}, "loads[0].name"),
]


def build(*tables: dict[str, Any], folder: Path = Path(), **keys: Any) -> loads.Loading:
    """Loads of a run of 100 steps, on a bridge where there are vehicles."""
    on_bridge = any(table.get("kind") == "vehicle" for table in tables)
    of_run = {"assembly": ON_BRIDGE, "fills": BRIDGE.fills} if on_bridge else {"assembly": ON_PIERS}
    return loads.build(tables, 1e-3, 100, (0.0, 0.0, -9.81), folder, **(of_run | keys))


@pytest.mark.parametrize(("table", "message"), REFUSED, ids=[f"{k}-{message.split(': ')[0]}" for k, (_, message) in enumerate(REFUSED)])
def test_it_is_one_line_that_begins_with_the_key(table: dict[str, Any], message: str, tmp_path: Path) -> None:
    rows = "".join(f"{0.01 * k:.2f},{np.sin(np.pi * k / 200) ** 2 * np.sin(0.7 * k):.6g}\n" for k in range(201))
    (tmp_path / "quake.csv").write_text(f"time_s,a_m_s2\n{rows}")
    with pytest.raises(InputError) as failure:
        build(table, folder=tmp_path)
    assert str(failure.value).startswith(message)
    assert "\n" not in str(failure.value)


def test_tables_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(InputError, match=r"loads\[1\]: gravity is given twice, first in loads\[0\]"):
        build({"kind": "gravity"}, {"kind": "gravity", "ramp": 1.0})
    with pytest.raises(InputError, match=r"loads\[1\]: gravity is ramped over 2 s; begin the tilt after that"):
        build({"kind": "gravity", "ramp": 2.0}, TILT | {"start": 1.0})
    with pytest.raises(InputError, match=r'loads\[1\]\.direction: "pier0" is already guided by loads\[0\]'):
        build(MOVED, MOVED | {"direction": [1.0, 0.0, 1.0]})
    build(MOVED, MOVED | {"direction": "y"})
    with pytest.raises(InputError, match='needs one structure of kind "bridge"'):
        build(AXLE, fills=())


@pytest.mark.parametrize(("table", "key"), [(SETTLES, "supports"), (SINE | {"delay": {"direction": "x", "speed": 9.0}}, "delay")])
def test_what_names_blocks_needs_a_structure(table: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError, match=rf"loads\[0\].{key}: needs a structure, whose blocks it names"):
        build(table, assembly=None)


@pytest.mark.parametrize("table", [TILT, PUSH])
def test_what_grows_with_gravity_needs_it(table: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"loads\[0\]: needs gravity, but run.gravity is zero"):
        loads.build([table], 1e-3, 100, (0.0, 0.0, 0.0), Path())
