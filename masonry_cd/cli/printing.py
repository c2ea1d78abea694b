# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints the result of a command, whichever it is, and sets the exit code."""

from __future__ import annotations

import functools
import shlex
import sys
from collections.abc import Callable
from contextlib import nullcontext, suppress
from typing import Any

import typer

from masonry_cd.app.progress import Interrupted
from masonry_cd.app.result import Result
from masonry_cd.cli.shared import errors_reported, warn

CONTINUED = {"run": ("--resume",), "study": (), "assess": ()}  # commands that continue what was interrupted, and by which option


def printed(command: Callable[..., Result[Any] | None]) -> Callable[..., None]:
    """A command that prints its result instead of returning it.

    Lines and the names of files go to standard output, unless the option ``quiet`` is given, warnings to standard error. The exit code is
    1, or 128 and the number of the signal, where the result was stopped.
    """

    @functools.wraps(command)
    def shown(**given: Any) -> None:
        with errors_reported():
            try:
                result = command(**given)
            except Interrupted:
                if command.__name__ in CONTINUED:
                    _print_how_to_continue(command.__name__)
                raise
            if result is None:  # (until all commands return one)
                return
            with suppress(OSError) if result.signal else nullcontext():  # the terminal may be what ended the command
                _print(result, given.get("quiet", False))
                if result.resumable:
                    _print_how_to_continue(command.__name__)
        if result.stopped:
            raise typer.Exit(128 + result.signal if result.signal else 1)

    return shown


def _print(result: Result[Any], quiet: bool) -> None:
    """Print a result."""
    written = [f"written: {', '.join(map(str, result.written))}"] if result.written else []
    if not quiet and (result.lines or written):
        typer.echo("\n".join([*result.lines, *written]))
    warn(result.warnings)


def _print_how_to_continue(name: str) -> None:
    """Print the command line by which a command continues."""
    words = [word for word in sys.argv[1:] if word != "--force"]
    words += [word for word in CONTINUED.get(name, ()) if word not in words]
    typer.echo(f"masonry-cd: go on with: {shlex.join(['masonry-cd', *words])}", err=True)
