"""Solvers of the friction problem, exchangeable by name: ``SOLVERS[name](problem, options, start) -> Solution``."""

from __future__ import annotations

from collections.abc import Callable

from masonry_cd.friction.problem import Problem, Solution
from masonry_cd.solvers import admm, auto, interior, newton, nlgs
from masonry_cd.solvers.options import Options, cores

Solver = Callable[[Problem, Options, Solution | None], Solution]

SOLVERS: dict[str, Solver] = {
    "admm": admm.solve,
    "auto": auto.solve,
    "interior": interior.solve,
    "newton": newton.solve,
    "nlgs": nlgs.solve,
}

__all__ = ["SOLVERS", "Options", "Solver", "cores"]
