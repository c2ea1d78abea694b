# SPDX-License-Identifier: GPL-3.0-or-later
"""The name of a solver as a key of a scene, checked without loading the solver."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from masonry_cd.mechanics.solvers import SOLVERS


def _is_known(name: str) -> str:
    """Refuse a name that is no solver's."""
    if name not in SOLVERS:
        *names, last = (f"'{known}'" for known in SOLVERS)
        raise ValueError(f"input should be {', '.join(names)} or {last}")
    return name


def _names(schema: dict[str, Any]) -> None:
    """What the JSON schema says of such a key."""
    schema["enum"] = [*SOLVERS]


SolverName = Annotated[str, AfterValidator(_is_known), Field(json_schema_extra=_names)]
