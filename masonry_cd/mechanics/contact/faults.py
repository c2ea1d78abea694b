# SPDX-License-Identifier: GPL-3.0-or-later
"""Faults that end contact detection and name two blocks."""

from __future__ import annotations


class ContactFault(RuntimeError):
    """Contacts of two blocks cannot be found, or are wrong.

    Attributes:
        blocks: the two.
        text: a sentence with two places for their names.
    """

    def __init__(self, blocks: tuple[int, int], text: str) -> None:
        super().__init__(text.format(*(f"block {block}" for block in blocks)))
        self.blocks, self.text = blocks, text


class TooManyPoints(ContactFault):
    """The meshes of two faces cross in more points than a pair has room for."""

    def __init__(self, blocks: tuple[int, int]) -> None:
        super().__init__(
            blocks, "the meshes of {} and {} cross in too many points; material.mesh_size: elements of one size on both sides would not"
        )


class UnexplainedOverlap(ContactFault):
    """Two blocks have a contact in which they are deeper in each other than they can have moved since they were last looked at."""

    def __init__(self, blocks: tuple[int, int], depth: float, explained: float) -> None:
        text = f"overlap by {1e3 * depth:.3g} mm, of which their motion explains {1e3 * explained:.3g} mm"
        super().__init__(blocks, f"{{}} and {{}} {text}: a fault of contact detection, not of the scene; a smaller run.dt may avoid it")
