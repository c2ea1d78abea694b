# SPDX-License-Identifier: GPL-3.0-or-later
"""The page: one HTML file that shows a run to whoever opens it, without a network and without this program.

    pack.py      arrays -> one deflated, base64 text
    motion.py    how blocks and joints move over the frames, in whole numbers
    series.py    plots over time: base motion, energy, solver error, cost
    words.py     the case as text and numbers
    section.py   a section of the page: what fills its template; sections, stress and limits list theirs
    document.py  how a template is filled, and what all pages of the program share
    build.py     all of it into run.html

The browser's part is in the templates and in the scripts next to this file; it uses WebGL 2 and ``DecompressionStream`` (browsers since
2023) and nothing from outside: a content policy in the page forbids it any request.
"""

from reports.page.build import write_page

__all__ = ["write_page"]
