# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd validate``: a test of a laboratory, or another program's result, repeated."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result, said
from masonry_cd.cli.shared import Force, Quiet


def _names(begun: str) -> list[str]:
    """The cases whose names begin like this, for the shell."""
    from masonry_cd.studies.laboratory.cases import CASES

    return [name for name in CASES if name.startswith(begun)]


def validate(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="NAME", help="Name of the case; without it the cases are listed.", show_default=False, autocompletion=_names
        ),
    ] = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="DIR", help="Folder for scenes and results.", show_default="validation/NAME")
    ] = None,
    force: Force = False,
    quiet: Quiet = False,
) -> Result[Any]:
    """Repeat a case of the laboratory page: its scenes, runs, table and curves, compared with measurements.

    DIR gets a folder for each scene with scene.toml, blocks.json and the results of its run, table.json with measured and computed values,
    and curves.svg. The scenes are good to start from; none of their values is fitted to the measurements.

    \b
    Examples:
      masonry-cd validate
      masonry-cd validate bed -o out/bed
    """
    from masonry_cd.app.folders import free_folder
    from masonry_cd.studies.laboratory.cases import CASES
    from masonry_cd.studies.laboratory.validate import FIGURE, TABLE, case_named
    from masonry_cd.studies.laboratory.validate import validate as repeat

    if name is None:
        return Result(None, [f"{case.name}: {case.title} ({case.source})" for case in CASES.values()])
    folder = output or Path("validation") / case_named(name).name
    free_folder(folder, (TABLE, FIGURE), force)
    return repeat(name, folder, said(not quiet))
