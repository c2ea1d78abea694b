# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks drawn as outlines: closed polylines of a DXF, and bodies of LMGC90 in a plane, drawn out by a thickness."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

STONES = [((0.0, 0.0), (1.0, 0.3)), ((0.0, 0.3), (0.4, 0.6)), ((0.4, 0.3), (1.0, 0.6))]
UP = (0.0, 0.0, 1.0)


def rectangle(low: tuple[float, float], high: tuple[float, float]) -> list[tuple[float, float]]:
    return [low, (high[0], low[1]), high, (low[0], high[1])]


def drawing(units: int = 6) -> Any:
    import ezdxf

    document: Any = ezdxf.new("R2010")
    document.header["$INSUNITS"] = units
    return document


def elevation(units: int = 6, size: float = 1.0) -> Any:
    document = drawing(units)
    for k, stone in enumerate(STONES):
        corners = [(size * x, size * y) for x, y in rectangle(*stone)][:: -1 if k else 1]
        document.modelspace().add_lwpolyline(corners, close=True, dxfattribs={"layer": f"C{k}"})
    return document


def made(folder: Path, document: Any, **keys: Any) -> tuple[list[Block], str]:
    document.saveas(folder / "a.dxf")
    blocks, notes, *_ = structures.make({"kind": "file", "path": "a.dxf", "up": "z", "thickness": 0.5, **keys}, 2000.0, folder)
    return blocks, "\n".join(notes)


def boxes_of(blocks: list[Block]) -> np.ndarray:
    return np.array([[block.vertices.min(axis=0), block.vertices.max(axis=0)] for block in blocks])


@pytest.mark.parametrize(("units", "size", "keys"), [(6, 1.0, {}), (6, 1.0, {"up": "y"}), (4, 1000.0, {}), (0, 100.0, {"units": "cm"})])
def test_an_elevation_stands_up_whatever_its_unit_and_axis(tmp_path: Path, units: int, size: float, keys: dict[str, Any]) -> None:
    blocks, notes = made(tmp_path, elevation(units, size), **keys)
    assert boxes_of(blocks)[:, :, [0, 2]] == pytest.approx(np.array(STONES))
    assert boxes_of(blocks)[:, :, 1] == pytest.approx(np.tile([0.0, 0.5], (3, 1)))
    assert [block.group for block in blocks] == ["C0", "C1", "C2"] and notes == ""


def test_outlines_in_an_upright_plane_stay_in_it(tmp_path: Path) -> None:
    """The plane is that of a polyline, or follows by the corners of one in space that ends where it began."""
    document = drawing()
    document.modelspace().add_lwpolyline(rectangle((0.0, 0.0), (1.0, 2.0)), close=True, dxfattribs={"extrusion": (0.0, -1.0, 0.0)})
    loop = [(0.0, y, z) for y, z in rectangle((2.0, 0.0), (3.0, 2.0))]
    document.modelspace().add_polyline3d([*loop, loop[0]])
    blocks, _ = made(tmp_path, document)
    assert boxes_of(blocks)[0] == pytest.approx(np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 2.0]]))
    assert np.ptp(blocks[1].vertices, axis=0) == pytest.approx([0.5, 1.0, 2.0])
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([1.0, 1.0])


def test_arcs_become_chords_within_the_distance_given(tmp_path: Path) -> None:
    document = drawing()
    document.modelspace().add_lwpolyline([(0, 0, 0), (2, 0, 1.0)], format="xyb", close=True)  # half a disc
    blocks, _ = made(tmp_path, document, chord=0.001)
    assert blocks[0].mass_properties.volume == pytest.approx(0.25 * math.pi, rel=2e-3)
    with pytest.raises(InputError) as refused:
        made(tmp_path, document)
    assert refused.value.place == "structure.chord"


def test_outlines_placed_by_inserts_and_not_convex(tmp_path: Path) -> None:
    document = drawing()
    corner = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    document.blocks.new("L").add_lwpolyline(corner, close=True)
    for place, scale in (((0, 0), 1.0), ((5, 0), -1.0)):
        document.modelspace().add_blockref("L", place, dxfattribs={"xscale": scale})
    blocks, _ = made(tmp_path, document)
    assert [block.mass_properties.volume for block in blocks] == pytest.approx([1.5, 1.5])
    assert [len(block.parts) for block in blocks] == [2, 2] and boxes_of(blocks)[1, :, 0] == pytest.approx([3.0, 5.0])


def test_open_polylines_are_counted_and_overlapping_ones_named(tmp_path: Path) -> None:
    document = elevation()
    document.modelspace().add_lwpolyline([(0, 0), (5, 5), (6, 5)])
    assert "1 LWPOLYLINE on layer 0 not read" in made(tmp_path, document)[1]
    document.modelspace().add_lwpolyline(rectangle((0.9, 0.0), (1.2, 0.3)), close=True)
    with pytest.raises(InputError, match='"b0" and "b3"'):
        made(tmp_path, document)


@pytest.mark.parametrize("corners", [[(0, 0), (1, 0), (2, 0)], [(0, 0), (1, 1), (1, 0), (0, 1)], [(0, 0), (3, 2), (3, 0), (0, 1)]])
def test_outlines_that_are_none_are_refused(tmp_path: Path, corners: list[tuple[float, float]]) -> None:
    """Without area, and crossing themselves."""
    document = drawing()
    document.modelspace().add_lwpolyline(corners, close=True)
    with pytest.raises(InputError, match=r"a\.dxf"):
        made(tmp_path, document)


BODIES = """$bdyty
 RBDY2      1
$blmty
 PLAIN      1  behav  STONE  avrd= 1.0D+00  gyrd= 1.0D+00
$nodty
 NO3xx      1                coo1= 0.5000000D+00  coo2= 0.1500000D+00  coo3= 0.0000000D+00
$tacty
 JONCx      1  color  BASEx  axe1= 0.5000000D+00  axe2= 0.1500000D+00
$$$$$$
$bdyty
 RBDY2      2
$blmty
 PLAIN      1  behav  STONE  avrd= 1.0D+00  gyrd= 1.0D+00
$nodty
 NO3xx      1                coo1= 0.5000000D+00  coo2= 0.8000000D+00  coo3= {turn}
$tacty
 POLYG      1  color  BLUEx  nb_vertex=      4
                             coo1=-0.5000000D+00  coo2=-0.2000000D+00
                             coo1= 0.5000000D+00  coo2=-0.2000000D+00
                             coo1= 0.5000000D+00  coo2= 0.2000000D+00
                             coo1=-0.5000000D+00  coo2= 0.2000000D+00
$$$$$$
"""


def test_bodies_of_lmgc90_in_a_plane(tmp_path: Path) -> None:
    """The upper one is turned upright by its node; the lower one is driven in all three directions."""
    (tmp_path / "BODIES.DAT").write_text(BODIES.format(turn=f"{math.pi / 2:.12E}".replace("E", "D")), encoding="ascii")
    driven = "\n".join(f"$dofty\n vlocy     {k} CT= 0.0" for k in (1, 2, 3))
    (tmp_path / "DRV_DOF.DAT").write_text(f"$bdyty\n RBDY2      1\n$nodty\n NO3xx 1\n{driven}\n$$$$$$\n", encoding="ascii")
    (tmp_path / "BULK_BEHAV.DAT").write_text("$behav\n STONE  RIGID  Umas= 1.8D+03\n", encoding="ascii")
    keys = {"kind": "file", "path": "BODIES.DAT", "units": "m", "up": "z"}
    blocks = structures.build({**keys, "thickness": 0.25}, 2000.0, tmp_path)
    assert [(block.name, block.fixed, block.density) for block in blocks] == [("RBDY2_1", True, 1800.0), ("RBDY2_2", False, 1800.0)]
    assert boxes_of(blocks)[1] == pytest.approx(np.array([[0.3, 0.0, 0.3], [0.7, 0.25, 1.3]]))
    with pytest.raises(InputError) as refused:
        structures.build(keys, 2000.0, tmp_path)
    assert refused.value.place == "structure.thickness"


def test_layers_whose_bytes_are_no_text_are_shown_with_question_marks(tmp_path: Path) -> None:
    """ezdxf hands bytes on that it cannot read; they get neither into a message nor into a group."""
    elevation().saveas(tmp_path / "good.dxf")
    data = (tmp_path / "good.dxf").read_bytes().replace(b"C1\r\n", b"C\x81\r\n").replace(b"C1\n", b"C\x81\n")
    (tmp_path / "a.dxf").write_bytes(data)
    keys = {"kind": "file", "path": "a.dxf", "up": "z", "thickness": 0.5}
    blocks = structures.build(keys, 2000.0, tmp_path)
    assert all(block.group.encode() for block in blocks)
    (tmp_path / "a.dxf").write_bytes(b"  0\nSECTION\n\x81\x82\nX\n  0\nEOF\n")
    with pytest.raises(InputError, match=r"a\.dxf"):
        structures.build(keys, 2000.0, tmp_path)
