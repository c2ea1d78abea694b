"""What every solver is told."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Options:
    """Options of one solve.

    Attributes:
        tolerance: natural map error (scaled, see ``masonry_cd.friction``) at which to stop.
        max_iterations: None takes the solver's own limit.
        seed: of the random sweep order.
        threads: for the solvers that can use more than one.
    """

    tolerance: float = 1e-8
    max_iterations: int | None = None
    seed: int = 0
    threads: int = 1
