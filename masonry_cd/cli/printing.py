# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints the result of a command, whichever it is, or its error, and sets the exit code."""

from __future__ import annotations

import functools
import shlex
import sys
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import Any

import typer

from masonry_cd.app.progress import Interrupted
from masonry_cd.app.result import Result

# commands that continue what was interrupted, and by which option
CONTINUED = {"run": ("--resume",), "limit": ("--resume",), "study": (), "assess": (), "calibrate": ()}


def printed(command: Callable[..., Result[Any]]) -> Callable[..., None]:
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
    typer.echo(f"masonry-cd: continue with: {shlex.join(['masonry-cd', *words])}", err=True)


def warn(lines: Iterable[str]) -> None:
    """Print warnings, a line each."""
    for line in lines:
        typer.echo(f"masonry-cd: warning: {line}", err=True)


@contextmanager
def _numeric_warnings() -> Iterator[list[str]]:
    """Collect what numpy and its like say of numbers, once for each place; other warnings pass."""
    met: list[str] = []
    with warnings.catch_warnings():
        warnings.filterwarnings("default", category=RuntimeWarning)
        passed = warnings.showwarning

        def show(message: Warning | str, category: type[Warning], filename: str, lineno: int, *more: Any) -> None:
            if issubclass(category, RuntimeWarning):
                met.append(f"{message} ({Path(filename).name}, line {lineno}): results may be affected, please report it")
            else:
                passed(message, category, filename, lineno, *more)

        warnings.showwarning = show  # type: ignore[assignment]
        yield met


@contextmanager
def errors_reported() -> Iterator[None]:
    """Report errors of the body in one line and set the exit code.

    What numpy says of numbers that the body then refuses helps no user next to that line. Of a body that is done each such warning has a
    line: it was not expected, or it were named where it comes up.
    """
    from masonry_cd.foundation.errors import InputError, in_plain_words
    from masonry_cd.foundation.extras import missing

    try:
        with _numeric_warnings() as met:
            yield
        warn(met)
    except InputError as error:
        typer.echo(f"masonry-cd: error: {error}", err=True)
        raise typer.Exit(2) from None
    except ModuleNotFoundError as failure:
        line = missing(failure)
        if line is None:
            raise
        typer.echo(f"masonry-cd: error: {line}", err=True)
        raise typer.Exit(2) from None
    except OSError as error:
        typer.echo(f"masonry-cd: error: {in_plain_words(error)}", err=True)
        raise typer.Exit(1) from None
    except MemoryError as error:
        typer.echo(f"masonry-cd: error: not enough memory: {error}", err=True)
        raise typer.Exit(1) from None
    except Interrupted as asked:
        typer.echo(f"masonry-cd: {asked}", err=True)
        raise typer.Exit(128 + asked.number) from None
    except KeyboardInterrupt:
        typer.echo("masonry-cd: interrupted", err=True)
        raise typer.Exit(130) from None
