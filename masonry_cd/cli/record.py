# SPDX-License-Identifier: GPL-3.0-or-later
"""``masonry-cd record``: the numbers of a record, and a picture of it and its correction."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from masonry_cd.cli.shared import errors_reported, warn


def record(
    file: Annotated[Path | None, typer.Argument(metavar="[FILE]", help="Record of accelerations.", show_default=False)] = None,
    output: Annotated[Path | None, typer.Option("-o", "--output", metavar="PNG", help="Picture to draw; none by default.")] = None,
    set_: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help='A key of [[loads]] kind = "record": units=g, window=[5,17].')
    ] = None,
    measure: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME", help='Intensity measure to print instead of Sa at five periods: "Sa(0.5)", "FIV3(0.5)"; as often as needed.'
        ),
    ] = None,
    formats: Annotated[bool, typer.Option("--formats", help="List the formats that are read, and who publishes them.")] = False,
) -> None:
    """Print the numbers of a record, and draw it: acceleration, velocity, displacement and spectrum, before and after its correction.

    Measures are PGA, PGV, PGD, Arias, CAV, D5-95, Sa(T, damping), AvgSA(from, to, count, damping), Housner(damping), FIV3(T, alpha, beta).

    \b
    Examples:
      masonry-cd record elcentro.AT2
      masonry-cd record elcentro.AT2 -o elcentro.png
      masonry-cd record aqv.csv -o aqv.png --set column=ns_m_s2 --set window=[5.0,17.0]
      masonry-cd record elcentro.AT2 -o elcentro.png --measure "Sa(0.5)" --measure "AvgSA(0.1,1.0)"
    """
    with errors_reported():
        from loads.picture import file_picture
        from loads.signal.accelerogram import Accelerogram, describe_both
        from loads.signal.measures import in_words, of_one_component
        from loads.signal.plausible import doubts
        from masonry_cd.app.record_doubts import unusual_pga
        from masonry_cd.app.scene_text import parse_change
        from masonry_cd.foundation.errors import InputError

        if formats:
            from loads.readers import formats as known

            typer.echo("\n".join(f"{name:9} {about}; {by}" for name, about, by in known()))
            return
        if file is None:
            raise InputError("FILE", "missing; --formats lists the formats that are read")
        if not os.path.exists(file):  # Path.exists raises where a name is too long
            raise InputError(file, "no such record")
        measures = of_one_component(measure, "--measure")
        keys = dict(parse_change(change) for change in set_ or ())
        processed = file_picture(file, output, **keys)
        correction = str(keys.get("correction", Accelerogram.model_fields["correction"].default))
        typer.echo("\n".join(describe_both(file.name, processed, correction)))
        typer.echo(f"{file.name}   {in_words(measures, {'x': processed.after})}")
        if output is not None:
            typer.echo(f"written: {output}")
        strong = unusual_pga(processed.after.numbers()["pga"], f"{file.name} has a")
        warn([*([strong] if strong else []), *doubts(processed, correction, file.name)])
