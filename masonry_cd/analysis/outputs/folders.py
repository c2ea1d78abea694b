# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that each command may leave in its folder, with what they hold; those of a run are in :mod:`reports.files`.

Commands refuse a folder that holds one of theirs, and take away what a former call wrote; docs/outputs.md lists them.
"""

from __future__ import annotations

BLOCKS = ("json", "obj", "stl", "vtu", "vtm", "vtkhdf", "step", "brep", "msh")
FOLDERS: dict[str, dict[str, str]] = {
    "build": {
        **{f"blocks.{name}": f"the blocks, with --format {name}" for name in BLOCKS},
        "structure.png": "the blocks by group, with ties",
        "problem.png": "blocks with errors, and their place",
        "fill.json": "the fill of a bridge, for formats of blocks that cannot store it",
        "plan.json": "the plan of a building, to correct and read back",
        "plan.svg": "that plan and the elevations of its walls, with any errors in red",
        "plan_left.csv": "parts of a drawing that were not understood",
        "plan_junctions.csv": "junctions and free ends of walls, with the widths found",
    },
    "export": {
        "DATBOX/BODIES.DAT": "the blocks for LMGC90, with --format lmgc90",
        "DATBOX/BULK_BEHAV.DAT": "gravity and densities",
        "DATBOX/TACT_BEHAV.DAT": "friction by pair of groups",
        "DATBOX/DRV_DOF.DAT": "supports",
        "DATBOX/v*.dat": "how they move",
        "DATBOX/DOF.INI": "the state at the beginning",
        "DATBOX/Vloc_Rloc.INI": "contacts at the beginning: none",
        "command.py": "runs that deck by pylmgc90",
        "deck.3ddat": "the scene for 3DEC 7, with --format 3dec",
    },
    "limit": {
        "limit.json": "verdict, factors, mechanisms, check and certificate",
        "mechanisms.csv": "every mechanism of the whole and of its parts with its check, the governing one first",
        "parts.kept": "finished parts of an analysis that was stopped, for --resume",
        "blocks.csv": "the velocity of every block in the mechanism",
        "joints.csv": "every joint: its motion, and its force at collapse",
        "ties.csv": "tension of every tie at collapse",
        "check.json": "the code check",
        "check.csv": "the code check step by step, with its clauses",
        "spectrum.png": "the spectra of the code check, with demand and capacity",
        "mechanism.png": "the mechanism with hinges and slips",
        "thrust.png": "the line of thrust at collapse",
        "limit.html": "the page with all of it",
        "capacity.csv": "the load factor as the mechanism proceeds",
        "capacity.json": "that curve with its bilinear idealisation",
        "capacity.png": "that curve, and the structure at its points",
        "crossing.csv": "the factor of a vehicle over its position",
        "crossing.png": "that envelope",
    },
    "select": {
        "selected.toml": "the table [records] of a study: the set with its factors",
        "selection.csv": "every record of the set: its factor, its misfit, its entry in the catalogue",
        "selection.json": "the set in numbers: mean and scatter against the target, EN 1998-1, spectra, excluded records with reasons",
        "selection.png": "the spectra of the set, and the target",
    },
    "strengthen": {
        "strengthen.json": "target, ties, prices, and every part before and after",
        "ties.csv": "the ties with their forces, bars and prices",
        "parts.csv": "every part and push: its governing mechanism before, with the computed forces, and with bars",
        "before.png": "the governing mechanism before",
        "after.png": "the governing mechanism with the ties",
        "strengthened.toml": "the scene with its ties",
        "strengthen.html": "the page with all of it",
    },
    "modal": {
        "modal.json": "frequencies, masses and the comparison with measured modes",
        "modal.csv": "every mode: frequency, participating masses",
        "shapes_continuum.csv": "modes of the bonded continuum, at the blocks' centres",
        "shapes_joints.csv": "modes of rigid blocks on elastic joints",
        "ambient.csv": "modes identified from an ambient record, in the format of --reference",
        "stabilisation.png": "the poles of that identification, over the order of the model",
        "modes_continuum.png": "those modes drawn",
        "modes_joints.png": "those modes drawn",
        "mesh_convergence.csv": "frequencies over the size of the elements",
    },
    "assess": {
        "assess.csv": "every run: the varied assumptions and the answers",
        "assess.json": "the effect of each assumption",
        "assess.png": "the tornado",
        "assess_global.png": "Sobol indices, with --global",
        "assess.html": "the page with all of it",
    },
    "study": {
        "runs.csv": "every run: its settings, its numbers, how it ended",
        "runs.parquet": "that table with its types",
        "fragility.csv": "every fit with its bands",
        "fragility.json": "the fits with the components of their scatter",
        "fragility.xml": "the fits for OpenQuake",
        "vulnerability.xml": "loss ratios over the intensity, for OpenQuake",
        "sensitivity.csv": "rank correlation of the varied keys with the damage",
        "joint_probabilities.csv": "every joint: how often it opened, slid and was lost",
        "limits.csv": "with asks = limit: every scene with its factors",
        "summary.json": "the study in numbers, starting with the verdict",
        "study.html": "the page with all of it",
        "fragility.png": "fragility curves with their bands",
        "ida.png": "the curves of the records with their quantiles",
        "cloud.png": "every run, and the regression",
        "stripes.png": "the runs of each level",
        "spread.png": "the distribution of the results",
        "tornado.png": "what matters",
        "median_opening.png": "the median opening of every joint",
    },
    "calibrate": {
        "posterior.parquet": "samples of the unknowns with their weights, for from in [vary] of a study",
        "samples.csv": "every sample: its round, weight, unknowns and predictions",
        "calibrate.json": "verdict, ranges, correlations, predictions, and the most useful further observations",
        "calibrate.png": "unknowns before and after, and observations compared with predictions",
        "motion.png": "likelihood of an unknown motion over two of its parameters, such as PGA and period",
        "calibrate.html": "the page with all of it",
    },
    "accuracy": {
        "accuracy.csv": "every setting: its error or its quartiles, and its cost",
        "accuracy.md": "that table with a summary",
        "accuracy.png": "the work-precision diagram",
        "accuracy.json": "with --ensemble: every setting, and the conclusions",
        "members.csv": "with --ensemble: every run",
    },
    "validate": {
        "table.json": "measured and computed values",
        "samples.json": "repeated tests and many motions, as distributions",
        "curves.svg": "the curves of both",
    },
    "risk": {
        "risk.html": "hazard, capacity, return period, class and frequencies on one page, each number with its formula",
        "risk.json": "those numbers",
        "hazard.png": "the hazard of the site, with demand and capacity",
    },
    "compare": {
        "comparison.csv": "the runs side by side, all digits",
        "comparison.md": "that table to read",
        "comparison.png": "displacements, damage, crack widths and grades side by side",
    },
}


def files_of(command: str) -> tuple[str, ...]:
    """The names of the files of a command."""
    return tuple(FOLDERS[command])
