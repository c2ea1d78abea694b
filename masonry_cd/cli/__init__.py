# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line ``masonry-cd``: one file per command. Its own imports are light; each command imports what it needs."""

from __future__ import annotations

import gc
import sys

COLLECT = (20_000, 10, 10)  # objects made between two looks for garbage, see the module gc: most of what a command makes as it starts stays


def main() -> None:
    """The entry point of the installed command. Ctrl-C while it loads, or a second one while it ends, leaves a line and no traceback."""
    gc.set_threshold(*COLLECT)  # a tenth of the time of a start
    from masonry_cd.foundation.errors import InputError
    from masonry_cd.foundation.own_packages import require_own_packages

    try:
        require_own_packages()
        from masonry_cd.cli.app import app

        app()
    except InputError as error:
        print(f"masonry-cd: error: {error}", file=sys.stderr)
        sys.exit(2)
    except KeyboardInterrupt:
        print("masonry-cd: interrupted", file=sys.stderr)
        sys.exit(130)
