"""Solvers of the friction problem, exchangeable by name: ``SOLVERS[name](problem, options, start) -> Solution``.

A solver is a module here that defines ``solve``, and goes by the module's name. It is imported when it is asked for, so that a scene
can be checked before numba is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Annotated, TypeAlias

from pydantic import AfterValidator

from masonry_cd.extensions import Extensions
from masonry_cd.solvers.options import Options, cores

if TYPE_CHECKING:
    from masonry_cd.friction.problem import Problem, Solution

Solver: TypeAlias = "Callable[[Problem, Options, Solution | None], Solution]"

SOLVERS: Extensions[Solver] = Extensions("masonry_cd.solvers", "solve")


def _is_known(name: str) -> str:
    """Refuse a name that is no solver's."""
    if name not in SOLVERS:
        *names, last = (f"'{known}'" for known in SOLVERS)
        raise ValueError(f"input should be {', '.join(names)} or {last}")
    return name


SolverName = Annotated[str, AfterValidator(_is_known)]

__all__ = ["SOLVERS", "Options", "Solver", "SolverName", "cores"]
