# SPDX-License-Identifier: GPL-3.0-or-later
"""The files that each command may leave in its folder, with what they hold; those of a run are in :mod:`reports.files`.

Commands refuse a folder that holds one of theirs, and take away what a former call wrote; docs/outputs.md lists them.
"""

from __future__ import annotations

BLOCKS = ("json", "obj", "stl", "vtu", "vtm", "vtkhdf", "step", "brep", "msh")
FOLDERS: dict[str, dict[str, str]] = {
    "build": {
        **{f"blocks.{name}": f"the blocks, as --format {name} asks" for name in BLOCKS},
        "structure.png": "the blocks by group, with ties",
        "problem.png": "of blocks that are refused: which, and where",
        "fill.json": "the fill of a bridge, next to blocks in formats that do not hold it",
        "plan.json": "the plan of a building, to correct and read again",
        "plan.svg": "that plan and the elevations of its walls; of a building that is refused, what is wrong in red",
        "plan_left.csv": "what of a drawing was not understood",
        "plan_junctions.csv": "where walls meet and where they end, with the widths found",
    },
    "export": {
        "DATBOX/BODIES.DAT": "the blocks for LMGC90, as --format lmgc90 asks",
        "DATBOX/BULK_BEHAV.DAT": "gravity and densities",
        "DATBOX/TACT_BEHAV.DAT": "friction by pair of groups",
        "DATBOX/DRV_DOF.DAT": "supports",
        "DATBOX/v*.dat": "how they move",
        "DATBOX/DOF.INI": "the state at the beginning",
        "DATBOX/Vloc_Rloc.INI": "contacts at the beginning: none",
        "command.py": "runs that deck by pylmgc90",
        "deck.3ddat": "the scene for 3DEC 7, as --format 3dec asks",
    },
    "limit": {
        "limit.json": "verdict, factors, mechanisms, check and certificate",
        "mechanisms.csv": "every mechanism of the whole and of its parts with its check, the gravest first",
        "parts.kept": "parts that an analysis which was stopped is done with, from which --resume goes on",
        "blocks.csv": "the velocity of every block in the mechanism",
        "joints.csv": "every joint: how it moves, and its force at collapse",
        "ties.csv": "what every tie pulls at collapse",
        "check.json": "the check by a code",
        "check.csv": "that check step by step, with its clauses",
        "spectrum.png": "the spectra of that check, with what is required and what is borne",
        "mechanism.png": "the mechanism with hinges and slips",
        "thrust.png": "the line of thrust at collapse",
        "limit.html": "the page with all of it",
        "capacity.csv": "the load factor while the mechanism moves on",
        "capacity.json": "that curve with its bilinear idealisation",
        "capacity.png": "that curve, and the structure at its points",
        "crossing.csv": "the factor of a vehicle over where it stands",
        "crossing.png": "that envelope",
    },
    "select": {
        "selected.toml": "the table [records] of a study: the set with its factors",
        "selection.csv": "every record of the set: its factor, its misfit, what the catalogue says of it",
        "selection.json": "the set in numbers: mean and scatter against the target, EN 1998-1, spectra, what was left out and why",
        "selection.png": "the spectra of the set, and the target",
    },
    "strengthen": {
        "strengthen.json": "target, ties, prices, and every part before and after",
        "ties.csv": "the ties with their forces, bars and prices",
        "parts.csv": "every part and push: its least mechanism before, with the least forces, and with bars",
        "before.png": "the mechanism that starts earliest before",
        "after.png": "the one with the ties",
        "strengthened.toml": "the scene with its ties",
        "strengthen.html": "the page with all of it",
    },
    "modal": {
        "modal.json": "frequencies, masses and what was compared",
        "modal.csv": "every mode: frequency, participating masses",
        "shapes_continuum.csv": "modes of the bonded continuum, at the blocks' centres",
        "shapes_joints.csv": "modes of rigid blocks on elastic joints",
        "ambient.csv": "modes identified from an ambient record, as measured modes are read",
        "stabilisation.png": "the poles among which they were found, over the order of the model",
        "modes_continuum.png": "those modes drawn",
        "modes_joints.png": "those modes drawn",
        "mesh_convergence.csv": "frequencies over the size of the elements",
    },
    "assess": {
        "assess.csv": "every run: what was varied, and what came of it",
        "assess.json": "what is varied, and what decides",
        "assess.png": "the tornado",
        "assess_global.png": "Sobol indices, with --global",
        "assess.html": "the page with all of it",
    },
    "study": {
        "runs.csv": "every run: what was asked, its numbers, how it ended",
        "runs.parquet": "that table with its types",
        "fragility.csv": "every fit with its bands",
        "fragility.json": "those with the parts of their scatter",
        "fragility.xml": "the fits as OpenQuake reads them",
        "vulnerability.xml": "loss ratios over the intensity, as OpenQuake reads them",
        "sensitivity.csv": "what goes with the damage, by rank correlation",
        "joint_probabilities.csv": "every joint: how often it opened, slid and was lost",
        "limits.csv": "of asks = limit: every scene with its factors",
        "summary.json": "the study in numbers, the verdict on it first",
        "study.html": "the page with all of it",
        "fragility.png": "fragility curves with their bands",
        "ida.png": "the curves of the records with their quantiles",
        "cloud.png": "every run, and the regression",
        "stripes.png": "the runs of each level",
        "spread.png": "how the runs are distributed",
        "tornado.png": "what matters",
        "median_opening.png": "the opening of every joint that half of the runs exceed",
    },
    "calibrate": {
        "posterior.parquet": "samples of the unknowns with their weights, which [vary] of a study takes by from",
        "samples.csv": "every sample: its round, weight, unknowns and predictions",
        "calibrate.json": "verdict, ranges, correlations, predictions, and what would help most",
        "calibrate.png": "unknowns before and after, and the observations next to what is predicted",
        "motion.png": "of an unknown motion: its likelihood over two of its numbers, as PGA and period",
        "calibrate.html": "the page with all of it",
    },
    "accuracy": {
        "accuracy.csv": "every setting: its error or its quartiles, and its cost",
        "accuracy.md": "that table to read, and what it says",
        "accuracy.png": "the work-precision diagram",
        "accuracy.json": "of an ensemble: every setting, and what they say",
        "members.csv": "of an ensemble: every run",
    },
    "validate": {
        "table.json": "what was measured, and what is computed",
        "samples.json": "repeated tests and many motions, as distributions",
        "curves.svg": "the curves of both",
    },
    "risk": {
        "risk.html": "hazard, capacity, return period, class and frequencies on one page, each number with its formula",
        "risk.json": "those numbers",
        "hazard.png": "the hazard of the site, with what is required and what is borne",
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
