# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line ``masonry-cd``. One file per command, whose own imports are light; inside it imports what it needs.

Exit codes: 0 done, 1 the run could not go on, 2 bad input (one line says what and where), 128 + N stopped by the signal N: 130 by Ctrl-C,
143 by SIGTERM.
"""

from __future__ import annotations

from importlib import import_module
from typing import Annotated

import typer

from masonry_cd import __version__
from masonry_cd.cli.printing import printed

COMMANDS = (  # files of this package, each with a function of its name, in the order of the help text
    "init", "run", "build", "report", "view", "export", "compare", "record", "select", "modal", "limit", "strengthen", "risk", "solve",
    "accuracy", "study", "assess", "calibrate", "validate", "schema", "plugins",
)  # fmt: skip

app = typer.Typer(
    name="masonry-cd",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 110},
)


def _print_version(asked: bool) -> None:
    if asked:
        typer.echo(f"masonry-cd {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    version: Annotated[bool, typer.Option("--version", help="Print the version and exit.", callback=_print_version, is_eager=True)] = False,
) -> None:
    """Seismic analysis of block masonry by non-smooth contact dynamics: which joints open, what falls, at which shaking.

    \b
    A first run:
      masonry-cd run examples/arch.toml -o out/arch
      masonry-cd report out/arch
    """


for name in COMMANDS:
    app.command()(printed(getattr(import_module(f"masonry_cd.cli.{name}"), name)))
