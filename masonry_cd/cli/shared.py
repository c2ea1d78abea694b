# SPDX-License-Identifier: GPL-3.0-or-later
"""What the commands share: arguments of the same name and meaning, and how errors are reported."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.progress import Interrupted


def _trust(given: bool) -> bool:
    """Take note of --trust, or that it is not given."""
    from masonry_cd.foundation.trust import trust

    trust(given)
    return given


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).", show_default=False)]
Output = Annotated[Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for the results; made if need be.", show_default=False)]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change the scene: run.dt=1e-3, loads[0].amplitude=0.3. As often as needed."),
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run.", show_default=False)]
Force = Annotated[
    bool,
    typer.Option("--force", help="Overwrite results that DIR already holds; files that masonry-cd did not write stay, and are refused."),
]
Trust = Annotated[
    bool,
    typer.Option(
        "--trust", help="Run code that the scene names: files of Python, programs of gmsh (.geo).", callback=_trust, show_default=False
    ),
]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but warnings and errors.")]


def exclude(first: tuple[str, object], second: tuple[str, object]) -> None:
    """Refuse two options that contradict each other, each a name and what was given."""
    from masonry_cd.foundation.errors import InputError

    if first[1] and second[1]:
        raise InputError(f"{first[0]} and {second[0]} exclude each other", "leave one out")


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

    What numpy says of numbers that the body then refuses helps no user beside that line. Of a body that is done each such warning has a
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
