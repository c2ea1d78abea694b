"""W of a local problem contact by contact: blocks m x m in compressed rows, and the pattern by which they are factorised."""

from __future__ import annotations

import numpy as np

from masonry_cd.mechanics.friction.local_operators import LocalArrays
from masonry_cd.mechanics.friction.problem import LocalProblem
from masonry_cd.mechanics.linalg.ordering import Pattern
from masonry_cd.mechanics.linalg.small_blocks import size_tuple


def block_arrays(problem: LocalProblem) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """W of a local problem in blocks: data (nnz, m, m), indices, indptr, and its diagonal blocks (C, m, m).

    Diagonal blocks that are zero are given as those of a typical contact: whatever stands there, the impulse is right when it stays.
    """
    m = problem.dimension
    blocks, own, scales = problem.w.tobsr((m, m)), problem.delassus_diagonal(), problem.scales()
    nothing = np.trace(own, axis1=1, axis2=2) < 0.5 * m * scales
    own[nothing] = scales[nothing, None, None] * np.eye(m)
    return (
        np.ascontiguousarray(blocks.data, dtype=np.float64),
        blocks.indices.astype(np.int64),
        blocks.indptr.astype(np.int64),
        own,
    )


def contact_pattern(indices: np.ndarray, indptr: np.ndarray) -> Pattern:
    """The pattern of W, contact by contact."""
    count = len(indptr) - 1
    return Pattern.of(count, np.repeat(np.arange(count), np.diff(indptr)), indices, in_subtrees=False)


def local_arrays(problem: LocalProblem) -> tuple[LocalArrays, np.ndarray]:
    """A local problem as the kernels take it, eliminated contact by contact in order, and the diagonal blocks of :func:`block_arrays`."""
    blocks, indices, indptr, own = block_arrays(problem)
    place, size = np.arange(problem.contacts), size_tuple(problem.dimension)
    none = np.empty((0, problem.dimension))
    return LocalArrays(blocks, indices, indptr, problem.q, problem.mu, none, problem.scales(), place, size), own


def in_elimination_order(given: LocalArrays) -> tuple[LocalArrays, Pattern]:
    """A local problem with its contacts placed in an order of elimination with little fill-in, and the pattern of W in that order."""
    pattern = contact_pattern(given.indices, given.indptr)
    return given._replace(place=pattern.place), pattern
