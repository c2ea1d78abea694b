# SPDX-License-Identifier: GPL-3.0-or-later
"""Contents of a DXF, by ezdxf: the entities of its model space with those that inserts bring, placed in the world.

Both readers of drawings, of blocks (:mod:`structures.files.dxf_blocks`) and of plans (:mod:`structures.plans.dxf_file`), walk it by
:func:`shown`, in the child process. What is hidden, or cannot be placed, comes with the reason, so that no reader passes it over in
silence. Sheets of paper space show the model once more and are counted only.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from masonry_cd.foundation.extras import require
from structures.files.foreign import Refused

DEEPEST = 8  # inserts within inserts: what goes deeper inserts itself
# What ezdxf raises of damaged files, in addition to errors of its own.
DAMAGED = (ValueError, ArithmeticError, KeyError, IndexError, AttributeError, TypeError, StopIteration, RecursionError)
FRAMES = ("VIEWPORT",)  # of paper space itself
OFF, FROZEN, INVISIBLE = "its layer is off", "its layer is frozen", "it is invisible"


class Shown(NamedTuple):
    """An entity in its place."""

    entity: Any  # of ezdxf, in world coordinates
    handle: str  # of what an insert brings, that of the insert with a number, A3/2
    layer: str  # on layer 0 of an insert a thing lies on the insert's own layer
    owner: str  # handle of the insert that brings it
    hidden: str  # why it is not seen; empty where it is
    mirrored: bool  # by the inserts that bring it
    damage: str = ""  # why what an insert brings cannot be followed

    @property
    def kind(self) -> str:
        """The type of the entity, LINE, INSERT ..."""
        return str(self.entity.dxftype())


def opened(path: Path, repair: bool) -> tuple[Any, bool]:
    """The drawing of a file, and whether it is damaged and was read as far as it could be.

    Raises:
        Refused: no DXF, or a damaged one that is not to be repaired.
    """
    require("a drawing (DXF)", "ezdxf")
    from ezdxf import DXFError, filemanagement, recover

    try:
        return filemanagement.readfile(path), False
    except DAMAGED + (DXFError,) as failure:
        if not repair:
            raise Refused(path.name, f"no DXF that can be read: {_said(failure)}") from None
        try:
            return recover.readfile(path)[0], True
        except DAMAGED + (DXFError,) as worse:
            raise Refused(path.name, f"no DXF that can be read: {_said(worse)}") from None
    except OSError:
        raise Refused(path.name, "is not a DXF file; its first lines should be 0 and SECTION") from None


def _said(failure: BaseException) -> str:
    return str(failure).strip() or type(failure).__name__


def shown(drawing: Any) -> Iterator[Shown]:
    """The entities of the model space, each insert before what it brings."""
    states = {
        layer.dxf.name.lower(): FROZEN if layer.is_frozen() else OFF for layer in drawing.layers if layer.is_frozen() or layer.is_off()
    }
    yield from _within(drawing.modelspace(), "", "", "", False, states, 0)


def on_sheets(drawing: Any) -> int:
    """How many entities the sheets of paper space hold."""
    return sum(entity.dxftype() not in FRAMES for sheet in drawing.layouts if not sheet.is_modelspace for entity in sheet)


def sheets_line(drawing: Any, name: str) -> list[str]:
    """A line on what stands in paper space, where something does."""
    count = on_sheets(drawing)
    return [f"{name}: {count} entit{'ies' if count > 1 else 'y'} in paper space not read; model space is"] if count else []


def _within(drawn: Any, owner: str, layer: str, hidden: str, mirrored: bool, states: dict[str, str], depth: int) -> Iterator[Shown]:
    """Yield the contents of a space or an insert."""
    for number, one in enumerate(drawn):
        handle = one.dxf.handle if not owner and one.dxf.handle else f"{owner}/{number}"
        on = str(one.dxf.layer) if one.dxf.hasattr("layer") else "0"
        on = layer if owner and on == "0" else on
        why = hidden or (INVISIBLE if one.dxf.get("invisible", 0) else states.get(on.lower(), ""))
        item = Shown(one, handle, on, owner, why, mirrored)
        if one.dxftype() != "INSERT" or one.mcount <= 1:
            yield from _followed(item, states, depth)
            continue
        for k, copy in enumerate(one.multi_insert()):
            yield from _followed(item._replace(entity=copy, handle=f"{handle}.{k}"), states, depth)


def _followed(item: Shown, states: dict[str, str], depth: int) -> Iterator[Shown]:
    """An entity, and what it brings where it is an insert."""
    from ezdxf import DXFError

    yield item
    if item.kind != "INSERT":
        return
    insert = item.entity
    skipped: list[tuple[Any, str]] = []
    try:
        block = insert.block()
        if block is None or block.block.is_xref or depth >= DEEPEST:
            yield item._replace(damage=_not_followed(insert, block))
            return
        brought = list(insert.virtual_entities(skipped_entity_callback=lambda one, why: skipped.append((one, why))))
        mirrored = bool(insert.matrix44().determinant() < 0.0)
    except DAMAGED + (DXFError,) as failure:
        yield item._replace(damage=f"damaged: {_said(failure)}")
        return
    hidden = item.hidden if item.hidden != OFF else ""  # a layer that is off hides what lies on it, a frozen one what it inserts, too
    yield from _within(brought, item.handle, item.layer, hidden, mirrored, states, depth + 1)
    for one, why in skipped:
        yield Shown(
            one, f"{item.handle}/{one.dxf.handle}", item.layer, item.handle, hidden, mirrored, f"cannot be placed by its insert: {why}"
        )


def _not_followed(insert: Any, block: Any) -> str:
    if block is None:
        return f'damaged: there is no block "{insert.dxf.name}"'
    if block.block.is_xref:
        return f'an external reference, to "{block.block.dxf.get("xref_path", "")}"; bind it'
    return f"inserts within inserts, deeper than {DEEPEST}"
