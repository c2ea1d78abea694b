# SPDX-License-Identifier: GPL-3.0-or-later
"""The examples in the docstrings of the interface run, and print what they say."""

from __future__ import annotations

import doctest
from importlib import import_module

import pytest
from places import ROOT

MODULES = sorted(path.stem for path in (ROOT / "masonry_cd" / "interface").glob("*.py"))
WITH_EXAMPLES = {
    "assessing",
    "comparison",
    "limit",
    "macro",
    "modal",
    "results",
    "run_stress",
    "running",
    "scenes",
    "simulation",
    "studies",
}


@pytest.mark.parametrize("name", MODULES)
def test_examples(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)  # where the scenes of the examples lie
    found = doctest.testmod(import_module(f"masonry_cd.interface.{name}"))
    assert found.failed == 0
    assert (found.attempted > 0) == (name in WITH_EXAMPLES)
