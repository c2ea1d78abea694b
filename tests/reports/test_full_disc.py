# SPDX-License-Identifier: GPL-3.0-or-later
"""A disc that is full: exports end in one line, and leave nothing half-made behind."""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path

import pytest
from forked import ended
from made_run import at_rest, box, shifted, write_run

from masonry_cd.cli import main

PATIENCE = 60  # [s]


def exported(folder: Path, form: str, limit: int) -> list[str]:
    """The lines on standard error of an export in a process whose files may have so many bytes, those of libraries among them."""

    def body() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
        os.dup2(write, 2)
        sys.stderr, sys.argv = os.fdopen(2, "w"), ["masonry-cd", "export", str(folder), "--format", form, "-o", str(folder / "view")]
        try:
            main()
        finally:
            sys.stderr.flush()

    read, write = os.pipe()
    how = ended(body, PATIENCE)
    os.close(write)
    with os.fdopen(read) as said:
        lines = said.read().splitlines()
    assert how.endswith(f"SystemExit: {1 if lines else 0}\n"), how
    return lines


@pytest.mark.parametrize(("form", "limit"), [("vtkhdf", 0), ("vtkhdf", 30_000), ("pvd", 0), ("pvd", 2000)])
def test_an_export_that_cannot_be_written_is_one_line(tmp_path, form, limit):
    """No file may grow beyond a limit; the library that writes learns of it as of a full disc."""
    stack = [box("base", (0, 0, 0), (2, 2, 1), fixed=True), *(box(f"b{k}", (0, 0, 1 + k), (1, 1, 2 + k)) for k in range(60))]
    rest = at_rest(stack)
    scene = "[structure]\n[run]\ndt = 1e-3\n"
    write_run(tmp_path / "result.h5", stack, [shifted(rest, slice(1, None), (0.01 * k, 0, 0)) for k in range(12)], scene=scene)
    (line,) = exported(tmp_path, form, limit)
    assert "cannot be written" in line
    assert not [path for path in (tmp_path / "view").rglob("*") if path.is_file() and path.name.startswith("blocks.")]
    assert not list((tmp_path / "view").rglob("*.part.*"))
    assert exported(tmp_path, form, 1 << 40) == []
