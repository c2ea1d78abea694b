# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line in this process, and what it was refused for."""

from __future__ import annotations

import sys
from functools import cache
from unittest import mock

from typer import main, testing
from typer.testing import CliRunner, Result

from masonry_cd.cli.app import app
from masonry_cd.foundation.errors import InputError

commands = cache(main.get_command)  # typer makes all commands again for each line, which takes longer than most of them


def masonry_cd(*words: object) -> Result:
    """The result of a command line."""
    typed = [str(word) for word in words]
    with mock.patch.object(sys, "argv", ["masonry-cd", *typed]), mock.patch.object(testing, "_get_command", commands):
        return CliRunner().invoke(app, typed)


def done(*words: object) -> Result:
    """The result of a command line, which has to end well."""
    result = masonry_cd(*words)
    assert result.exit_code == 0, result.output
    return result


def refusal(result: Result) -> InputError:
    """The fault for which a command was refused, which it printed, alone, before it ended with exit code 2."""
    error: BaseException | None = result.exception
    while error is not None and not isinstance(error, InputError):
        error = error.__context__
    assert error is not None, result.output
    assert result.exit_code == 2
    assert result.stderr.endswith(f"masonry-cd: error: {error}\n")
    return error
