# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd plugins``: what installed packages add."""

from __future__ import annotations

from masonry_cd.app.result import Result


def plugins() -> Result[None]:
    """List what installed packages add: kinds of structures and loads, readers of records, reports, mechanisms, joint laws, solvers.

    Prints a line for each: its type, its name in a scene, the package, and its place in the package. None is imported.

    \b
    Examples:
      masonry-cd plugins
    """
    from masonry_cd.foundation.plugins import plugins as found

    lines = [f"{one.group.removesuffix('s').replace('_', ' ')} {one.name}: {one.package}, {one.place}" for one in found()]
    return Result(None, lines or ["no installed package adds anything; see docs/plugins.md"])
