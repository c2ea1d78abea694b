# SPDX-License-Identifier: GPL-3.0-or-later
"""Files from elsewhere: none runs anything, crashes, hangs or fills the memory. Each ends in one line; sound ones give the same bits."""

from __future__ import annotations

import json
import math
import os
import random
import shutil
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from models import tower

import structures
from masonry_cd.foundation.errors import InputError
from masonry_cd.foundation.gmsh_session import gmsh_session
from masonry_cd.foundation.trust import VARIABLE
from structures.files import cutting, foreign, mesh_readers, meshfile

HEAD = 'SetFactory("OpenCASCADE");\nBox(1) = {0, 0, 0, 1, 0.4, 0.5};\n'
CUT = {"kind": "solid", "units": "m", "course_height": 0.25, "unit_length": 0.5}
ASKED = {"scale": 1.0, "up": "z", "course_height": 0.25, "unit_length": 0.5, "running": True, "chord": 0.03, "tolerance": 1e-6}
PLACES = 12  # at which a character is changed, one file each


def mesh(folder: Path, name: str) -> None:
    structures.build({"kind": "file", "path": name, "units": "m", "up": "z"}, 2000.0, folder)


def cad(folder: Path, name: str, **keys: object) -> None:
    table = {**CUT, "path": name, "chord": 0.03, **keys}
    structures.build({key: value for key, value in table.items() if key != "units" or not name.endswith(".step")}, 2000.0, folder)


def refused(capfd: pytest.CaptureFixture[str], name: str, read, *args: object, **keys: object) -> str:
    """The one line that a file is refused by, with nothing else said."""
    with pytest.raises(InputError) as failure:
        read(*args, **keys)
    message = str(failure.value)
    assert name in message
    assert message.isprintable(), "more than one line"
    assert len(message) < 600
    assert capfd.readouterr() == ("", "")
    return message


@pytest.fixture
def model(tmp_path: Path):
    """Writes a box and a cylinder as STEP or BREP."""

    def write(name: str) -> bytes:
        with gmsh_session() as gmsh:
            gmsh.model.occ.addBox(0, 0, 0, 2, 0.4, 0.5)
            gmsh.model.occ.addCylinder(3, 0, 0, 0, 0, 0.5, 0.3)
            gmsh.model.occ.synchronize()
            gmsh.write(str(tmp_path / name))
        return (tmp_path / name).read_bytes()

    return write


@pytest.mark.parametrize("command", ["SystemCall", "NonBlockingSystemCall"])
def test_a_geo_that_is_not_trusted_runs_nothing(
    tmp_path: Path, command: str, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sentinel = tmp_path / "sentinel"
    (tmp_path / "wall.geo").write_text(f'{command} ": > {sentinel}";\n{HEAD}')
    message = refused(capfd, "wall.geo", cad, tmp_path, "wall.geo")
    assert message.startswith("structure.path: wall.geo is a program")
    assert message.endswith("pass --trust, else use a .step or .brep")
    assert message == refused(capfd, "wall.geo", cad, tmp_path, "wall.geo", trusted=True)  # a key of the scene vouches for nothing
    assert not sentinel.exists()
    monkeypatch.setenv(VARIABLE, "1")
    cad(tmp_path, "wall.geo")  # and this file is one that would have run it
    for _ in range(50):
        if sentinel.exists():
            return
        time.sleep(0.1)
    raise AssertionError("the file runs nothing even where it is trusted: the test shows nothing")


def test_only_a_geo_is_trusted(tmp_path: Path, model) -> None:
    model("wall.brep")
    with pytest.raises(InputError, match=r"structure\.trusted: belongs to \.geo files"):
        cad(tmp_path, "wall.brep", trusted=True)


@pytest.mark.usefixtures("trusting")
def test_a_trusted_geo_ends_its_child_alone(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "wall.geo").write_text(HEAD + "Exit;\n")
    assert "ended with code 0 and no answer" in refused(capfd, "wall.geo", cad, tmp_path, "wall.geo", trusted=True)


@pytest.mark.usefixtures("trusting")
def test_a_trusted_geo_writes_into_a_folder_that_goes_and_sees_no_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SECRET", "word")
    monkeypatch.setenv("TMPDIR", str(tmp_path / "tmp"))
    (tmp_path / "tmp").mkdir()
    monkeypatch.setattr("tempfile.tempdir", None)
    (tmp_path / "wall.geo").write_text(HEAD + f'Printf(GetEnv("SECRET")) > "{tmp_path}/seen";\nPrintf("here") > "here";\n')
    before = set(os.listdir())
    cad(tmp_path, "wall.geo", trusted=True)
    assert (tmp_path / "seen").read_text().strip() == ""
    assert set(os.listdir()) == before
    assert not list((tmp_path / "tmp").iterdir())


@pytest.mark.skipif(not hasattr(signal, "SIGXCPU"), reason="the child is isolated from what is hidden here, and is limited by the system")
@pytest.mark.usefixtures("trusting")
@pytest.mark.parametrize("limit", [1, 2])
def test_an_endless_loop_ends(tmp_path: Path, limit: int, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "wall.geo").write_text("i = 0;\nFor k In {0:1e15}\ni += 1;\nEndFor\n" + HEAD)
    message = refused(capfd, "wall.geo", cad, tmp_path, "wall.geo", trusted=True, time_limit=limit)
    assert message.endswith(f"not done after {limit} s of computing; it is damaged or too large; structure.time_limit gives it longer")


def sleeps(number: int) -> bool:
    """Return True if a process by that number is the sleep of a test."""
    try:
        return b"sleep" in Path(f"/proc/{number}/cmdline").read_bytes()
    except (FileNotFoundError, ProcessLookupError):
        return False


def test_what_a_file_started_ends_with_it(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A reader that waits takes no processor time: the wall time ends it, and what it waits for, which would go on for a day."""
    (tmp_path / "wall.geo").write_text(f'SystemCall "echo $$ > {tmp_path}/number; exec {shutil.which("sleep")} 86400";\n' + HEAD)
    limits = foreign.Limits(seconds=0.5)
    assert "not done after" in refused(
        capfd, "wall.geo", foreign.read, "structures.files.cutting:cut", tmp_path / "wall.geo", ASKED, limits
    )
    number, waited = int((tmp_path / "number").read_text()), 0
    while sleeps(number) and waited < 600:  # it was killed, and ends when the system gets round to it
        time.sleep(0.1)
        waited += 1
    assert not sleeps(number)


@pytest.mark.parametrize(  # some crash in OpenCASCADE, some go round for ever
    ("name", "seed"),
    [("wall.step", 3), pytest.param("wall.brep", 7, marks=pytest.mark.slow(reason="OpenCASCADE goes round until its time is up"))],
)
def test_damaged_models_end_in_one_line(tmp_path: Path, name: str, seed: int, model, capfd: pytest.CaptureFixture[str]) -> None:
    whole = model(name)
    capfd.readouterr()
    cad(tmp_path, name)
    pick = random.Random(seed)
    outcomes = set()
    for _ in range(PLACES):
        at = pick.randrange(len(whole) // 10, len(whole))
        (tmp_path / name).write_bytes(whole[:at] + bytes([pick.choice(b"0123456789#-(")]) + whole[at + 1 :])
        try:  # a changed digit may leave a sound model
            cad(tmp_path, name, time_limit=3.0)
            outcomes.add("read")
        except InputError as failure:
            assert str(failure).isprintable()
            outcomes.add("refused")
        assert capfd.readouterr() == ("", "")
    assert "refused" in outcomes


@pytest.mark.parametrize("name", ["wall.step", "wall.brep"])
def test_half_a_model_ends_in_one_line(tmp_path: Path, name: str, model, capfd: pytest.CaptureFixture[str]) -> None:
    whole = model(name)
    capfd.readouterr()
    (tmp_path / name).write_bytes(whole[: len(whole) // 2])
    refused(capfd, name, cad, tmp_path, name, time_limit=20.0)


def vtm(folder: Path, points: str) -> None:
    """A multi-block file whose one data set announces a number of points."""
    (folder / "part.vtp").write_text(f"""<VTKFile type="PolyData" version="1.0" byte_order="LittleEndian"><PolyData>
<Piece NumberOfPoints="{points}" NumberOfPolys="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0
</DataArray></Points><Polys><DataArray type="Int64" Name="connectivity" format="ascii">0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">3</DataArray></Polys></Piece></PolyData></VTKFile>""")
    (folder / "whole.vtm").write_text("""<VTKFile type="vtkMultiBlockDataSet" version="1.0"><vtkMultiBlockDataSet>
<DataSet index="0" name="a" file="part.vtp"/></vtkMultiBlockDataSet></VTKFile>""")


@pytest.mark.parametrize("points", ["1000000000", "99999999999999999999", "-1", "10"])
def test_announced_points_that_are_not_there(tmp_path: Path, points: str, capfd: pytest.CaptureFixture[str]) -> None:
    vtm(tmp_path, points)
    refused(capfd, "whole.vtm", mesh, tmp_path, "whole.vtm")


def test_a_multi_block_that_names_itself(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    vtm(tmp_path, "3")
    text = (tmp_path / "whole.vtm").read_text()
    (tmp_path / "whole.vtm").write_text(text.replace("part.vtp", "whole.vtm"))
    refused(capfd, "whole.vtm", mesh, tmp_path, "whole.vtm")


@pytest.mark.parametrize("suffix", ["stl", "vtu"])
def test_half_a_mesh_ends_in_one_line(tmp_path: Path, suffix: str, capfd: pytest.CaptureFixture[str]) -> None:
    meshfile.write(tmp_path / f"stack.{suffix}", tower(2))
    whole = (tmp_path / f"stack.{suffix}").read_bytes()
    for share in (0.02, 0.3, 0.9):
        (tmp_path / f"stack.{suffix}").write_bytes(whole[: int(share * len(whole))])
        refused(capfd, f"stack.{suffix}", mesh, tmp_path, f"stack.{suffix}")


def test_an_stl_that_announces_four_billion_triangles(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "huge.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 2**32 - 1) + b"\0" * 100)
    refused(capfd, "huge.stl", mesh, tmp_path, "huge.stl")


def test_entities_that_multiply_end_in_one_line(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """A VTU is XML: ten entities of ten of the one before make ten thousand million characters."""
    entities = "".join(f'<!ENTITY e{k} "{f"&e{k - 1};" * 10}">' for k in range(1, 11))
    (tmp_path / "many.vtu").write_text(f'<?xml version="1.0"?><!DOCTYPE v [<!ENTITY e0 "0123456789">{entities}]><VTKFile>&e10;</VTKFile>')
    refused(capfd, "many.vtu", mesh, tmp_path, "many.vtu")


@pytest.mark.parametrize("cell", ["0 1 2 9", "0 1 2 -1"])
def test_cells_that_name_points_that_there_are_not(tmp_path: Path, cell: str, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "tetra.vtu").write_text(f"""<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian"><UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1"><Points><DataArray type="Float64" NumberOfComponents="3" format="ascii">
0 0 0 1 0 0 0 1 0 0 0 1</DataArray></Points><Cells><DataArray type="Int64" Name="connectivity" format="ascii">{cell}</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4</DataArray><DataArray type="Int64" Name="types" format="ascii">10</DataArray>
</Cells></Piece></UnstructuredGrid></VTKFile>""")
    assert "names a point outside 0 to 3" in refused(capfd, "tetra.vtu", mesh, tmp_path, "tetra.vtu")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("o a\nv 1 2\n", "bad.obj: line 2: a vertex has three coordinates: v 1 2"),
        (f"o a\nv 0 0 0\nf {'1' * 5000} 1 1\n", "bad.obj: line 3: no number where one belongs: f 111"),
        ("o a\nv 0 0 nan\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n", "bad.obj: "),
        ("o a\nv 0 0 0\nv 1 0 0\nf 1 2\nf\n", "bad.obj: "),
    ],
)
def test_lines_of_an_obj(tmp_path: Path, text: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bad.obj").write_text(text)
    assert refused(capfd, "bad.obj", mesh, tmp_path, "bad.obj").startswith(message)


def same(one: foreign.FileContents, other: foreign.FileContents) -> bool:
    """To the bit."""
    pairs = zip(one[0], other[0], strict=True)
    return list(one[1]) == list(other[1]) and all(
        a[:2] == b[:2] and a[3] == b[3] and a[2].tobytes() == b[2].tobytes() and a[2].shape == b[2].shape for a, b in pairs
    )


@pytest.mark.parametrize("suffix", ["stl", "vtu", "vtm"])
def test_a_child_reads_meshes_to_the_same_bits(tmp_path: Path, suffix: str) -> None:
    file = tmp_path / f"stack.{suffix}"
    meshfile.write(file, tower(3))
    reader = f"read_{suffix}"
    read = foreign.read(f"structures.files.mesh_readers:{reader}", file)
    assert len(read[0]) >= 1
    assert same(read, getattr(mesh_readers, reader)(file))


@pytest.mark.parametrize("name", ["wall.step", "wall.brep", "wall.geo"])
def test_a_child_cuts_solids_to_the_same_bits(tmp_path: Path, name: str, model) -> None:
    if name.endswith(".geo"):
        (tmp_path / name).write_text(HEAD)
    else:
        model(name)
    read = foreign.read("structures.files.cutting:cut", tmp_path / name, ASKED)
    assert len(read[0]) >= 2
    assert same(read, cutting.cut(tmp_path / name, **ASKED))


@pytest.mark.parametrize("height", [1e-9, 1e-12])
def test_more_stones_than_are_allowed_are_refused_before_they_are_cut(tmp_path: Path, height: float, model) -> None:
    model("wall.brep")
    with pytest.raises(InputError, match=r"^structure\.course_height: makes about .* blocks, at most 100000 are allowed; most_blocks = N "):
        cad(tmp_path, "wall.brep", course_height=height)
    with pytest.raises(InputError, match=r"makes about 8.7 blocks, at most 2 are allowed"):
        cad(tmp_path, "wall.brep", most_blocks=2)


def test_a_child_imports_no_more_than_it_needs() -> None:
    text = "import sys, structures.files.foreign, structures.files.mesh_readers, structures.files.cutting; print(*sys.modules)"
    there = set(subprocess.run([sys.executable, "-c", text], capture_output=True, text=True, check=True).stdout.split())
    assert "numpy" in there
    assert not there & {"numba", "scipy", "pydantic", "gmsh", "vtkmodules", "pyvista", "trimesh", "meshio", "masonry_cd.foundation.errors"}


# Readers that misbehave, found by their names in the child.


def crashing(path: Path) -> foreign.FileContents:
    print("noise")
    os.kill(os.getpid(), 11)
    return [], ()


def hungry(path: Path) -> foreign.FileContents:
    return [(0, "b", np.ones((2**31, 3)), ())], ()  # 48 GiB


def flooding(path: Path) -> foreign.FileContents:
    while True:
        sys.stdout.write("x" * 2**16)


def lying(path: Path) -> foreign.FileContents:
    return [(0, "b", np.zeros((3, 3)), ((0, 1, 3),))], ()


def ill(path: Path) -> foreign.FileContents:
    raise ValueError("two\nlines \x1b[31m" + "x" * 5000)


@pytest.mark.parametrize(
    ("reader", "message"),
    [
        ("crashing", "a.bin: cannot be read: its reader crashed (SIGSEGV); it is damaged, or needs more than 4 GiB of memory"),
        ("hungry", "a.bin: cannot be read: it needs more than 4 GiB of memory"),
        ("flooding", "a.bin: cannot be read: "),
        ("lying", "a.bin: cannot be read: its reader answers nonsense: a face names a vertex that does not exist"),
        ("ill", "a.bin: cannot be read: two"),
        ("none", "a.bin: cannot be read: module"),
    ],
)
def test_whatever_a_child_does_ends_in_one_line(tmp_path: Path, reader: str, message: str, capfd: pytest.CaptureFixture[str]) -> None:
    limits = foreign.Limits(seconds=20.0, output=2**20)
    assert refused(capfd, "a.bin", foreign.read, f"test_foreign:{reader}", tmp_path / "a.bin", None, limits).startswith(message)


SOUND = [0, "b", [[0.0] * 3] * 4, [[0, 1, 2]], "", False, 0.0]  # a piece with one face


def forged(path: Path, text: str) -> None:
    """Write an answer as it is, and leave at once."""
    Path(foreign.ANSWER).write_text(text, encoding="utf-8")
    os._exit(0)


@pytest.mark.parametrize(
    ("answer", "why"),
    [
        ([[SOUND[:-1] + [0.0, 1]], [], []], "positional"),
        ([[[*SOUND[:2], [[0.0, 0.0]] * 4, *SOUND[3:]]], [], []], "coordinates"),
        ([[[*SOUND[:2], [[0.0, 0.0, "x"]] * 4, *SOUND[3:]]], [], []], "float"),
        ([[[*SOUND[:3], [[0, 1, -1]], *SOUND[4:]]], [], []], "vertex"),
        ([[[*SOUND[:3], [[0, 1, 0.9]], *SOUND[4:]]], [], []], "integer"),
        ([[[*SOUND[:3], 5, *SOUND[4:]]], [], []], "iterable"),
        ([[[math.inf, *SOUND[1:]]], [], []], "infinity"),
        ([[[0, None, *SOUND[2:]]], [], []], "not a string"),
        ([[SOUND], [None], []], "NoneType"),
        ([[SOUND], [], [1]], "encode"),
        ([[SOUND], []], "unpack"),
        ({"pieces": []}, "unpack"),
    ],
)
def test_answers_are_checked(tmp_path: Path, answer: object, why: str) -> None:
    with pytest.raises(InputError, match=rf"a\.bin: cannot be read: its reader answers nonsense: .*{why}"):
        foreign.read("test_foreign:forged", tmp_path / "a.bin", {"text": json.dumps(answer)})


def test_an_answer_that_is_no_json_is_refused(tmp_path: Path) -> None:
    sound = json.dumps([[SOUND], [1.0], ["a\nb"]])
    (((number, name, vertices, faces, *_),), figures, notes) = foreign.read("test_foreign:forged", tmp_path / "a.bin", {"text": sound})
    assert (number, name, vertices.shape, faces, figures, notes) == (0, "b", (4, 3), ((0, 1, 2),), [1.0], ["a b"])
    for text in (sound[:-1], "[" * 100_000, ""):
        with pytest.raises(InputError, match=r"a\.bin: cannot be read: its reader answers nonsense: "):
            foreign.read("test_foreign:forged", tmp_path / "a.bin", {"text": text})


def test_the_command_line_tells_one_line_and_exits_with_2(tmp_path: Path) -> None:
    (tmp_path / "wall.geo").write_text(HEAD + "Exit;\n")
    (tmp_path / "scene.toml").write_text(
        '[structure]\nkind = "solid"\npath = "wall.geo"\nunits = "m"\ncourse_height = 0.25\ntrusted = true\n'
        "[material]\ndensity = 2000.0\nfriction = 0.6\n[run]\ndt = 1e-3\nduration = 0.1\n"
    )
    command = [sys.executable, "-m", "masonry_cd", "build", str(tmp_path / "scene.toml"), "-o", str(tmp_path / "out"), "--trust"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("masonry-cd: error: ")
    assert done.stderr.count("\n") == 1
    assert "wall.geo" in done.stderr


def test_a_cad_model_gets_memory_by_its_size(tmp_path: Path) -> None:
    (tmp_path / "small.step").write_bytes(bytes(1000))
    (tmp_path / "large.step").write_bytes(bytes(10**8))
    assert foreign.of_model(tmp_path / "small.step").memory < 2e9 < foreign.of_model(tmp_path / "large.step").memory == foreign.MEMORY
