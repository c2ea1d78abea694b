"""Draw docs/architecture.png: the rooms of the code from the top layer to the lowest, and which room imports which.

    python docs/draw_architecture.py

Rooms and imports are read from the sources by ``ast``; nothing is imported. A room is a package of the wheel or a package inside
``masonry_cd``; the plain modules of ``masonry_cd`` (errors.py, jit.py ...) make one room. The order of the layers is that of the
import-linter contract in pyproject.toml. What is drawn is kept in the picture as text, so that a test can compare it with the code.
"""

from __future__ import annotations

import ast
import json
import textwrap
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).resolve().parents[1]
PICTURE = ROOT / "docs" / "architecture.png"
CORE, PLAIN = "masonry_cd", "masonry_cd/*.py"
ROW, LANE, LEFT, TOP = 0.74, 0.36, 6.3, 1.0  # height of a row, width of a lane, where lanes begin, room for the title [in]
INK, PALE, CLIMBS = "#1f2933", "#7b8794", "#c0392b"
BANDS = ("#e8f1f5", "#f6efe4")  # backgrounds of layers, by turns
LANES = ("#1b6ca8", "#b5651d", "#2e7d5b", "#7a4b94")


class Room(NamedTuple):
    """A room and what it imports."""

    name: str
    purpose: str  # first sentence of its docstring
    inside: tuple[str, ...]  # packages in it, or modules of the room of plain modules
    imports: tuple[str, ...]  # rooms imported when a module is loaded
    lazy: tuple[str, ...]  # rooms imported inside functions only


def packages() -> list[str]:
    """The packages of the wheel."""
    return _pyproject()["tool"]["hatch"]["build"]["targets"]["wheel"]["packages"]


def layers() -> list[list[str]]:
    """The rooms of each layer, from the top, by the contract of import-linter. The plain modules of several layers are in the lowest."""
    (contract,) = (c for c in _pyproject()["tool"]["importlinter"]["contracts"] if c["type"] == "layers")
    rows: list[list[str]] = []
    for layer in reversed(contract["layers"]):
        modules = [tuple(name.strip().split(".")) for name in layer.replace(":", "|").split("|")]
        row = dict.fromkeys(_room(parts) for parts in modules if parts[0] in packages())
        below = {name for names in rows for name in names}
        rows.append([name for name in row if name not in below])
    return [row for row in reversed(rows) if row]


def rooms() -> dict[str, Room]:
    """All rooms of the tree by name."""
    files: dict[str, list[Path]] = {}
    for package in packages():
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            if parts not in ((CORE, "__init__"), (CORE, "__main__")):
                files.setdefault(_room(parts), []).append(path)
    return {name: _read(name, paths) for name, paths in files.items()}


def _pyproject() -> dict:
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def _room(parts: tuple[str, ...]) -> str:
    """The room of a module given by the parts of its name."""
    if parts[0] != CORE:
        return parts[0]
    return f"{CORE}/{parts[1]}" if len(parts) > 1 and (ROOT / CORE / parts[1]).is_dir() else PLAIN


def _read(name: str, paths: list[Path]) -> Room:
    """Read the modules of one room."""
    at_once: set[str] = set()
    later: set[str] = set()
    for path in paths:
        for module, in_function in _imports(ast.parse(path.read_text(encoding="utf-8"))):
            (later if in_function else at_once).add(_room(tuple(module.split("."))))
    own = {name}
    if name == PLAIN:
        return Room(name, "What every room may use", tuple(path.name for path in paths), tuple(sorted(at_once - own)), ())
    purpose = ast.get_docstring(ast.parse((ROOT / name / "__init__.py").read_text(encoding="utf-8"))) or ""
    purpose = purpose.split("\n\n")[0].replace("\n", " ").replace("``", "").split(". ")[0].rstrip(".")
    inside = tuple(path.parent.name for path in sorted((ROOT / name).glob("*/__init__.py")))
    return Room(name, purpose, inside, tuple(sorted(at_once - own)), tuple(sorted(later - at_once - own)))


def _imports(tree: ast.Module) -> Iterator[tuple[str, bool]]:
    """Modules of this project that a file imports, and whether that is inside a function; imports for type checkers do not count."""
    own = (*packages(),)

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
    """What a picture shows: room -> [purpose, packages inside, imports, imports inside functions]."""
    from PIL import Image

    with Image.open(picture) as image:
        return json.loads(image.info["Rooms"])


def as_drawn(found: dict[str, Room]) -> dict[str, list]:
    """Rooms in the form in which the picture keeps them."""
    return json.loads(json.dumps({name: room[1:] for name, room in sorted(found.items())}))


def draw(picture: Path = PICTURE, found: dict[str, Room] | None = None) -> None:
    """Draw the rooms of the tree, or those given."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    found, order = found or rooms(), [(k, name) for k, names in enumerate(layers()) for name in names]
    if {name for _, name in order} != set(found):
        raise SystemExit(f"rooms without a layer, or layers without a room: {sorted({name for _, name in order} ^ set(found))}")
    place = {name: i for i, (_, name) in enumerate(order)}
    width, height = LEFT + LANE * (len(order) + 0.8), TOP + ROW * len(order) + 0.75
    figure = plt.figure(figsize=(width, height), dpi=150, facecolor="white")
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, width), ylim=(height, 0))
    axes.axis("off")
    axes.text(0.25, 0.42, "The rooms of masonry_cd and their imports", size=15, weight="bold", color=INK, va="center")
    axes.text(0.25, 0.75, "Each lane starts at a room and has a dot on every room that it imports.", size=9, color=PALE, va="center")
    level = {name: k for k, name in order}
    for i, (layer, name) in enumerate(order):
        _row(axes, i, layer, found[name], width)
    for i, (_, name) in enumerate(order):
        _lane(axes, i, found[name], place, level)
    climbs = any(level[other] < level[name] for name, room in found.items() for other in (*room.imports, *room.lazy))
    _key(axes, TOP + ROW * len(order) + 0.4, climbs)
    figure.savefig(picture, metadata={"Software": None, "Rooms": json.dumps(as_drawn(found))})
    plt.close(figure)


def _y(row: int) -> float:
    """Height of the middle of a row."""
    return TOP + ROW * (row + 0.5)


def _row(axes, i: int, layer: int, room: Room, width: float) -> None:
    """The band of a room with its name, its purpose and what is inside."""
    axes.axhspan(TOP + ROW * i, TOP + ROW * (i + 1), color=BANDS[layer % 2], lw=0)
    axes.plot([0.0, width], [TOP + ROW * i] * 2, color="white", lw=1.0)
    axes.text(0.25, _y(i), room.name, size=10.5, weight="bold", color=INK, va="center", family="DejaVu Sans Mono")
    lines = [(line, {"size": 8, "color": INK}) for line in textwrap.wrap(room.purpose, 62)]
    small = {"size": 7, "color": PALE, "family": "DejaVu Sans Mono"}
    lines += [(line, small) for line in textwrap.wrap(", ".join(room.inside), 64)]
    apart = min(0.17, 0.94 * ROW / len(lines))
    for k, (line, font) in enumerate(lines):
        axes.text(2.25, _y(i) + apart * (k - 0.5 * (len(lines) - 1)), line, va="center", **font)


def _lane(axes, i: int, room: Room, place: dict[str, int], layer: dict[str, int]) -> None:
    """The lane of a room: a square on itself, full dots on what it imports, rings on what it imports inside functions."""
    x, colour = LEFT + LANE * (i + 0.5), LANES[i % len(LANES)]
    rows = [place[name] for name in (*room.imports, *room.lazy)]
    if rows:
        axes.plot([x, x], [_y(min([i, *rows])), _y(max([i, *rows]))], color=colour, lw=1.4, zorder=2)
    axes.plot([LEFT - 0.1, x], [_y(i)] * 2, color=colour, lw=0.6, ls=(0, (1, 2)), zorder=1)
    axes.plot(x, _y(i), "s", ms=9, color=colour, zorder=3)
    for names, fill in ((room.imports, True), (room.lazy, False)):
        for name in names:
            climbs = layer[name] < layer[room.name]
            edge = CLIMBS if climbs else colour
            axes.plot(x, _y(place[name]), "X" if climbs else "o", ms=7, mec=edge, mfc=edge if fill else "white", mew=1.4, zorder=4)


def _key(axes, y: float, climbs: bool) -> None:
    """What the signs mean; that of an import that climbs only where there is one."""
    signs = (
        ("s", INK, "a room"),
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
