# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal companions of a scene: the bonded elastic continuum, and rigid blocks on elastic joints."""

from __future__ import annotations

import os
import warnings
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from masonry_cd.interface.running import RunWarning
from masonry_cd.interface.scenes import Scene, scene


def modal(
    source: Scene | str | os.PathLike[str] | Mapping[str, Any], folder: str | os.PathLike[str] | None = None, **options: Any
) -> dict[str, Any]:
    """Modal frequencies and shapes, as ``masonry-cd modal`` computes them.

    Args:
        source: a scene, or what :func:`masonry_cd.scene` makes one of.
        folder: where tables and pictures are written; nowhere by default.
        options: young [Pa], one value or by group of blocks, poisson, method ("continuum", "joints" or "both"), modes, mesh_size [m],
            restraint, reference, fit, pictures.

    Returns:
        what modal.json holds: ``models`` by method, with ``frequency_hz``, ``participation`` and so on.

    Raises:
        InputError: a wrong option, scene, or file of measured modes.

    >>> import masonry_cd as mc
    >>> made = mc.modal("examples/trilithon.toml", young=3e9, method="joints", modes=2)
    >>> len(made["models"]["joints"]["frequency_hz"])
    2
    """
    from masonry_cd.app.modal_case import modal_case

    asked = scene(source)  # which holds the files of its arrays
    found = modal_case(asked.checked, options, None if folder is None else Path(folder))
    for line in found["warnings"]:
        warnings.warn(line, RunWarning, stacklevel=2)
    return found
