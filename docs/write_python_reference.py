# SPDX-License-Identifier: GPL-3.0-or-later
"""Write docs/python_reference.md: every name of the package from its docstring, with arguments, errors, an example and members of classes.

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

`import masonry_cd as mc` has these functions and classes. [Python](python.md) shows how they go together, [Plug-ins](plugins.md#contracts)
what functions of yours are given and have to return. Written from the docstrings by `python docs/write_python_reference.py`.

"""
ROLE = re.compile(r":[a-z]+:`~?([^`]+)`")  # of a docstring
SECTION = re.compile(r"^(Args|Attributes|Raises|Returns|Examples?):\n((?:[ \t]+.*\n?|\n(?=[ \t]))*)", re.MULTILINE)
ENTRY = re.compile(r"^ {4}(\S[^:\n]*): (.*(?:\n {5,}.*)*)", re.MULTILINE)
SESSION = re.compile(r"^ *>>> .*\n?(?: *(?:>>> |\.\.\. |\S).*\n?)*", re.MULTILINE)


def reference() -> str:
    """The text of the page."""
    found = {name: getattr(mc, name) for name in sorted(mc.NAMES, key=str.lower)}
    parts = [HEAD]
    for title, wanted in (("function", False), ("class", True)):
        rows = [f"| [`mc.{name}`](#mc{name.lower()}) | {line(each)} |" for name, each in found.items() if inspect.isclass(each) is wanted]
        parts.append("\n".join([f"| {title} | |", "|---|---|", *rows, "", ""]))
    return "".join(parts) + "\n".join("".join(section(name, each)).rstrip() + "\n" for name, each in found.items())


def section(name: str, value: Any) -> Iterator[str]:
    """Title, what a name takes, what is said of it, its arguments and errors, an example, and the members of a class."""
    text = ROLE.sub(r"`\1`", inspect.getdoc(value) or "").replace("``", "`") + "\n"
    sections = {found[1]: found[2] for found in SECTION.finditer(text)}
    yield f"## mc.{name}\n\n"
    if not inspect.isclass(value) or {"Args", "Attributes"} & sections.keys():
        yield f"`mc.{called(name, value)}`\n\n"
    yield f"{plain(re.split(r'^(?:Args|Attributes|Raises|Returns|Examples?):|^ *>>> ', text, maxsplit=1, flags=re.MULTILINE)[0])}\n\n"
    for title in ("Args", "Attributes", "Raises"):
        yield table({"Raises": "raises"}.get(title, "takes"), ENTRY.findall(sections.get(title, "")))
    if example := SESSION.search(text):
        yield f"```pycon\n{inspect.cleandoc(chr(10) + example[0]).strip()}\n```\n\n"
    if inspect.isclass(value):
        yield table("member", ((called(member, each), line(each)) for member, each in members(value)))


def table(head: str, entries: Any) -> str:
    """A table of names and what they are; nothing where there are none."""
    rows = [f"| `{name}` | {plain(said)} |" for name, said in entries]
    return "\n".join([f"| {head} | |", "|---|---|", *rows, "", ""]) if rows else ""


def plain(text: str) -> str:
    """The paragraphs of a docstring as one line each, so that a cell of a table holds them."""
    paragraphs = [" ".join(part.split()) for part in re.split(r"\n\s*\n", text)]
    return " ".join(part for part in paragraphs if part).replace("``", "`").replace("|", "\\|")


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
    text = ROLE.sub(r"`\1`", re.split(r"(?<=[a-z)`\]])\. ", said)[0]).replace("``", "`")
    return text.rstrip(".").replace("|", "\\|") + "."


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
