# SPDX-License-Identifier: GPL-3.0-or-later
"""Plug-ins: what installed packages add by entry points, and what a file of the user's adds by its name.

    group of entry points    the entry is                               a scene asks for it by
    masonry_cd.structures    a StructureKind, or its build alone        [structure] kind = "name"
    masonry_cd.loads         a LoadKind                                 [[loads]] kind = "name"
    masonry_cd.readers       a Reader                                   [[loads]] format = "name", or the file's content
    masonry_cd.reports       an Output                                  [report] name = true
    masonry_cd.mechanisms    bodies(whole, element, direction)          [[limit.mechanism]] mechanisms = ["name"]
    masonry_cd.joint_laws    a JointLaw                                 mc.Simulation(scene, law="name"), in Python
    masonry_cd.solvers       solve(problem, options, start)             [run] solver = "name", --solver name

The kinds of the program itself are found by their place (:mod:`masonry_cd.foundation.extensions`) and asked first: metadata of packages are
looked at only for a name that is not among them, and a package is imported only where a scene names what it adds. A kind of structure or
load may also be in a file next to the scene, ``kind = "my_file.py:name"``, which runs where the command line says --trust.
"""

from __future__ import annotations

import importlib.util
import re
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.foundation.files import is_file
from masonry_cd.foundation.signatures import require_call
from masonry_cd.foundation.trust import require_trust

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

CALLED: dict[str, dict[str, str]] = {  # by group: how the functions of an entry are called, by their names; or itself, where it has none
    "structures": {"build": "table, density, folder"},
    "loads": {"part": "table, grid, where"},
    "readers": {"recognises": "source", "read": "source, request"},
    "reports": {"write": "job"},
    "mechanisms": {"bodies": "whole, element, direction"},
    "joint_laws": {"function": "opening, slip, history, step, stress"},
    "solvers": {"solve": "problem, options, start"},
}
OWN_FILE = re.compile(r"(?P<path>.+\.py):(?P<name>[A-Za-z_]\w*)")
PROGRAM = "a program that runs with your rights"


class Plugin(NamedTuple):
    """An addition by a package."""

    group: str  # one of CALLED
    name: str
    package: str  # and its version
    place: str  # module:attribute


@cache
def entries(group: str) -> dict[str, EntryPoint]:
    """The entries of a group by name; of two of one name the first package by name."""
    from importlib.metadata import entry_points  # where a name asks for it: it takes its time

    found = sorted(entry_points(group=f"masonry_cd.{group}"), key=lambda entry: (_package(entry), entry.name), reverse=True)
    return {entry.name: entry for entry in found}


def _package(entry: EntryPoint) -> str:
    return "" if entry.dist is None else f"{entry.dist.name} {entry.dist.version}"


def plugins() -> list[Plugin]:
    """All that installed packages add; none of them is imported."""
    return [Plugin(group, name, _package(entry), entry.value) for group in CALLED for name, entry in sorted(entries(group).items())]


def names(group: str) -> tuple[str, ...]:
    """Names of what packages add to a group."""
    return tuple(sorted(entries(group)))


def load(group: str, name: str) -> Any:
    """Import the addition of a package.

    Raises:
        InputError: the package cannot be imported, has no such thing, or one with functions that cannot be called as they will be.
    """
    entry = entries(group)[name]
    unusable = f'plug-in "{name}" of {_package(entry)} cannot be used'
    try:
        found = entry.load()
    except Exception as failure:  # whatever foreign code raises
        raise InputError(unusable, f"{_in_a_line(failure)}") from None
    return _called(group, found, unusable)


def _called(group: str, found: Any, where: str) -> Any:
    """Return the object that a package or a file adds to a group, after checking the arguments of its functions."""
    for name, arguments in CALLED[group].items():
        require_call(getattr(found, name, found), arguments, where, name)
    return found


def find(group: str, name: str, key: str, known: Mapping[str, Any], folder: Path | None = None) -> Any:
    """Find the object that a name stands for: in the program itself, a file, or a package.

    Args:
        group: of the plug-in.
        name: as the scene gives it.
        key: of the scene, for messages.
        known: what the program itself has, by name.
        folder: of the scene, where a file may be named.

    Raises:
        InputError: an unknown name, a file that is not there, not trusted or has no such thing, a package that cannot be imported.
    """
    own = OWN_FILE.fullmatch(name) if folder is not None else None
    if own is not None and folder is not None:
        return _called(group, _of_file(folder / own["path"], own["name"], key), key)
    if name in known:
        return known[name]
    if name not in entries(group):
        every = [*known, *names(group)]
        raise InputError(key, f'unknown {key.rpartition(".")[2]} "{name}"{suggest(name, every)}; one of {", ".join(every)}')
    return load(group, name)


def _of_file(path: Path, name: str, key: str) -> Any:
    """Return the object that a Python file defines."""
    if not is_file(path):
        raise InputError(key, f'no file "{path}"')
    require_trust(key, path.name, PROGRAM)
    try:
        module = _module_of(path, path.stat().st_mtime_ns)
    except Exception as failure:
        raise InputError(key, f"{path.name} cannot be used: {_in_a_line(failure)}") from None
    if not hasattr(module, name):
        raise InputError(key, f'{path.name} defines no "{name}"')
    return getattr(module, name)


@cache
def _module_of(path: Path, stamp: int) -> ModuleType:
    """A Python file as a module, run once as long as it is not changed; ``stamp`` is when it was [ns]."""
    spec = importlib.util.spec_from_file_location(f"masonry_cd_own_{path.stem}", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where models of keys look for what their annotations name
    spec.loader.exec_module(module)
    return module


def _in_a_line(failure: Exception) -> str:
    return f"{type(failure).__name__}: {' '.join(str(failure).split())}"
