# SPDX-License-Identifier: GPL-3.0-or-later
"""Parts of the program that a run left out, as its scene does not need them, and why: ``run --explain``, ``explanation`` in summary.json.

Every line names what was spared, and what it rests on: a symmetry, a bound, a counter of the run, or what the scene does not ask for.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

from masonry_cd.app.run_report import RunReport
from masonry_cd.app.scene import Scene
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper
from masonry_cd.mechanics.model.joint_laws import LAWS
from reports.settings import OUTPUTS, Report

HEAVY = {
    "gmsh": "gmsh", "vtk": "vtkmodules", "pyvista": "pyvista", "matplotlib": "matplotlib", "pandas": "pandas", "trimesh": "trimesh",
    "meshio": "meshio", "scikit-fem": "skfem", "obspy": "obspy",
}  # fmt: skip
AXES = "xyz"
UNKNOWNS = ("three unknowns per block instead of six", "six unknowns per block instead of twelve", "meshes of triangles, not tetrahedra")


def left_out(scene: Scene, stepper: Stepper, report: RunReport) -> list[str]:
    """All that was left out of a run that has ended, one line each."""
    lines = [_plane(scene, stepper), *_pairs(stepper, report), _islands(scene, report), _solver(scene, report)]
    lines += _laws(stepper)
    return [*lines, *_outputs(scene.report), packages_not_loaded()]


def _plane(scene: Scene, stepper: Stepper) -> str:
    """The reduction to a plane, or why there is none."""
    if stepper.plane is not None:
        axis, at = AXES[stepper.plane.axis], stepper.plane.at
        unknowns = UNKNOWNS[(stepper.assembly.deformation is not None) + (stepper.system.facets is not None)]
        return (
            f"third dimension: the scene is its own mirror image about {axis} = {at:.4g} m and moves in that plane; half the contacts, "
            f"two rows per contact instead of three, {unknowns}"
        )
    if not scene.run.planar:
        return "third dimension: kept, since run.planar is false"
    return "third dimension: kept, since blocks or motion are not symmetric about one plane"


def _pairs(stepper: Stepper, report: RunReport) -> list[str]:
    """Pairs of blocks that were not looked at, and searches that were not repeated."""
    parts, done = len(stepper.assembly.shapes.part_block), report.left_out
    possible, listed = parts * (parts - 1) // 2, len(stepper.detector.pairs)
    kept, far = done["pairs_with_points_kept"], done["pairs_not_looked_at"]
    return [
        f"pairs of blocks: {possible - listed} of {possible} not listed, since their boxes are apart",
        f"broad phase: left out in {report.steps - done['broad_phases']} of {report.steps} steps, since no block had left its box",
        f"listed pairs: contact points kept {kept} times, since the pair had not moved; "
        f"not looked at {far} times, since it could not have met",
        f"iterations: none in {report.steps_as_before} of {report.steps} steps, in which the impulses of the last step were good enough",
        f"impacts apart from forces: not solved in {report.steps - report.steps_apart} of {report.steps} steps, in which no gap closed "
        "fast enough to matter",
    ]


def _islands(scene: Scene, report: RunReport) -> str:
    """Describe the islands that were solved separately, and those that were not solved at all."""
    if not scene.run.islands:
        return "islands: all blocks solved as one, since run.islands is false"
    found = f"islands, which touch one another only through supports: {report.islands_mean:.3g} on average, {report.islands_max} at most"
    return f"{found}; each was solved by itself, and {report.sleeping_mean:.0%} of the blocks slept, since they were at rest"


def _solver(scene: Scene, report: RunReport) -> str:
    """Which methods were used how often, by the solver's own words."""
    by_count = sorted(report.solver_reasons.items(), key=lambda item: -item[1])
    words = ", ".join(f'"{reason}" in {count}' for reason, count in by_count[:4]) + (" and others" if len(by_count) > 4 else "")
    if scene.run.solver == "auto":
        return f"solvers: auto takes what was cheapest in the steps before, others where that falls short: {words} of {report.steps} steps"
    return f"solvers: all but {scene.run.solver}, which the scene asks for: {words} of {report.steps} steps"


def _laws(stepper: Stepper) -> list[str]:
    """Parts of the contact law that no joint needs."""
    lines = [law.absent for law in LAWS if law.absent and not law.holds(stepper.assembly.laws)]
    rigid = stepper.assembly.deformation is None
    return [*lines, "strains of blocks: none, blocks are rigid (no deformable in [material])"] if rigid else lines


def _outputs(asked: Report) -> list[str]:
    """Reports that the scene does not ask for."""
    missing = [name for name, output in OUTPUTS.items() if output.asked is None and not getattr(asked, name, False)]
    return [f"reports: {', '.join(missing)} not made, since [report] does not ask for them"] if missing else []


def packages_not_loaded(loaded: Mapping[str, object] | None = None) -> str:
    """The line on heavy packages that a run did not load; ``loaded`` are the modules by name, left out: those of this process."""
    found = sys.modules if loaded is None else loaded
    return f"packages not loaded: {', '.join(name for name, module in HEAVY.items() if module not in found) or 'none'}"
