# SPDX-License-Identifier: GPL-3.0-or-later
"""Good inputs in the formats of networks and of other programs, as the tests make them: records by ``record``, blocks by ``build``."""

from __future__ import annotations

import io
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from benchmarks.fuzz import texts

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

import mesh_files
import numpy as np
import record_files

USC, RENADIC = "FILE     1 OF UNCORRECTED ACCELEROGRAM DATA OF VOLUME I:", "RENADIC"
CDMG, BHRC = "UNCORRECTED ACCELEROGRAM DATA              PROCESSED: 02/08/94", "* VOL1DS FILE:  5528/01"
RECORDS: dict[str, tuple[str | bytes, str]] = {  # and the key that they need
    "cosmos": (record_files.cosmos(), ""),
    "csmip 2": (record_files.csmip2(), ""),
    "csmip 1": (record_files.csmip1(), ""),
    "csmip pairs": (record_files.volume(CDMG, "CHAN  1:  90 DEG"), ""),
    "usc": (record_files.volume(USC, "COMP  UP          9", lead=" "), ""),
    "renadic": (record_files.volume(RENADIC, "COMP NS"), ""),
    "bhrc": (record_files.volume(BHRC, "COMP L1", pairs=False), ""),
    "geonet": (record_files.geonet(), "column=0"),
    "smc": (record_files.smc(), ""),
    "afad": (record_files.afad(), "column=0"),
    "unam": (record_files.unam(), "column=1"),
    "cwb": (record_files.cwb(), "column=1"),
    "sac": (record_files.sac(), "units=m/s2"),
    "itaca": (record_files.itaca(), ""),
    "counted": (record_files.counted(), "units=m/s2"),
    "rate": (record_files.counted("103 SAMPLES AT 200 HZ, CM/S2"), ""),
    "fixed": (record_files.fortran(), ""),
    "above": ("SITE,,\nSAMPLING RATE=200Hz,,\nUNIT=gal,,\nNS,EW\n" + "".join(f"{v:.6f},{-v:.6f}\n" for v in record_files.WAVE), "column=0"),
    "slist": (record_files.slist(), ""),
    "tspair": (record_files.tspair(), ""),
    "film": (record_files.film(), ""),
    "skip": ("Downloaded\nyesterday\n" + record_files.counted(), "skip=2 units=m/s2"),
    "step": ("time,acc [g]\n" + "".join(f"{0.005 * k:.2f},{v:.6f}\n" for k, v in enumerate(record_files.WAVE)), "time_step=0.005"),
}


def miniseed() -> bytes:
    """An accelerogram in records of miniSEED, of 512 bytes each."""
    from obspy import Trace

    header = {"network": "XX", "station": "FUZZ", "channel": "HNE", "delta": record_files.STEP}
    out = io.BytesIO()
    Trace((100.0 * record_files.WAVE).astype(np.float32), header).write(out, format="MSEED", reclen=512)
    return out.getvalue()


def gse() -> bytes:
    """Counts in GSE 2, which obspy writes into files alone."""
    from obspy import Trace

    header = {"station": "FUZZ", "channel": "HNE", "delta": record_files.STEP}
    with tempfile.TemporaryDirectory() as folder:
        Trace((1000.0 * record_files.WAVE).astype(np.int32), header).write(f"{folder}/a.gse", format="GSE2")
        return Path(folder, "a.gse").read_bytes()


def records() -> Iterator[tuple[str, tuple[str, ...], str, bytes]]:
    """Kind, command, name and content of a record in each format."""
    for kind, (content, key) in {
        **RECORDS,
        "miniseed": (miniseed(), "units=cm/s2"),
        "gse": (gse(), "calibration=1e-3 units=cm/s2"),
    }.items():
        data = content.encode() if isinstance(content, str) else content
        sets = [word for one in key.split() for word in ("--set", one)]
        yield f"record {kind}", ("record", "quake.dat", *sets), "quake.dat", data


def blocks(nursery: Path) -> Iterator[tuple[str, str, dict[str, bytes]]]:
    """Kind, name of the file that is changed, and all files, of two boxes in each format."""
    folder = nursery / "formats"
    folder.mkdir()
    mesh_files.gltf(folder / "boxes.gltf")
    mesh_files.gltf(folder / "boxes.glb", glb=True)
    mesh_files.threemf(folder / "boxes.3mf")
    mesh_files.lmgc90(folder)
    made: dict[str, str | bytes] = {
        "boxes.off": mesh_files.off(), "boxes.ply": mesh_files.ply(), "binary.ply": mesh_files.ply("binary_little_endian"),
        "boxes.dxf": mesh_files.dxf(), "polyface.dxf": mesh_files.dxf(polyface=True), "boxes.compas": mesh_files.compas(),
        "boxes.3dec": mesh_files.threedec(), "prism.3dec": mesh_files.PRISM, "sets.3dec": mesh_files.SETS,
        "boxes.wrl": mesh_files.vrml(), "boxes.msh": mesh_files.msh(), "elevation.dxf": mesh_files.elevation(),
    }  # fmt: skip
    for name, content in made.items():
        (folder / name).write_bytes(content.encode() if isinstance(content, str) else content)
    companions = {"boxes.gltf": ("boxes.bin",), "BODIES.DAT": ("DRV_DOF.DAT", "BULK_BEHAV.DAT")}
    for name in (*made, "boxes.gltf", "boxes.glb", "boxes.3mf", "BODIES.DAT"):
        files = {own: (folder / own).read_bytes() for own in (name, *companions.get(name, ()))}
        stated = "" if name.endswith(("3mf", "gltf", "glb")) else 'units = "m"\nup = "z"\n'
        stated += "thickness = 0.5\n" if name == "elevation.dxf" else ""
        scene = texts.scene(structure=f'kind = "file"\npath = "{name}"\n{stated}fixed = {{ below = 0.9 }}\nrepair = true')
        yield f"block file {name.rpartition('.')[2].upper()}", name, {"scene.toml": scene.encode(), **files}
