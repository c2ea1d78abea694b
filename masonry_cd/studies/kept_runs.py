# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs of a measurement that takes hours: each is kept as it ends, so that the same command goes on after a kill, or with more of them.

A file has a line of JSON for each run that has ended, by its name; its first line says of what they are the runs.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from concurrent.futures import as_completed
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, TypeVar

from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.files import read_text
from masonry_cd.foundation.workers import workers as pool_of

Asked = TypeVar("Asked")
Row = dict[str, Any]


class KeptRuns:
    """The runs that have ended, by name.

    Args:
        file: where they are kept, made once there is one; its folder is made if need be.
        identity: of what they are the runs.
        force: begin anew.

    Raises:
        InputError: the file is that of something else.
    """

    def __init__(self, file: Path, identity: str, force: bool) -> None:
        self._file, self._identity = file, identity
        self._rows = {} if force else self._read()

    def make(
        self, function: Callable[[Asked], Row], asked: Mapping[str, Asked], workers: int, ended: Callable[[str, Row, int], None]
    ) -> dict[str, Row]:
        """Make those that are missing, in their order, each in one of some processes.

        Args:
            function: makes a run.
            asked: what it is given, by the name of the run.
            workers: processes.
            ended: called as a run ends with its name, what it came to, and how many are left.

        Raises:
            InputError: a run that cannot be made; a process that died. The others are kept.
        """
        missing = [name for name in asked if name not in self._rows]
        if missing:
            self._begin()
        with pool_of(workers, "spawn") as pool, self._file.open("a") as file:
            runs = {pool.submit(function, asked[name]): name for name in missing}
            try:
                for left, run in enumerate(as_completed(runs), 1 - len(missing)):
                    self._rows[runs[run]] = run.result()
                    print(json.dumps([runs[run], self._rows[runs[run]]]), file=file, flush=True)
                    ended(runs[run], self._rows[runs[run]], -left)
            except BrokenProcessPool:
                raise InputError("", f"a process of the runs died, perhaps for want of memory; those in {self._file} are kept") from None
        return {name: self._rows[name] for name in asked}

    def _begin(self) -> None:
        """Write anew what is known: a kill may have torn the last line."""
        self._file.parent.mkdir(parents=True, exist_ok=True)
        own_files.note(self._file, growing=True)
        with replacing(self._file) as part:
            part.write_text("".join(json.dumps(line) + "\n" for line in [self._identity, *self._rows.items()]))

    def _read(self) -> dict[str, Row]:
        """What the file holds; lines that are no JSON are those of runs to be made again."""
        if not self._file.exists():
            return {}
        first, *lines = read_text(self._file).splitlines() or [""]
        if first != json.dumps(self._identity):
            of = "of another scene, or of one that was changed, or of another version of the program"
            raise InputError(self._file, f"{of}; choose another folder, or --force to begin anew")
        return dict(found for line in lines if (found := _parsed(line)) is not None)


def _parsed(line: str) -> tuple[str, Row] | None:
    """The name of a run and what it came to."""
    try:
        name, row = json.loads(line)
    except ValueError:
        return None
    return str(name), dict(row)
