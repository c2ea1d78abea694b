# SPDX-License-Identifier: GPL-3.0-or-later
"""A set of records for a site, as ``masonry-cd select`` chooses it."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.interface.returned import returned


def select_records(
    source: str | os.PathLike[str] | Mapping[str, Any], folder: str | os.PathLike[str] | None = None, *, force: bool = False
) -> dict[str, Any]:
    """Choose from a folder of records a set whose spectra match that of a site in their mean and, if requested, their scatter.

    Args:
        source: a selection file; or a dict with its tables, whose paths begin in the working folder.
        folder: where selected.toml, selection.csv, selection.json and the picture are written; nowhere by default.
        force: overwrite what the folder holds.

    Returns:
        what selection.json holds, ``motions`` with their ``factor`` and ``misfit``, ``fit``, ``en_1998_1``, ``left_out`` and ``spectra``
        among it; and ``records``, the table ``[records]`` for :func:`masonry_cd.study`.

    Raises:
        InputError: a wrong key, no records, too few that may be chosen, a folder that holds results.
    """
    from masonry_cd.app.scene import Origin
    from masonry_cd.studies.selection.command import select
    from masonry_cd.studies.selection.tables import read_selection, selection_of

    if isinstance(source, Mapping):
        selection = selection_of(source, Path.cwd() / "selection", Origin("", Path("selection")))
    else:
        selection = read_selection(Path(source))
    return returned(select(selection, None if folder is None else Path(folder), force))
