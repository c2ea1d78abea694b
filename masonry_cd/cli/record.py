# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd record``: the numbers of a record, and a picture of it and its correction."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from masonry_cd.app.result import Result
from masonry_cd.foundation.errors import InputError


def record(
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="Record of accelerations.", show_default=False)] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="PNG", help="Picture to draw; none by default.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A key of [[loads]] kind = "record": units=g, window=[5,17].')
    ] = None,
    measure: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME", help='Intensity measure to print instead of Sa at five periods: "Sa(0.5)", "FIV3(0.5)"; repeatable.'),
    ] = None,
    formats: Annotated[bool, typer.Option("--formats", help="List the formats that are read, with their publishers.")] = False,
) -> Result[Any]:
    """Print the numbers of a record, and draw it: acceleration, velocity, displacement and spectrum, before and after its correction.

    Measures are PGA, PGV, PGD, Arias, CAV, D5-95, Sa(T, damping), AvgSA(from, to, count, damping), Housner(damping), FIV3(T, alpha, beta).

    \b
    Examples:
      masonry-cd record elcentro.AT2
      masonry-cd record elcentro.AT2 -o elcentro.png
      masonry-cd record aqv.csv -o aqv.png --set column=ns_m_s2 --set window=[5.0,17.0]
      masonry-cd record elcentro.AT2 -o elcentro.png --measure "Sa(0.5)" --measure "AvgSA(0.1,1.0)"
    """
    if formats:
        from loads.readers import formats as known

        return Result(None, [f"{name:9} {about}; {by}" for name, about, by in known()])
    if file is None:
        raise InputError("FILE", "missing; --formats lists the formats that are read")
    from masonry_cd.app.commands.record import record as command

    return command(file, output, set_ or (), measure)
