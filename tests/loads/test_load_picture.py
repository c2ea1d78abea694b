# SPDX-License-Identifier: GPL-3.0-or-later
"""loads.picture: a record is drawn without a display, and peaks survive the thinning of long curves."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hostile import refused_at
from pictures import main_colours
from places import ROOT

from loads.picture import AFTER, BEFORE, file_picture, thin_curve

TIME = 0.01 * np.arange(1001)
WAVE = 2.0 * np.sin(np.pi * TIME / 10.0) ** 2 * np.sin(2 * np.pi * 1.3 * TIME)


@pytest.fixture
def quake(tmp_path: Path) -> Path:
    file = tmp_path / "quake.txt"
    file.write_text("t a_m_s2\n" + "".join(f"{t:.2f} {a + 0.5:.9g}\n" for t, a in zip(TIME, WAVE, strict=True)))
    return file


def test_a_file_is_drawn_and_its_numbers_returned(quake: Path) -> None:
    picture = quake.with_name("quake.png")
    processed = file_picture(quake, picture, band=[0.1, 25.0], taper=0.5)
    assert {BEFORE, AFTER} <= main_colours(picture)
    numbers = processed.numbers()
    assert numbers["before"]["pga"] == pytest.approx(abs(WAVE + 0.5).max(), rel=1e-6)
    assert numbers["after"]["pga"] == pytest.approx(abs(WAVE).max(), rel=0.02)
    assert abs(numbers["after"]["end_displacement"]) < 1e-12


def test_long_curves_keep_their_peaks_when_thinned() -> None:
    values = np.zeros(300_000)
    values[[77_777, 123_456]] = 3.0, -4.0
    times, drawn = thin_curve(np.arange(300_000.0), values)
    assert len(drawn) <= 20_000
    assert (drawn.max(), drawn.min()) == (3.0, -4.0)
    assert (np.diff(times) >= 0.0).all()


def test_bad_keys_and_places_are_named(quake: Path) -> None:
    with refused_at("record.windw"):
        file_picture(quake, quake.with_name("p.png"), windw=[0, 1])
    with refused_at("no/p.png"):
        file_picture(quake, quake.parent / "no" / "p.png")
    with refused_at("p.tiffany"):
        file_picture(quake, quake.with_name("p.tiffany"))


def test_loads_alone_bring_neither_matplotlib_nor_obspy() -> None:
    code = "import sys, loads, loads.picture; print([m for m in ('matplotlib', 'obspy', 'pandas') if m in sys.modules])"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd=ROOT)
    assert run.stdout.strip() == "[]"
