# SPDX-License-Identifier: GPL-3.0-or-later
"""The search for inputs that break a promise: it sees each kind of broken promise, and its cases repeat."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.fuzz import inputs, mutators, promises, texts, together, worker

LINE = "masonry-cd: error: a.toml:3: run.dt: missing\n"
REFUSED = promises.Outcome(2, "", LINE, 0.1, 3e8, False, (), False)
DONE = promises.Outcome(0, "written\n", "masonry-cd: warning: coarse\n", 0.1, 3e8, False, (), True)
STOPPED = promises.Outcome(
    130, "", "masonry-cd: warning: the run ended early, interrupted\nmasonry-cd: continue with: x\n", 1.0, 3e8, True, (), True
)


def test_kept_promises() -> None:
    assert [promises.broken(outcome) for outcome in (REFUSED, DONE, STOPPED)] == ["", "", ""]
    early = replace(DONE, code=1, stderr="masonry-cd: warning: the run ended early, no finite velocity; the results hold all frames\n")
    assert promises.broken(early) == ""


@pytest.mark.parametrize(
    ("outcome", "wrong"),
    [
        (replace(REFUSED, code=None), "did not end"),
        (replace(REFUSED, code=-11), "ended by signal 11"),
        (replace(REFUSED, code=99, stderr="Traceback (most recent call last):\n"), "traceback"),
        (replace(DONE, code=3), "exit code 3"),
        (replace(DONE, code=130), "exit code 130"),
        (replace(REFUSED, stderr=""), "0 lines for a refusal"),
        (replace(REFUSED, stderr=LINE + LINE), "2 lines for a refusal"),
        (replace(REFUSED, stderr="error\n"), "1 lines for a refusal"),
        (replace(REFUSED, stderr=LINE[:-1] + "x" * 1000 + "\n"), "a line of more than 1000 characters"),
        (replace(REFUSED, stderr=LINE[:-1] + "\x1b[31m\n"), "control characters in a line"),
        (replace(DONE, stderr="/a/b.py:3: RuntimeWarning: overflow\n"), "other lines on standard error"),
        (replace(DONE, code=1, stderr="masonry-cd: error: not enough memory\n"), "other lines on standard error"),
        (replace(DONE, seconds=31.0), "took 31 s"),
        (replace(DONE, memory=4.5e9), "took 4.5 GB"),
        (replace(DONE, left=("result.part.h5",)), "left result.part.h5"),
        (replace(DONE, left=("a.txt",)), "wrote a.txt"),
        (replace(REFUSED, output=True), "left an output after a refusal"),
    ],
)
def test_broken_promises(outcome: promises.Outcome, wrong: str) -> None:
    assert promises.broken(outcome) == wrong


def npz() -> bytes:
    import io

    out = io.BytesIO()
    np.savez(out, q=np.arange(6.0), mu=np.ones(2), W_indptr=np.arange(3))
    return out.getvalue()


GOOD = {
    inputs.BYTES: b"abc def\n" * 5,
    inputs.LINES: texts.RECORDS["at2"].encode(),
    inputs.TOKENS: texts.SCENES["sine"].encode(),
    inputs.TOML: texts.SCENES["shocks"].encode(),
    inputs.JSON: texts.blocks(),
    inputs.NPZ: npz(),
}


@pytest.mark.parametrize("change", GOOD)
def test_changes_repeat_and_mostly_change_something(change: str) -> None:
    content = GOOD[change]
    first, again = ([mutators.changed(content, change, np.random.default_rng([7, k])) for k in range(60)] for _ in range(2))
    assert first == again
    assert len(set(first)) > 40


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs os.fork")
@pytest.mark.parametrize("text", [texts.SCENES["sine"].replace("dt =", "td ="), "\0", ""])
def test_a_case_is_refused_in_a_process_of_its_own(tmp_path: Path, text: str) -> None:
    folder = tmp_path / "case"
    folder.mkdir()
    (folder / "scene.toml").write_text(text)
    outcome = worker.run_case(folder, ["run", "scene.toml", "-o", "written"], "written")
    assert (outcome.code, outcome.output, outcome.left) == (2, False, ())
    assert outcome.stderr.startswith("masonry-cd: error: scene.toml")
    assert promises.broken(outcome) == ""


@pytest.mark.skipif(not (together.PEAK.exists() and hasattr(os, "fork")), reason="needs os.fork and Linux")
def test_cases_in_one_process_end_as_they_do_alone(tmp_path: Path) -> None:
    """Records by the command line: one that is read, one refused, and one after what ended the process."""
    good = texts.RECORDS["at2"].encode()
    shared = [together.Case({"quake.at2": text}, ["record", "quake.at2"], "written") for text in (good, b"\0", good)]
    outcomes = [*together.run_cases(shared, tmp_path)]
    assert [one.code for one in outcomes] == [0, 2, 0]
    assert outcomes[0].stdout == outcomes[2].stdout == together.alone(shared[0], tmp_path).stdout
    assert outcomes[1].stderr.startswith("masonry-cd: error: record.path: quake.at2") and promises.broken(outcomes[1]) == ""
    assert [*tmp_path.iterdir()] == []


@pytest.mark.skipif(not (together.PEAK.exists() and hasattr(os, "fork")), reason="needs os.fork and Linux")
def test_a_case_that_ends_the_process_is_judged_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    good = together.Case({"quake.at2": texts.RECORDS["at2"].encode()}, ["record", "quake.at2"], "written")
    ends = good._replace(command=["record", "quake.at2", "--ends"])
    called = worker.called
    monkeypatch.setattr(worker, "called", lambda command: os.abort() if "--ends" in command else called(command))
    codes = [one.code for one in together.run_cases([good, ends, good], tmp_path)]
    assert codes == [0, -6, 0]
