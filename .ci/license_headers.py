# SPDX-License-Identifier: GPL-3.0-or-later
"""Every source file names its licence in its first line, as SPDX has it.

``python .ci/license_headers.py`` writes what is missing, ``--check`` lists it. A file that begins with #! keeps that line first.
Kernels are stamped by the bytes of their sources, so that all are compiled again.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

LINE = "# SPDX-License-Identifier: GPL-3.0-or-later\n"


def missing(root: Path) -> list[Path]:
    """The Python files of the repository without the line."""
    listed = subprocess.run(["git", "ls-files", "*.py", "*.pyi"], cwd=root, capture_output=True, text=True, check=True).stdout.split("\n")
    files = [root / name for name in listed if name]
    return [file for file in files if LINE not in file.read_text(encoding="utf-8").splitlines(keepends=True)[:2]]


def write(file: Path) -> None:
    """Put the line at the head of a file."""
    text = file.read_text(encoding="utf-8")
    first, rest = text.split("\n", 1) if text.startswith("#!") else ("", text)
    file.write_text(f"{first}\n{LINE}{rest}" if first else LINE + text, encoding="utf-8")


if __name__ == "__main__":
    found = missing(Path(__file__).resolve().parents[1])
    if "--check" in sys.argv:
        print("\n".join(map(str, found)))
        sys.exit(1 if found else 0)
    for one in found:
        write(one)
    print(f"{len(found)} files")
