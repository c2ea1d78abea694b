# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd plugins``: what installed packages add."""

from __future__ import annotations

import typer

from masonry_cd.cli.shared import errors_reported


def plugins() -> None:
    """List what installed packages add: kinds of structures and loads, readers of records, reports, mechanisms, joint laws.

    None of them is imported. A line for each: what it is, its name in a scene, the package, and where it stands there.

    \b
    Examples:
      masonry-cd plugins
    """
    with errors_reported():
        from masonry_cd.foundation.plugins import plugins as found

        every = found()
        if not every:
            typer.echo("no installed package adds anything; docs/plugins.md shows how one does")
        for plugin in every:
            typer.echo(f"{plugin.group.removesuffix('s').replace('_', ' ')} {plugin.name}: {plugin.package}, {plugin.place}")
