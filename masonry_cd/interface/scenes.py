# SPDX-License-Identifier: GPL-3.0-or-later
"""Scenes: what stands, what shakes it, how it is computed; from a file, a dict, keywords, or arrays.

A scene in Python is what the command line makes of a scene file: a checked text. One that is *of a file* keeps the file's text, its
changes are those of ``--set``, and its relative paths begin where the file lies. One *made in Python* is written as TOML; its arrays become
files next to that text (:mod:`masonry_cd.interface.arrays`), in a temporary folder at first and in that of each run of it, where the text
is scene.toml. Other files that it names are named by their full paths, so that it may be run anywhere.
"""

from __future__ import annotations

import html
import os
import re
import shutil
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from masonry_cd.app.folders import is_run, names_of_run
from masonry_cd.app.inputs import paths_of
from masonry_cd.app.scene import Scene as CheckedScene
from masonry_cd.app.scene import parse_scene
from masonry_cd.app.scene_text import dump_toml, override, parse_toml, read_text
from masonry_cd.foundation import own_files
from masonry_cd.foundation.atomic import replacing
from masonry_cd.foundation.errors import InputError
from masonry_cd.interface.arrays import BLOCK_FILE, hold_arrays, into_files
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.temporary import TemporaryFolder
from masonry_cd.interface.values import changes as changes_of
from masonry_cd.interface.values import plain, with_absolute_paths

if TYPE_CHECKING:
    from PIL.Image import Image

    from masonry_cd.interface.structure import Structure
    from masonry_cd.io.results import Results

CALLED = "scene"  # one made in Python, in messages
FILE = "scene.toml"  # one made in Python, in the folder of its run
OWN_FILES = re.compile(rf"{re.escape(BLOCK_FILE)}|motion\d+\.csv")


@dataclass(frozen=True)
class _Origin:
    """The text that a scene began as."""

    text: str
    path: Path
    called: str  # by messages; empty where they name the lines of a file
    changes: tuple[str, ...] = ()

    def checked(self) -> CheckedScene:
        return parse_scene(self.text, self.path, self.changes, self.called)


class Scene(Sealed):
    """A checked scene. It does not change: :meth:`changed` gives another one. Made by :func:`masonry_cd.scene`.

    ``print(scene)`` shows its text, TOML as in a scene file.
    """

    def __init__(self, origin: _Origin, files: TemporaryFolder | None = None) -> None:
        self._origin, self._files = origin, files
        self._checked = origin.checked()

    @property
    def checked(self) -> CheckedScene:
        """Return the checked tables of the application."""
        return self._checked

    @property
    def title(self) -> str:
        """Title of pictures and closing lines."""
        return self._checked.title

    @property
    def text(self) -> str:
        """The scene as TOML: all that a run depends on except the files that it names."""
        return self._checked.text

    @property
    def tables(self) -> dict[str, Any]:
        """The tables of the text, a new copy: ``scene.tables["run"]["dt"]``."""
        return deepcopy(dict(self._checked.tables))

    def changed(self, *changes: str, **tables: Any) -> Scene:
        """Another scene, in which some keys are changed.

        Args:
            changes: ``key=value`` as ``--set`` takes it.
            tables: by keyword, as :func:`masonry_cd.scene` takes them. Keys of a table are changed one by one, others stay; a table that
                says its ``kind`` takes the place of the one before, and lists are replaced as a whole.

        Raises:
            InputError: see :func:`masonry_cd.scene`.

        >>> import masonry_cd as mc
        >>> arch = mc.scene("examples/arch.toml")
        >>> finer = arch.changed("run.dt=5e-4", structure={"thickness": 0.35})
        >>> finer.tables["run"]["dt"], finer.tables["structure"]["thickness"], finer.title == arch.title
        (0.0005, 0.35, True)
        """
        if self._files is None and not hold_arrays(tables):
            made = (*self._origin.changes, *changes, *changes_of(plain(tables, ""), self.tables))
            return Scene(replace(self._origin, changes=made))
        now = self.tables
        if self._files is None:
            now = with_absolute_paths(now, self._checked.folder)
        return _made(now, changes, tables, self._checked.folder if self._files else None)

    @cached_property
    def structure(self) -> Structure:
        """The blocks that stand.

        Raises:
            InputError: blocks that are unsound, or keys of the structure that are wrong.
        """
        from masonry_cd.app.case import make_structures
        from masonry_cd.interface.structure import Structure
        from structures.ties import lines_of

        blocks, notes, bars = make_structures(self._checked)[:3]
        return Structure(blocks, tuple(notes), lines_of(bars))

    def to_compas(self) -> list[dict[str, Any]]:
        """The blocks as meshes of COMPAS, for ``json.dump``; :func:`masonry_cd.from_compas` reads them back.

        Raises:
            InputError: a sphere, which is not a mesh; see also :attr:`structure`.
        """
        from masonry_cd.interface.compas import to_compas

        return to_compas(self.structure.blocks)

    def to_deck(self, folder: str | os.PathLike[str], program: str, *, force: bool = False) -> list[Path]:
        """Write the deck of another program, as ``masonry-cd export`` does; return its files.

        Args:
            folder: created if missing.
            program: "lmgc90" or "3dec".
            force: whether files that are there may be overwritten.

        Raises:
            InputError: what that program has no words for, or files that are there.
        """
        from masonry_cd.app.commands.export import deck
        from masonry_cd.interface.returned import returned

        result = deck(self._checked, program, Path(folder), force)
        returned(result)
        return list(result.written)

    def picture(self, view: str = "auto") -> Image:
        """The structure by groups of blocks, as an image that a notebook shows.

        Args:
            view: auto (front for structures that are prisms across y, else isometric), front, back, side, left, top or isometric.
        """
        return self.structure.picture(self.title, view)

    def write(self, path: str | os.PathLike[str], *, force: bool = False) -> Path:
        """Write the scene as a file that the command line takes, and next to it the files that hold its arrays; return its path.

        Args:
            path: of the scene file.
            force: overwrite files that are there with another content.

        Raises:
            InputError: such a file, or a scene of a file with relative paths that is written into another folder.
        """
        path = Path(path)
        relative = sorted(name for name in self._named() if not Path(name).is_absolute())
        if self._files is None and relative and path.absolute().parent != self._checked.folder.absolute():
            raise InputError(path, f"the scene names {relative[0]}, which is relative to {self._checked.folder}: write it there")
        contents = {path: self.text.encode()} | {path.with_name(name): (self._checked.folder / name).read_bytes() for name in self._own()}
        for file, content in contents.items():
            if not force and file.exists() and (file.is_dir() or file.read_bytes() != content):
                raise InputError(file, "exists already with other content; choose another folder, or overwrite it with force=True")
        path.parent.mkdir(parents=True, exist_ok=True)
        for file, content in contents.items():
            with replacing(file) as part:
                part.write_bytes(content)
        return path

    def placed(self, folder: Path, force: bool) -> CheckedScene:
        """The scene as a run in a folder takes it; one made in Python is written there, over existing files where that is requested."""
        if self._files is None:
            return self._checked
        own_files.begin(folder, (*names_of_run(), FILE, *self._own()), is_run)
        return replace(self._checked, path=self.write(folder / FILE, force=force))

    def portable(self) -> tuple[dict[str, Any], dict[str, bytes]]:
        """Its tables with full paths, and the files that hold its arrays, by the names that the tables give them."""
        own = {name: (self._checked.folder / name).read_bytes() for name in self._own()}
        return with_absolute_paths(self.tables, self._checked.folder, frozenset(own)), own

    def __reduce__(self) -> tuple[Any, ...]:
        own = None if self._files is None else {name: (self._checked.folder / name).read_bytes() for name in self._own()}
        return _again, (self._origin, own)

    def _named(self) -> set[str]:
        """Names of the files that the scene reads."""
        return set(paths_of([self._checked.structure, *self._checked.structures, *self._checked.loads]))

    def _own(self) -> list[str]:
        """Names of the files that hold its arrays."""
        return sorted(name for name in self._named() if OWN_FILES.fullmatch(name)) if self._files is not None else []

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        tables, run = self._checked.structures or (self._checked.structure,), self._checked.run
        kind = " + ".join(str(table.get("kind", "?")) for table in tables)
        loads = ", ".join(str(load.get("kind", "?")) for load in self._checked.loads) or "gravity"
        length = f"{run.duration:g} s" if run.has_duration else "as long as its loads"
        return f'<Scene "{self.title}": {kind}, {loads}, {"limit analysis" if self._checked.static else length}>'

    def _repr_html_(self) -> str:
        return (
            f"<details open><summary><b>{html.escape(self.title)}</b></summary>"
            f'<pre style="line-height:1.3">{html.escape(self.text)}</pre></details>'
        )


def scene(source: str | os.PathLike[str] | Mapping[str, Any] | Scene | None = None, /, *changes: str, **tables: Any) -> Scene:
    """A scene, from a file, from a dict of its tables, or from the tables by keyword.

    Args:
        source: a scene file; or a dict with the tables ``structure``, ``material``, ``loads``, ``run``, ``report`` and the ``title``; or
            a scene. Nothing where the keywords say all.
        changes: ``key=value`` as ``--set`` takes it, e.g. ``"run.dt=1e-3"``.
        tables: by keyword; over those of the source, as in :meth:`Scene.changed`.

    ``structure`` may be a list of blocks, or a table with one under ``blocks``: each a pair of vertices (V, 3) [m] and faces (loops of
    indices from zero, counter-clockwise seen from outside), a dict with the keys name, vertices, faces, density, group and fixed, a
    :class:`masonry_cd.Block`, or an object that has vertices and faces, of trimesh, pyvista, COMPAS or another program; ``fixed`` next to
    them names the supports, ``*`` standing for anything. A table of ``loads`` of kind "record", or a component of a shock, may hold
    ``time`` (N,) [s] and ``acceleration`` (N,) or (N, 1 to 3) [m/s2], or ``velocity`` [m/s] or ``displacement`` [m], or a function of time
    that gives a row of it, of one component along its ``direction`` or of several along x, y and z; ``channels`` names them ("HNE"). The
    keys of a record (``correction``, ``scale``, ``taper`` ...) stand next to them, and it is treated and judged as a record is.

    Raises:
        InputError: no such file, no TOML, an unknown or missing key, a value out of range; the words are those of the command line.

    >>> import masonry_cd as mc
    >>> stack = mc.scene(
    ...     structure={"blocks": [mc.box((-1, -1, -1), (1, 1, 0)), mc.box((-0.3, -0.3, 0), (0.3, 0.3, 1))], "fixed": "b0"},
    ...     material={"density": 2200.0, "friction": 0.6},
    ...     loads=[{"kind": "sinusoidal", "direction": "x", "amplitude": 0.1, "frequency": 2.0, "cycles": 1}],
    ...     run={"dt": 2e-3, "duration": 0.04},
    ... )
    >>> stack
    <Scene "scene": file, sinusoidal, 0.04 s>
    >>> stack.structure.names, stack.structure["b1"].vertices.shape
    (['b0', 'b1'], (8, 3))
    >>> mc.scene(stack, "run.dtt=1e-3")
    Traceback (most recent call last):
        ...
    masonry_cd.foundation.errors.InputError: scene: run.dtt: unknown key (did you mean "dt"?)
    """
    if isinstance(source, Scene):
        return source.changed(*changes, **tables) if changes or tables else source
    if source is None or isinstance(source, Mapping):
        return _made(source or {}, changes, tables, None)
    if not isinstance(source, str | os.PathLike):
        raise InputError("scene", f"a file, a dict or tables by keyword are needed, got a {type(source).__name__}")
    path = Path(source)
    of_file = _Origin(read_text(path), path, "")
    if hold_arrays(tables):
        return Scene(of_file).changed(*changes, **tables)
    made = (*changes, *changes_of(plain(tables, ""), parse_toml(of_file.text, path))) if tables else changes
    return Scene(replace(of_file, changes=made))


def _again(origin: _Origin, own: Mapping[str, bytes] | None) -> Scene:
    """A scene that was pickled, with the files of its arrays where it was made in Python; others are read where they lie."""
    if own is None:
        return Scene(origin)
    files = TemporaryFolder()
    for name, content in own.items():
        (files.path / name).write_bytes(content)
    return Scene(replace(origin, path=files.path / FILE), files)


def scene_of(results: Results) -> Scene:
    """The scene that made a run: of its file where that was a file of the user's, else made in Python as it was then."""
    origin = origin_of(results)
    named = set(paths_of(results.tables))
    if origin.path.absolute() != results.path.absolute().with_name(FILE) or not all(
        Path(name).is_absolute() or OWN_FILES.fullmatch(name) for name in named
    ):
        return Scene(origin)
    files = TemporaryFolder()
    for name in named:
        if OWN_FILES.fullmatch(name):
            shutil.copyfile(origin.path.with_name(name), files.path / name)
    return Scene(_Origin(results.scene, files.path / FILE, CALLED), files)


def origin_of(results: Results) -> _Origin:
    """The scene that made a run, for resuming it: its text to the letter, read where its file lay."""
    return _Origin(results.scene, results.scene_file, str(results.path))


def _made(source: Mapping[str, Any], changes: tuple[str, ...], tables: Mapping[str, Any], own: Path | None) -> Scene:
    """A scene made in Python.

    Args:
        source: its tables.
        changes: as ``--set`` takes them.
        tables: over those of the source.
        own: folder with the files of arrays that the source names; None where it names none.
    """
    files = TemporaryFolder()
    kept = {name for name in paths_of(source) if OWN_FILES.fullmatch(name)} if own is not None else set()
    for name in kept:
        shutil.copyfile(Path(str(own)) / name, files.path / name)
    now = plain(into_files(source, files.path), "")
    more = plain(into_files(tables, files.path), "")
    now = deepcopy(now)
    for change in (*changes_of(more, now), *changes):
        override(now, change)
    made = frozenset(path.name for path in files.path.iterdir())
    return Scene(_Origin(dump_toml(with_absolute_paths(now, Path.cwd(), made)), files.path / FILE, CALLED), files)
