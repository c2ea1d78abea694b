# SPDX-License-Identifier: GPL-3.0-or-later
"""The page, and its print."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from reports.files import Job, Output
from reports.outputs import PAGE, PRINT, write_page


def _page(job: Job) -> Iterable[Path]:
    write_page(job.results, job.folder / PAGE, job.settings, job.summary, job.damage)
    return [job.folder / PAGE]


def _print(job: Job) -> Iterable[Path]:
    from reports.page.pdf import write_pdf

    write_pdf(job.folder / PAGE, job.folder / PRINT)
    return [job.folder / PRINT]


OUTPUTS = {
    "page": Output({PAGE: "the page that shows the run to any browser"}, _page, lambda job: job.settings.html, 50),
    "pdf": Output({PRINT: "the page on A4"}, _print, place=51),
}
