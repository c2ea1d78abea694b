# SPDX-License-Identifier: GPL-3.0-or-later
r"""The tree in numbers: files, lines, the longest file, kernels with many arguments, import cycles, private names that tests use.

    python -m benchmarks.tree [FOLDER]

Read from the sources as text; nothing of the program is imported or run, so that older states of it can be measured too.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections.abc import Iterator
from pathlib import Path

PACKAGES = ("masonry_cd", "structures", "loads", "reports")
MOST_LINES, MOST_ARGUMENTS = 400, 10  # of a file and of a kernel, as the design asks for
KERNEL = re.compile(r"@(?:entry|kernel|borrower|njit|numba\.njit)\b")
PUBLIC = "replace|fields|asdict|make|repr_html_|repr_png_"  # names of any NamedTuple, and of what notebooks show
PRIVATE = re.compile(rf"_(?!(?:{PUBLIC})$)[a-z]\w*")


def sources(root: Path, *folders: str) -> dict[str, str]:
    """The modules below some folders by dotted name, with their text."""
    found = {}
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            name = ".".join(path.relative_to(root).with_suffix("").parts)
            found[name.removesuffix(".__init__")] = path.read_text(encoding="utf-8")
    return found


def imports(modules: dict[str, str], name: str) -> set[str]:
    """The modules among the given ones that a module imports when it is loaded or later, but for the type checker alone."""
    found: set[str] = set()
    for node in _outside_type_checking(ast.parse(modules[name])):
        if isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{item.name}" if f"{node.module}.{item.name}" in modules else node.module for item in node.names}
        elif isinstance(node, ast.Import):
            found |= {item.name for item in node.names}
    return {other for other in found if other in modules and other != name}


def _outside_type_checking(tree: ast.AST) -> Iterator[ast.AST]:
    """All nodes but those under ``if TYPE_CHECKING``."""
    for node in ast.iter_child_nodes(tree):
        if not (isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING"):
            yield node
            yield from _outside_type_checking(node)


def cycles(graph: dict[str, set[str]]) -> list[list[str]]:
    """Groups of modules that import one another, by Tarjan's algorithm (SIAM J. Comput. 1, 1972)."""
    number: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        number[node] = low[node] = len(number)
        stack.append(node)
        for other in graph[node]:
            if other not in number:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], number[other])
        if low[node] == number[node]:
            at = stack.index(node)
            group = stack[at:]
            del stack[at:]
            if len(group) > 1:
                found.append(sorted(group))

    for node in graph:
        if node not in number:
            visit(node)
    return found


def wide_kernels(modules: dict[str, str]) -> list[str]:
    """Compiled functions with more than MOST_ARGUMENTS arguments, as ``module.function (arguments)``."""
    found = []
    for name, text in modules.items():
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.FunctionDef) and any(KERNEL.match(f"@{ast.unparse(item)}") for item in node.decorator_list):
                count = len(node.args.args)
                if count > MOST_ARGUMENTS:
                    found.append(f"{name}.{node.name} ({count})")
    return found


def private_names(text: str) -> list[str]:
    """Names that begin with an underscore and that a module takes from elsewhere: imported, as attributes, or to set them by name."""
    found = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom):
            found += [item.name for item in node.names]
        elif isinstance(node, ast.Attribute) and ast.unparse(node) != "os._exit" and ast.unparse(node.value) not in ("self", "cls"):
            found.append(node.attr)
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith(("setattr", "getattr")):
            found += [str(given.value) for given in node.args if isinstance(given, ast.Constant)]
    return [name for name in found if PRIVATE.fullmatch(name.rpartition(".")[2])]


def table(root: Path) -> list[str]:
    """The figures of a tree as lines of Markdown."""
    program, tests = sources(root, *PACKAGES), sources(root, "tests")
    everything = program | tests | sources(root, "benchmarks")
    lines = {name: text.count("\n") for name, text in everything.items()}
    longest = max(program, key=lines.__getitem__)
    private = sum(len(private_names(text)) for text in tests.values())
    circles = cycles({name: imports(everything, name) for name in everything})
    wide = wide_kernels(program)
    rows = [
        ("files of the program", len(program)),
        ("lines of the program", sum(lines[name] for name in program)),
        ("lines with tests and benchmarks", sum(lines.values())),
        ("longest file of the program", f"{longest}, {lines[longest]} lines"),
        (f"files of the program over {MOST_LINES} lines", sum(lines[name] > MOST_LINES for name in program)),
        (f"kernels over {MOST_ARGUMENTS} arguments", len(wide)),
        ("import cycles", len(circles)),
        ("private names used by tests", private),
    ]
    out = ["| | |", "|---|---|", *(f"| {what} | {value} |" for what, value in rows)]
    return [*out, *(f"\ncycle: {', '.join(group)}" for group in circles), *(f"\nwide: {name}" for name in wide)]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", nargs="?", type=Path, default=Path(__file__).parents[1])
    print("\n".join(table(parser.parse_args().folder)))
