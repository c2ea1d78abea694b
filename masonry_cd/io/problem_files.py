# SPDX-License-Identifier: GPL-3.0-or-later
r"""Friction problems in files: the field's FCLIB format (HDF5) and a plain .npz, read, checked and written.

A local problem holds W, q and mu: u = W r + q. A global one holds M, H, f, w and mu: M v = H r + f, u = H^T v + w, so that W = H^T M^-1 H
and q = H^T M^-1 f + w. Rows come as (n, t1, t2) per contact; the impulses are called r there, p elsewhere in this program. ContactBench's
own .npz (G, g, mus) holds W and q by rows (t1, t2, n). Format and collection: Acary, Bremond, Huber & Perignon, "FCLIB: a collection of
discrete 3D frictional contact problems", 2014.

A global problem whose M has one block per body, and whose contacts touch two bodies at most, is read as a problem over bodies. Elastic
contacts: a global problem in .npz holds the diagonal C of their compliance as well, u = H^T v + C r + w; the W next to it, as that of
every local problem, contains it. FCLIB has a place for it in local problems only. Sparse matrices in FCLIB follow CSparse: ``nz`` counts
the entries of a list of triplets, -1 says compressed columns, -2 compressed rows.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import h5py
import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import splu

from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.files import is_file
from masonry_cd.io.stored_arrays import datasets, npz_arrays, open_hdf5
from masonry_cd.mechanics.friction.contact_geometry import Geometry
from masonry_cd.mechanics.friction.coupling import is_definite
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Problem
from masonry_cd.mechanics.linalg.small_blocks import inverses, size_tuple

UNSYMMETRIC = 1e-2  # of the largest entry: published problems reach 1e-3
INDEFINITE = 1e-4  # of the largest diagonal entry
LARGEST = 1e100  # entry of any array: its square is a number, and so are sums of them
HDF5 = (".hdf5", ".h5")
FORMS = {  # of FCLIB: equality constraints, which are not supported, and the matrices and vectors that are read
    "fclib_local": (("V", "R"), ("W",), ("q", "mu")),
    "fclib_global": (("G",), ("M", "H"), ("f", "w", "mu")),
}


def read_problem(path: Path | str) -> Problem:
    """Read a friction problem and check it.

    Raises:
        InputError: no such file, a format that is not known, a missing or misshapen array, NaN or infinity, negative friction, W
            unsymmetric or indefinite. The line names the file and the array.
    """
    path = Path(path)
    if not is_file(path):
        raise InputError(path, f"{'is a folder, not a friction problem' if path.is_dir() else 'no such file'}")
    if path.suffix == ".npz":
        return _read_npz(path)
    if path.suffix in HDF5:
        return _read_fclib(path)
    raise InputError(path, f'unknown format "{path.suffix}"; write .npz or FCLIB in HDF5 ({", ".join(HDF5)})')


def write_problem(path: Path | str, problem: Problem, title: str = "") -> None:
    """Write a problem: .npz with W and q (and M, H, f, w of a problem over bodies), or FCLIB HDF5, local or global.

    Raises:
        InputError: the ending of the name is neither .npz nor an HDF5 one, or a global FCLIB problem would have elastic contacts.
    """
    path = Path(path)
    if path.suffix == ".npz":
        _write_npz(path, problem)
    elif path.suffix in HDF5:
        _write_fclib(path, problem, title)
    else:
        raise InputError(path, f'unknown format "{path.suffix}"; write .npz or FCLIB in HDF5 ({", ".join(HDF5)})')


def _read_npz(path: Path) -> Problem:
    """Read the plain format."""
    arrays = npz_arrays(path)
    if {"G", "g", "mus"} <= set(arrays):
        return _read_contactbench(path, arrays)
    mu = _vector(path, arrays, "mu")
    if any(name.startswith("M_") for name in arrays):
        mass, h = (_compressed(path, arrays, name) for name in ("M", "H"))
        w = _vector(path, arrays, "w")
        compliance = _vector(path, arrays, "C") if "C" in arrays else np.zeros_like(w)
        return _global(path, mass, h, _vector(path, arrays, "f"), w, mu, compliance)
    return _local(path, _compressed(path, arrays, "W"), _vector(path, arrays, "q"), mu)


def _read_contactbench(path: Path, arrays: Mapping[str, np.ndarray]) -> LocalProblem:
    """Read a problem of ContactBench: c = G r + g, dense, with rows (t1, t2, n) per contact."""
    q, mu, w = (_vector(path, arrays, name) for name in ("g", "mus", "G"))
    if len(q) != 3 * len(mu) or len(w) != len(q) ** 2:
        raise InputError(path, f"{len(w)} entries of G and {len(q)} of g do not fit {len(mu)} of mus: 9 for each pair, 3 for each contact")
    order = np.roll(np.arange(len(q)).reshape(-1, 3), 1, axis=1).ravel()
    return _local(path, sparse.csr_matrix(w.reshape(len(q), -1)[order][:, order]), q[order], mu)


def _write_npz(path: Path, problem: Problem) -> None:
    """Write the plain format."""
    local = problem.to_local() if isinstance(problem, FrictionProblem) else problem
    matrices = {"W": local.w}
    vectors = {"q": local.q.ravel(), "mu": problem.mu}
    if isinstance(problem, FrictionProblem):
        matrices["M"], matrices["H"], vectors["f"], vectors["w"] = _global_form(problem)
        if problem.compliance.any():
            vectors["C"] = problem.compliance.ravel()
    for name, matrix in matrices.items():
        vectors |= {f"{name}_data": matrix.data, f"{name}_indices": matrix.indices, f"{name}_indptr": matrix.indptr}
    with replacing(path) as part:
        np.savez_compressed(part, allow_pickle=False, **vectors)


def _compressed(path: Path, arrays: Mapping[str, np.ndarray], name: str) -> sparse.csr_matrix:
    """A matrix in compressed rows from its three arrays."""
    data, indices, indptr = (_vector(path, arrays, f"{name}_{part}", whole=part != "data") for part in ("data", "indices", "indptr"))
    rows, last = len(indptr) - 1, int(indices.max(initial=-1)) + 1
    ordered = rows >= 0 and indptr[0] == 0 and indptr[-1] == len(data) and (np.diff(indptr) >= 0).all()
    if not ordered or len(indices) != len(data) or (indices < 0).any():
        raise InputError(path, f"{name}_indptr and {name}_indices do not describe {name}_data as compressed rows")
    columns = 3 * len(arrays["mu"]) if name == "H" else max(rows, last)
    if name == "H" and "w" in arrays:
        columns = len(arrays["w"])
    return sparse.csr_matrix((data, indices, indptr), (rows, max(columns, last)))


def _vector(path: Path, arrays: Mapping[str, np.ndarray], name: str, whole: bool = False) -> np.ndarray:
    """A one-dimensional array of finite numbers that can be squared, or of ``whole`` ones."""
    if name not in arrays:
        raise InputError(path, f"{name} is missing{suggest(name, arrays)}; the file has {', '.join(arrays) or 'nothing'}")
    out = np.asarray(arrays[name]).ravel()
    if out.dtype.kind not in "fiu":
        raise InputError(path, f"{name} should hold real numbers, not {out.dtype.name}")
    numbers = out.astype(np.float64)
    for wrong, what in (
        (~np.isfinite(numbers), "is not a finite number"),
        (np.abs(numbers) > LARGEST, "is too large to be squared"),
        ((numbers != np.floor(numbers)) & whole, "is not a whole number"),
    ):
        if wrong.any():
            raise InputError(path, f"{name}[{int(np.argmax(wrong))}] {what}")
    return out.astype(np.int64) if whole else numbers


# --- FCLIB ----------------------------------------------------------------------------------------------------------------------


def _read_fclib(path: Path) -> Problem:
    """Read a local or global problem of the FCLIB format."""
    with open_hdf5(path) as file:
        form = next((name for name in FORMS if isinstance(file.get(name), h5py.Group)), None)
        if form is None:
            _refuse_other_kinds(path, file)
            raise InputError(path, "an HDF5 file, but not an FCLIB file: it has neither fclib_local nor fclib_global")
        group, (equalities, matrices, vectors) = file[form], FORMS[form]
        _refuse_equalities(path, group, equalities)
        whole = datasets(group)
        matrix = {name: _fclib_matrix(path, group, name) for name in matrices}
        vector = {name: _fclib_vector(path, group, name) for name in vectors}
    mu = vector["mu"]
    if form == "fclib_local":
        return _of_dimension(path, whole, _local(path, matrix["W"], vector["q"], mu))
    f, w = vector["f"], vector["w"]
    return _of_dimension(path, whole, _global(path, matrix["M"], matrix["H"], f, w, mu, np.zeros_like(w)))


def _refuse_other_kinds(path: Path, file: h5py.File) -> None:
    """Name what else the format has: contacts that resist rolling, and what a later version may bring."""
    for name in file:
        if name.startswith("fclib_") and isinstance(file[name], h5py.Group):
            what = "contacts that resist rolling" if name.endswith("_rolling") else "problems of this kind"
            raise InputError(path, f"{name}: {what} are not supported; {' and '.join(FORMS)} are")


def _of_dimension(path: Path, found: Mapping[str, np.ndarray], problem: Problem) -> Problem:
    """The problem, if it has as many rows per contact as the file says."""
    if "spacedim" in found and problem.contacts and (said := _count(path, found, "spacedim")) != problem.dimension:
        raise InputError(path, f"spacedim is {said}, but its arrays hold {problem.dimension} rows per contact")
    return problem


def _refuse_equalities(path: Path, group: h5py.Group, names: tuple[str, ...]) -> None:
    """Problems with equality constraints are not supported."""
    for name in names:
        if name in group:
            raise InputError(path, f"{group.name[1:]}/{name}: equality constraints are not supported")


def _count(path: Path, arrays: Mapping[str, np.ndarray], name: str) -> int:
    """One whole number."""
    found = _vector(path, arrays, name, whole=True)
    if len(found) != 1:
        raise InputError(path, f"{name} should be one number, but has {len(found)} entries")
    return int(found[0])


def _fclib_vector(path: Path, group: h5py.Group, name: str) -> np.ndarray:
    """One of the vectors of a problem."""
    return _vector(path, datasets(group.get("vectors")), name)


def _fclib_matrix(path: Path, group: h5py.Group, name: str) -> sparse.csr_matrix:
    """One of the matrices of a problem: triplets, compressed columns or compressed rows."""
    where = f"{group.name[1:]}/{name}"
    if name not in group:
        raise InputError(path, f"{where} is missing")
    arrays = datasets(group[name], f"{where}/")
    rows, columns, nz = (_count(path, arrays, f"{where}/{key}") for key in ("m", "n", "nz"))
    i, p = (_vector(path, arrays, f"{where}/{key}", whole=True) for key in ("i", "p"))
    x = _vector(path, arrays, f"{where}/x")
    if nz > min(len(i), len(p), len(x)):
        raise InputError(path, f"{where}/nz states {nz} entries, more than i, p and x have")
    try:
        if nz >= 0:
            return sparse.coo_matrix((x[:nz], (i[:nz], p[:nz])), (rows, columns)).tocsr()
        compressed = (sparse.csc_matrix if nz == -1 else sparse.csr_matrix)((x, i, p), (rows, columns))
        if (np.diff(compressed.indptr) < 0).any():  # of a matrix whose last offset is 0 check_format looks at none
            raise ValueError("the offsets in p should not decrease")
        compressed.check_format(full_check=True)
        return compressed.tocsr()
    except ValueError as failure:
        raise InputError(path, f"{where}: {failure}") from None


def _write_fclib(path: Path, problem: Problem, title: str) -> None:
    """Write a problem over bodies as a global problem, one in the impulses as a local problem."""
    if isinstance(problem, FrictionProblem):
        if problem.compliance.any():
            raise InputError(path, "a global FCLIB problem cannot store elastic contacts; write .npz, or the local problem")
        mass, h, f, w = _global_form(problem)
        kind, matrices, vectors = "fclib_global", {"M": mass, "H": h}, {"f": f, "w": w}
    else:
        kind, matrices, vectors = "fclib_local", {"W": problem.w}, {"q": problem.q.ravel()}
    with h5py.File(path, "w") as file:
        group = file.create_group(kind)
        group["spacedim"] = np.array([problem.dimension], dtype=np.int32)
        for name, matrix in matrices.items():
            for key, value in zip(["m", "n", "nzmax", "nz"], (*matrix.shape, matrix.nnz, -2), strict=True):
                group[f"{name}/{key}"] = np.array([value], dtype=np.int32)
            group[f"{name}/p"], group[f"{name}/i"] = matrix.indptr.astype(np.int32), matrix.indices.astype(np.int32)
            group[f"{name}/x"] = matrix.data
        for name, vector in (vectors | {"mu": problem.mu}).items():
            group[f"vectors/{name}"] = vector
        for key, text in (("title", title or path.stem), ("description", "written by masonry-cd"), ("math_info", "")):
            group[f"info/{key}"] = text


# --- from matrices to problems -----------------------------------------------------------------------------------------------------


def _global_form(problem: FrictionProblem) -> tuple[sparse.csr_matrix, sparse.csr_matrix, np.ndarray, np.ndarray]:
    """M, H (as FCLIB has it: unknowns by rows), f = M v_free and w = b."""
    bodies, n = problem.v_free.shape
    mass = inverses(np.ascontiguousarray(problem.inverse_mass), size_tuple(n))
    blocks = sparse.bsr_matrix((mass, np.arange(bodies), np.arange(bodies + 1)), (bodies * n, bodies * n)).tocsr()
    blocks.eliminate_zeros()
    f = np.einsum("bij,bj->bi", mass, problem.v_free).ravel()
    return blocks, problem.jacobian_matrix().T.tocsr(), f, problem.offset.ravel()


def _local(path: Path, w: sparse.csr_matrix, q: np.ndarray, mu: np.ndarray) -> LocalProblem:
    """Check a local problem."""
    m = _rows_per_contact(path, "q", q, mu)
    if w.shape != (len(q), len(q)):
        raise InputError(path, f"W is {w.shape[0]} x {w.shape[1]}, q has {len(q)} entries")
    problem = LocalProblem(w, q.reshape(-1, m), mu)
    if len(mu):
        _check_definite(path, problem)
    return problem


def _rows_per_contact(path: Path, name: str, vector: np.ndarray, mu: np.ndarray) -> int:
    """2 or 3, from the lengths of mu and of a vector over the contacts."""
    if (mu < 0).any():
        raise InputError(path, f"mu[{int(np.argmax(mu < 0))}] is negative")
    if len(mu) == 0 and len(vector) == 0:
        return 3
    m = len(vector) // max(len(mu), 1)
    if m not in (2, 3) or m * len(mu) != len(vector):
        raise InputError(path, f"{name} has {len(vector)} entries, but needs 3 for each of {len(mu)} contacts (planar: 2)")
    return m


def _check_definite(path: Path, problem: LocalProblem) -> None:
    """W should be symmetric and positive semidefinite up to what published problems show."""
    w = problem.w
    if not abs(w).max() > 0:
        raise InputError(path, "W is zero")
    _check_symmetric(path, "W", w)
    shift = INDEFINITE * w.diagonal().max()
    if not shift > 0.0:
        raise InputError(path, "W is indefinite: no entry of its diagonal is positive")
    if not is_definite(w, shift):
        raise InputError(path, f"W is indefinite: it has eigenvalues below -{shift:.1e}")


def _check_symmetric(path: Path, name: str, matrix: sparse.csr_matrix) -> None:
    """A matrix should be symmetric up to what published problems show."""
    largest = abs(matrix).max() if matrix.nnz else 0.0
    skew = abs(matrix - matrix.T).max() if matrix.nnz else 0.0
    if skew > UNSYMMETRIC * largest:
        said = f"by {skew / largest:.1e} of its largest entry, at most {UNSYMMETRIC:g} may come from rounding"
        raise InputError(path, f"{name} is unsymmetric {said}")


def _global(
    path: Path, mass: sparse.csr_matrix, h: sparse.csr_matrix, f: np.ndarray, w: np.ndarray, mu: np.ndarray, compliance: np.ndarray
) -> FrictionProblem | LocalProblem:
    """Check a global problem; over bodies if it has the structure, else in the impulses."""
    m = _rows_per_contact(path, "w", w, mu)
    if mass.shape != (len(f), len(f)) or h.shape != (len(f), len(w)):
        sizes = f"M {mass.shape[0]} x {mass.shape[1]}, H {h.shape[0]} x {h.shape[1]}, f {len(f)}, w {len(w)}"
        raise InputError(path, f"shapes disagree: {sizes}")
    _check_symmetric(path, "M", mass)
    if len(compliance) != len(w):
        raise InputError(path, f"C has {len(compliance)} entries, w has {len(w)}")
    if (compliance < 0).any():
        raise InputError(path, f"C[{int(np.argmax(compliance < 0))}] is negative")
    bodies = _as_bodies(mass, h, f, w.reshape(-1, m), mu, compliance.reshape(-1, m))
    if bodies is not None:
        return bodies
    try:
        delassus, q = _eliminate(mass, h, f)
    except RuntimeError:
        raise InputError(path, "M is singular") from None
    return _local(path, delassus + sparse.diags(compliance), q + w, mu)


def _eliminate(mass: sparse.csr_matrix, h: sparse.csr_matrix, f: np.ndarray) -> tuple[sparse.csr_matrix, np.ndarray]:
    """H^T M^-1 H and H^T M^-1 f, body by body: a body is a set of unknowns that M couples, such as the nodes of a deformable block.

    Raises:
        RuntimeError: M is singular.
    """
    count, body = connected_components(mass, directed=False)
    order = np.argsort(body, kind="stable")
    ends = np.cumsum(np.bincount(body, minlength=count))
    mass, h, f = mass[order][:, order], h[order], f[order]
    rows, columns, data = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)], [np.zeros(0)]
    q = np.zeros(h.shape[1])
    for first, end in zip(np.concatenate([[0], ends[:-1]]), ends, strict=True):
        own = h[first:end]
        touched = np.unique(own.indices)
        dense = own[:, touched].toarray()
        solved = splu(mass[first:end, first:end].tocsc()).solve(np.column_stack([dense, f[first:end]]))
        rows.append(np.repeat(touched, len(touched)))
        columns.append(np.tile(touched, len(touched)))
        data.append((dense.T @ solved[:, :-1]).ravel())
        q[touched] += dense.T @ solved[:, -1]
    entries = (np.concatenate(data), (np.concatenate(rows), np.concatenate(columns)))
    return sparse.csr_matrix(entries, (h.shape[1], h.shape[1])), q


def _as_bodies(
    mass: sparse.csr_matrix, h: sparse.csr_matrix, f: np.ndarray, w: np.ndarray, mu: np.ndarray, compliance: np.ndarray
) -> FrictionProblem | None:
    """The problem over bodies of 6 (planar 3) unknowns, or of twice as many, those that deform.

    None if M couples bodies or a contact touches none or more than two.
    """
    rigid = 6 if w.shape[1] == 3 else 3
    found = (_as_bodies_of(n, mass, h, f, w, mu, compliance) for n in (rigid, 2 * rigid))
    return next((problem for problem in found if problem is not None), None)


def _as_bodies_of(
    n: int, mass: sparse.csr_matrix, h: sparse.csr_matrix, f: np.ndarray, w: np.ndarray, mu: np.ndarray, compliance: np.ndarray
) -> FrictionProblem | None:
    """The problem over bodies of n unknowns, or None if it is none."""
    contacts, m = w.shape
    if len(f) % n:
        return None
    count = len(f) // n
    blocks = mass.tobsr((n, n))
    blocks.sum_duplicates()
    if not np.array_equal(blocks.indices, np.arange(count)) or (np.diff(blocks.indptr) != 1).any():
        return None
    if (np.linalg.eigvalsh(blocks.data) <= 0).any():
        return None
    inverse = inverses(np.ascontiguousarray(blocks.data), size_tuple(n))  # LAPACK's rounds by the processor
    if (np.abs(np.einsum("bij,bji->b", inverse, blocks.data) - n) > 0.5).any():  # singular but for rounding
        return None
    rows = h.T.tobsr((m, n))
    rows.sort_indices()
    touched = np.diff(rows.indptr)
    if (touched > 2).any() or (touched == 0).any():
        return None
    bodies, jacobian = np.full((contacts, 2), -1), np.zeros((contacts, 2, m, n))
    for side in range(2):
        on = np.flatnonzero(touched > side)
        at = rows.indptr[on] + side
        bodies[on, side], jacobian[on, side] = rows.indices[at], rows.data[at]
    v_free = np.einsum("bij,bj->bi", inverse, f.reshape(count, n))
    return FrictionProblem(inverse, v_free, bodies, Geometry.by_rows(jacobian), w.copy(), mu, compliance)
