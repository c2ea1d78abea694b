# SPDX-License-Identifier: GPL-3.0-or-later
"""Finished parts of an analysis, kept in its folder, so that a stopped analysis continues where it ended.

``parts.kept`` has a record for each part and push: its length, and the pickled analysis behind a stamp of scene, blocks and version. A part
of another stamp is analysed again, and the last record is left out where a kill cut it short. Only our own values and arrays are read.
mechanisms.csv grows next to it. Once all is written, parts.kept goes.
"""

from __future__ import annotations

import hashlib
import io
import pickle
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from masonry_cd.analysis.limit.macro import ElementAnalysis
from masonry_cd.foundation import own_files
from masonry_cd.foundation.errors import InputError

if TYPE_CHECKING:
    from masonry_cd.app.limit_structure import LimitStructure
    from masonry_cd.limit.checked import Checked
    from structures.macro_elements import MacroElement

NAME = "parts.kept"
LENGTH = 8  # bytes of the length of a record
READ = {  # what a record may consist of, by its module
    "masonry_cd.analysis.limit.macro": {"ElementAnalysis"},
    "masonry_cd.analysis.limit.found": {"FoundMechanism"},
    "masonry_cd.analysis.limit.mechanism": {"Mechanism"},
    "masonry_cd.analysis.limit.oscillator": {"Oscillator"},
    "masonry_cd.analysis.limit.outcome": {"SearchNumbers"},
    "structures.macro_elements.element": {"MacroElement"},
    "numpy": {"ndarray", "dtype"},
    "numpy._core.multiarray": {"_reconstruct", "scalar"},
    "numpy.core.multiarray": {"_reconstruct", "scalar"},
    "numpy._core.numeric": {"_frombuffer"},
    "numpy.core.numeric": {"_frombuffer"},
}


@dataclass
class KeptParts:
    """The finished parts of an analysis, in a folder that is created with the first of them."""

    folder: Path
    stamp: bytes
    known: dict[tuple[str, tuple[float, ...]], ElementAnalysis] = field(default_factory=dict)
    begun: bool = False  # whether the file is that of this analysis
    others: int = 0  # records of another scene, other blocks or another version, which are of no use

    @classmethod
    def to(cls, folder: Path, structure: LimitStructure, resume: bool) -> KeptParts:
        """The parts kept in a folder where an analysis is to be resumed; none of a new one.

        Raises:
            InputError: a record that is none of ours.
        """
        made, file = cls(folder, _stamp(structure)), folder / NAME
        for record in _records(file) if resume else ():
            if not record.startswith(made.stamp):
                made.others += 1
                continue
            try:
                part = _Reader(io.BytesIO(record[len(made.stamp) :])).load()
            except (pickle.UnpicklingError, EOFError, ValueError, TypeError) as failure:
                raise InputError(file, f"is damaged, {failure}; --force begins again") from None
            made.known[_key(part)] = part
        return made

    def of(self, push: tuple[MacroElement, Sequence[float]]) -> ElementAnalysis | None:
        """The analysis of a part under a push, where it is kept."""
        element, way = push
        return self.known.get((element.name, tuple(map(float, way))))

    def add(self, part: ElementAnalysis, rows: Sequence[Checked]) -> None:
        """Keep a part, and write the table of all mechanisms so far."""
        from reports.limit.tables import write_mechanisms

        if not self.begun:
            own_files.begin(self.folder, (NAME,))
            own_files.note(self.folder / NAME, growing=True)
            (self.folder / NAME).write_bytes(b"".join(map(self._record, self.known.values())))
            self.begun = True
        if _key(part) not in self.known:
            with (self.folder / NAME).open("ab") as file:
                file.write(self._record(part))
        write_mechanisms([each.row for each in rows], self.folder)

    def _record(self, part: ElementAnalysis) -> bytes:
        record = self.stamp + pickle.dumps(part, protocol=4)
        return len(record).to_bytes(LENGTH, "big") + record


def _key(part: ElementAnalysis) -> tuple[str, tuple[float, ...]]:
    """The name of a part and the direction of its push."""
    return part.element.name, tuple(part.direction.tolist())


class _Reader(pickle.Unpickler):
    """Reads records that consist of our own values and arrays, and of nothing else."""

    def find_class(self, module: str, name: str) -> Any:
        """A class of READ.

        Raises:
            UnpicklingError: any other.
        """
        if name not in READ.get(module, ()):
            raise pickle.UnpicklingError(f"{module}.{name} has no place in {NAME}")
        return super().find_class(module, name)


def _records(file: Path) -> list[bytes]:
    """The whole records of a file; none where it is not there."""
    data, found, at = file.read_bytes() if file.exists() else b"", [], 0
    while at + LENGTH <= len(data):
        end = at + LENGTH + int.from_bytes(data[at : at + LENGTH], "big")
        if end > len(data):
            break
        found.append(data[at + LENGTH : end])
        at = end
    return found


def _stamp(structure: LimitStructure) -> bytes:
    """A digest of the input of the analysis of a part: the text of the scene, the blocks, the version."""
    from masonry_cd import __version__

    sha = hashlib.sha256(f"{__version__}\n{structure.scene.text}".encode())
    for block in structure.assembly.blocks:
        sha.update(np.ascontiguousarray(block.vertices).tobytes())
    return sha.digest()
