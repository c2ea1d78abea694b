# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic modes against closed forms, beams, bars and chains; measured modes, the MAC and the pairing with computed ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from beams import CLAMPED, FREE, HINGED, Beam, chain
from models import box, tower
from scipy.optimize import brentq

from masonry_cd.analysis.modal.measured_modes import fit_factor, mac, pair, read_measured
from masonry_cd.analysis.modal.modes import Modes, modal
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Block

YOUNG, DENSITY = 2e9, 2000.0


def wall(height: float, thickness: float, width: float, courses: int) -> list[Block]:
    """A cantilever wall in running bond, two stretchers or a stretcher and two halves per course, on the ground."""
    blocks = [box("ground", (-5.0, -5.0, -1.0), (5.0, 5.0, 0.0), fixed=True)]
    for course in range(courses):
        edges = np.array([0.0, 0.5, 1.0] if course % 2 else [0.0, 0.25, 0.75, 1.0]) * width - width / 2
        z = height * np.arange(courses + 1) / courses
        for k in range(len(edges) - 1):
            low, high = (edges[k], -thickness / 2, z[course]), (edges[k + 1], thickness / 2, z[course + 1])
            blocks.append(box(f"c{course}.{k}", low, high))
    return blocks


def beam(length: float, depth: float, width: float, pieces: int) -> list[Block]:
    """A beam along x between two end blocks."""
    x = length * np.arange(pieces + 1) / pieces
    blocks = [box(f"b{k}", (x[k], -width / 2, -depth / 2), (x[k + 1], width / 2, depth / 2)) for k in range(pieces)]
    ends = ((-1.0, 0.0), (length, length + 1.0))
    return blocks + [box(f"end{k}", (a, -width, -depth), (b, width, depth), fixed=True) for k, (a, b) in enumerate(ends)]


def along(modes: Modes, axis: int) -> np.ndarray:
    """Frequencies of the modes that move the centroids mostly along one axis; torsion leaves them where they are."""
    motion = np.abs(modes.shapes).max(axis=1)
    return modes.frequencies[(np.argmax(motion, axis=1) == axis) & (motion.max(axis=1) > 1e-6)]


def bending(modes: Modes, axis: int) -> np.ndarray:
    """Frequencies of the modes of a cantilever that the base can excite along one axis: torsion has no such share."""
    return modes.frequencies[modes.participation[:, axis] > 5e-3]


def test_cantilever_wall_out_of_plane() -> None:
    modes = modal(wall(5.0, 0.5, 0.8, 10), YOUNG, 0.2, modes=12)
    exact = Beam(5.0, 0.5, 0.8, YOUNG, 0.2, DENSITY).frequencies(CLAMPED, FREE, 3)
    error = bending(modes, 1)[:3] / exact - 1.0
    print("\ncantilever wall, out of plane [Hz]:", bending(modes, 1)[:3].round(3), "Timoshenko", np.round(exact, 3), "error %", 100 * error)
    assert np.abs(error).max() < 0.01
    in_plane = Beam(5.0, 0.8, 0.5, YOUNG, 0.2, DENSITY).frequencies(CLAMPED, FREE, 2)
    assert bending(modes, 0)[:2] == pytest.approx(in_plane, rel=0.01)


def test_simply_supported_beam() -> None:
    blocks = beam(6.0, 0.6, 0.4, 6)
    modes = modal(blocks, YOUNG, 0.2, modes=8, restraint={"base": "yz"})
    exact = Beam(6.0, 0.6, 0.4, YOUNG, 0.2, DENSITY).frequencies(HINGED, HINGED, 3)
    error = along(modes, 2)[:3] / exact - 1.0
    print("\nsimply supported beam [Hz]:", along(modes, 2)[:3].round(3), "Timoshenko", np.round(exact, 3), "error %", 100 * error)
    assert np.abs(error).max() < 0.01
    assert modes.facts["rigid_motions"] == 1  # it may slide along x


def test_transfer_matrix_agrees_with_euler_bernoulli_for_slender_beams() -> None:
    slender = Beam(10.0, 0.01, 0.01, YOUNG, 0.2, DENSITY)
    assert slender.frequencies(HINGED, HINGED, 3) == pytest.approx([slender.euler(k) for k in (1, 2, 3)], rel=1e-4)
    roots = np.array([1.87510407, 4.69409113, 7.85475744]) / np.pi  # of cos x cosh x = -1
    assert slender.frequencies(CLAMPED, FREE, 3) == pytest.approx(slender.euler(1) * roots**2, rel=1e-4)


def test_mesh_convergence_and_order() -> None:
    blocks = wall(5.0, 0.5, 0.8, 10)
    exact = Beam(5.0, 0.5, 0.8, YOUNG, 0.2, DENSITY).frequencies(CLAMPED, FREE, 3)
    print("\n  size [m]  order  unknowns   error of the first three out-of-plane frequencies [%]")
    errors = {}
    for size, order in ((1.0, 2), (0.5, 2), (0.25, 2), (0.5, 1), (0.25, 1)):
        modes = modal(blocks, YOUNG, 0.2, modes=9, size=size, order=order)
        errors[size, order] = bending(modes, 1)[:3] / exact - 1.0
        print(f"  {size:8.2f}  {order:5d}  {modes.facts['unknowns']:8d}  ", (100 * errors[size, order]).round(2))
    assert (errors[1.0, 2] > errors[0.5, 2]).all()  # from above: too stiff, as displacement methods are
    assert (errors[0.5, 2] > errors[0.25, 2]).all()
    assert np.abs(errors[0.25, 2]).max() < 0.01
    assert errors[0.25, 1][0] > 0.08  # linear tetrahedra on the mesh on which quadratic ones are within 1 %


def test_bar_of_two_stones_is_bonded() -> None:
    """Axial vibration of a bar whose lower half is four times stiffer and denser: tan(a) tan(b) = Z1 / Z2."""
    length, young, density = 3.0, (8e9, 2e9), (2600.0, 1800.0)
    blocks = [box("ground", (-1.0, -1.0, -1.0), (1.0, 1.0, 0.0), fixed=True)]
    for half, name in enumerate(("lower", "upper")):
        corners = box(name, (-0.2, -0.2, half * length), (0.2, 0.2, (half + 1) * length))
        blocks.append(Block(name, corners.vertices, corners.faces, density[half], name))
    modes = modal(blocks, {"lower": young[0], "upper": young[1]}, 0.0, modes=8)
    speed = np.sqrt(np.array(young) / density)
    impedance = np.sqrt(np.array(young) * density)

    def condition(f: float) -> float:
        a, b = 2 * np.pi * f * length / speed
        return float(impedance[0] * np.cos(a) * np.cos(b) - impedance[1] * np.sin(a) * np.sin(b))

    exact = brentq(condition, 1.0, 0.2 * speed.min() / length)
    assert along(modes, 2)[0] == pytest.approx(exact, rel=1e-3)
    assert modes.facts["mass_kg"] == pytest.approx(0.16 * length * sum(density), rel=1e-9)


@pytest.mark.parametrize("half_base", [False, True])
def test_rigid_blocks_make_a_chain(half_base: bool) -> None:
    """Along the tower n masses on n springs, about its axis n inertias on n torsion springs."""
    n, side, height = 12, 0.5, 0.25
    area, mass = side**2, DENSITY * side**2 * height
    normal = YOUNG / height
    tangential = normal / 2.4
    blocks = tower(n, side, height, DENSITY)
    modes = modal(blocks, YOUNG, 0.2, method="joints", modes=6 * n, stiffness=None if half_base else (normal, tangential))
    axial = along(modes, 2)
    assert len(axial) == n
    assert axial == pytest.approx(chain(n, normal * area, mass, half_base), rel=1e-6)
    polar, inertia = area * side**2 / 6, mass * side**2 / 6
    torsion = chain(n, tangential * polar, inertia, half_base)
    for f in torsion:
        assert np.abs(modes.frequencies / f - 1.0).min() < 1e-6


def test_one_block_sways_and_rocks() -> None:
    """Two unknowns: sway x and rocking r about the centroid, coupled by the height of the joint below it."""
    b, d, h = 0.6, 0.4, 1.0
    blocks = [box("ground", (-1, -1, -1), (1, 1, 0), fixed=True), box("b", (-b / 2, -d / 2, 0.0), (b / 2, d / 2, h))]
    normal, tangential = 3e9, 1e9
    mass, area = DENSITY * b * d * h, b * d
    found = modal(blocks, YOUNG, method="joints", modes=6, stiffness=(normal, tangential))
    expected = [np.sqrt(normal * area / mass), np.sqrt(tangential * area * (b**2 + d**2) / 12 / (mass * (b**2 + d**2) / 12))]
    for width in (b, d):
        sway = tangential * area * np.array([[1.0, -h / 2], [-h / 2, h**2 / 4]])
        sway[1, 1] += normal * area * width**2 / 12
        root_mass = np.sqrt([mass, mass * (width**2 + h**2) / 12])
        expected += list(np.sqrt(np.linalg.eigvalsh(sway / np.outer(root_mass, root_mass))))
    assert found.frequencies == pytest.approx(np.sort(expected) / (2 * np.pi), rel=1e-9)


def test_all_modes_carry_all_mass_and_are_the_same_when_the_world_turns() -> None:
    blocks = wall(2.0, 0.3, 0.8, 5)
    modes = modal(blocks, YOUNG, 0.2, method="joints", modes=10_000)
    assert modes.participation.sum(axis=0) == pytest.approx(np.ones(3), abs=1e-9)
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) + np.sin(0.7) * cross + (1 - np.cos(0.7)) * cross @ cross
    turned = [Block(b.name, b.vertices @ turn.T, b.faces, b.density, b.group, b.fixed) for b in blocks]
    again = modal(turned, YOUNG, 0.2, method="joints", modes=20)
    assert again.frequencies == pytest.approx(modes.frequencies[:20], rel=1e-6)


def test_both_models_agree_and_scale_with_the_root_of_the_modulus() -> None:
    blocks = wall(5.0, 0.5, 0.8, 10)
    soft, stiff = (modal(blocks, young, 0.2, method="joints", modes=3) for young in (YOUNG, 4 * YOUNG))
    assert stiff.frequencies == pytest.approx(2 * soft.frequencies, rel=1e-9)
    assert soft.scaled(4.0).frequencies == pytest.approx(stiff.frequencies, rel=1e-9)
    assert soft.scaled(4.0).facts["normal_stiffness_pa_m"] == pytest.approx(stiff.facts["normal_stiffness_pa_m"])
    by_group = modal(blocks, {"default": YOUNG}, 0.2, method="joints", modes=3)
    assert by_group.frequencies == pytest.approx(soft.frequencies, rel=1e-12)
    solid = modal(blocks, YOUNG, 0.2, modes=3)
    assert soft.frequencies == pytest.approx(solid.frequencies, rel=0.05)


@pytest.mark.parametrize("method", ["continuum", "joints"])
def test_two_runs_agree_to_the_bit(method: str) -> None:
    first, second = (modal(tower(40), YOUNG, method=method, modes=4) for _ in range(2))
    assert np.array_equal(first.frequencies, second.frequencies)
    assert np.array_equal(first.shapes, second.shapes)


@pytest.mark.parametrize("method", ["continuum", "joints"])
def test_a_structure_without_supports_floats(method: str) -> None:
    blocks = [block for block in tower(8, 0.5, 0.5) if not block.fixed]
    modes = modal(blocks, YOUNG, 0.0, method=method, modes=6)
    assert modes.facts["rigid_motions"] == 6
    first = Beam(4.0, 0.5, 0.5, YOUNG, 0.0, DENSITY).frequencies(FREE, FREE, 1)[0]
    assert modes.frequencies[0] == pytest.approx(first, rel=0.01 if method == "continuum" else 0.06)
    assert modes.participation.max() < 1e-6  # what vibrates freely keeps its momentum


@pytest.mark.parametrize("method", ["continuum", "joints"])
def test_shapes_are_scaled_to_one_and_stand_still_at_the_base(method: str) -> None:
    modes = modal(tower(8, 0.5, 0.5), YOUNG, method=method, modes=3)
    skin = modes.field.skin()
    assert np.linalg.norm(skin.shapes, axis=2).max(axis=1) == pytest.approx(np.ones(3), rel=1e-9)
    top, outside = modes.field.at(np.array([[0.0, 0.0, 4.0], [0.0, 0.0, 9.0]]))
    assert np.abs(top[0, 0]).max() > 0.6  # bending along x or y; two equal directions may mix
    assert outside == pytest.approx([0.0, 5.0], abs=1e-9)
    base = modes.field.at(np.array([[0.1, 0.1, 0.0]]))[0]
    assert np.abs(base[0]).max() < (1e-9 if method == "continuum" else 0.05)


@pytest.mark.parametrize("method", ["continuum", "joints"])
def test_a_block_in_the_air_is_named(method: str) -> None:
    blocks = [*tower(2), box("cloud", (3.0, 3.0, 3.0), (4.0, 4.0, 4.0))]
    with pytest.raises(InputError, match=r'block "cloud" is (bonded|tied) to no support'):
        modal(blocks, YOUNG, method=method)


SHAPED = """\
# ambient vibration test
mode,frequency_hz,point,x_mm,y_mm,z_mm,ux,uz
1,4.0,top,0,0,2000,1.0,0.1
1,,middle,0,0,1000,0.4,
2, 9.5 ,top,0,0,2000,,1.0
"""


@pytest.fixture(scope="module")
def modes() -> Modes:
    """Eight blocks on a rectangular footprint, so that no two frequencies coincide."""
    blocks: list[Block] = [tower(1)[0]]
    blocks += [box(f"b{k}", (-0.3, -0.2, k * 0.25), (0.3, 0.2, (k + 1) * 0.25)) for k in range(8)]
    return modal(blocks, 2e9, method="joints", modes=6)


def written(folder: Path, text: str) -> Path:
    path = folder / "measured.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_shapes_units_and_gaps_are_read(tmp_path: Path) -> None:
    first, second = read_measured(written(tmp_path, SHAPED))
    assert (first.mode, first.frequency, second.mode, second.frequency) == (1, 4.0, 2, 9.5)
    assert first.points == pytest.approx(np.array([[0.0, 0.0, 2.0], [0.0, 0.0, 1.0]]))
    assert np.array_equal(np.isnan(first.shape), [[False, True, False], [False, True, True]])
    assert second.has_shape and second.shape[0, 2] == 1.0


def test_periods_and_bare_frequencies(tmp_path: Path) -> None:
    modes = read_measured(written(tmp_path, "mode,period_s\n2,0.1\n1,0.25\n"))
    assert [(m.mode, m.frequency) for m in modes] == [(1, 4.0), (2, pytest.approx(10.0))]
    assert not modes[0].has_shape


def test_mac_is_blind_to_sign_and_scale_and_to_what_was_not_measured() -> None:
    a = np.array([1.0, 2.0, -1.0, 0.5])
    assert mac(a, -3.0 * a) == pytest.approx(1.0)
    assert mac(np.array([1.0, 0.0]), np.array([0.0, 2.0])) == 0.0
    assert mac(np.array([1.0, 1.0]), np.array([1.0, 0.0])) == pytest.approx(0.5)
    assert mac(np.array([1.0, np.nan]), np.array([7.0, 5.0])) == pytest.approx(1.0)


def test_measured_modes_find_the_computed_ones_that_they_resemble(modes: Modes, tmp_path: Path) -> None:
    """The computed modes, written in another order and with a few per cent of noise."""
    noise = np.random.default_rng(0)
    moving = np.flatnonzero(np.abs(modes.shapes).max(axis=(1, 2)) > 0.1)  # torsion does not move the centroids
    order = moving[[2, 0, 1]].tolist()
    lines = ["mode,frequency_hz,x_m,y_m,z_m,ux,uy,uz"]
    for number, k in enumerate(order, start=1):
        for point, shape in zip(modes.points, modes.shapes[k], strict=True):
            moved = -2.0 * shape + 0.03 * noise.standard_normal(3)
            lines.append(",".join(map(str, [number, 1.1 * modes.frequencies[k], *point, *moved])))
    pairs = pair(modes, read_measured(written(tmp_path, "\n".join(lines))))
    assert [p.mode for p in pairs] == [k + 1 for k in order]
    assert min(p.mac for p in pairs) > 0.99
    assert [p.error_percent for p in pairs] == pytest.approx([100 * (1 / 1.1 - 1)] * 3)


def test_fit_meets_the_first_measured_frequency(modes: Modes, tmp_path: Path) -> None:
    measured = read_measured(written(tmp_path, f"mode,frequency_hz\n1,{1.3 * modes.frequencies[0]}\n"))
    factor = fit_factor(modes, measured)
    assert factor == pytest.approx(1.69)
    assert pair(modes.scaled(factor), measured)[0].error_percent == pytest.approx(0.0, abs=1e-9)


def test_more_modes_measured_than_computed(modes: Modes, tmp_path: Path) -> None:
    pairs = pair(modes, read_measured(written(tmp_path, "mode,frequency_hz\n1,4\n50,900\n")))
    assert pairs[0].mode == 1
    assert pairs[1].mode is None


def test_a_point_far_from_the_structure_is_an_error(modes: Modes, tmp_path: Path) -> None:
    text = "mode,frequency_hz,x_m,y_m,z_m,ux\n1,4.0,0,0,2000,1.0\n"
    with pytest.raises(InputError, match=r"measured.csv:2: the point \(0, 0, 2000\) m lies 2e\+03 m outside the structure"):
        pair(modes, read_measured(written(tmp_path, text)))


def test_components_of_any_size_resemble_alike() -> None:
    shape = np.array([[1.0, np.nan, 0.5], [0.2, 0.1, -0.3]])
    for size in (1e308, 1e-300, -1e200):
        assert mac(size * shape, shape) == pytest.approx(1.0)
    assert mac(0.0 * shape, shape) == 0.0
