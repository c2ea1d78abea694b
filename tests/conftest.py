# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures that several test modules use."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from block_files import cuboid
from hypothesis import settings
from places import SHARED
from tiers import (  # noqa: F401  hooks of pytest
    pytest_addoption,
    pytest_collection_modifyitems,
    pytest_runtest_call,
    pytest_runtest_makereport,
    pytest_runtest_setup,
    pytest_runtest_teardown,
    pytest_terminal_summary,
)

from masonry_cd.foundation.trust import VARIABLE

settings.register_profile("steady", derandomize=True, deadline=None, max_examples=50, database=None)  # the same examples in every run
settings.register_profile("search", deadline=None, max_examples=2000, database=None)  # pytest tests/properties --hypothesis-profile search
settings.load_profile("steady")


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder of reference data beside the checkout; tests that need it skip where it is absent."""
    folder = SHARED
    if not folder.is_dir():
        pytest.skip("the reference data are not beside this checkout")
    return folder


@pytest.fixture
def trusting(monkeypatch: pytest.MonkeyPatch) -> None:
    """Code that scenes name may run, as by --trust."""
    monkeypatch.setenv(VARIABLE, "1")


@pytest.fixture
def block_on_plate(tmp_path: Path) -> Callable[..., Path]:
    """Writes a scene of one block on a plate shaken along x, C = 0.2 m/s at 2 Hz for one cycle; keys are replaced by name."""

    def write(**lines: str) -> Path:
        plate = cuboid((-2.0, -1.0, -0.5), (2.0, 1.0, 0.0)) | {"name": "plate", "fixed": True, "group": "base"}
        block = cuboid((-0.5, -0.25, 0.0), (0.5, 0.25, 0.4)) | {"name": "block", "group": "block"}
        (tmp_path / "blocks.json").write_text(json.dumps({"units": "m", "blocks": [plate, block]}))
        keys = {
            "title": 'title = "Block on a plate"',
            "path": 'path = "blocks.json"',
            "density": "density = 2000.0",
            "friction": "friction = 0.0",
            "amplitude": "amplitude = 0.2",
            "dt": "dt = 1e-3",
            "duration": "duration = 0.5",
            "solver": 'solver = "nlgs"',
            "report": "",
        } | lines
        text = """\
{title}
[structure]
kind = "file"
{path}
[material]
{density}
{friction}
[[loads]]
kind = "sinusoidal"
direction = "x"
{amplitude}
frequency = 2.0
cycles = 1
[run]
{dt}
{duration}
{solver}
{report}
"""
        scene = tmp_path / "scene.toml"
        scene.write_text(text.format(**keys))
        return scene

    return write
