# SPDX-License-Identifier: GPL-3.0-or-later
"""The numbers of a record, and a picture of it and its correction: what ``masonry-cd record`` does."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from loads.picture import file_picture
from loads.signal.accelerogram import Accelerogram, Processed, describe_both
from loads.signal.measures import in_words, of_one_component
from loads.signal.plausible import doubts
from masonry_cd.app.record_doubts import unusual_pga
from masonry_cd.app.result import Result
from masonry_cd.app.scene_text import parse_change
from masonry_cd.foundation.errors import InputError


def record(file: Path, output: Path | None = None, changes: Sequence[str] = (), measures: Sequence[str] | None = None) -> Result[Processed]:
    """Correct a record and measure it.

    Args:
        file: the record.
        output: picture to draw; none when not given.
        changes: ``key=value``, keys of a load of kind "record".
        measures: intensity measures in place of Sa at five periods.

    Raises:
        InputError: no record, a wrong key or measure.
    """
    if not os.path.exists(file):  # Path.exists raises where a name is too long
        raise InputError(file, "no such record")
    chosen = of_one_component(measures, "--measure")
    keys = dict(parse_change(change) for change in changes)
    processed = file_picture(file, output, **keys)
    correction = str(keys.get("correction", Accelerogram.model_fields["correction"].default))
    strong = unusual_pga(processed.after.numbers()["pga"], f"{file.name} has a")
    return Result(
        processed,
        [*describe_both(file.name, processed, correction), f"{file.name}   {in_words(chosen, {'x': processed.after})}"],
        [*([strong] if strong else []), *doubts(processed, correction, file.name)],
        [] if output is None else [output],
    )
