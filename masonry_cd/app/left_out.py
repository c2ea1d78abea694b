# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether a run leaves the elasticity of its masonry out, and what that comes to."""

from __future__ import annotations

from typing import TYPE_CHECKING

from masonry_cd.io.summary import Summary

if TYPE_CHECKING:
    from masonry_cd.app.case import Case

FEW = 5  # free blocks that are a study of mechanics rather than a building


def elasticity_left_out(case: Case) -> Summary:
    """The elastic period that rigid joints leave out, for the summary; nothing where something is elastic, or nothing shakes."""
    assembly, material = case.assembly, case.scene.material
    rigid = assembly.deformation is None and not assembly.laws.elastic.any() and not assembly.shapes.rounding.any()
    if not rigid or (~assembly.fixed).sum() <= FEW or not case.joints.count or not _shaken(case):
        return Summary()
    from masonry_cd.analysis.modal.elastic_period import elastic_period

    named = material.masonry
    moduli = None if named is None else named.model_copy(update={"stiffness": "mean"}).moduli
    velocity = case.loading.support_velocity
    moved = velocity[: case.scene.run.steps + 1].mean(axis=1)
    return elastic_period(assembly, case.joints, moved, case.scene.run.dt, moduli)


def _shaken(case: Case) -> bool:
    """Whether a load shakes the base; a settlement moves it once."""
    from loads import shakes

    return bool(case.loading.support_velocity.any()) and shakes(case.scene.loads)
