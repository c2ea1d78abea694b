# SPDX-License-Identifier: GPL-3.0-or-later
"""The texts of good study files, one for each design, and the motions that they name."""

from __future__ import annotations

import numpy as np

_LIMITS = """[limit_states]
cracked = { quantity = "max_opening", above = 1e-3 }
heavy = { quantity = "grade", at_least = "D3" }
collapse = { quantity = "collapsed_blocks", above = 0 }
[run]
workers = 1
timeout = 60.0
grace = 30.0
keep = "summary"
memory = 2.0
"""
_RECORDS = """[records]
folder = "records"
pattern = '(?P<motion>.+)_(?P<component>[^_]+)\\.acc'
x = ["NS", "H1"]
y = ["EW"]
shake = ["x"]
exclude = ["far*"]
units = "m/s2"
dt = 0.01
trim = { arias = [0.01, 0.99], before = 0.05, after = 0.05 }
rotate = 30.0
"""
_MEASURE = '[intensity]\nmeasure = "Sa(0.3)"\nof = "geometric_mean"\nalso = ["AvgSA(0.1,0.5)", "FIV3(0.4)"]\n'
_DISTRIBUTIONS = """[vary]
"material.friction" = { distribution = "lognormal", median = 0.6, beta = 0.15, low = 0.3, high = 0.9 }
"material.density" = { distribution = "normal", mean = 2000.0, std = 50.0 }
"loads[0].amplitude" = { from = 0.1, to = 0.3, count = 3 }
[[correlation]]
keys = ["material.friction", "material.density"]
rho = 0.5
"""
STUDIES = {
    "grid": f'scene = "scene.toml"\ndesign = "grid"\n[vary]\n"loads[0].amplitude" = [0.1, 0.2]\n"run.seed" = [1, 2]\n{_LIMITS}',
    "sample": f'scene = "scene.toml"\ndesign = "sample"\nsamples = 8\nseed = 3\n{_DISTRIBUTIONS}{_LIMITS}',
    "ensemble": f'scene = "scene.toml"\ndesign = "ensemble"\n[ensemble]\nmembers = 4\nperturb = "velocities"\nsize = 1e-8\n{_LIMITS}',
    "stripes": f'scene = "scene.toml"\ndesign = "stripes"\n{_RECORDS}{_MEASURE}levels = [1.0, 2.0]\n{_LIMITS}',
    "ida": f'scene = "scene.toml"\ndesign = "ida"\n{_RECORDS}{_MEASURE}[ida]\nstart = 1.0\nstep = 1.0\ngrowth = 0.2\n{_LIMITS}',
}


def motions() -> dict[str, bytes]:
    """Two motions of two components, one column each."""
    t = 0.01 * np.arange(60)
    names = ("one_NS", "one_EW", "two_H1", "two_EW", "far_NS", "far_EW")
    return {
        f"records/{name}.acc": "".join(f"{a:.6f}\n" for a in (1.0 + 0.2 * k) * np.sin((15.0 + k) * t) * np.sin(np.pi * t / 0.6)).encode()
        for k, name in enumerate(names)
    }
