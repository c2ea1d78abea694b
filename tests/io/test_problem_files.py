# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems in files: both formats there and back, the collected problems, and bad input in one line."""

from __future__ import annotations

import re
import zipfile
from collections.abc import Callable, Mapping
from pathlib import Path

import h5py
import numpy as np
import pytest
import scenes
from hostile import refused_at
from places import SHARED
from scipy import sparse

from masonry_cd.app.commands.solve import solve
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.problem_files import read_problem, write_problem
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, Problem, natural_map_error

COLLECTED = SHARED / "friction_problems"
needs_collection = pytest.mark.skipif(not COLLECTED.is_dir(), reason="the collected friction problems are not here")


@pytest.mark.parametrize("ending", ["npz", "hdf5"])
@pytest.mark.parametrize("local", [True, False])
def test_there_and_back(tmp_path: Path, ending: str, local: bool) -> None:
    """A problem written and read again gives the same relative velocities and the same error."""
    problem = scenes.wall(3, 3)
    written = problem.to_local() if local else problem
    write_problem(tmp_path / f"p.{ending}", written)
    read = read_problem(tmp_path / f"p.{ending}")
    assert isinstance(read, LocalProblem if local else FrictionProblem)
    impulse = np.random.default_rng(1).normal(size=(problem.contacts, 3))
    np.testing.assert_allclose(read.apply(impulse), problem.apply(impulse), atol=1e-12)
    assert natural_map_error(read, impulse) == pytest.approx(natural_map_error(problem, impulse), rel=1e-10)


def test_elastic_contacts_there_and_back(tmp_path: Path) -> None:
    """Their compliance is kept over bodies in .npz, is part of W in local problems, and is refused by name where FCLIB has no place."""
    problem = scenes.softened(scenes.wall(3, 3), 0.5)
    impulse = np.random.default_rng(1).normal(size=(problem.contacts, 3))
    write_problem(tmp_path / "bodies.npz", problem)
    write_problem(tmp_path / "local.hdf5", problem.to_local())
    bodies, local = read_problem(tmp_path / "bodies.npz"), read_problem(tmp_path / "local.hdf5")
    assert isinstance(bodies, FrictionProblem)
    np.testing.assert_array_equal(bodies.compliance, problem.compliance)
    for read in (bodies, local):
        np.testing.assert_allclose(read.apply(impulse), problem.apply(impulse), atol=1e-12)
    with pytest.raises(InputError, match="cannot store elastic contacts"):
        write_problem(tmp_path / "global.hdf5", problem)
    assert not (tmp_path / "global.hdf5").exists()


def test_a_problem_of_contactbench_has_its_normals_last(tmp_path: Path) -> None:
    """A block on a slope of one in two slides where friction is less, c = G r + g with rows (t1, t2, n)."""
    np.savez(tmp_path / "p.npz", G=np.diag([2.0, 2.0, 1.0]), g=[[-1.0], [0.0], [-2.0]], mus=[0.25])
    read = read_problem(tmp_path / "p.npz")
    np.testing.assert_array_equal(read.free_relative_velocity(), [[-2.0, -1.0, 0.0]])
    assert natural_map_error(read, np.array([[2.0, 0.5, 0.0]])) < 1e-15  # the tangent would have to be as large to stick
    np.savez(tmp_path / "q.npz", G=np.eye(3), g=np.zeros(3), mus=[0.2, 0.2])
    with pytest.raises(InputError, match="9 entries of G and 3 of g do not fit 2 of mus"):
        read_problem(tmp_path / "q.npz")


def test_planar_problem_there_and_back(tmp_path: Path) -> None:
    """Two rows per contact survive."""
    w = np.diag([2.0, 1.0, 3.0, 1.0])
    write_problem(tmp_path / "p.npz", LocalProblem(sparse.csr_matrix(w), np.array([[-1.0, 0.2], [0.5, 0.0]]), np.array([0.5, 0.5])))
    found = solve(tmp_path / "p.npz", tolerance=1e-12, output=tmp_path / "s.npz").value
    assert found["converged"]
    assert np.load(tmp_path / "s.npz")["r"][0] == pytest.approx([0.5, -0.2])


@needs_collection
@pytest.mark.parametrize("name", ["Spheres-i099-356-679", "fclib_local_problem_test", "LMGC_100_PR_PerioBox-i00361-60-03000"])
def test_both_formats_hold_the_same_problem(name: str) -> None:
    """Relative velocities of the .npz and of the FCLIB file agree at random impulses."""
    plain, published = read_problem(COLLECTED / f"{name}.npz"), read_problem(COLLECTED / f"{name}.hdf5")
    impulse = np.random.default_rng(2).normal(size=(plain.contacts, 3))
    np.testing.assert_allclose(plain.apply(impulse), published.apply(impulse), atol=1e-9)


@needs_collection
def test_collected_problems_are_solved() -> None:
    """All seven to 1e-10 by our measure, recomputed from the impulses that were saved."""
    names = sorted(path.name for path in COLLECTED.glob("*.npz"))
    assert len(names) == 7
    missed = {name: found["error"] for name in names if not (found := solve(COLLECTED / name, tolerance=1e-10).value)["converged"]}
    assert not missed


@needs_collection
def test_published_reactions_are_no_reference() -> None:
    """The reactions stored with the spheres have a large error by our measure; ours do not."""
    file = COLLECTED / "Spheres-i099-356-679.npz"
    problem = read_problem(file)
    assert natural_map_error(problem, np.load(file)["r_ref"].reshape(-1, 3)) > 1e-3
    assert solve(file).value["error"] <= 1e-8


def test_files_that_are_no_problems(tmp_path: Path) -> None:
    """No file, no format, no FCLIB group, no HDF5: one line each."""
    (tmp_path / "text.hdf5").write_text("not HDF5")
    (tmp_path / "text.npz").write_text("not a zip")
    (tmp_path / "p.txt").write_text("")
    (tmp_path / "folder.npz").mkdir()
    with h5py.File(tmp_path / "other.hdf5", "w") as file:
        file["x"] = 1.0
    for name, kind in (("rolling", "fclib_global_rolling"), ("later", "fclib_bilateral")):
        with h5py.File(tmp_path / f"{name}.hdf5", "w") as file:
            file.create_group(kind)["spacedim"] = np.array([3])
    for name, message in [
        ("none.npz", "no such file"),
        ("text.hdf5", "not a readable HDF5 file"),
        ("text.npz", "not a readable .npz file"),
        ("p.txt", "unknown format"),
        ("folder.npz", "is a folder"),
        ("other.hdf5", "neither fclib_local nor fclib_global"),
        ("rolling.hdf5", "fclib_global_rolling: contacts that resist rolling are not supported; fclib_local and fclib_global are"),
        ("later.hdf5", "fclib_bilateral: problems of this kind are not supported"),
    ]:
        with pytest.raises(InputError, match=message):
            read_problem(tmp_path / name)


def test_solver_and_tolerance_are_checked(tmp_path: Path) -> None:
    """A misspelt solver is answered with a suggestion."""
    with pytest.raises(InputError, match='did you mean "admm"'):
        solve(tmp_path / "p.npz", solver="adm")
    with refused_at("tolerance"):
        solve(tmp_path / "p.npz", tolerance=0.0)
    with pytest.raises(InputError, match=r"SOLUTION\.npz"):
        solve(tmp_path / "p.npz", output=tmp_path)


def deformable(blocks: int, nodes: int) -> tuple[sparse.csr_matrix, sparse.csr_matrix, np.ndarray]:
    """M, H (unknowns by rows) and f of a stack of blocks of several nodes, which M couples, with one contact to a joint."""
    rng, n = np.random.default_rng(6), 3 * nodes
    root = rng.normal(size=(blocks, n, n))
    mass = sparse.block_diag([a @ a.T + n * np.eye(n) for a in root], format="csr")
    h = np.zeros((blocks * n, 3 * blocks))
    for b in range(blocks):
        columns = np.arange(3 * b, 3 * b + 3)
        weights = rng.dirichlet(np.ones(nodes), 2)
        for node in range(nodes):
            h[b * n + 3 * node : b * n + 3 * node + 3, columns] = weights[0, node] * np.eye(3)[[1, 2, 0]].T
            if b:
                h[(b - 1) * n + 3 * node : (b - 1) * n + 3 * node + 3, columns] = -weights[1, node] * np.eye(3)[[1, 2, 0]].T
    return mass, sparse.csr_matrix(h), rng.normal(size=blocks * n)


def written_global(path: Path, mass: sparse.csr_matrix, h: sparse.csr_matrix, f: np.ndarray) -> Path:
    """A global FCLIB problem of these, with friction 0.5."""
    with h5py.File(path, "w") as file:
        group = file.create_group("fclib_global")
        for name, matrix in {"M": mass, "H": h}.items():
            for key, value in zip(["m", "n", "nzmax", "nz"], (*matrix.shape, matrix.nnz, -2), strict=True):
                group[f"{name}/{key}"] = np.array([value], dtype=np.int32)
            group[f"{name}/p"], group[f"{name}/i"], group[f"{name}/x"] = matrix.indptr, matrix.indices, matrix.data
        for name, vector in {"f": f, "w": np.zeros(h.shape[1]), "mu": np.full(h.shape[1] // 3, 0.5)}.items():
            group[f"vectors/{name}"] = vector
    return path


def test_global_problem_of_deformable_blocks(tmp_path: Path) -> None:
    """Blocks of 24 unknowns: W and q are those of the dense formula, and sparse; the problem is solved."""
    mass, h, f = deformable(6, 8)
    path = written_global(tmp_path / "p.hdf5", mass, h, f)
    problem = read_problem(path)
    assert isinstance(problem, LocalProblem)
    inverse = np.linalg.inv(mass.toarray())
    np.testing.assert_allclose(problem.w.toarray(), h.T @ inverse @ h.toarray(), atol=1e-14)
    np.testing.assert_allclose(problem.q.ravel(), h.T @ inverse @ f, atol=1e-14)
    assert problem.w.nnz < 0.5 * problem.q.size**2
    assert solve(path).value["error"] <= 1e-8


def test_one_negative_eigenvalue_is_found(tmp_path: Path) -> None:
    """Symmetric, with a positive diagonal, and indefinite all the same; what rounding may do is let pass."""
    local = scenes.wall(3, 3).to_local()
    dense = local.w.toarray()
    values, vectors = np.linalg.eigh(dense)
    for depth, refused in ((1e-2, True), (1e-9, False)):
        worse = dense - (values[0] + depth * dense.diagonal().max()) * np.outer(vectors[:, 0], vectors[:, 0])
        write_problem(tmp_path / "p.npz", LocalProblem(sparse.csr_matrix(worse), local.q, local.mu))
        if refused:
            with pytest.raises(InputError, match="W is indefinite"):
                read_problem(tmp_path / "p.npz")
        else:
            assert read_problem(tmp_path / "p.npz").contacts == local.contacts


def test_damaged_npz_files(tmp_path: Path) -> None:
    """Each byte of the compressed data, and a header that announces 256 TiB."""
    write_problem(tmp_path / "p.npz", scenes.tower(3))
    whole = (tmp_path / "p.npz").read_bytes()
    for at in range(30, len(whole), 97):
        (tmp_path / "q.npz").write_bytes(whole[:at] + bytes([whole[at] ^ 0x5A]) + whole[at + 1 :])
        try:
            read_problem(tmp_path / "q.npz")
        except InputError as failure:
            assert str(failure).startswith(f"{tmp_path}/q.npz: ")
    head = (
        np.lib.format.magic(1, 0) + b"\x76\0" + b"{'descr': '<f8', 'fortran_order': False, 'shape': (35184372088832,), }".ljust(117) + b"\n"
    )
    with zipfile.ZipFile(tmp_path / "r.npz", "w") as file:
        file.writestr("mu.npy", head)
    with refused_at("r.npz"):
        read_problem(tmp_path / "r.npz")


# --- what is wrong in a file ------------------------------------------------------------------------------------------------------------

Arrays = dict[str, np.ndarray]


def npz(problem: Callable[[], Problem], change: Callable[[Arrays], Mapping[str, np.ndarray | None]]) -> Callable[[Path], Path]:
    """A .npz file some of whose arrays are others or, where None, gone."""

    def make(folder: Path) -> Path:
        write_problem(folder / "p.npz", problem())
        arrays = dict(np.load(folder / "p.npz"))
        kept = {name: array for name, array in (arrays | change(arrays)).items() if array is not None}
        np.savez(folder / "p.npz", allow_pickle=False, **kept)
        return folder / "p.npz"

    return make


def hdf5(problem: Callable[[], Problem], change: Callable[[h5py.File], None]) -> Callable[[Path], Path]:
    """An FCLIB file that is changed."""

    def make(folder: Path) -> Path:
        write_problem(folder / "p.hdf5", problem())
        with h5py.File(folder / "p.hdf5", "r+") as file:
            change(file)
        return folder / "p.hdf5"

    return make


def local() -> LocalProblem:
    return scenes.tower(1).to_local()


def three() -> FrictionProblem:
    return scenes.tower(3)


def put(array: np.ndarray, place: int, value: float) -> np.ndarray:
    """A copy with another value at a place."""
    out = array.copy()
    out[place] = value
    return out


def at(place: str, value: object = None) -> Callable[[h5py.File], None]:
    """Another value in place of a dataset, group or link; none where that is None."""

    def change(file: h5py.File) -> None:
        del file[place]
        if value is not None:
            file[place] = value

    return change


def index(value: int) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        file["fclib_local/W/i"][3] = value

    return change


def empty(file: h5py.File) -> None:
    """Offsets of H that run out of it and end as those of a matrix without entries."""
    offsets = file["fclib_global/H/p"]
    offsets[1:-1], offsets[-1] = 52, 0


def external(file: h5py.File) -> None:
    del file["fclib_global/M/x"]
    file["fclib_global/M"].create_dataset("x", shape=(4,), dtype="f8", external=[("/dev/zero", 0, 32)])


def announced(file: h5py.File) -> None:
    del file["fclib_global/vectors/f"]
    file["fclib_global/vectors"].create_dataset("f", shape=(10**15,), dtype="f8", chunks=(1000,))


def lopsided(arrays: Arrays, name: str, row: int, column: int) -> Arrays:
    """An entry far from its mirror image, which is not rounding."""
    dense = sparse.csr_matrix(tuple(arrays[f"{name}_{part}"] for part in ("data", "indices", "indptr"))).toarray()
    dense[row, column] += 0.3 * dense[row, row]
    full = sparse.csr_matrix(dense)
    return {f"{name}_{part}": getattr(full, part) for part in ("data", "indices", "indptr")}


def massless(folder: Path) -> Path:
    """A node of a deformable block without mass."""
    mass, h, f = deformable(2, 8)
    keep = sparse.diags((np.arange(mass.shape[0]) != 5).astype(float))
    return written_global(folder / "p.hdf5", (keep @ mass @ keep).tocsr(), h, f)


@pytest.mark.parametrize(
    ("make", "named"),
    [
        (npz(local, lambda a: {"q": put(a["q"], 4, np.nan)}), "q[4]"),
        (npz(local, lambda a: {"q": a["q"][:-1]}), "q"),
        (npz(local, lambda a: {"q": np.tile(a["q"], 2)}), "q"),
        (npz(local, lambda a: {"mu": put(a["mu"], 1, -0.1)}), "mu[1]"),
        (npz(local, lambda _: {"mu": None}), "mu"),
        (npz(local, lambda a: {"W_data": put(a["W_data"], 0, np.inf)}), "W_data[0]"),
        (npz(local, lambda a: {"W_data": -a["W_data"]}), "W"),
        (npz(local, lambda a: {"W_data": a["W_data"][:-1]}), "W_indptr"),
        (npz(local, lambda a: {"W_data": a["W_data"].astype(str)}), "W_data"),
        (npz(local, lambda a: {"q": a["q"].astype(complex)}), "q"),
        (npz(local, lambda a: {"q": put(a["q"], 2, 1e200)}), "q[2]"),
        (npz(local, lambda a: {"W_indices": a["W_indices"] + 0.5}), "W_indices[0]"),
        (npz(local, lambda a: {"W_indices": put(a["W_indices"], 3, 999)}), "W"),
        (npz(local, lambda a: {"W_indices": put(a["W_indices"], 3, -1)}), "W_indptr"),
        (npz(local, lambda a: lopsided(a, "W", 0, 5)), "W"),
        (npz(lambda: scenes.tower(2), lambda a: lopsided(a, "M", 0, 3)), "M"),
        (npz(three, lambda _: {"C": np.full(36, -1.0)}), "C[0]"),
        (npz(three, lambda _: {"C": np.zeros(5)}), "C"),
        (hdf5(local, index(999)), "fclib_local/W"),
        (hdf5(local, index(-1)), "fclib_local/W"),
        (hdf5(local, at("fclib_local/W", np.eye(3))), "fclib_local/W/m"),
        (hdf5(local, at("fclib_local/W/x", np.array([b"one"]))), "fclib_local/W/x"),
        (hdf5(local, at("fclib_local/W/x")), "fclib_local/W/x"),
        (hdf5(local, at("fclib_local/W/nz", np.array([10**6]))), "fclib_local/W/nz"),
        (hdf5(local, at("fclib_local/W/m", np.array([12, 12]))), "fclib_local/W/m"),
        (hdf5(local, at("fclib_local/vectors", np.zeros(3))), "q"),
        (hdf5(local, at("fclib_local/vectors/q", "none")), "q"),
        (hdf5(local, at("fclib_local/spacedim", np.array([2]))), "spacedim"),
        (massless, "M"),
        (hdf5(three, at("fclib_global/M/x", h5py.SoftLink("/nowhere"))), "fclib_global/M/x"),
        (hdf5(three, at("fclib_global/vectors", h5py.SoftLink("/fclib_global/vectors"))), "not a readable HDF5 file"),
        (hdf5(three, at("fclib_global/M", h5py.SoftLink("/nowhere"))), "not a readable HDF5 file"),
        (hdf5(three, at("fclib_global/M/x", h5py.ExternalLink("/etc/passwd", "/"))), "fclib_global/M/x"),
        (hdf5(three, empty), "fclib_global/H"),
        (hdf5(three, external), "fclib_global/M/x"),
        (hdf5(three, announced), "has arrays"),
    ],
)
def test_the_file_and_the_array_are_named(tmp_path: Path, make: Callable[[Path], Path], named: str) -> None:
    path = make(tmp_path)
    with refused_at(str(path)) as caught:
        read_problem(path)
    (fault,) = caught.value.faults
    assert re.match(rf"{re.escape(named)}\b|{re.escape(named)}[ :]", fault.text), fault.text
    assert str(fault).isprintable()
