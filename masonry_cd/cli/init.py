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
    force: Annotated[bool, typer.Option("--force", help="Overwrite existing files.")] = False,
) -> Result[None]:
    """Write a starter scene for a kind of structure, ready to run.

    The scene lists every key with its unit and default, and sets those that a first run needs. masonry-cd.schema.json is written next to it
    for editors; the kinds file and solid also get a small file of blocks. That of solid is a gmsh program, so its scene needs --trust.

    \b
    Examples:
      masonry-cd init arch
      masonry-cd init church -o scenes/church.toml
    """
    from masonry_cd.app.starters import write_starter
    from structures import kind_of

    remark = kind_of(kind).remark
    return Result(None, [remark] if remark else [], written=write_starter(kind, output or Path(f"{kind}.toml"), force))
