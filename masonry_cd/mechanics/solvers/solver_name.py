# SPDX-License-Identifier: GPL-3.0-or-later
"""The name of a solver as a key of a scene, checked without loading the solver; one that a package adds is imported."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import AfterValidator, Field

from masonry_cd.mechanics.solvers import SOLVERS
from masonry_cd.mechanics.solvers.by_name import every_solver, is_solver, solver_named


def _is_known(name: str) -> str:
    """Refuse a name that is not a solver's, or that of a package which cannot be used."""
    if name in SOLVERS:
        return name
    if not is_solver(name):
        *names, last = (f"'{known}'" for known in every_solver())
        raise ValueError(f"input should be {', '.join(names)} or {last}")
    solver_named(name)
    return name


def _names(schema: dict[str, Any]) -> None:
    """Put the names of solvers into the JSON schema of such a key."""
    schema["enum"] = [*every_solver()]


SolverName = Annotated[str, AfterValidator(_is_known), Field(json_schema_extra=_names)]
