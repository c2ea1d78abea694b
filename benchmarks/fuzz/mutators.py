# SPDX-License-Identifier: GPL-3.0-or-later
"""Changes to a good input: bytes, lines, words and numbers of a text, values of a tree, arrays of a file of arrays."""

from __future__ import annotations

import io
import json
import re
import tempfile
import tomllib
from collections.abc import Callable, MutableMapping, MutableSequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.fuzz import inputs
from masonry_cd.app.scene_text import dump_toml

Random = np.random.Generator

NUMBERS = [
    "0", "-0", "-0.0", "-1", "1", "2", "3", "1e308", "-1e308", "1e-308", "5e-324", "1e-300", "1e999", "nan", "-nan", "inf", "-inf",
    "NaN", "Infinity", "9" * 19, "9" * 30, "1" * 5000, "2147483648", "4294967296", "18446744073709551616", "1_000", "0x10", "0b1",
    "1e", ".", "1,5", "٣", "²", "1e-9", "1e9", "0.1", "-1e-3", "1e15", "1e-15", "1e5", "100", "1e200", "1e-200", "1e22",
]  # fmt: skip
WORDS = [
    "", "\0", "\x1b[31m", "y" * 6000, "=cmd|' /C calc'!A0", "../../etc/passwd", "/dev/zero", "/dev/stdin", ".", "nan", "true",
    "\u202e", "\ufeff", "a\nb", "\\", '"', "'", "%s%n", "{}", "[]", "[[", "#", "=", ":", ",", ";", "\t", "\r", "\x85", "\u2028",
    "é", "\U0001f600", "*", "a" * 300,
]  # fmt: skip
VALUES: list[Any] = [
    None, True, False, 0, -1, 1, 2, 3, 10**18, 10**30, -(10**30), 1.0, 0.5, 1e308, -1e308, 1e-300, 5e-324, float("nan"),
    float("inf"), -0.0, 1e9, 1e-9, 1e-3, 100, 1000, 1e15, 1e200, "", "x", "a\0b", "\x1b[0m", "y" * 6000, "nan", "1.0", "=1+1", [],
    {}, [[]], [[[[1]]]], {"a": 1}, {"": {}}, [1, 2, 3], [0.0, 0.0, 0.0], [1e308, 1e308, 1e308], ["x"], [None], list(range(1000)),
    "../..", "/dev/zero", "y", "z", "base", "stone", "block",
]  # fmt: skip


def changed(content: bytes, change: str, random: Random) -> bytes:
    """A file's content with one to four changes of a kind; where the kind does not apply any more, bytes are changed."""
    apply: Callable[[bytes, Random], bytes] = {
        inputs.BYTES: of_bytes, inputs.LINES: of_lines, inputs.TOKENS: of_tokens, inputs.TOML: of_toml, inputs.JSON: of_json,
        inputs.NPZ: of_npz, inputs.HDF5: of_hdf5,
    }[change]  # fmt: skip
    try:
        return apply(content, random)
    except (ValueError, RecursionError, OSError, TypeError, KeyError):
        return of_bytes(content, random)


def _some(random: Random, most: int = 4) -> range:
    """How many changes: few are more likely."""
    return range(1 + min(int(random.geometric(0.6)) - 1, most - 1))


def _pick(random: Random, choices: Any) -> Any:
    return choices[int(random.integers(len(choices)))]


# --- bytes ---------------------------------------------------------------------------------------------------------------------------


def of_bytes(content: bytes, random: Random) -> bytes:
    """Bits flipped, bytes set, ranges left out, repeated, zeroed, moved; the end cut off; bytes put in."""
    data = bytearray(content)
    for _ in _some(random):
        at, length = int(random.integers(len(data) + 1)), int(2 ** random.uniform(0, 10))
        kind = _pick(random, ["flip", "flip", "set", "leave out", "repeat", "zero", "cut", "insert", "number"])
        if kind == "flip" and at < len(data):
            data[at] ^= 1 << int(random.integers(8))
        elif kind == "set" and at < len(data):
            data[at] = _pick(random, [0, 1, 0x7F, 0x80, 0xFF, 10, 32, 34, int(random.integers(256))])
        elif kind == "leave out":
            del data[at : at + length]
        elif kind == "repeat":
            data[at:at] = data[at : at + length]
        elif kind == "zero":
            data[at : at + length] = bytes(len(data[at : at + length]))
        elif kind == "cut":
            del data[at:]
        elif kind == "insert":
            data[at:at] = random.bytes(min(length, 64))
        elif kind == "number":  # as the counts and offsets of binary formats are
            data[at : at + 4] = _pick(random, [b"\xff" * 4, b"\0\0\0\x80", b"\xff\xff\xff\x7f", b"\0\0\0\0"])
    return bytes(data)


# --- text ----------------------------------------------------------------------------------------------------------------------------


def of_lines(content: bytes, random: Random) -> bytes:
    """Lines left out, repeated, swapped, joined, cut; foreign ones put in."""
    lines = content.decode("utf-8", "surrogateescape").splitlines(keepends=True) or [""]
    for _ in _some(random):
        at, other = int(random.integers(len(lines))), int(random.integers(len(lines)))
        kind = _pick(random, ["leave out", "repeat", "swap", "join", "cut", "insert", "end", "many"])
        if kind == "leave out" and len(lines) > 1:
            del lines[at]
        elif kind == "repeat":
            lines.insert(other, lines[at])
        elif kind == "swap":
            lines[at], lines[other] = lines[other], lines[at]
        elif kind == "join":
            lines[at] = lines[at].rstrip("\r\n")
        elif kind == "cut":
            lines[at] = lines[at][: int(random.integers(len(lines[at]) + 1))]
        elif kind == "insert":
            lines.insert(at, _pick(random, [*WORDS, *NUMBERS]) + "\n")
        elif kind == "end":
            del lines[at + 1 :]
        elif kind == "many":
            lines[at:at] = [lines[at]] * int(2 ** random.uniform(0, 12))
    return "".join(lines).encode("utf-8", "surrogateescape")


TOKEN = re.compile(r"[-+]?\d+\.?\d*(?:[eE][-+]?\d+)?|[A-Za-z_]\w*|\"[^\"\n]*\"|[^\s\w]")


def of_tokens(content: bytes, random: Random) -> bytes:
    """Numbers, words and signs of a text replaced by extreme or foreign ones, or by others of the same text; or left out, or repeated."""
    text = content.decode("utf-8", "surrogateescape")
    for _ in _some(random):
        tokens = list(TOKEN.finditer(text))
        if not tokens:
            return of_bytes(content, random)
        token = _pick(random, tokens)
        word = token.group()
        kind = _pick(random, ["extreme", "extreme", "extreme", "other", "leave out", "repeat", "nest"])
        if kind == "extreme":
            new = _pick(random, NUMBERS if word[-1].isdigit() and random.random() < 0.8 else WORDS)
            new = f'"{new}"' if word.startswith('"') and random.random() < 0.8 else new
        elif kind == "other":
            new = _pick(random, tokens).group()
        elif kind == "leave out":
            new = ""
        elif kind == "repeat":
            new = f"{word} {word}"
        else:
            depth = _pick(random, [1, 3, 300, 3000, 100_000])
            begin, end = _pick(random, [("[", "]"), ("{a = ", "}"), ('{"a": ', "}"), ("(", ")")])
            new = begin * depth + word + end * (depth if random.random() < 0.7 else 0)
        text = text[: token.start()] + new + text[token.end() :]
    return text.encode("utf-8", "surrogateescape" if "\udc80" <= max(text) <= "\udcff" else "surrogatepass")


# --- trees ---------------------------------------------------------------------------------------------------------------------------


def of_toml(content: bytes, random: Random) -> bytes:
    """Values of the tables replaced, left out, renamed, moved; keys put in."""
    tree = tomllib.loads(content.decode())
    _shake(tree, random)
    return dump_toml(_without_none(tree)).encode("utf-8", "surrogatepass")


def of_json(content: bytes, random: Random) -> bytes:
    """Values of a JSON file replaced, left out, renamed, moved; keys put in; one in twenty is nested too deep to read."""
    tree = json.loads(content)
    _shake(tree, random)
    text = json.dumps(tree)
    if random.random() < 0.05:
        text = '{"a": ' * 100_000 + text
    return text.encode("utf-8", "surrogatepass")


def _shake(tree: Any, random: Random) -> None:
    """Change a tree in place."""
    for _ in _some(random):
        holders = [*_places(tree)]
        if not holders:
            return
        inner = _pick(random, list({id(holder): holder for holder, _ in holders}.values()))  # a long list is no likelier than a short one
        inner, key = _pick(random, [place for place in holders if place[0] is inner])
        kind = _pick(random, ["replace", "replace", "replace", "scale", "leave out", "rename", "move", "repeat"])
        other, there = _pick(random, holders)
        if kind == "replace":
            inner[key] = deepcopy(_pick(random, VALUES))
        elif kind == "scale" and isinstance(inner[key], (int, float)):
            inner[key] = inner[key] * float(_pick(random, [-1.0, 1e-9, 1e9, 0.5, 2.0, 1e-3, 1e3, 1e30, 1.0 + 1e-9]))
        elif kind == "leave out":
            del inner[key]
        elif kind == "rename" and isinstance(inner, MutableMapping):
            inner[_pick(random, WORDS)] = inner.pop(key)
        elif kind == "move":
            other[there] = deepcopy(inner[key])
        elif kind == "repeat" and isinstance(inner, MutableSequence):
            inner.extend([deepcopy(inner[key]) for _ in range(_pick(random, [1, 2, 100]))])


def _places(value: Any) -> list[tuple[Any, Any]]:
    """The places of all values inside a tree: what holds them, and their key."""
    own: list[tuple[Any, Any]]
    if isinstance(value, MutableMapping):
        own = [(value, key) for key in value]
    elif isinstance(value, MutableSequence):
        own = [(value, key) for key in range(len(value))]
    else:
        return []
    return own + [place for holder, key in own for place in _places(holder[key])]


def _without_none(value: Any) -> Any:
    """A tree as TOML can hold it."""
    if isinstance(value, MutableMapping):
        return {str(key): _without_none(item) for key, item in value.items() if item is not None}
    if isinstance(value, MutableSequence):
        return [_without_none(item) for item in value if item is not None]
    return value


# --- arrays --------------------------------------------------------------------------------------------------------------------------


def _array(values: np.ndarray, random: Random) -> np.ndarray:
    """An array with other values, another shape or another kind."""
    values = np.array(values)
    kind = _pick(random, ["value", "value", "value", "shorter", "longer", "shape", "kind", "empty", "scale", "huge"])
    if kind == "value" and values.size and values.dtype.kind in "iuf":
        extremes = (
            [0, -1, 1, 2**31 - 1, -(2**31)] if values.dtype.kind in "iu" else [0.0, -1.0, np.nan, np.inf, 1e308, 1e-308, -1e200, 1e9, 1e-9]
        )
        for _ in _some(random):
            values.flat[int(random.integers(values.size))] = _pick(random, extremes)
    elif kind == "shorter":
        values = values.ravel()[: int(random.integers(values.size + 1))]
    elif kind == "longer":
        values = np.concatenate([values.ravel(), values.ravel()[: int(random.integers(values.size + 1))]])
    elif kind == "shape":
        values = _pick(random, [values.reshape(-1, 1), values.reshape(1, -1), values[None, None], values.sum()])
    elif kind == "kind":
        values = values.astype(_pick(random, ["i8", "f4", "f8", "c16", "S3", "U3", "?", "u1", ">f8", "f2"]))
    elif kind == "empty":
        values = values[:0] if values.ndim else np.zeros(0)
    elif kind == "scale" and values.dtype.kind == "f":
        values = values * _pick(random, [-1.0, 0.0, 1e-300, 1e150, 1e300, 1e-9, 1e9])
    elif kind == "huge":
        values = np.zeros(int(2 ** random.uniform(10, 22)))
    return values


def of_npz(content: bytes, random: Random) -> bytes:
    """Arrays changed, left out, renamed or exchanged; or compressed again."""
    with np.load(io.BytesIO(content), allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    for _ in _some(random):
        name, other = _pick(random, [*arrays]), _pick(random, [*arrays])
        kind = _pick(random, ["change", "change", "change", "leave out", "rename", "exchange"])
        if kind == "change":
            with np.errstate(all="ignore"):
                arrays[name] = _array(arrays[name], random)
        elif kind == "leave out" and len(arrays) > 1:
            del arrays[name]
        elif kind == "rename":
            arrays[_pick(random, ["a", "M_data", "mu", "q", "x" * 300])] = arrays.pop(name)
        elif kind == "exchange":
            arrays[name], arrays[other] = arrays[other], arrays[name]
    out = io.BytesIO()
    np.savez(out, allow_pickle=False, **arrays)
    return out.getvalue()


def of_hdf5(content: bytes, random: Random) -> bytes:
    """Datasets changed, left out, exchanged or turned into groups and links; attributes left out."""
    import h5py

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "changed.hdf5"
        path.write_bytes(content)
        with h5py.File(path, "r+") as file:
            names: list[str] = []
            file.visit(names.append)
            for _ in _some(random):
                name = _pick(random, names)
                try:
                    if name not in file:
                        continue
                    kind = _pick(random, ["change", "change", "change", "leave out", "group", "link", "text", "attributes"])
                    item = file[name]
                except RuntimeError:  # a link that an earlier change made leads to itself, here or on the way
                    continue
                if kind == "attributes":
                    for key in [*item.attrs]:
                        del item.attrs[key]
                    continue
                values = item[()] if isinstance(item, h5py.Dataset) else np.zeros(3)
                del file[name]
                if kind == "change":
                    with np.errstate(all="ignore"):
                        file[name] = _array(values, random)
                elif kind == "group":
                    file.create_group(name)
                elif kind == "link":
                    file[name] = _pick(
                        random, [h5py.SoftLink("/nowhere"), h5py.SoftLink(f"/{name}"), h5py.ExternalLink("/etc/passwd", "/")]
                    )
                elif kind == "text":
                    file[name] = _pick(random, WORDS).replace("\0", "")
        return path.read_bytes()


# --- changes by the command line -----------------------------------------------------------------------------------------------------

KEYS = [
    "run.dt", "run.duration", "run.solver", "run.tolerance", "run.gravity", "run.frames_per_second", "run.threads", "run.seed",
    "run", "loads[0].amplitude", "loads[0].kind", "loads[0]", "loads", "loads[1].kind", "loads[-1].kind", "loads[999999999999].x",
    "structure.kind", "structure.path", "structure", "material.friction", "material.density", "material.joints.normal_stiffness",
    "material.joints.default.cohesion", "report.times", "report.cut", "report.grades.width", "title", "a.b.c", "", "=", "[0]", ".",
    "..", '"', 'a."b.c".d', "run.", ".run", "run..dt", "run.dt[0]", "material.friction.stone-base", "structure.most_blocks",
    "structure.repair", "structure.gaps", "x" * 6000, "\x1b[31m.a",
]  # fmt: skip


def set_text(random: Random) -> str:
    """A text for ``--set``; the system takes no NUL in it."""
    value = _pick(
        random, [*NUMBERS, *WORDS, "[" * 3000, "[" * 300 + "]" * 300, "{a = 1}", "[1, 2]", "1979-05-27", '"x"', "true", '"auto"', "1e-3"]
    )
    text = f"{_pick(random, KEYS)}{_pick(random, ['=', '=', '=', '=', ' = ', '==', ''])}{value}"
    return text.replace("\0", "")
