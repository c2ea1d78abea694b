# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd schema``: the JSON schema of the scene file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.app.result import Result
from masonry_cd.foundation.atomic import replacing


def schema(
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE", help="Write it to a file instead of printing it.")
    ] = None,
    plan: Annotated[bool, typer.Option("--plan", help="Schema of a building's plan, plan.json.")] = False,
) -> Result[str]:
    """Print the JSON schema of the scene file, or of a plan, for completion and checks in editors.

    Taplo and Even Better TOML read it where the first line of a scene names it: #:schema ./masonry-cd.schema.json

    \b
    Examples:
      masonry-cd schema -o masonry-cd.schema.json
      masonry-cd schema --plan -o plan.schema.json
    """
    from masonry_cd.app.scene_schema import plan_schema_text, schema_text

    text = plan_schema_text() if plan else schema_text()
    if output is None:
        return Result(text, [text.removesuffix("\n")])
    with replacing(output) as part:
        part.write_text(text, encoding="utf-8")
    return Result(text, written=[output])
