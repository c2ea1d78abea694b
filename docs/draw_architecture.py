# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw docs/architecture.png: the packages of the code from the top floor to the lowest, and which imports which.

    python docs/draw_architecture.py

Imports are read from the sources by ``ast``; nothing is imported. The packages and the order of the floors are those of the import-linter
contract in pyproject.toml. What is drawn is kept in the picture as text, so that a test can compare it with the code.
"""

from __future__ import annotations

import ast
import json
import textwrap
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "architecture.png"
CORE = "masonry_cd"
ROW, LANE, LEFT, TOP = 0.82, 0.36, 7.4, 1.0  # height of a row, width of a lane, where lanes begin, height of the title [in]
INK, PALE, CLIMBS = "#1f2933", "#7b8794", "#c0392b"
BANDS = ("#e8f1f5", "#f6efe4")  # backgrounds of layers, by turns
LANES = ("#1b6ca8", "#b5651d", "#2e7d5b", "#7a4b94")


class Package(NamedTuple):
    """A package and what it imports."""

    name: str
    purpose: str  # first sentence of its docstring
    inside: tuple[str, ...]  # packages in it
    imports: tuple[str, ...]  # packages imported when a module is loaded
    lazy: tuple[str, ...]  # packages imported inside functions only


def shipped() -> list[str]:
    """The packages of the wheel."""
    return _pyproject()["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]


@cache
def floors() -> list[list[str]]:
    """The packages of each floor, from the top, by the contract of import-linter."""
    (contract,) = (c for c in _pyproject()["tool"]["importlinter"]["contracts"] if c["type"] == "layers")
    rows = [[name.strip().replace(".", "/") for name in layer.split("|")] for layer in contract["layers"]]
    return [row for row in rows if row[0].split("/")[0] in shipped()]


def packages() -> dict[str, Package]:
    """All packages of the tree by name."""
    files: dict[str, list[Path]] = {}
    for top in shipped():
        for path in sorted((ROOT / top).rglob("*.py")):
            name = _package(path.relative_to(ROOT).with_suffix("").parts)
            if name:
                files.setdefault(name, []).append(path)
    return {name: _read(name, paths) for name, paths in files.items()}


def _pyproject() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def _package(parts: tuple[str, ...]) -> str:
    """The package on a floor that a module belongs to, given by the parts of its name; empty for what only holds packages."""
    names = ["/".join(parts[: n + 1]) for n in range(len(parts))]
    return next((name for name in reversed(names) for row in floors() if name in row), "")


def _read(name: str, paths: list[Path]) -> Package:
    """Read the modules of one package."""
    at_once: set[str] = set()
    later: set[str] = set()
    for path in paths:
        for module, in_function in _imports(ast.parse(path.read_text(encoding="utf-8"))):
            (later if in_function else at_once).add(_package(tuple(module.split("."))))
    own = {name, ""}
    purpose = ast.get_docstring(ast.parse((ROOT / name / "__init__.py").read_text(encoding="utf-8"))) or ""
    purpose = purpose.split("\n\n")[0].replace("\n", " ").replace("``", "").split(". ")[0].rstrip(".")
    inside = tuple(path.parent.name for path in sorted((ROOT / name).glob("*/__init__.py")))
    return Package(name, purpose, inside, tuple(sorted(at_once - own)), tuple(sorted(later - at_once - own)))


def _imports(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Modules of this project that a file imports, and whether that is inside a function; imports for type checkers do not count."""
    own = (*shipped(),)

    def visit(node: ast.AST, in_function: bool) -> Iterator[tuple[str, bool]]:
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.dump(node.test):
            return
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        yield from ((name, in_function) for name in names if name.split(".")[0] in own)
        for child in ast.iter_child_nodes(node):
            yield from visit(child, in_function or isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef)))

    yield from visit(tree, False)


def drawn(picture: Path = PICTURE) -> dict[str, list]:
    """Return the contents of a picture: package -> [purpose, packages inside, imports, imports inside functions]."""
    from PIL import Image

    with Image.open(picture) as image:
        return json.loads(image.info["Packages"])


def as_drawn(found: dict[str, Package]) -> dict[str, list]:
    """Packages in the form in which the picture keeps them."""
    return json.loads(json.dumps({name: package[1:] for name, package in sorted(found.items())}))


def draw(picture: Path = PICTURE, found: dict[str, Package] | None = None) -> None:
    """Draw the packages of the tree, or those given."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    found, order = found or packages(), [(k, name) for k, names in enumerate(floors()) for name in names]
    if {name for _, name in order} != set(found):
        raise SystemExit(f"packages without a floor, or floors without a package: {sorted({name for _, name in order} ^ set(found))}")
    place = {name: i for i, (_, name) in enumerate(order)}
    width, height = LEFT + LANE * (len(order) + 0.8), TOP + ROW * len(order) + 0.75
    figure = plt.figure(figsize=(width, height), dpi=150, facecolor="white")
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.axis("off")
    axes.text(0.25, 0.42, "The packages of masonry_cd and their imports", size=15, weight="bold", color=INK, va="center")
    axes.text(0.25, 0.75, "Each lane starts at a package and has a dot on every package that it imports.", size=9, color=PALE, va="center")
    level = {name: k for k, name in order}
    for i, (layer, name) in enumerate(order):
        _row(axes, i, layer, found[name], width)
    for i, (_, name) in enumerate(order):
        _lane(axes, i, found[name], place, level)
    climbs = any(level[other] < level[name] for name, package in found.items() for other in (*package.imports, *package.lazy))
    _key(axes, TOP + ROW * len(order) + 0.4, climbs)
    figure.savefig(picture, metadata={"Software": None, "Packages": json.dumps(as_drawn(found))})
    plt.close(figure)


def _y(row: int) -> float:
    """Height of the middle of a row."""
    return TOP + ROW * (row + 0.5)


def _row(axes, i: int, layer: int, package: Package, width: float) -> None:
    """The band of a package with its name, its purpose and what is inside."""
    axes.axhspan(TOP + ROW * i, TOP + ROW * (i + 1), color=BANDS[layer % 2], lw=0)
    axes.plot([0.0, width], [TOP + ROW * i] * 2, color="white", lw=1.0)
    axes.text(0.25, _y(i), package.name, size=10.5, weight="bold", color=INK, va="center", family="DejaVu Sans Mono")
    lines = [(line, {"size": 8, "color": INK}) for line in textwrap.wrap(package.purpose, 62)]
    small = {"size": 7, "color": PALE, "family": "DejaVu Sans Mono"}
    lines += [(line, small) for line in textwrap.wrap(", ".join(package.inside), 64)]
    apart = min(0.17, 0.94 * ROW / len(lines))
    for k, (line, font) in enumerate(lines):
        axes.text(3.3, _y(i) + apart * (k - 0.5 * (len(lines) - 1)), line, va="center", **font)


def _lane(axes, i: int, package: Package, place: dict[str, int], layer: dict[str, int]) -> None:
    """The lane of a package: a square on itself, full dots on what it imports, rings on what it imports inside functions."""
    x, colour = LEFT + LANE * (i + 0.5), LANES[i % len(LANES)]
    rows = [place[name] for name in (*package.imports, *package.lazy)]
    if rows:
        axes.plot([x, x], [_y(min([i, *rows])), _y(max([i, *rows]))], color=colour, lw=1.4, zorder=2)
    axes.plot([LEFT - 0.1, x], [_y(i)] * 2, color=colour, lw=0.6, ls=(0, (1, 2)), zorder=1)
    axes.plot(x, _y(i), "s", ms=9, color=colour, zorder=3)
    for names, fill in ((package.imports, True), (package.lazy, False)):
        for name in names:
            climbs = layer[name] < layer[package.name]
            edge = CLIMBS if climbs else colour
            axes.plot(x, _y(place[name]), "X" if climbs else "o", ms=7, mec=edge, mfc=edge if fill else "white", mew=1.4, zorder=4)


def _key(axes, y: float, climbs: bool) -> None:
    """Explain the signs; that of an import that climbs only where there is one."""
    signs = (
        ("s", INK, "a package"),
        ("o", INK, "imports it"),
        ("o", "white", "imports it inside a function"),
        ("X", CLIMBS, "an import that climbs"),
    )
    for k, (marker, fill, words) in enumerate(signs if climbs else signs[:-1]):
        x = 0.35 + (0.0, 1.2, 2.6, 5.2)[k]
        axes.plot(x, y, marker, ms=7, mfc=fill, mec=CLIMBS if marker == "X" else INK, mew=1.4)
        axes.text(x + 0.15, y, words, size=8, color=INK, va="center")


if __name__ == "__main__":
    draw()
