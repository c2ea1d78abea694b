# SPDX-License-Identifier: GPL-3.0-or-later
"""A meshed block as a beam: own frequencies, by the masses and stiffness of the step, against Timoshenko's closed forms; its stress.

Uniform-strain triangles are too stiff in bending where few lie across the beam, and converge at second order all the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from models import box, stepper
from scipy import linalg, optimize

from masonry_cd.mechanics.dynamics.element_stress import ElementStress
from masonry_cd.mechanics.dynamics.system import System
from masonry_cd.mechanics.model.elastic_blocks import ElasticBlocks

LENGTH, DEPTH, WIDTH, YOUNG, DENSITY = 2.0, 0.25, 0.1, 1e9, 2000.0
SHEAR = 5.0 / 6.0  # share of the section that shears, without Poisson's ratio
SIZES = (0.125, 0.0625, 0.047)
Held = Callable[[np.ndarray], list[tuple[int, int]]]


def beam(size: float, length: float = LENGTH) -> System:
    """A block along x, that touches nothing, in its plane."""
    blocks = [
        box("base", (-1.0, -1.0, -3.0), (2.0, 1.0, -2.0), fixed=True),
        box("beam", (-length / 2, -WIDTH / 2, -DEPTH / 2), (length / 2, WIDTH / 2, DEPTH / 2), density=DENSITY),
    ]
    keys = {"deformable": "tetrahedra", "young": YOUNG, "poisson": 0.0, "mesh_size": size}
    return stepper(blocks, 1, material=ElasticBlocks.model_validate(keys), planar=True).system


def moved_nodes(system: System) -> np.ndarray:
    """Displacements of the nodes in the plane (N, 2, n) by each unknown of the block."""
    strains = system.strains
    assert strains is not None
    assert strains.warps is not None
    nodes, shapes = strains.warps.meshes[0].nodes, strains.warps.shapes(1)
    still, unit = np.zeros(len(nodes)), np.ones(len(nodes))
    rigid = [np.stack(field, axis=1) for field in ((unit, still), (still, unit), (nodes[:, 2], -nodes[:, 0]))]
    strained = []
    for column in strains.arrays.columns:
        one = np.zeros((2, 6))
        one[1, column] = 1.0
        strained.append((nodes @ strains.deformation.gradients(one)[1].T)[:, [0, 2]])
    return np.concatenate([np.stack([*rigid, *strained], axis=2), shapes[:, [0, 2]]], axis=2)


def frequencies(size: float, held: Held) -> tuple[np.ndarray, int]:
    """The first three [Hz], where some nodes are held along some coordinates of the plane; and the number of nodes."""
    system = beam(size)
    strains = system.strains
    assert strains is not None
    moved = moved_nodes(system)
    nodes = strains.warps.meshes[0].nodes if strains.warps else np.zeros((0, 3))
    used = np.abs(moved).max(axis=(0, 1)) > 0.0  # the others fill the room of a block
    rigid = [system.assembly.mass[1], system.assembly.mass[1], system.assembly.inertia[1, 1, 1]]
    mass, stiffness = np.concatenate([rigid, strains.mass[0]])[used], np.zeros((len(used), len(used)))
    stiffness[3:, 3:] = strains.stiffness[0]
    free = linalg.null_space(np.array([moved[node, k, used] for node, k in held(nodes)]))
    squares = linalg.eigh(free.T @ stiffness[np.ix_(used, used)] @ free, free.T @ (mass[:, None] * free), eigvals_only=True)
    found = np.sqrt(squares.clip(0.0)) / (2.0 * math.pi)
    return found[found > 1e-3][:3], len(nodes)


def clamped(nodes: np.ndarray) -> list[tuple[int, int]]:
    """One end held."""
    return [(node, k) for node in np.flatnonzero(nodes[:, 0] < -LENGTH / 2 + 1e-9) for k in (0, 1)]


def on_supports(nodes: np.ndarray) -> list[tuple[int, int]]:
    """Both ends held upright, free to turn and to move along."""
    return [(node, 1) for node in np.flatnonzero(np.abs(nodes[:, 0]) > LENGTH / 2 - 1e-9)]


def bent(size: float, fibre: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A short beam held at one end, with a couple of the stress ``fibre`` = M / W at the other: stress along it in each element, the place
    of its centre (E, 3), its share of the volume."""
    length = 2.0 * DEPTH
    system = beam(size, length)
    strains, moved = system.strains, moved_nodes(system)
    assert strains is not None
    assert strains.warps is not None
    mesh = strains.warps.meshes[0]
    nodes, used = mesh.nodes, np.abs(moved).max(axis=(0, 1)) > 0.0
    end = np.flatnonzero(nodes[:, 0] > length / 2 - 1e-9)
    end = end[np.argsort(nodes[end, 2])]
    force = np.zeros((len(nodes), 2))
    for a, b in pairwise(end):
        low, high = 2.0 * fibre / DEPTH * WIDTH * nodes[[a, b], 2]
        force[[a, b], 0] += (nodes[b, 2] - nodes[a, 2]) / 6.0 * np.array([2.0 * low + high, low + 2.0 * high])
    held = np.flatnonzero(nodes[:, 0] < -length / 2 + 1e-9)
    rows = [(node, 0) for node in held] + [(held[np.argmin(np.abs(nodes[held, 2]))], 1)]
    free = linalg.null_space(np.array([moved[node, k, used] for node, k in rows]))
    stiffness = np.zeros((len(used), len(used)))
    stiffness[3:, 3:] = strains.stiffness[0]
    load = np.einsum("nk,nku->u", force, moved)[used]
    found = np.zeros(len(used))
    found[used] = free @ np.linalg.solve(free.T @ stiffness[np.ix_(used, used)] @ free, free.T @ load)
    stress = ElementStress(strains)
    stress.take_step(strains, found[None, 3:], np.tile(np.eye(3), (2, 1, 1)))
    return stress.sums[:, 0] / strains.step, nodes[mesh.elements].mean(axis=1), mesh.shares()


def test_the_stress_at_the_edge_of_a_bent_beam_tends_to_that_of_its_moment() -> None:
    """M / W: the largest stress of an element at first order, since its centre is a third of it inside; the slope of the stress over the
    depth at second."""
    fibre, largest, slope = 1e6, [], []
    for size in (0.5 * DEPTH, 0.25 * DEPTH, 0.125 * DEPTH):
        along, centre, share = bent(size, fibre)
        largest.append(np.max(along[np.abs(centre[:, 0]) < 0.6 * DEPTH]) / fibre - 1.0)
        slope.append(0.5 * DEPTH * (share * along * centre[:, 2]).sum() / (share * centre[:, 2] ** 2).sum() / fibre - 1.0)
    assert largest == pytest.approx([-0.31, -0.087, -0.025], abs=0.02)
    assert slope == pytest.approx([-0.18, -0.064, -0.018], abs=0.01)
    assert slope[1] / slope[2] > 3.0


def closed_form(cantilever: bool) -> np.ndarray:
    """The first three frequencies [Hz] of Timoshenko's beam (Huang, J. Appl. Mech. 28, 1961) and of its waves along."""
    area, inertia = WIDTH * DEPTH, WIDTH * DEPTH**3 / 12.0
    turn = inertia / (area * LENGTH**2)
    shear = YOUNG * inertia / (SHEAR * area * 0.5 * YOUNG * LENGTH**2)

    def equation(omega: float) -> float:
        b = math.sqrt(DENSITY * area * LENGTH**4 * omega**2 / (YOUNG * inertia))
        root = math.sqrt((turn - shear) ** 2 + 4.0 / b**2)
        alpha, beta = math.sqrt(0.5 * (root - turn - shear)), math.sqrt(0.5 * (root + turn + shear))
        if not cantilever:
            return math.sin(b * beta)
        both = math.sinh(b * alpha) * math.sin(b * beta) * b * (turn + shear) / math.sqrt(1.0 - b**2 * turn * shear)
        return 2.0 + (b**2 * (turn - shear) ** 2 + 2.0) * math.cosh(b * alpha) * math.cos(b * beta) - both

    grid = np.arange(1.0, 1300.0)
    values = [equation(omega) for omega in grid]
    bending = [
        optimize.brentq(equation, low, low + 1.0) / (2.0 * math.pi)
        for low, one, two in zip(grid, values, values[1:], strict=False)
        if one * two < 0.0
    ]
    along = math.sqrt(YOUNG / DENSITY) / (4.0 if cantilever else 2.0) / LENGTH
    return np.sort([*bending, along])[:3]


@pytest.mark.validation
@pytest.mark.parametrize(("held", "cantilever"), [(clamped, True), (on_supports, False)], ids=["cantilever", "simply-supported"])
def test_three_frequencies_converge_at_second_order(held: Held, cantilever: bool) -> None:
    """Errors fall as the number of nodes grows, h^2 of a plane mesh being one over that; the last mesh is within 3.2 %."""
    exact, off, nodes, lines = closed_form(cantilever), [], [], []
    for size in SIZES:
        found, count = frequencies(size, held)
        off.append(found / exact - 1.0)
        nodes.append(count)
        lines.append(f"{size:6.4f} m {count:4d} nodes: {found.round(2)} Hz, off by {(100.0 * off[-1]).round(2)} %")
    print("\n".join(["", f"closed form {exact.round(2)} Hz", *lines]))
    assert (np.array(off) > 0.0).all()  # stiffer than the solid
    assert np.abs(off[-1]).max() < 0.032
    order = 2.0 * np.log(off[0] / off[-1]) / np.log(nodes[-1] / nodes[0])
    assert (order > 1.8).all()
