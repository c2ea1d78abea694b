# SPDX-License-Identifier: GPL-3.0-or-later
"""What numpy says of numbers is not hidden: a line each where a command is done, and nothing beside the line of a refusal."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
import typer

from masonry_cd.cli.printing import errors_reported
from masonry_cd.foundation.errors import InputError


def test_a_warning_that_was_not_expected_is_one_line(capsys):
    with errors_reported():
        for _ in range(3):
            np.array([1e308]) * 10.0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("masonry-cd: warning: overflow encountered in multiply (test_numeric_warnings.py, line ")


def test_one_that_is_named_at_its_place_is_none(capsys):
    with errors_reported(), np.errstate(over="ignore"):
        np.array([1e308]) * 10.0
    assert capsys.readouterr().err == ""


def test_beside_a_refusal_it_says_nothing(capsys):
    with pytest.raises(typer.Exit) as ended, errors_reported():
        np.array([1e308]) * 10.0
        raise InputError("material.density", "not finite")
    assert ended.value.exit_code == 2
    assert capsys.readouterr().err == "masonry-cd: error: material.density: not finite\n"


def test_other_warnings_pass():
    with pytest.warns(UserWarning, match="of another kind"), errors_reported():
        warnings.warn("of another kind", UserWarning, stacklevel=1)
