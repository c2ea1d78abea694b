# SPDX-License-Identifier: GPL-3.0-or-later
"""Friction problems in files: both formats there and back, the collected problems, and bad input in one line."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
import scenes
from places import SHARED
from scipy import sparse

from masonry_cd.app.commands.solve import solve
from masonry_cd.foundation.errors import InputError
from masonry_cd.io.problem_files import read_problem, write_problem
from masonry_cd.mechanics.friction.problem import FrictionProblem, LocalProblem, natural_map_error

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
    with pytest.raises(InputError, match="no place for elastic contacts"):
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


@pytest.mark.parametrize(("wrong", "line"), [(np.full(3, -1.0), r"C\[0\] is negative"), (np.zeros(5), "C has 5 entries, w has 36")])
def test_wrong_compliance_is_named(tmp_path: Path, wrong: np.ndarray, line: str) -> None:
    """Negative or of another length."""
    write_problem(tmp_path / "p.npz", scenes.tower(3))
    arrays = dict(np.load(tmp_path / "p.npz"))
    np.savez(tmp_path / "p.npz", **arrays, C=np.resize(wrong, 36) if len(wrong) == 3 else wrong)
    with pytest.raises(InputError, match=line):
        read_problem(tmp_path / "p.npz")


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


def broken(tmp_path: Path, **changes: np.ndarray | None) -> Path:
    """A sound .npz with some arrays replaced or, where None, left out."""
    write_problem(tmp_path / "sound.npz", scenes.tower(1).to_local())
    arrays = dict(np.load(tmp_path / "sound.npz")) | changes
    np.savez(tmp_path / "broken.npz", **{name: array for name, array in arrays.items() if array is not None})
    return tmp_path / "broken.npz"


def test_bad_arrays_are_named(tmp_path: Path) -> None:
    """NaN, wrong lengths, missing arrays and negative friction are reported in one line with the file and the array."""
    q = np.load(broken(tmp_path))["q"]
    w = np.load(broken(tmp_path))["W_data"]
    bad: list[tuple[dict[str, np.ndarray | None], str]] = [
        ({"q": np.where(np.arange(len(q)) == 4, np.nan, q)}, r"q\[4\] is not a finite number"),
        ({"q": q[:-1]}, "q has 11 entries, for 4 contacts"),
        ({"q": np.tile(q, 2)}, "q has 24 entries"),
        ({"mu": np.array([0.5, -0.1, 0.5, 0.5])}, r"mu\[1\] is negative"),
        ({"mu": None}, "mu is missing"),
        ({"W_data": np.where(np.arange(len(w)) == 0, np.inf, w)}, r"W_data\[0\] is not a finite number"),
        ({"W_data": -w}, "W is indefinite"),
        ({"W_data": w[:-1]}, "compressed rows"),
        ({"W_data": w.astype(str)}, "W_data should hold real numbers, not str"),
        ({"q": q.astype(complex)}, "q should hold real numbers, not complex128"),
        ({"q": np.where(np.arange(len(q)) == 2, 1e200, q)}, r"q\[2\] is too large to be squared"),
        ({"W_indices": np.load(broken(tmp_path))["W_indices"] + 0.5}, r"W_indices\[0\] is no whole number"),
    ]
    for changes, message in bad:
        path = broken(tmp_path, **changes)
        with pytest.raises(InputError, match=message) as caught:
            read_problem(path)
        assert str(path) in str(caught.value)
        assert "\n" not in str(caught.value)


def test_unsymmetric_matrix_is_refused(tmp_path: Path) -> None:
    """An entry far from its mirror image is no rounding."""
    local = scenes.tower(1).to_local()
    dense = local.w.toarray()
    dense[0, 5] += 0.3 * dense[0, 0]
    write_problem(tmp_path / "p.npz", LocalProblem(sparse.csr_matrix(dense), local.q, local.mu))
    with pytest.raises(InputError, match="W is unsymmetric by 3"):
        read_problem(tmp_path / "p.npz")


@pytest.mark.parametrize("wrong", [999, -1])
def test_indices_out_of_range_are_reported(tmp_path: Path, wrong: int) -> None:
    """In compressed rows of both formats: never read from beyond an array."""
    problem = scenes.tower(1).to_local()
    write_problem(tmp_path / "p.hdf5", problem)
    with h5py.File(tmp_path / "p.hdf5", "r+") as file:
        file["fclib_local/W/i"][3] = wrong
    with pytest.raises(InputError, match="fclib_local/W: indices must be"):
        read_problem(tmp_path / "p.hdf5")
    indices = problem.w.indices.copy()
    indices[3] = wrong
    with pytest.raises(InputError, match="W is 12 x 1000, q has 12" if wrong > 0 else "do not describe W_data as compressed rows"):
        read_problem(broken(tmp_path, W_indices=indices))


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        ("W", np.eye(3), "fclib_local/W/m is missing"),
        ("W/x", np.array([b"one"]), "fclib_local/W/x should hold real numbers"),
        ("W/x", None, "fclib_local/W/x is missing"),
        ("W/nz", np.array([10**6]), "nz counts 1000000 entries"),
        ("W/m", np.array([12, 12]), "fclib_local/W/m should be one number"),
        ("vectors", np.zeros(3), "q is missing; it holds nothing"),
        ("vectors/q", "none", "q should hold real numbers"),
        ("spacedim", np.array([2]), "spacedim is 2, but its arrays hold 3 rows per contact"),
    ],
)
def test_bad_datasets_are_named(tmp_path: Path, place: str, value: object, message: str) -> None:
    """Groups for datasets, datasets for groups, text for numbers: one line each, no traceback."""
    write_problem(tmp_path / "p.hdf5", scenes.tower(1).to_local())
    with h5py.File(tmp_path / "p.hdf5", "r+") as file:
        del file[f"fclib_local/{place}"]
        if value is not None:
            file[f"fclib_local/{place}"] = value
    with pytest.raises(InputError, match=message):
        read_problem(tmp_path / "p.hdf5")


def test_unsymmetric_mass_is_refused(tmp_path: Path) -> None:
    """M of a global problem is checked as W of a local one is."""
    write_problem(tmp_path / "p.npz", scenes.tower(2))
    arrays = dict(np.load(tmp_path / "p.npz"))
    mass = sparse.csr_matrix((arrays["M_data"], arrays["M_indices"], arrays["M_indptr"])).toarray()
    mass[0, 3] = mass[0, 0]
    full = sparse.csr_matrix(mass)
    arrays |= {"M_data": full.data, "M_indices": full.indices, "M_indptr": full.indptr}
    np.savez(tmp_path / "p.npz", allow_pickle=False, **arrays)
    with pytest.raises(InputError, match="M is unsymmetric by"):
        read_problem(tmp_path / "p.npz")


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
        ("text.hdf5", "no HDF5 file"),
        ("text.npz", "no .npz file"),
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
    with pytest.raises(InputError, match="tolerance"):
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


def test_singular_mass_is_reported(tmp_path: Path) -> None:
    """A node without mass."""
    mass, h, f = deformable(2, 8)
    keep = sparse.diags((np.arange(mass.shape[0]) != 5).astype(float))
    with pytest.raises(InputError, match="M is singular"):
        read_problem(written_global(tmp_path / "p.hdf5", (keep @ mass @ keep).tocsr(), h, f))


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


def damaged(place: str, value: object) -> Callable[[h5py.File], None]:
    def change(file: h5py.File) -> None:
        del file[place]
        file[place] = value

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


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (damaged("fclib_global/M/x", h5py.SoftLink("/nowhere")), "p.hdf5: fclib_global/M/x is missing"),
        (damaged("fclib_global/vectors", h5py.SoftLink("/fclib_global/vectors")), "p.hdf5: no HDF5 file that can be read"),
        (damaged("fclib_global/M", h5py.SoftLink("/nowhere")), "p.hdf5: no HDF5 file that can be read"),
        (damaged("fclib_global/M/x", h5py.ExternalLink("/etc/passwd", "/")), "p.hdf5: fclib_global/M/x lies in another file"),
        (empty, "p.hdf5: fclib_global/H: the offsets in p should not decrease"),
        (external, "p.hdf5: fclib_global/M/x keeps its data in another file"),
        (announced, "p.hdf5: announces arrays of 8e+06 GB, at most 16 GB are read"),
    ],
)
def test_links_offsets_other_files_and_sizes_that_are_not_there(tmp_path: Path, change: Callable[[h5py.File], None], message: str) -> None:
    write_problem(tmp_path / "p.hdf5", scenes.tower(3))
    with h5py.File(tmp_path / "p.hdf5", "r+") as file:
        change(file)
    with pytest.raises(InputError) as failure:
        read_problem(tmp_path / "p.hdf5")
    assert str(failure.value).startswith(f"{tmp_path}/{message}")
    assert str(failure.value).isprintable()


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
    with pytest.raises(InputError, match=r"r\.npz: no \.npz file that can be read"):
        read_problem(tmp_path / "r.npz")
