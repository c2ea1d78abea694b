"""The rigid block as the limit of blocks that deform, of one strain each and meshed, as they become stiff."""

from __future__ import annotations

import math

import numpy as np
import pytest
from models import stepper, tower

from masonry_cd.model.elastic_blocks import ElasticBlocks

STEPS, TOLERANCE = 300, 1e-10
STIFFER = (1e10, 1e11, 1e12, 1e15)  # Young's modulus [Pa]


def end(material: ElasticBlocks | None) -> np.ndarray:
    """By how much the blocks of a tower have moved after a pulse of its base, (B, 3) [m]."""
    shaken = np.zeros((STEPS + 1, 1, 3))
    shaken[:, 0, 0] = 0.15 * np.array([math.sin(2.0 * math.pi * k / 200.0) if k < 200 else 0.0 for k in range(STEPS + 1)])
    machine = stepper(
        tower(3, side=0.5, height=0.25), STEPS, support_velocity=shaken, material=material, solver="auto", tolerance=TOLERANCE
    )
    for _ in range(STEPS):
        assert machine.step().error <= TOLERANCE
    return machine.state.position[1:] - machine.assembly.centre[1:]


@pytest.mark.parametrize("kind", [{"deformable": "uniform"}, {"deformable": "tetrahedra", "mesh_size": 10.0}], ids=["uniform", "meshed"])
def test_stiff_blocks_tend_to_rigid_ones_at_first_order(kind: dict[str, object]) -> None:
    """What differs from rigid blocks falls as 1 / E, down to 1e15 Pa."""
    rigid = end(None)
    off = [np.abs(end(ElasticBlocks.model_validate(kind | {"young": young})) - rigid).max() for young in STIFFER]
    assert off[1] < 0.15 * off[0]
    assert off[2] < 0.15 * off[1]
    assert off[3] < 1e-9
