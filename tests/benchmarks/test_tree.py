# SPDX-License-Identifier: GPL-3.0-or-later
"""The rules of the house that can be counted hold: benchmarks.tree counts them."""

from __future__ import annotations

import pytest
from places import ROOT

from benchmarks.tree import private_names, table

MODULE = """
import os
from package import shown, _hidden
from package import __version__
package._kernel(self._own, os._exit)
monkeypatch.setattr(package, "_constant", 1)
"""


def test_private_names_are_found() -> None:
    """Imported, as attributes, or set by name; what a class keeps for itself and what Python calls public do not count."""
    assert sorted(private_names(MODULE)) == ["_constant", "_hidden", "_kernel"]


@pytest.mark.slow(reason="reads every file of the tree")
def test_the_rules_hold_here() -> None:
    """Files under 400 lines, kernels of at most ten arguments, no import cycle, no test that reaches into private functions."""
    rows = dict(line.strip("| ").split(" | ") for line in table(ROOT)[2:] if line.startswith("| "))
    assert {name: rows[name] for name in rows if name.startswith(("files of the program over", "kernels", "import cycles", "private"))} == {
        "files of the program over 400 lines": "0",
        "kernels over 10 arguments": "0",
        "import cycles": "0",
        "private names used by tests": "0",
    }
