# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts of good inputs: scenes that use most keys, records of each format, measured modes."""

from __future__ import annotations

import json

import numpy as np


def cuboid(low: tuple[float, float, float], high: tuple[float, float, float], **keys: object) -> dict[str, object]:
    """A block of a block file."""
    vertices = [[x, y, z] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    faces = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    return {"vertices": vertices, "faces": faces, **keys}


def blocks() -> bytes:
    """Two plates, a block on one of them, and one on top of it made of two parts."""
    below = cuboid((-0.5, -0.3, 0.0), (0.5, 0.3, 0.4), name="block", group="stone", density=2200.0)
    halves = [cuboid((-0.4, -0.3, 0.4), (0.0, 0.3, 0.8)), cuboid((0.0, -0.3, 0.4), (0.4, 0.3, 0.8))]
    top = cuboid((-0.4, -0.3, 0.4), (0.4, 0.3, 0.8), name="top", group="stone", parts=halves)
    plate = cuboid((-2.0, -1.0, -0.5), (2.0, 1.0, 0.0), name="plate", group="base", fixed=True)
    second = cuboid((2.5, -1.0, -0.5), (3.5, 1.0, 0.0), name="plate2", group="base", fixed=True)
    return json.dumps({"units": "m", "blocks": [plate, below, top, second]}, indent=1).encode()


SINE = """[[loads]]
kind = "sinusoidal"
direction = "x"
amplitude = 0.1
frequency = 5.0
cycles = 2
start = 0.001
ramp = 0.05
delay = { direction = "x", speed = 800.0 }
"""


def scene(
    structure: str = 'kind = "file"\npath = "blocks.json"', loads: str = "", run: str = "", report: str = "", joints: str = ""
) -> str:
    """A scene of ten steps."""
    return f"""title = "A case"
[structure]
{structure}
[material]
density = 2000.0
friction.default = 0.6
friction.stone-base = 0.7
{joints}
{loads}
[run]
dt = 1e-3
duration = 0.02
{run}
[report]
{report}
"""


MORTAR = """[material.joints.default]
normal_stiffness = 2e10
tangential_stiffness = 8e9
cohesion = 1.5e5
tension = 1e5
theta = 0.6
[material.joints.stone-stone]
normal_stiffness = 8e9
"""
FORCES = """[[loads]]
kind = "push"
direction = "x"
rate = 0.5
initial = 0.01
peak = 0.4
[[loads]]
kind = "point"
block = "block"
force = [10.0, 0.0, -5.0]
point = [0.1, 0.0, 0.2]
moment = [0.0, 1.0, 0.0]
ramp = 0.002
[[loads]]
kind = "tie"
blocks = ["block", "plate"]
points = [[0.0, 0.0, 0.2], [1.5, 0.0, -0.1]]
diameter = 0.02
tension = 100.0
[[loads]]
kind = "gravity"
ramp = 0.002
"""
SUPPORTS = """[[loads]]
kind = "settlement"
supports = ["plate"]
direction = "-z"
displacement = 0.01
start = 0.001
duration = 0.02
[[loads]]
kind = "spreading"
direction = "x"
displacement = 0.01
start = 0.0
duration = 0.02
[[loads]]
kind = "motion"
supports = ["plate"]
time = [0.0, 0.01, 0.03]
displacement = [0.0, 0.002, 0.01]
rotation = [0.0, 0.5, -1.0]
axis = "y"
about = [0.1, 0.0, 0.0]
[[loads]]
kind = "tilt"
direction = "y"
rate = 10.0
angle = 20.0
"""
SHOCKS = """[[loads]]
kind = "sequence"
rest = "still"
longest_rest = 0.02
still = 1e-3
hold = 0.002
[[loads.shocks]]
name = "first"
components = [{direction = "x", path = "quake.csv", column = "ns_m_s2"}, {direction = "z", path = "quake.csv", column = 2}]
target_pga = 1.0
rotate = 30.0
[[loads.shocks]]
components = [{direction = "x", path = "quake.csv", column = 1, window = [0.05, 0.3], taper = 0.02, band = [0.5, 20.0]}]
scale = 0.5
"""
ARTIFICIAL = """[[loads]]
kind = "artificial"
direction = "x"
spectrum = "EC8"
ag = 1.2
ground = "B"
rise = 0.5
level = 1.5
duration = 3.0
periods = [0.1, 0.5]
tolerance = 0.3
seed = 11
"""
RECORD = """[[loads]]
kind = "record"
direction = [1.0, 0.5, 0.0]
path = "quake.csv"
format = "csv"
column = "ns_m_s2"
units = "m/s2"
scale = 0.5
rotate = 10.0
window = [0.02, 0.35]
taper = 0.02
resample = "run"
band = [0.5, 20.0]
band_order = 2
correction = "linear"
"""
ALL_OF_RUN = """theta = 0.55
solver = "nlgs"
tolerance = 1e-6
max_iterations = 200
seed = 3
threads = 1
frames_per_second = 500.0
checkpoint_every = 10.0
planar = true
islands = true
settle = true
gravity = [0.0, 0.0, -9.81]
"""
ALL_OF_REPORT = """opened = 1e-5
slid = 1e-5
largest = 0.02
view = "front"
cut = "y=0.1"
times = []
scale = 10.0
damage = true
grades.width = [1e-4, 5e-3, 15e-3, 25e-3, inf]
grades.labels = ["none", "light", "moderate", "heavy", "severe", "lost"]
"""
SCENES = {
    "sine": scene(loads=SINE, run=ALL_OF_RUN),
    "mortar": scene(loads=SINE, joints=MORTAR, run='solver = "interior"\n'),
    "forces": scene(loads=FORCES, run='solver = "admm"\n'),
    "moving supports": scene(loads=SUPPORTS, run='solver = "newton"\n'),
    "shocks": scene(loads=SHOCKS),
    "record": scene(loads=RECORD),
    "reports": scene(loads=SINE, report=ALL_OF_REPORT),
    "artificial": scene(loads=ARTIFICIAL),
}

OPENING = '[[structure.openings]]\ncentre = 0.2\nwidth = 0.6\nsill = 0.3\nheight = 1.0\nhead = "round"\ndepth = 0.15\n'
_KINDS = {
    "arch": """\
span = 3.0
rise = 1.2
thickness = 0.4
voussoirs = 7
width = 1.0
buttress_width = 0.8
buttress_height = 1.5
buttress_courses = 3
""",
    "pointed arch": """\
kind = "arch"
shape = "pointed"
span = 3.0
rise = 2.0
thickness = 0.4
voussoirs = 8
abutment = 0.5
""",
    "flat arch": """\
kind = "arch"
shape = "flat"
span = 2.0
skew = 20.0
thickness = 0.4
voussoirs = 7
""",
    "aqueduct": """\
tiers = 2
spans = [2, 1]
clear_span = 3.0
pier_width = 1.5
pier_courses = [3, 2]
ring_thickness = 0.5
course_height = 0.5
width = 1.5
unit_length = 1.0
ends = "pier"
channel_width = 0.6
channel_height = 0.5
base_margin = 1.0
pier_blocks = 2
""",
    "wall": """\
length = 2.0
height = 2.0
thickness = 0.4
course_height = 0.25
unit_length = 0.5
leaves = 2
through = 3
gable = 0.5
"""
    + OPENING,
    "tower": """\
side = 3.0
side_y = 3.5
height = 8.0
thickness = 0.6
course_height = 0.5
unit_length = 1.0
belfry_width = 1.0
belfry_height = 1.5
door_width = 0.8
door_height = 1.8
inclination = 2.0
bonded = true
base_depth = 0.5
""",
    "column": """\
height = 4.0
diameter = 0.9
top_diameter = 0.8
drums = 4
sides = 8
plinth = 0.3
capital = 0.4
width = 1.2
base_depth = 0.5
""",
    "vault": """\
form = "barrel"
span = 3.0
thickness = 0.4
voussoirs = 7
length = 2.0
unit_length = 0.7
bonded = true
""",
    "cross vault": """\
kind = "vault"
form = "cross"
span = 3.0
thickness = 0.4
voussoirs = 7
unit_length = 0.7
pier = 0.8
""",
    "dome": """\
span = 4.0
thickness = 0.4
sides = 8
rows = 4
unit_length = 0.8
oculus = 0.8
drum_height = 1.0
drum_thickness = 0.6
base_depth = 0.4
""",
    "packing": """\
diameters = [0.2, 0.1]
shares = [1.0, 2.0]
count = 30
length = 0.6
width = 0.5
height = 1.0
wall_thickness = 0.1
seed = 1
base_depth = 0.2
""",
    "church": """\
block_length = 2.0
course_height = 1.0
length = 18.0
width = 7.0
height = 8.0
thickness = 1.0
apse = false
tower = false
windows = 2
window_width = 1.0
gable = 2.0
roof = "timber"
roof_mass = 150.0
door_width = 2.0
door_height = 4.0
""",
}
STRUCTURES = {name: scene(structure=text if "kind" in text else f'kind = "{name}"\n{text}') for name, text in _KINDS.items()}

WAVE = np.round(np.sin(np.linspace(0.0, 12.0, 40)), 6)
TIME = 0.01 * np.arange(40)


def _rows(values: list[str], width: int) -> str:
    return "\n".join(" ".join(values[k : k + width]) for k in range(0, len(values), width))


_KNET = {"Origin Time": "2011/03/11", "Station Code": "X", "Sampling Freq(Hz)": "100Hz", "Duration Time(s)": "0.4", "Dir.": "N-S",
         "Scale Factor": "2000(gal)/8388608", "Memo.": ""}  # fmt: skip
_ESM = {"EVENT_NAME": "A QUAKE", "SAMPLING_INTERVAL_S": "0.010000", "NDATA": "40", "STREAM": "HNN", "UNITS": "cm/s^2",
        "DATA_TYPE": "ACCELERATION", "USER1": ""}  # fmt: skip
RECORDS = {
    "at2": "PEER DATABASE\nA, QUAKE, 05/19/40\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS=  40, DT=   .01 SEC\n"
    + _rows([f"{v: .7E}" for v in WAVE], 5) + "\n",
    "esm": "".join(f"{key}: {value}\n" for key, value in _ESM.items()) + "".join(f"{v:.6f}\n" for v in WAVE),
    "knet": "".join(f"{key:<18}{value}\n" for key, value in _KNET.items()) + _rows([f"{1000 * v:.0f}" for v in WAVE], 8) + "\n",
    "csv": "time_s,ns_m_s2,up_m_s2\n" + "".join(f"{t:.6g},{v:.6g},{0.5 * v:.6g}\n" for t, v in zip(TIME, WAVE, strict=True)),
    "txt": "# synthetic\n" + "".join(f" {t:.8g}   {v:.6f}\n" for t, v in zip(TIME, WAVE, strict=True)),
}  # fmt: skip
KEYS_OF_RECORDS = {"csv": "column=1", "txt": 'units="m/s2"'}

MEASURED = """mode,frequency_hz,point,x_m,y_m,z_m,ux,uy
1,4.5,a,0.0,0.0,0.8,1.0,0.1
1,4.5,b,0.0,0.0,0.2,0.4,
2,6.5,a,0.0,0.0,0.8,,1.0
3,12.0,,,,,,
"""
