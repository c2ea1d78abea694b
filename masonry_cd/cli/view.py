# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd view``: the page of a run or a study in the browser."""

from __future__ import annotations

from typing import Any

from masonry_cd.app.result import Result
from masonry_cd.cli.shared import Folder


def view(folder: Folder) -> Result[Any]:
    """Open the page of a run (report.html) or of a study (study.html) in the browser.

    Without a display, the path of the page is printed.

    \b
    Examples:
      masonry-cd view out/aqueduct
    """
    from masonry_cd.app.commands.view import view as command

    return command(folder)
