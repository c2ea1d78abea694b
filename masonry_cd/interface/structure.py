# SPDX-License-Identifier: GPL-3.0-or-later
"""The blocks of a structure, as a sequence that knows their names."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING, Any, overload

import numpy as np

from masonry_cd.foundation.errors import InputError, suggest
from masonry_cd.interface.sealed import Sealed
from masonry_cd.interface.tables import frame_of
from masonry_cd.mechanics.model.blocks import Block

if TYPE_CHECKING:
    from pandas import DataFrame
    from PIL.Image import Image


class Structure(Sealed, Sequence[Block]):
    """Blocks in the order of the results: ``structure["drum1"].vertices``, ``structure[0].faces``, ``len(structure)``."""

    blocks: tuple[Block, ...]
    notes: tuple[str, ...]
    ties: tuple[np.ndarray, ...]

    def __init__(self, blocks: Sequence[Block], notes: tuple[str, ...] = (), ties: Sequence[np.ndarray] = ()) -> None:
        self.blocks, self.notes, self.ties = tuple(blocks), notes, tuple(ties)
        """The blocks; lines on what was changed in making them; ties by their ends (2, 3) each [m]."""

    @cached_property
    def names(self) -> list[str]:
        """Names of the blocks."""
        return [block.name for block in self.blocks]

    def index(self, name: object, start: int = 0, stop: int | None = None) -> int:
        """Place of a block, given itself or its name.

        Raises:
            InputError: no block has this name.
        """
        if not isinstance(name, str):
            return self.blocks.index(name, start, len(self.blocks) if stop is None else stop)
        if name not in self.names:
            raise InputError("", f'no block is named "{name}"{suggest(name, self.names)}; the first are {", ".join(self.names[:5])}')
        return self.names.index(name)

    @cached_property
    def table(self) -> DataFrame:
        """A row per block: group, fixed, volume [m3], mass [kg], x, y, z of its centre of mass [m]; fill on it counts in the latter two."""
        made = [block.mass_properties for block in self.blocks]
        heavy, centre = np.array([item.volume for item in made]), np.array([item.centre for item in made])
        columns: dict[str, Any] = {
            "group": [block.group for block in self.blocks],
            "fixed": [block.fixed for block in self.blocks],
            "volume": heavy - [block.carried_volume for block in self.blocks],
            "mass": heavy * [block.density for block in self.blocks],
        }
        return frame_of(columns | dict(zip("xyz", centre.T, strict=True)), index=self.names, name="block")

    def picture(self, title: str = "Structure", view: str = "auto") -> Image:
        """The blocks by group, as an image that a notebook shows; ``view`` as in :meth:`Scene.picture`."""
        from masonry_cd.interface.plots import image_of
        from reports.drawing.solids import structure_scene

        return image_of(structure_scene(self.blocks, title, view, self.ties))

    @overload
    def __getitem__(self, key: int | str) -> Block: ...

    @overload
    def __getitem__(self, key: slice) -> Structure: ...

    def __getitem__(self, key: int | str | slice) -> Block | Structure:
        if isinstance(key, slice):
            return Structure(self.blocks[key])
        return self.blocks[self.index(key) if isinstance(key, str) else key]

    def __iter__(self) -> Iterator[Block]:
        return iter(self.blocks)

    def __len__(self) -> int:
        return len(self.blocks)

    def __repr__(self) -> str:
        fixed = sum(block.fixed for block in self.blocks)
        return f"<Structure: {len(self.blocks)} blocks, {fixed} of them fixed>"

    def _repr_html_(self) -> str:
        return f"<p>{html.escape(repr(self)[1:-1])}</p>{self.table._repr_html_()}"
