# SPDX-License-Identifier: GPL-3.0-or-later
"""A small scene for tests of the interface: two blocks on a base, shaken for a tenth of a second."""

from __future__ import annotations

from typing import Any

import numpy as np

import masonry_cd as mc


def shaking(components: int = 1, peak: float = 4.0) -> dict[str, Any]:
    """A motion by arrays: a sine of 5 Hz for 0.4 s, from rest to rest."""
    time = np.arange(0.0, 0.4005, 1e-3)
    sine = peak * np.sin(10 * np.pi * time)
    return {"kind": "record", "time": time, "acceleration": np.outer(sine, [1.0, 0.5, 0.25][:components]), "correction": "none"}


def two_blocks() -> dict[str, Any]:
    """Tables of a scene; the blocks are arrays."""
    blocks = [mc.box((-2, -1, -0.5), (2, 1, 0)), mc.box((-0.2, -0.2, 0), (0.2, 0.2, 0.4)), mc.box((-0.2, -0.2, 0.4), (0.2, 0.2, 1.2))]
    return {
        "title": "Two blocks",
        "structure": {"blocks": blocks, "fixed": "b0"},
        "material": {"density": 2000.0, "friction": 0.5},
        "loads": [{"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 5.0, "cycles": 2}],
        "run": {"dt": 2e-3, "duration": 0.1, "frames_per_second": 50.0},
    }
