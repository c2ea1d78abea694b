"""The page: one HTML file that shows a run to whoever opens it, without a network and without this program.

    pack.py      arrays -> one deflated, base64 text
    motion.py    how blocks and joints move over the frames, in whole numbers
    series.py    plots over time: base motion, energy, solver error, cost
    words.py     the case in words and numbers, as HTML
    document.py  what stands around the body of every page: head, style, script
    build.py     all of it into page.html

The browser's part is in page.html, style.css and the scripts beside them; it uses WebGL 2 and ``DecompressionStream`` (browsers since
2023) and nothing from outside: a content policy in the page forbids it any request.
"""

from reports.page.build import write_page

__all__ = ["write_page"]
