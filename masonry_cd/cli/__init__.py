"""The command line ``masonry-cd``: one file per command. Its own imports are light; each command imports what it needs."""

from __future__ import annotations


def main() -> None:
    """The entry point of the installed command."""
    from masonry_cd.cli.app import app

    app()
