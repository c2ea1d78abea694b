# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal companions of a scene: the bonded elastic continuum, and rigid blocks on elastic joints."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.interface.returned import returned
from masonry_cd.interface.scenes import Scene, scene


def modal(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any],
    folder: str | os.PathLike[str] | None = None,
    *,
    force: bool = False,
    **options: Any,
) -> dict[str, Any]:
    """Modal frequencies and shapes, as ``masonry-cd modal`` computes them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of.
        folder: where tables and pictures are written; nowhere by default.
        force: overwrite what the folder holds.
        options: young [Pa], one value or by group of blocks, poisson, method ("continuum", "joints" or "both"), modes, mesh_size [m],
            restraint, reference, fit, pictures; ambient and sensors, the files of an ambient record, lowest and highest [Hz].

    Returns:
        what modal.json holds: ``models`` by method, with ``frequency_hz``, ``participation`` and so on.

    Raises:
        InputError: a wrong option, scene, or file of measured modes or of an ambient record.

    >>> import masonry_cd as mc
    >>> made = mc.modal("examples/trilithon.toml", young=3e9, method="joints", modes=2)
    >>> len(made["models"]["joints"]["frequency_hz"])
    2
    """
    from masonry_cd.app.commands.modal import modal as command

    asked = scene(source)  # which holds the files of its arrays
    return returned(command(asked.checked, options, None if folder is None else Path(folder), force))
