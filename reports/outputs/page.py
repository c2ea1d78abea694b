# SPDX-License-Identifier: GPL-3.0-or-later
"""The page, and its print: Chromium, or a browser of its family, prints it to PDF without a display."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Iterable
from pathlib import Path

from masonry_cd.foundation.atomic import part_of
from masonry_cd.foundation.errors import InputError
from reports.files import Job, Output, never
from reports.outputs import PAGE, PRINT, write_page

BROWSERS = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "microsoft-edge", "chrome", "msedge")
FLAGS = (
    "--headless", "--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--no-pdf-header-footer", "--virtual-time-budget=30000",
)  # fmt: skip
PATIENCE = 300.0  # [s]


def write_pdf(page: Path, path: Path) -> None:
    """Print a page to a PDF.

    Raises:
        InputError: no browser of the family here, or one that prints nothing.
    """
    browser = next((found for name in BROWSERS if (found := shutil.which(name))), None)
    if browser is None:
        raise InputError(
            "--pdf", "Chromium, which prints the page, is missing (Debian: apt-get install chromium); or print report.html from any browser"
        )
    part_of(path).unlink(missing_ok=True)
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [browser, *FLAGS, f"--user-data-dir={profile}", f"--print-to-pdf={part_of(path).resolve()}", page.resolve().as_uri()]
        try:
            subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, timeout=PATIENCE, check=False)
        except subprocess.TimeoutExpired:
            raise InputError("--pdf", f"{browser} did not finish within {PATIENCE:g} s") from None
    if not part_of(path).exists():
        raise InputError("--pdf", f"{browser} printed nothing")
    part_of(path).replace(path)


def _write_html(job: Job) -> Iterable[Path]:
    write_page(job.results, job.folder / PAGE, job.settings, job.summary, job.damage)
    return [job.folder / PAGE]


def _write_print(job: Job) -> Iterable[Path]:
    write_pdf(job.folder / PAGE, job.folder / PRINT)
    return [job.folder / PRINT]


OUTPUTS = {
    "html": Output({PAGE: "the page of the run, for any browser"}, _write_html, place=50, needs=("matplotlib",)),
    "pdf": Output({PRINT: "the page on A4"}, _write_print, never, 51),
}
