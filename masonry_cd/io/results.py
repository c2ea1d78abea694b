# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading the result file of a run: the one way by which reports, exports, comparisons and resumed runs get at results.

Opening a file checks all of it: that it is whole, that names, types, shapes and indices are those of layout.py, and the checksums of
segments.py. Rows that do not hold are left out, from the first segment in which anything is damaged, and ``words`` says so; whatever
leaves nothing to report is an InputError of one line.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from masonry_cd.foundation.errors import InputError, in_a_line
from masonry_cd.io.block_arrays import Meshes, read_blocks, read_fill
from masonry_cd.io.gauges import Gauges, read_gauges
from masonry_cd.io.hdf5_file import READ_ERRORS, open_to_read
from masonry_cd.io.layout import (
    CLOSING,
    DATASETS,
    ELEMENT_STRESS,
    FORMAT,
    GRADIENT,
    JOINT_CONSTANTS,
    JOINT_PEAKS,
    NODE_DISPLACEMENT,
    PRESENT,
    REACTION,
    SHOCK_PEAKS,
    STEP_PEAKS,
    STRESS,
)
from masonry_cd.io.result_checks import check_constants, check_growing, rows_that_read
from masonry_cd.io.segments import Segments, checksum_of_constants, checksum_of_peaks, checksum_of_step_peaks
from masonry_cd.io.summary import Summary
from masonry_cd.io.tie_bars import TieBar, read_bars
from masonry_cd.mechanics.dynamics.pauses import Aftermath
from masonry_cd.mechanics.model.blocks import Block
from masonry_cd.mechanics.model.fill import CoveredFaces
from masonry_cd.mechanics.model.joints import Joints

CHUNK_BYTES = 1 << 24  # of frames that are read together
SUPPORT_FRAMES = 200  # looked at for the support that moves least
SAME = 1e-6  # share of the largest motion of a support by which others may differ and count as moving alike


class Results:
    """A result file, read lazily. Use ``Results.open(path)`` or the class as a context manager."""

    def __init__(self, file: h5py.File, path: Path, unfinished: bool = False, sums: bool = True) -> None:
        """Check an open file, see :meth:`open`; ``unfinished``: its writer has not closed it."""
        self.file, self.path = file, path
        self.format = int(file.attrs.get("format", 0))  # 0: from before there were checksums
        if self.format > FORMAT:
            raise InputError(path, f"has format {self.format} of a newer masonry_cd; this version reads formats up to {FORMAT}")
        self.words: tuple[str, ...] = ()  # what is damaged, a line each
        sizes = check_constants(file, path)
        self._segments = Segments(file, unfinished, sums) if self.format else None
        self._peaks_hold = self.format == 0 or checksum_of_peaks(file) == int(file["segments/peaks"][0])
        self._step_peaks_hold = "peaks" in file and checksum_of_step_peaks(file) == int(file["segments/step_peaks"][0])
        if self.format and checksum_of_constants(file) != file.attrs["constant"]:
            raise InputError(path, "damaged: its blocks, joints or scene have changed since they were written")
        self._rows = rows_that_read(file, path) if self._segments is None else self._segments.last
        check_growing(file, path, self._rows, sizes)
        self._say_what_is_damaged(unfinished)

    def _say_what_is_damaged(self, unfinished: bool) -> None:
        """Fill ``words``; refuse a file of which no frame holds."""
        damaged = self._segments is not None and self._segments.damaged
        if not self.frames:
            what = (
                "damaged from its first frame on" if damaged else "not the result of a run, or of a run that ended before its first frame"
            )
            raise InputError(self.path, str(what))
        lines = []
        if damaged:
            lines.append(f"{self.path}: damaged; data after {self.time[-1]:.6g} s is left out ({self.frames} frames are intact)")
        if not self._peaks_hold and not unfinished:
            lines.append(f"{self.path}: the largest values of the joints are damaged; the largest values of the frames are used")
        if "peaks" in self.file and not self._step_peaks_hold and not unfinished:
            lines.append(f"{self.path}: the largest drifts and hinges are damaged; the largest values of the frames are used")
        self.words = tuple(lines)

    @classmethod
    def open(cls, path: Path, sums: bool = True) -> Results:
        """Open a result file, also one whose run was killed or is at work.

        Args:
            path: of the file.
            sums: compare the checksums of what grows, for which all of it is read; not for one that this process is writing.

        Raises:
            InputError: no such file, no HDF5 file, no result of a run, one of a newer format, or one of which nothing holds.
        """
        path = Path(path)
        if not path.exists():
            raise InputError(path, "no such result file")
        file, unfinished = open_to_read(path)
        try:
            return cls(file, path, unfinished, sums)
        except InputError:
            file.close()
            raise
        except (*READ_ERRORS, IndexError, AttributeError) as reason:
            file.close()
            raise InputError(path, f"damaged: {in_a_line(reason)}") from None

    def __enter__(self) -> Results:
        return self

    def __exit__(self, *_: object) -> None:
        self.file.close()

    def rows(self, name: str) -> int:
        """Rows that hold of a dataset that grows; 0 where there is none of the name."""
        return self._rows.get(name, 0)

    def segments_up_to(self, rows: Mapping[str, int]) -> int:
        """How many segments there are up to the given rows of each dataset.

        Raises:
            InputError: the file has fewer rows that hold, or no segment ends there.
        """
        if self._segments is None or any(self.rows(name) < count for name, count in rows.items()):
            damage = " (later data is damaged)" if self.words else ""
            raise InputError(self.path, f"has fewer frames than its checkpoint{damage}, so the run cannot be resumed")
        found = self._segments.ending_at(rows)
        if found is None:
            raise InputError(self.path, "the checkpoint next to it belongs to other results, so the run cannot be resumed")
        return found

    @cached_property
    def frames(self) -> int:
        """Number of frames whose positions, orientations and joints are all written."""
        return min(self.rows(one.name) for one in DATASETS if one.shape[0] == "F" and one.name in self.file)

    def gradient(self, frame: int) -> np.ndarray | None:
        """Gradients of the displacement within the blocks at a frame, body frames, (B, 3, 3); None where none deforms.

        A block that is not there has shrunk to its centre.
        """
        found = np.asarray(self.file[GRADIENT][frame], dtype=float) if GRADIENT in self.file else None
        there = self.present(frame)
        if not there.all():
            found = np.zeros((len(there), 3, 3)) if found is None else found
            found[~there] = -np.eye(3)
        return found

    def present(self, frame: int = -1) -> np.ndarray:
        """Which blocks are there at a frame, (B,) bool; frames below zero count from the last."""
        if PRESENT not in self.file:
            return np.ones(len(self.blocks), dtype=bool)
        return np.asarray(self.file[PRESENT][range(self.frames)[frame]], dtype=bool)

    @cached_property
    def time(self) -> np.ndarray:
        """(F,) [s]."""
        return self.file["time"][: self.frames]

    @cached_property
    def support(self) -> int:
        """Block to which displacements are relative: the support that moves least in the run, the first of equals; -1 without one.

        Where all supports move together it is the first; where some of them settle or spread, one that stays. Older versions did not write
        it: then it is the one that moves least over the frames.
        """
        if "blocks/support" in self.file:
            return int(self.file["blocks/support"][0])
        fixed = np.flatnonzero([block.fixed for block in self.blocks])
        if not len(fixed):
            return -1
        frames = np.unique(np.linspace(0, self.frames - 1, min(self.frames, SUPPORT_FRAMES)).round().astype(int))
        places = np.array([self.position[frame][fixed] for frame in frames.tolist()], dtype=float)
        farthest = np.linalg.norm(places - places[0], axis=2).max(axis=0)
        return int(fixed[np.argmax(farthest <= farthest.min() + SAME * farthest.max())])

    @property
    def position(self) -> h5py.Dataset:
        """(F or more, B, 3) [m], read on indexing."""
        return self.file["position"]

    @property
    def orientation(self) -> h5py.Dataset:
        """(F or more, B, 4), read on indexing."""
        return self.file["orientation"]

    @property
    def velocity(self) -> h5py.Dataset:
        """(F or more, B, 6) [m/s, rad/s], read on indexing."""
        return self.file["velocity"]

    @cached_property
    def blocks(self) -> tuple[Block, ...]:
        """The blocks as they were built."""
        return tuple(read_blocks(self.file["blocks"]))

    @cached_property
    def fill(self) -> CoveredFaces | None:
        """The faces on which the fill of bridges lies; None without one, and in a file of an older version."""
        return read_fill(self.file["blocks"])

    @cached_property
    def ties(self) -> tuple[TieBar, ...]:
        """The bars of all ties, in the order of ``ties/tension``; none in a file without ties, or of an older version."""
        return read_bars(self.file, len(self.blocks))

    @cached_property
    def gauges(self) -> Gauges:
        """Return the histories at gauges, see :mod:`masonry_cd.io.gauges`."""
        return read_gauges(self.file)

    @cached_property
    def joints(self) -> Joints:
        """The joints at rest."""
        return Joints(**{name: self.file["joints"][name][...] for name in JOINT_CONSTANTS})

    @property
    def has_stress(self) -> bool:
        """Return True if the run kept the stress of its blocks and joints, which a scene asks for."""
        return STRESS in self.file

    @property
    def stress(self) -> h5py.Dataset:
        """(F or more, B, 6) mean stress since the frame before, see layout.py [Pa], read on indexing."""
        return self.file[STRESS]

    @cached_property
    def meshes(self) -> Meshes | None:
        """The meshes of the blocks whose elements' stress the run kept; None where there are none."""
        return Meshes.read(self.file) if "meshes" in self.file else None

    @property
    def element_stress(self) -> h5py.Dataset:
        """(F or more, E, 6) mean stress of the elements since the frame before, see layout.py [Pa], read on indexing."""
        return self.file[ELEMENT_STRESS]

    @property
    def node_displacement(self) -> h5py.Dataset:
        """(F or more, K, 3) of the nodes, beyond the rigid block, body frames, see layout.py [m], read on indexing."""
        return self.file[NODE_DISPLACEMENT]

    def in_chunks(self, numbers: int) -> Iterator[slice]:
        """Slices of the frames in their order, of some 16 MB each where a frame has this many ``numbers``, for little memory."""
        rows = max(1, CHUNK_BYTES // (8 * numbers))
        for first in range(0, self.frames, rows):
            yield slice(first, min(first + rows, self.frames))

    def has_joint_history(self, name: str) -> bool:
        """Return True if the run wrote a history of its joints; older versions wrote fewer."""
        return f"joints/{name}" in self.file

    def joint_history(self, name: str) -> np.ndarray:
        """(F, J) history of opening, sliding, rotation, contact_area, normal_force, shear_force, and of bonded and crushed where
        joints are; (F, J, 3) of force_point."""
        return self.file[f"joints/{name}"][: self.frames]

    def joints_at(self, name: str, frame: int) -> np.ndarray:
        """(J,) or (J, 3), a history at a frame; those below zero count from the last."""
        return np.asarray(self.file[f"joints/{name}"][range(self.frames)[frame]])

    @property
    def reaction(self) -> np.ndarray | None:
        """(F, S, 6) forces and moments of the supports, in the order of the blocks, see layout.py [N, N m]; None in older files."""
        return np.asarray(self.file[REACTION][: self.frames], dtype=float) if REACTION in self.file else None

    @property
    def peaks(self) -> dict[str, np.ndarray]:
        """Largest joint measures over all steps, (J,) each; NaN where a run was killed before it wrote them, or where they are damaged."""
        found = {name: self.file[f"joints/peak/{name}"][...] for name in JOINT_PEAKS}
        return found if self._peaks_hold else {name: np.full_like(values, np.nan) for name, values in found.items()}

    @property
    def step_peaks(self) -> dict[str, np.ndarray]:
        """The largest drifts, displacements and hinges over all steps by the names of STEP_PEAKS; empty in a file of an older version.

        All are NaN where a run was killed before it wrote them, or where they are damaged.
        """
        found = {name: self.file[f"peaks/{name}"][...] for name in STEP_PEAKS} if "peaks" in self.file else {}
        return found if self._step_peaks_hold else {name: np.full_like(values, np.nan) for name, values in found.items()}

    @property
    def has_peaks_of_steps(self) -> bool:
        """Return True if the largest drifts, displacements and hinges are known over all steps, not only over the frames."""
        return self._step_peaks_hold and not np.isnan(self.file["peaks/drift"][...]).any()

    def step_peaks_after(self, shock: int) -> dict[str, np.ndarray]:
        """Those of SHOCK_PEAKS up to the end of the rest after a shock; empty in a file of an older version."""
        return {name: self.file[f"shocks/peaks/{name}"][shock] for name in SHOCK_PEAKS} if "shocks/peaks" in self.file else {}

    @cached_property
    def shocks(self) -> tuple[Aftermath, ...]:
        """The shocks of a sequence whose rests are over; none for any other run."""
        count = self.rows("shocks/frame")
        columns = (self.file[f"shocks/{name}"][:count] for name in ("name", "start", "end", "frame") if count)
        found = (Aftermath(n.decode(), float(a), float(b), int(f)) for n, a, b, f in zip(*columns, strict=True))
        return tuple(shock for shock in found if shock.frame < self.frames)

    def peaks_after(self, shock: int) -> dict[str, np.ndarray]:
        """Largest joint measures up to the end of the rest after a shock, (J,) each."""
        return {name: self.file[f"shocks/{name}"][shock] for name in JOINT_PEAKS}

    def per_step(self, name: str) -> np.ndarray:
        """(N,) a value per step, e.g. ``solver/error``, ``energy/kinetic``, ``penetration``; empty where the run wrote none."""
        return self.file[name][: self.rows(name)] if name in self.file else np.zeros(0)

    @property
    def energies(self) -> dict[str, np.ndarray]:
        """(N,) of each energy by its name [J]."""
        return {name: self.per_step(f"energy/{name}") for name in self.file.get("energy", ())}

    @cached_property
    def closing(self) -> Summary | None:
        """Return the contents of summary.json of a run that has ended, without the damage; None for one that has not."""
        count = self.rows(CLOSING)
        return Summary.model_validate_json(self.file[CLOSING][:count].tobytes()) if count else None

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the program that wrote the run, and of what decides its numbers."""
        return dict(json.loads(str(self.file.attrs.get("versions", "{}"))))

    @property
    def inputs(self) -> dict[str, str]:
        """SHA-256 of the files that the scene reads, by their names in it."""
        return dict(json.loads(str(self.file.attrs.get("inputs", "{}"))))

    @property
    def title(self) -> str:
        """The title of the case."""
        return str(self.file.attrs["title"])

    @property
    def scene(self) -> str:
        """The text of the scene file that made this run."""
        return str(self.file.attrs["scene"])

    @cached_property
    def tables(self) -> dict[str, Any]:
        """The tables of that text; empty where the result keeps none."""
        return tomllib.loads(self.scene)

    @property
    def scene_file(self) -> Path:
        """Where the scene file lay when the run began, as seen from here; older versions did not write it: then next to the results."""
        return self.path.parent / str(self.file.attrs.get("scene_file", "") or "scene.toml")
