"""``python -m masonry_cd``: the command line."""

from masonry_cd.cli import main

main()
