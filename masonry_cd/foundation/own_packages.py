# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that ``structures``, ``loads`` and ``reports`` are this program's: a file of such a name next to a script would hide them."""

from __future__ import annotations

import sys
from importlib.util import find_spec
from pathlib import Path

from masonry_cd.foundation.errors import InputError

PACKAGES = ("structures", "loads", "reports")
HOME = Path(__file__).resolve().parents[2]  # the folder that holds masonry_cd and the packages next to it


def require_own_packages() -> None:
    """Check where Python finds the packages next to masonry_cd; nothing is imported.

    Raises:
        InputError: names the file that hides one, and the remedy.
    """
    for name in PACKAGES:
        place = _place(name)
        if place is None:
            raise InputError(f'the package "{name}" of masonry_cd is missing in {HOME}', "install masonry-cd again")
        if place.resolve() not in (HOME / name / "__init__.py", HOME / name):
            remedy = f"rename it, or run from another folder, so that Python finds {HOME / name}"
            raise InputError(f'{place} hides the package "{name}" of masonry_cd', str(remedy))


def _place(name: str) -> Path | None:
    """The file from which a package is imported, or has been; None where there is none."""
    module = sys.modules.get(name)
    if module is not None:
        file = getattr(module, "__file__", None)
        return Path(file) if file else None
    spec = find_spec(name)
    if spec is None:
        return None
    if spec.origin:
        return Path(spec.origin)
    return Path(next(iter(spec.submodule_search_locations or [""])))  # a folder without __init__.py
