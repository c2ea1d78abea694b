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
Workers = Annotated[
    int | None, typer.Option(metavar="N", min=1, help="Processes of this machine.", show_default="run.workers, or all cores")
]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Of a dask scheduler that runs: tcp://host:8786.")]
Slurm = Annotated[Path | None, typer.Option(metavar="CONFIG", help="Workers as jobs of Slurm, by this file (TOML).")]
Retry = Annotated[bool, typer.Option("--retry", help="Make runs again that failed or timed out.")]
Planned = Annotated[bool, typer.Option("--plan", help="Check everything, say how many runs there are, and make none.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Say nothing but warnings and errors.")]


def exclude(first: tuple[str, object], second: tuple[str, object]) -> None:
    """Refuse two options that contradict each other, each a name and what was given."""
    from masonry_cd.foundation.errors import InputError

    if first[1] and second[1]:
        raise InputError(f"{first[0]} and {second[0]}", "they exclude each other; leave one out")
