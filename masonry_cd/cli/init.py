# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd init``: a starter scene."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.result import Result


def _kinds(begun: str) -> list[str]:
    """The kinds of structure whose names begin like this, for the shell."""
    from structures import KINDS

    return [kind for kind in KINDS if kind.startswith(begun)]


def init(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", help="Kind of structure: arch, wall, church ...", show_default=False, autocompletion=_kinds)
    ],
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="SCENE", help="The scene file.", show_default="KIND.toml")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Overwrite files that are there.")] = False,
) -> Result[None]:
    """Write a starter scene of a kind of structure, which runs as it is.

    It names every key with its unit and default; those that a first scene needs are set. masonry-cd.schema.json next to it is for
    editors, and the kinds file and solid get a small file of blocks. That of solid is a program of gmsh, so its scene runs with --trust.

    \b
    Examples:
      masonry-cd init arch
      masonry-cd init church -o scenes/church.toml
    """
    from masonry_cd.app.starters import write_starter
    from structures import kind_of

    remark = kind_of(kind).remark
    return Result(None, [remark] if remark else [], written=write_starter(kind, output or Path(f"{kind}.toml"), force))
