# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/python_reference.md: every name of the package with a line from its docstring, and the members of its classes.

python docs/write_python_reference.py
"""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from typing import Any

import masonry_cd as mc

PAGE = Path(__file__).with_name("python_reference.md")
HEAD = """# Python, every name

Written from the docstrings by `python docs/write_python_reference.py`; `help(mc.run)` says more, with what is raised and an example.
[Python](python.md) shows how they go together, [Plug-ins](plugins.md#contracts) what functions of yours are given and have to return.

"""
ROLE = re.compile(r":[a-z]+:`~?([^`]+)`")  # of a docstring


def reference() -> str:
    """The text of the page."""
    found = {name: getattr(mc, name) for name in sorted(mc.NAMES, key=str.lower)}
    functions = [f"| `mc.{called(name, each)}` | {line(each)} |" for name, each in found.items() if not inspect.isclass(each)]
    parts = [HEAD + "\n".join(["| function | |", "|---|---|", *functions]) + "\n"]
    for name, each in found.items():
        if inspect.isclass(each):
            rows = [f"| `{called(member, value)}` | {line(value)} |" for member, value in members(each)]
            table = "\n".join(["", "| member | |", "|---|---|", *rows, ""]) if rows else ""
            made = f"\n`mc.{called(name, each)}`\n" if re.search(r"^(?:Args|Attributes):", inspect.getdoc(each) or "", re.MULTILINE) else ""
            parts.append(f"## mc.{name}\n\n{line(each)}\n{made}{table}")
    return "\n".join(parts)


def members(kind: type) -> Iterator[tuple[str, Any]]:
    """Public methods and properties of a class and its bases of this program, by name."""
    own = [base for base in kind.__mro__ if base.__module__.partition(".")[0] in ("masonry_cd", "structures")]
    found = {name: value for base in reversed(own) for name, value in vars(base).items() if not name.startswith("_")}
    for name, value in sorted(found.items()):
        value = value.__func__ if isinstance(value, classmethod | staticmethod) else value
        if isinstance(value, property | cached_property) or inspect.isfunction(value):
            yield name, value


def called(name: str, value: Any) -> str:
    """A name, and of a function or a class what it takes."""
    if not (inspect.isfunction(value) or inspect.isclass(value)):
        return name
    taken = [one.replace(annotation=one.empty) for one in inspect.signature(value).parameters.values() if one.name not in ("self", "cls")]
    return f"{name}{inspect.Signature(taken)}"


def line(value: Any) -> str:
    """The first sentence of a docstring."""
    said = " ".join((inspect.getdoc(value) or "").partition("\n\n")[0].split())
    return ROLE.sub(r"`\1`", re.split(r"(?<=[a-z)`\]])\. ", said)[0]).rstrip(".").replace("|", "\\|") + "."


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
