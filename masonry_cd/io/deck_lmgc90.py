# SPDX-License-Identifier: GPL-3.0-or-later
"""A deck for LMGC90: DATBOX, and command.py, which runs it by its package pylmgc90.

    BODIES.DAT        a RBDY3 a block, a POLYR a convex part with the corners in the world; mass and inertia are found by LMGC90
    BULK_BEHAV.DAT    gravity and densities              TACT_BEHAV.DAT    Coulomb's law with inelastic shocks by pair of groups
    DRV_DOF.DAT       supports: all six velocities       vx0.dat ...       their velocity over time, straight between its values
    DOF.INI, Vloc_Rloc.INI    at rest

Fields stand where the program's READ statements have them (LMGC90 user guide and sources, version 3): numbers have 14 characters
from columns 35, 56 and 77 on. Groups become colours of five letters. Joints are rigid and dry, which is the law of both programs.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from masonry_cd.foundation.errors import InputError
from masonry_cd.io.deck import AXES, Deck
from masonry_cd.mechanics.model.geometry import triangles

WIDTH, COLOUR = 14, 5  # letters of a number and of a colour
ALERT = 0.05  # distance within which contacts are looked for, in widths of the smallest block
ZERO = "0.0000000D+00".rjust(WIDTH)
BEGIN = " " * 29


def files(deck: Deck) -> dict[str, str]:
    """The text of each file, by its path in the folder of the deck.

    Raises:
        InputError: joints that are elastic or bonded.
    """
    if deck.assembly.laws.by_area.any():
        raise InputError(
            "--format", "LMGC90 decks have rigid dry joints only, but some of this scene are elastic or bonded (material.joints)"
        )
    colours, materials = _short(deck.groups()), _materials(deck)
    start = "\n! {}\n\n$steps        0              time= 0.0000000D+00\n"
    made = {
        "BODIES.DAT": "".join(_bodies(deck, colours, materials)),
        "BULK_BEHAV.DAT": "".join(_bulk(deck, materials)),
        "TACT_BEHAV.DAT": "".join(_laws(deck, colours)),
        "DRV_DOF.DAT": "".join(_driven(deck)),
        "DOF.INI": start.format("DOF"),
        "Vloc_Rloc.INI": start.format("Vloc_Rloc"),
    }
    for motion in range(deck.support_velocity.shape[1]):
        for d in deck.moving(motion):
            rows = enumerate(deck.support_velocity[:, motion, d].tolist())
            made[_history(motion, d)] = "".join(f"{k * deck.dt:.9E} {v:.9E}\n" for k, v in rows)
    return {f"DATBOX/{name}": text for name, text in made.items()} | {"command.py": _command(deck)}


def number(value: float) -> str:
    """A number of 14 characters, with as many digits as these hold."""
    for digits in range(WIDTH - 2, -1, -1):
        text = f"{value:.{digits}f}"
        if len(text) <= WIDTH and (abs(value) >= 1e-4 or value == 0.0):
            return text.rjust(WIDTH)
    return f"{value:.6E}".replace("E", "D").rjust(WIDTH)


def _three(names: Sequence[str], values: Sequence[float]) -> str:
    return "  ".join(f"{name}={number(value)}" for name, value in zip(names, values, strict=True))


def _short(groups: dict[str, list[int]]) -> dict[str, str]:
    """A colour for each group: its first letters, or a number where these are those of another."""
    made: dict[str, str] = {}
    for k, group in enumerate(groups):
        letters = "".join(letter for letter in group if letter.isascii() and letter.isalnum())[:COLOUR].ljust(COLOUR, "x")
        made[group] = f"c{k:04d}" if letters in made.values() else letters
    return made


def _materials(deck: Deck) -> dict[float, str]:
    """A name for each density [kg/m3]."""
    return {density: f"m{k:04d}" for k, density in enumerate(dict.fromkeys(block.density for block in deck.assembly.blocks))}


def _history(motion: int, d: int) -> str:
    return f"v{AXES[d]}{motion}.dat"


def _bodies(deck: Deck, colours: dict[str, str], materials: dict[float, str]) -> Iterator[str]:
    yield f"! File BODIES: {' '.join(deck.title.split())}\n"
    for b, block in enumerate(deck.assembly.blocks):
        yield f"$bdyty\n RBDY3  {b + 1:7d}\n$blmty\n PLAIN      1  behav  {materials[block.density]}  avrd={ZERO}  gyrd={ZERO}\n"
        yield f"{BEGIN}I1  ={ZERO}  I2  ={ZERO}  I3  ={ZERO}\n$nodty\n NO6xx      1                "
        yield f"{_three(('coo1', 'coo2', 'coo3'), (0, 0, 0))}\n{BEGIN}{_three(('coo4', 'coo5', 'coo6'), (0, 0, 0))}\n$tacty\n"
        for part in block.convex_parts:
            corners = triangles(part.faces).tolist()
            yield f" POLYR      1  color  {colours[deck.group_of(b)]}  nb_vertex={len(part.vertices):8d}   nb_faces={len(corners):8d}\n"
            yield from (f"{BEGIN}{_three(('coo1', 'coo2', 'coo3'), corner)}\n" for corner in part.vertices.tolist())
            yield from (
                BEGIN + "   ".join(f"ver{i + 1}={vertex + 1:13d}" for i, vertex in enumerate(triangle)) + "\n" for triangle in corners
            )
        yield "$$$$$$\n"


def _bulk(deck: Deck, materials: dict[float, str]) -> Iterator[str]:
    yield f"! File BEHAVIOUR\n\n$gravy\n{' ' * 19}{_three(('grv1', 'grv2', 'grv3'), deck.gravity.tolist())}\n"
    for density, name in materials.items():
        yield f"\n$behav  lawty\n {name}  {'RIGID':30}  Umas={number(density)}\n"


def _laws(deck: Deck, colours: dict[str, str]) -> Iterator[str]:
    yield "! File BEHAVIOUR\n"
    alert = number(ALERT * deck.assembly.width)
    pairs = [(one, other, float(deck.assembly.friction[i, j])) for one, other, i, j in deck.pairs()]
    names = {mu: f"iqs{k:02d}" for k, mu in enumerate(dict.fromkeys(mu for _, _, mu in pairs))}
    for mu, name in names.items():
        yield f"\n$behav  lawty\n {name}  {'IQS_CLB':30}  fric={number(mu)}\n"
    for one, other, mu in pairs:
        yield "\n$seety\n cdbdy  cdtac  cdcol  behav  anbdy  antac  ancol       alert\n"
        yield f" RBDY3  POLYR  {colours[one]}  {names[mu]}  RBDY3  POLYR  {colours[other]}      {alert}\n"


def _driven(deck: Deck) -> Iterator[str]:
    still = "".join(f" {value}" for value in (ZERO, ZERO, ZERO, ZERO, number(1.0), ZERO))
    for b in np.flatnonzero(deck.assembly.fixed).tolist():
        motion = int(deck.assembly.support_of[b])
        moving = deck.moving(motion)
        yield f"$bdyty\n RBDY3  {b + 1:7d}\n$nodty\n NO6xx      1\n"
        yield "$dofty        [CT......+......AMP..*..cos.(..OMEGA.*.time.+.PHI..)]...*...[RAMPI.....+.....RAMP.*.time]\n"
        for k in range(6):
            yield f" vlocy  {k + 1:5d}" + (f" evolution {_history(motion, k)}\n" if k in moving else f"{still}\n")
        yield "$$$$$$\n"


def _command(deck: Deck) -> str:
    """A script of pylmgc90 that makes the steps of the run."""
    return f'''"""Runs the deck next to it with LMGC90: python command.py"""

from pylmgc90 import chipy

dt, steps, theta = {deck.dt!r}, {deck.steps}, {deck.theta!r}
tolerance, relaxation, every = {max(deck.tolerance, 1e-6)!r}, 1.0, 100

chipy.Initialize()
chipy.checkDirectories()
chipy.PRPRx_UseCpCundallDetection(200)
chipy.PRPRx_LowSizeArrayPolyr(100)
chipy.RBDY3_NewRotationScheme()
chipy.SetDimension(3, 0)
chipy.TimeEvolution_SetTimeStep(dt)
chipy.Integrator_InitTheta(theta)
chipy.ReadDatbox(deformable=False)
chipy.OpenDisplayFiles()
chipy.ComputeMass()
for step in range(steps):
    chipy.IncrementStep()
    chipy.ComputeFext()
    chipy.ComputeBulk()
    chipy.ComputeFreeVelocity()
    chipy.SelectProxTactors()
    chipy.RecupRloc()
    chipy.ExSolver("Stored_Delassus_Loops         ", "Quad ", tolerance, relaxation, 50, 1000)
    chipy.UpdateTactBehav()
    chipy.StockRloc()
    chipy.ComputeDof()
    chipy.UpdateStep()
    chipy.WriteOut(every)
    chipy.WriteDisplayFiles(every)
chipy.CloseDisplayFiles()
chipy.Finalize()
'''
