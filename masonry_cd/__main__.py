# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m masonry_cd``: the command line, as the installed command ``masonry-cd``.

Python puts the working folder before all others on its path. Unless masonry_cd itself is there, it is taken off again: the user's own
files, called loads.py or reports.py, have nothing to do with a command.
"""

import sys
from pathlib import Path

if sys.path and Path(sys.path[0]).resolve() == Path.cwd() != Path(__file__).resolve().parent.parent and not sys.flags.safe_path:
    del sys.path[0]

from masonry_cd.cli import main

main()
