# SPDX-License-Identifier: GPL-3.0-or-later
"""Draw docs/tutorials/page.png: the page of a run as Chromium shows it. The tutorial's run leaves the page that is shown there.

python docs/draw_page.py out/demo
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from pathlib import Path

PICTURE = Path(__file__).parent / "tutorials" / "page.png"
WIDTH, HEIGHT = 1400, 1000  # of the window [pixels]
WAIT = 15000  # until the model is drawn, by the page's own clock [ms]
FLAGS = ("--headless", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars")


def draw(page: Path) -> None:
    """Open the page, and keep what the window shows in a palette of 256 colours."""
    from PIL import Image

    with tempfile.TemporaryDirectory() as folder:
        shot = Path(folder) / "page.png"
        window = (f"--window-size={WIDTH},{HEIGHT}", f"--virtual-time-budget={WAIT}", f"--user-data-dir={folder}/profile")
        command = ["chromium", *FLAGS, *window, f"--screenshot={shot}", page.resolve().as_uri()]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with Image.open(shot) as image:
            image.convert("RGB").quantize(256).save(PICTURE, optimize=True)


if __name__ == "__main__":
    draw(Path(sys.argv[1]) / "report.html")
