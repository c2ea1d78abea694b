# SPDX-License-Identifier: GPL-3.0-or-later
"""The table of what numba compiles: seconds of a kernel are without those of the kernels in it."""

from __future__ import annotations

import numba
import pytest

from benchmarks.compiling import Clock, table


@numba.njit
def half(x):
    return 0.5 * x


@numba.njit
def quarter(x):
    return half(half(x))


def test_seconds_of_a_kernel_are_without_those_of_the_kernels_in_it(monkeypatch: pytest.MonkeyPatch) -> None:
    now = iter([0.0, 1.0, 4.0, 6.0, 10.0, 11.0])  # quarter begins, half begins and ends, quarter ends; half again
    monkeypatch.setattr("benchmarks.compiling.time.process_time", lambda: next(now))
    clock = Clock()
    with numba.core.event.install_listener("numba:compile", clock):
        assert quarter(4.0) == 1.0
        assert half(4) == 2.0
    name = f"{__name__}.half"
    assert [took for (kernel, _), took in clock.seconds.items() if kernel == name] == [[3.0], [1.0]]
    rows = table(clock, False, 1).splitlines()
    assert rows[2] == f"| {name} | 2 | 4.00 |" and rows[-1] == "| together | 3 | 7.00 |"
    assert f"| {name} | float64 | 1 | 3.00 |" in table(clock, True, 3)
