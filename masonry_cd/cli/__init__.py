"""The command line ``masonry-cd``: one file per command. Its own imports are light; each command imports what it needs."""

from __future__ import annotations

import sys


def main() -> None:
    """The entry point of the installed command. Ctrl-C while it loads, or a second one while it ends, leaves a line and no traceback."""
    try:
        from masonry_cd.cli.app import app

        app()
    except KeyboardInterrupt:
        print("masonry-cd: interrupted", file=sys.stderr)
        sys.exit(130)
