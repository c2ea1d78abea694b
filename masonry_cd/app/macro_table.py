# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of ``[[limit.mechanism]]``: macro-elements that a user chooses or adds."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import AfterValidator, Field, model_validator

from loads.motion import DirectionKey
from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.fields import Table
from masonry_cd.foundation.plugins import names
from masonry_cd.foundation.units import Unit

Text = Annotated[str, Field(min_length=1)]
Metres = Annotated[float, Unit("m")]
Place = Annotated[tuple[Metres, Metres, Metres], Field(strict=False)]


def _known(name: str) -> str:
    """A mechanism of ours, or of an installed package."""
    from structures.macro_elements.element import MECHANISMS

    if name not in MECHANISMS and name not in names("mechanisms"):
        every = (*MECHANISMS, *names("mechanisms"))
        raise ValueError(f'unknown mechanism "{name}"{suggest(name, every)}; one of {", ".join(every)}')
    return name


class MechanismTable(Table):
    """A table ``[[limit.mechanism]]``: one of the parts that the kind of the structure names, or a part by group, blocks or box."""

    part: Text | None = None
    """A part by the name that masonry-cd limit --macro-elements gives it: "facade, gable"."""
    group: Text | None = None
    """Or: all blocks of a group."""
    blocks: Annotated[tuple[Text, ...], Field(strict=False, min_length=1)] | None = None
    """Or: these blocks."""
    box: Annotated[tuple[Place, Place], Field(strict=False)] | None = None
    """Or: the blocks whose centres of mass lie between these two corners."""
    name: Text | None = None
    """Of the part in tables; by default what names its blocks."""
    direction: DirectionKey | None = None
    """Of the push; by default those of the part, of other blocks along and against x and y."""
    mechanisms: (
        Annotated[
            tuple[
                Annotated[
                    Literal[
                        "overturning", "vertical bending", "horizontal bending", "corner overturning", "rocking and sliding of piers",
                        "in-plane shear", "hinges of an arch",
                    ]
                    | str,
                    AfterValidator(_known),
                ],
                ...,
            ],
            Field(strict=False, min_length=1),
        ]
        | None
    ) = None  # fmt: skip
    """Of rigid bodies, beside the free least one, or those of a package; by default those of the part, of other blocks overturning and both
    bendings."""

    @model_validator(mode="after")
    def _one_choice(self) -> MechanismTable:
        given = [name for name in ("part", "group", "blocks", "box") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"{' and '.join(given) or 'nothing'} given; name the blocks by one of part, group, blocks or box")
        return self
