# SPDX-License-Identifier: GPL-3.0-or-later
"""The folder of a study: what it was, and what each finished run came to, so that the same command continues it.

study.toml        the study file as given
study.json        what it resolves to, for the statistics
rows/NAME.json    a finished run: done, failed or timeout
rows/NAME.hang    where a run hung that was ended by the watchdog
joints/NAME.npz   the joints of a run that is done
reference/        result.h5 of the first run of the plan that is done
runs/NAME/        run folders, where they are kept
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Mapping
from fnmatch import fnmatchcase
from pathlib import Path

import numpy as np

from masonry_cd.analysis.fragility.folder import FILE, StudyFacts, read_facts
from masonry_cd.analysis.outputs.folders import files_of
from masonry_cd.analysis.run_row import RunRow, row_of
from masonry_cd.app.folders import names_of_run
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.studies.study.plan import Planned
from masonry_cd.studies.study.study_file import ReadStudy
from masonry_cd.studies.study.task import ROWS, SCENE, Outcome
from masonry_cd.studies.study.watchdog import SUFFIX as HANG

NAME, TEXT = FILE, "study.toml"
JOINTS, REFERENCE, RUNS = "joints", "reference", "runs"
KEPT = (ROWS, JOINTS, REFERENCE, RUNS)  # its folders
ABOUT = ("run", "motion", "level", "member", "values")  # keys of a row's file that say what was asked


class StudyFolder:
    """A study's folder.

    Args:
        path: created if missing, once something is written.
    """

    def __init__(self, path: Path) -> None:
        self.path = path

    def require_same(self, identity: Mapping[str, str]) -> None:
        """Refuse the folder of another study, or one that holds something else.

        Raises:
            InputError: names what differs.
        """
        if not (self.path / NAME).exists():
            if any((self.path / name).exists() for name in (ROWS, "result.h5")):
                raise InputError(self.path, f"holds results, and no {NAME} says of which study; choose another folder, or --force")
            return
        try:
            then = read_facts(self.path).identity
        except InputError as error:
            raise InputError(error.place, f"{error.faults[0].text}; choose another folder, or --force") from None
        for name, digest in identity.items():
            if then.get(name) != digest:
                raise InputError(self.path, f"holds another study, of another {name}; choose another folder, or --force to begin again")

    def require_own(self) -> None:
        """Refuse to clear a folder where somebody else has put something.

        Raises:
            InputError: names all of these files.
        """
        own_files.check(self.path, self._names(), is_study)
        old = not (self.path / own_files.LIST).exists() and is_study(self.path)
        places = [self.path / name for name in KEPT]
        others = [path for place in places for path in own_files.others_below(place, OF_OLD[place.name] if old else _is_in_progress)]
        own_files.refuse(self.path, [str(path.relative_to(self.path)) for path in others])

    def hold(self, more: Iterable[str] = ()) -> None:
        """Make the folder if need be, with its list of own files; ``more`` names files that the study brings along.

        Raises:
            InputError: a file of somebody else lies where one of a study goes.
        """
        own_files.begin(self.path, (*self._names(), *more), is_study)

    def _names(self) -> tuple[str, ...]:
        """All files next to the folders that a study or an assessment may write."""
        return (*files_of("study"), *files_of("assess"), *files_of("calibrate"), *files_of("accuracy"), NAME, TEXT, "probability_*.png")

    def clear(self) -> None:
        """Take away what a former study left; :meth:`require_own` has looked before."""
        for name in KEPT:
            shutil.rmtree(self.path / name, ignore_errors=True)
        (self.path / NAME).unlink(missing_ok=True)

    def begin(self, study: ReadStudy, facts: StudyFacts) -> None:
        """Write what the study is."""
        old = is_study(self.path)
        self.hold()
        for name, files in ((ROWS, ("*.json",)), (JOINTS, ("*.npz",)), (REFERENCE, ("result.h5", "run.txt"))):
            own_files.begin(self.path / name, files, lambda _: old)
        for part in [*(self.path / ROWS).glob("*.part.*"), *(self.path / JOINTS).glob("*.part.*")]:
            part.unlink()
        for part in (self.path / RUNS).glob("*.part"):
            shutil.rmtree(part, ignore_errors=True)
        with replacing(self.path / TEXT) as part:
            part.write_text(study.text, encoding="utf-8")
        self.describe(facts)

    def describe(self, facts: StudyFacts) -> None:
        """Write study.json."""
        with replacing(self.path / NAME) as part:
            part.write_text(json.dumps(facts.as_dict(), indent=1, default=str) + "\n", encoding="utf-8")

    def finished(self, retry: bool) -> dict[str, RunRow]:
        """The rows of runs that have ended; with ``retry`` those that are done alone."""
        found = {file.stem: _read_row(file) for file in (self.path / ROWS).glob("*.json")}
        return {name: row for name, row in found.items() if row.status and (row.done or not retry)}

    def forget_hangs(self, runs: Iterable[Planned]) -> None:
        """Remove the marks of runs that hung, before they are repeated."""
        again = {run.name for run in runs}
        for trace in (self.path / ROWS).glob(f"*{HANG}"):
            if trace.stem in again:
                trace.unlink()

    def add(self, run: Planned, outcome: Outcome) -> None:
        """Write what a run came to; its row last, so that a row stands for all of it."""
        if outcome.joints is not None:
            with replacing(self.path / JOINTS / f"{run.name}.npz") as part, part.open("wb") as stream:
                np.savez_compressed(stream, **outcome.joints)
        if outcome.reference is not None:
            self.write_reference(run.name, outcome.reference)
        asked = run.asked
        about = dict(zip(ABOUT, (run.name, asked.motion, asked.level, asked.member, dict(asked.values)), strict=True))
        with replacing(self.path / ROWS / f"{run.name}.json") as part:
            part.write_text(json.dumps({**about, **outcome.row.as_dict()}, default=str) + "\n", encoding="utf-8")

    def has_reference(self, name: str) -> bool:
        """Return True if the reference is the result of a run."""
        named = self.path / REFERENCE / "run.txt"
        there = named.is_file() and (self.path / REFERENCE / "result.h5").is_file()
        return there and named.read_text(encoding="utf-8").strip() == name

    def write_reference(self, name: str, results: bytes) -> None:
        """Write the result file of a run as the reference."""
        (self.path / REFERENCE / "run.txt").unlink(missing_ok=True)
        with replacing(self.path / REFERENCE / "result.h5") as part:
            part.write_bytes(results)
        with replacing(self.path / REFERENCE / "run.txt") as part:
            part.write_text(name + "\n", encoding="utf-8")


def is_study(folder: Path) -> bool:
    """Return True if a folder that has no list of its files is that of a study of an earlier version: by its study.json."""
    try:
        return {"format", "program", "identity"} <= set(json.loads(read_text(folder / NAME)))
    except (OSError, ValueError, TypeError):
        return False


def _is_in_progress(path: Path) -> bool:
    """Return True if a kill may have left it, by its path in a study's folder: a file half written, a run half copied, a hang's trace."""
    return own_files.HALF in path.name or path.parts[0].endswith(".part") or path.suffix == HANG


def _is_of_old_run(path: Path) -> bool:
    """Return True if a run of an earlier version has left it in ``runs/NAME``."""
    return len(path.parts) == 2 and any(fnmatchcase(path.name, name) for name in (*names_of_run(), SCENE))


# How files of earlier versions, which wrote no lists, are known: by folder, from the path below it
OF_OLD: dict[str, Callable[[Path], bool]] = {
    ROWS: lambda path: path.suffix == ".json" or _is_in_progress(path),
    JOINTS: lambda path: path.suffix == ".npz" or _is_in_progress(path),
    REFERENCE: lambda path: path.name in ("result.h5", "run.txt") or _is_in_progress(path),
    RUNS: lambda path: _is_of_old_run(path) or _is_in_progress(path),
}


def digest_of(value: object) -> str:
    """A digest of what JSON can write."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, default=str).encode()).hexdigest()[:16]


def _read_row(file: Path) -> RunRow:
    """A row; an empty one where it is damaged: its run is repeated."""
    try:
        return row_of(json.loads(file.read_text(encoding="utf-8")), ABOUT)
    except (OSError, ValueError, TypeError, AttributeError):
        return RunRow()
