# SPDX-License-Identifier: GPL-3.0-or-later
"""Names and groups of blocks in the text of STEP files that this program writes (ISO 10303-21, strings by its section 6.4.3).

The kernel writes a product for each solid, in their order, after that of the whole; of one solid that product alone. It numbers them. Here
they get the names of the blocks, and their occurrences in the whole those of the groups, where every reader looks for them. Where a file
says that it comes from here, both are read from the text: the kernel takes seconds to find the labels of hundreds of solids, and the square
of that for more. This module imports no geometry: the child process that reads a file does not need it.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

ORIGIN = "masonry_cd"  # the system that a file says it comes from
HEAD = 2000  # bytes in which it says so
STRING = r"'((?:[^']|'')*)'"
SYSTEM = re.compile(rf"(\bFILE_NAME\({STRING},\s*{STRING},\s*\(\s*{STRING}\s*\),\s*\(\s*{STRING}\s*\),\s*{STRING}\s*,\s*){STRING}")
PRODUCT = re.compile(rf"\bPRODUCT\({STRING},\s*{STRING},")
OCCURRENCE = re.compile(rf"(\bNEXT_ASSEMBLY_USAGE_OCCURRENCE\({STRING},)\s*{STRING},")


def put(text: str, names: Sequence[str], groups: Sequence[str]) -> str:
    """The text of a file as the kernel has written it, with the names and groups of its solids."""
    own = iter([_written(name) for name in (["structure"] if len(names) > 1 else []) + list(names)])
    of = iter([_written(group) for group in groups])

    def product(_: re.Match[str]) -> str:
        name = next(own)
        return f"PRODUCT({name},{name},"

    text = SYSTEM.sub(lambda match: f"{match[1]}{_written(ORIGIN)}", text, count=1)
    return OCCURRENCE.sub(lambda match: f"{match[1]}{next(of)},", PRODUCT.sub(product, text))


def get(path: Path) -> tuple[list[str], list[str]] | None:
    """Names and groups of the solids of a file, in their order; None where it does not come from here."""
    if path.suffix.lower() not in (".step", ".stp"):
        return None
    with path.open("rb") as file:
        system = SYSTEM.search(file.read(HEAD).decode("latin-1"))
    if system is None or _read(system[len(system.groups())]) != ORIGIN:
        return None
    text = path.read_text(encoding="latin-1")
    names = [_read(match[1]) for match in PRODUCT.finditer(text)]
    return (names[1:], [_read(match[3]) for match in OCCURRENCE.finditer(text)]) if len(names) > 1 else (names, [""])


def _written(text: str) -> str:
    """Quotes and backslashes doubled, other characters than those of ASCII by their numbers."""
    return "'" + re.sub(r"[^ -~]", lambda m: f"\\X4\\{ord(m[0]):08X}\\X0\\", re.sub(r"(['\\])", r"\1\1", text)) + "'"


def _read(text: str) -> str:
    """The string that is written so."""
    plain = re.sub(r"\\X4\\([0-9A-F]{8})\\X0\\", lambda m: chr(int(m[1], 16)), text)
    return re.sub(r"(['\\])\1", r"\1", plain)
