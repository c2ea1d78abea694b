# SPDX-License-Identifier: GPL-3.0-or-later
"""The tiers: a marker says why, and what takes long must carry it."""

from __future__ import annotations

import pytest

pytest_plugins = "pytester"
BURNS = "import time\n{mark}\ndef test_burns():\n    end = time.process_time() + 0.3\n    while time.process_time() < end: pass\n"
SLOW = '@__import__("pytest").mark.slow(reason="it burns")'


@pytest.fixture
def tier(pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch) -> pytest.Pytester:
    """A folder of tests with the hooks, where numba keeps what it compiles next to them."""
    pytester.makeconftest("from tiers import *")
    pytester.makeini("[pytest]\nmarkers = slow: with a reason\naddopts = --strict-markers\n")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(pytester.path))
    return pytester


@pytest.mark.parametrize(
    ("mark", "options", "outcome"), [("", [], "passed"), ("", ["--budget=0.03"], "failed"), (SLOW, ["--budget=0.03"], "passed")]
)
def test_only_what_is_marked_may_take_long(tier: pytest.Pytester, mark: str, options: list[str], outcome: str) -> None:
    tier.makepyfile(BURNS.format(mark=mark))
    result = tier.runpytest_inprocess(*options)
    result.assert_outcomes(**{outcome: 1})
    if outcome == "failed":
        result.stdout.fnmatch_lines(["*it took 0.* s of processor time, 0.03 s are meant: make it smaller or mark it slow*"])


def test_another_process_counts_but_a_fixture_does_not_and_both_are_printed(tier: pytest.Pytester) -> None:
    """A fixture may serve many tests: the first one must not pay for it."""
    burn = "import time\nwhile time.process_time() < 0.3: pass"
    tier.makepyfile(
        f"import subprocess, sys, pytest\ndef burn(): subprocess.run([sys.executable, '-c', {burn!r}])\n"
        "@pytest.fixture\ndef burnt(): burn()\ndef test_fixture(burnt): pass\ndef test_process(): burn()\n"
    )
    result = tier.runpytest_inprocess("--budget=0.03")
    result.assert_outcomes(passed=1, failed=1)
    lines = [r"=+ processor time, of .* s =+", r"\. \d s", r" +[0-9.]+[1-9] s  .*::test_", r" +[0-9.]+[1-9] s  .*::test_"]
    result.stdout.re_match_lines([*lines, r"resident memory of a process: (0\.0[1-9]|0\.[1-9]|[1-9]).* GB at most"])


def test_what_is_compiled_meanwhile_is_not_held_against_a_test(tier: pytest.Pytester) -> None:
    tier.makepyfile(BURNS.format(mark="") + "    open('kernel.nbc', 'w').close()\n")
    tier.runpytest_inprocess("--budget=0.03").assert_outcomes(passed=1)


@pytest.mark.parametrize("mark", ["slow", "slow()", 'slow("it burns")', 'slow(reason=" ")', 'slow(reason="it burns", why=1)'])
def test_a_marker_without_a_reason_is_refused(tier: pytest.Pytester, mark: str) -> None:
    tier.makepyfile(BURNS.format(mark=f'@__import__("pytest").mark.{mark}'))
    result = tier.runpytest_inprocess()
    assert result.ret == pytest.ExitCode.USAGE_ERROR
    result.stderr.fnmatch_lines(['*::test_burns: say why: @pytest.mark.slow(reason="...")'])
