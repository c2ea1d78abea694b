# SPDX-License-Identifier: GPL-3.0-or-later
"""Extensions: modules that one new file adds. They are found in their package by what they define; there is no list to be kept.

    package                 a module there defines          a scene asks for it by
    structures.kinds        KIND = StructureKind(...)       [structure] kind = "MODULE"
    loads.kinds             KINDS = {"name": LoadKind}      [[loads]] kind = "name"
    loads.readers           FORMATS = {"name": Reader}      [[loads]] format = "name"
    masonry_cd.mechanics.solvers      solve(problem, options, start)  [run] solver = "MODULE"
    reports.outputs         OUTPUTS = {"name": Output}      [report] name = true

MODULE is the name of the file without its ending. Modules that define no such thing are helpers of the others. What a module defines
is read from its source, where it stands at the beginning of a line: names can be checked before anything heavy is imported.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Generic, TypeVar

Value = TypeVar("Value")


class Extensions(Mapping[str, Value], Generic[Value]):
    """The functions or values of one name in the modules of a package, by module. A module is imported on first use.

    Args:
        package: its full name; every folder on its ``__path__`` is searched.
        name: defined at the top level of a module.
    """

    def __init__(self, package: str, name: str) -> None:
        self._package, self._name = package, name

    def __getitem__(self, name: str) -> Value:
        if name not in self._modules():
            raise KeyError(name)
        found: Value = getattr(import_module(f"{self._package}.{name}"), self._name)
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._modules()  # without importing it

    def __iter__(self) -> Iterator[str]:
        return iter(self._modules())

    def __len__(self) -> int:
        return len(self._modules())

    def _modules(self) -> tuple[str, ...]:
        """Names of the modules that define it."""
        return _defining(self._package, rf"(?:def {self._name}\(|{self._name} = )")


class Entries(Mapping[str, Value], Generic[Value]):
    """The entries of the tables of one name in the modules of a package, module by module. All these modules are imported at once.

    Args:
        package: its full name; every folder on its ``__path__`` is searched.
        table: a dictionary at the top level of a module.
    """

    def __init__(self, package: str, table: str) -> None:
        self._package, self._table = package, table

    def __getitem__(self, name: str) -> Value:
        return self._entries()[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries())

    def __len__(self) -> int:
        return len(self._entries())

    def _entries(self) -> dict[str, Value]:
        """Name -> entry."""
        modules = _defining(self._package, rf"{self._table}\b[^=\n]*=")
        found: dict[str, Value] = {}
        for module in modules:
            found |= getattr(import_module(f"{self._package}.{module}"), self._table)
        return found


def _defining(package: str, definition: str) -> tuple[str, ...]:
    """The modules of a package with a line that begins with a definition, a regular expression; by name."""
    return _search(tuple(import_module(package).__path__), definition)


@cache
def _search(folders: tuple[str, ...], definition: str) -> tuple[str, ...]:
    """Names of the files in some folders with such a line."""
    line = re.compile(f"^{definition}", re.MULTILINE)
    files = [file for folder in folders for file in Path(folder).glob("*.py") if file.stem != "__init__"]
    return tuple(sorted({file.stem for file in files if line.search(file.read_text(encoding="utf-8"))}))
