# SPDX-License-Identifier: GPL-3.0-or-later
"""Arguments that several commands have, of the same name and meaning."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def _trust(given: bool) -> bool:
    """Take note of --trust, or that it is not given."""
    from masonry_cd.foundation.trust import trust

    trust(given)
    return given


SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).", show_default=False)]
Output = Annotated[
    Path, typer.Option("-o", "--output", metavar="DIR", help="Folder for the results; created if missing.", show_default=False)
]
Changes = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Change the scene: run.dt=1e-3, loads[0].amplitude=0.3. Repeatable."),
]
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="Folder of a run.", show_default=False)]
Force = Annotated[
    bool,
    typer.Option("--force", help="Overwrite the results in DIR; files that masonry-cd did not write are an error and stay."),
]
Trust = Annotated[
    bool,
    typer.Option("--trust", help="Run code that the scene names: Python files, gmsh programs (.geo).", callback=_trust, show_default=False),
]
Workers = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Processes on this machine.", show_default="run.workers, or all cores")
]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Address of a running dask scheduler: tcp://host:8786.")]
Slurm = Annotated[Path | None, typer.Option(metavar="CONFIG", help="Start workers as Slurm jobs, as this file (TOML) describes.")]
Retry = Annotated[bool, typer.Option("--retry", help="Repeat runs that failed or timed out.")]
Planned = Annotated[bool, typer.Option("--plan", help="Check the input and print the number of runs, without running them.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print only warnings and errors.")]


def exclude(first: tuple[str, object], second: tuple[str, object]) -> None:
    """Refuse two options that contradict each other, each a name and what was given."""
    from masonry_cd.foundation.errors import InputError

    if first[1] and second[1]:
        raise InputError(f"{first[0]} and {second[0]}", "they exclude each other; leave one out")
