# SPDX-License-Identifier: GPL-3.0-or-later
"""Solvers of the friction problem, exchangeable by name: ``SOLVERS[name](problem, options, start) -> Solution``.

A solver is a module here that defines ``solve``, and has the module's name. It is imported on first use, so that a scene
can be checked before numba is loaded.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

from masonry_cd.foundation.extensions import Extensions
from masonry_cd.mechanics.solvers.options import Options, cores, threads_that_pay

if TYPE_CHECKING:
    from masonry_cd.mechanics.friction.problem import Problem, Solution

Solver: TypeAlias = "Callable[[Problem, Options, Solution | None], Solution]"

SOLVERS: Extensions[Solver] = Extensions("masonry_cd.mechanics.solvers", "solve")


__all__ = ["SOLVERS", "Options", "Solver", "cores", "threads_that_pay"]
