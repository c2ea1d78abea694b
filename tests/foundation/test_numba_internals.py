# SPDX-License-Identifier: GPL-3.0-or-later
"""Uses of numba beyond its public interface, name by name: a failure here names what a new version has changed."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from typing import Any, NamedTuple

import numba
import numpy as np
import pytest

from masonry_cd.foundation import jit, kernel_store, numba_internals
from masonry_cd.foundation.jit import entry, kernel


@kernel()
def _plus(x, n):
    return x + n


@kernel()
def _applied(steps, x):
    return steps.first(x, 1)


class Steps(NamedTuple):
    first: Any


STEPS = Steps(_plus)


@entry()
def plus_three(x):
    return _plus(_plus(x, 1), 2)


@entry()
def plus_one(x):
    return _applied(STEPS, x)


@entry()
def twice(x):
    return 2 * x


class Shelf(NamedTuple):
    upper: np.ndarray
    lower: np.ndarray


@kernel()
def _filled(shelf, value):
    if value < 0.0:
        return np.empty(0)
    room = np.full(2, value)
    shelf.upper[:] = room[0]
    shelf.lower[:] = room[0] + room[1]
    return room


@kernel()
def _filled_twice(shelf):
    return _filled(shelf, -1.0).sum() + _filled(shelf, 1.0).sum()


@kernel()
def _handed_on(shelf, x, times):
    for _ in range(times):
        x, shelf = shelf.lower, Shelf(x, shelf.upper)
    return x, shelf


@entry()
def fill_and_turn(shelf: Shelf, x: np.ndarray, times: int) -> tuple[np.ndarray, Shelf]:
    _filled_twice(shelf)
    return _handed_on(shelf, x, times)


@pytest.fixture(scope="module", autouse=True)
def empty_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Kernels are compiled here: one that is loaded has no intermediate code to look at."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(kernel_store.FOLDER, str(tmp_path_factory.mktemp("store")))
        yield


def test_the_internals_are_used_in_the_versions_tried() -> None:
    assert not jit.PLAIN


def test_numbers_in_calls_share_one_version() -> None:
    """Dispatcher.get_call_template, unliteral."""
    assert plus_three(1.0) == 4.0
    assert len(_plus.inner.overloads) == 1


def test_what_an_entry_calls_is_its_own() -> None:
    """JITCodeLibrary._optimize_final_module, ModuleRef.functions, Linkage: no other code may call it, so that LLVM can change it."""
    x = np.zeros(2)
    fill_and_turn(Shelf(x, x.copy()), x.copy(), 2)
    (version,) = fill_and_turn.outer.overloads.values()
    assert type(version.library) is numba_internals._MachineCode
    assert "linkonce_odr" not in version.library.get_llvm_str()


def test_kernels_stay_intermediate_code() -> None:
    """JITCodeLibrary.finalize, NativeLowering.run_pass, Compiler.define_pipelines, Dispatcher._insert."""
    plus_three(1.0)
    (version,) = _plus.inner.overloads.values()
    assert type(version.library) is numba_internals._IntermediateCode
    assert "define" in version.library.get_llvm_str()
    assert _plus.inner.nopython_signatures and not callable(version.entry_point)


def test_kernels_are_given_to_kernels_under_a_name_without_an_address() -> None:
    """Dispatcher._type, lower_constant."""
    assert plus_one(1.0) == 2.0
    assert numba.typeof(_plus.inner).name == f"{__name__}._plus"


def test_no_references_are_counted_to_arguments() -> None:
    """Lower.lower_assign, Lower.delvar."""
    fill_and_turn(Shelf(np.zeros(2), np.zeros(2)), np.zeros(2), 0)
    (version,) = _filled_twice.inner.overloads.values()
    found = re.search(
        rf"^define[^\n]*{re.escape(version.fndesc.mangled_name)}.*?^}}", version.library.get_llvm_str(), re.MULTILINE | re.DOTALL
    )
    assert found is not None
    own = found.group()
    assert "_filled" in own and own.count("NRT_decref") == 2  # to the arrays that it gets
    assert "NRT_incref" not in own


def test_what_is_handed_on_or_assigned_anew_is_held() -> None:
    """Three arrays that change places three times are in their own again; nothing is lost, and nothing stays behind."""
    given = [np.full(2, value) for value in (3.0, 4.0, 5.0)]
    fill_and_turn(Shelf(*given[:2]), given[2], 1)
    counts = [sys.getrefcount(array) for array in given]
    for times in range(300):
        x, shelf = fill_and_turn(Shelf(*given[:2]), given[2], times)
        places = [shelf.upper, shelf.lower, x]
        assert [place[0] for place in places[times % 3 :] + places[: times % 3]] == [1.0, 2.0, 5.0]
        del x, shelf, places
    assert [sys.getrefcount(array) for array in given] == counts


def test_settings_are_equal_as_numba_s_own_are() -> None:
    """Flags._values."""
    first, second = numba_internals._Flags(), numba_internals._Flags()
    assert first == second and hash(first) == hash(second)
    second.nrt = True
    assert first != second


def test_of_what_is_kept_only_names_are_parsed(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    """CompileResult._reduce, JITCodeLibrary._unserialize: machine code next to stubs, which define the two names that numba asks for."""
    import pickle

    from masonry_cd.foundation import kernel_store

    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    twice(np.float32(1.0))
    (file,) = tmp_path.iterdir()
    (_, form, (code, stubs)), *_ = pickle.loads(kernel_store.read(file.name))
    assert form == "object" and code.startswith(b"\x7fELF") and len(stubs) < 4000
