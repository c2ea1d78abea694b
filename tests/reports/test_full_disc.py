"""A disc that is full: exports end in one line, and leave nothing half-made behind."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from made_run import at_rest, box, shifted, write_run
from places import ROOT

CODE = """
import resource, sys
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[1]), resource.RLIM_INFINITY))
from masonry_cd.cli.app import app
app(sys.argv[2:])
"""


@pytest.mark.parametrize(("form", "limit"), [("vtkhdf", 0), ("vtkhdf", 30_000), ("pvd", 0), ("pvd", 2000)])
def test_an_export_that_cannot_be_written_is_one_line(tmp_path, form, limit):
    """No file may grow beyond a limit; the library that writes learns of it as of a full disc."""
    stack = [box("base", (0, 0, 0), (2, 2, 1), fixed=True), *(box(f"b{k}", (0, 0, 1 + k), (1, 1, 2 + k)) for k in range(60))]
    rest = at_rest(stack)
    scene = "[structure]\n[run]\ndt = 1e-3\n"
    write_run(tmp_path / "result.h5", stack, [shifted(rest, slice(1, None), (0.01 * k, 0, 0)) for k in range(12)], scene=scene)
    words = ["export", str(tmp_path), "--format", form, "-o", str(tmp_path / "view")]
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", CODE, str(limit), *words], capture_output=True, text=True, env=environment)
    assert done.returncode == 1, done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert "cannot be written" in done.stderr
    assert not [path for path in (tmp_path / "view").rglob("*") if path.is_file() and path.name.startswith("blocks.")]
    assert not list((tmp_path / "view").rglob("*.part.*"))
    free = subprocess.run([sys.executable, "-c", CODE, str(1 << 40), *words], capture_output=True, text=True, env=environment)
    assert free.returncode == 0, free.stderr
