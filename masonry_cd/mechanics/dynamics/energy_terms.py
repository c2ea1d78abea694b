# SPDX-License-Identifier: GPL-3.0-or-later
"""The terms of the energy balance of a run, which :mod:`masonry_cd.mechanics.dynamics.energy` closes in each step, and their words."""

WORKS = {
    "base_work": "work of the base",
    "gravity_work": "work of gravity",
    "force_work": "work of point loads and ties",
    "change_work": "put in by changes of the model",
}
"""Terms of the work that is put in."""
LOSSES = {
    "kinetic": "kinetic",
    "elastic": "stored elastically",
    "friction": "lost in friction",
    "impact": "lost in impacts",
    "damping": "lost in damping",
    "bond": "taken by bonds that soften",
    "crushing": "lost in crushing",
    "ground": "stored in the ground",
    "radiation": "lost to the ground",
}
"""Where it went."""
LIFT = {"correction": "lifts out of overlaps"}
ENERGIES = LOSSES | WORKS | LIFT | {"balance": "balance, ideally zero"}
