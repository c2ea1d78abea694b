# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of a mechanism by the kinematic approach of codes: what it bears, what an earthquake asks of it, and every value between.

table.py     the keys of [limit.check]
check.py     a mechanism checked by the code that they name
ground.py    the motion of the ground: the spectrum of a code, or that of a record
level.py     how high a mechanism is held, the whole and parts alike
floors.py    its motion at a height of a building
steps.py     values with symbol, unit, clause and formula, and the formulas with their numbers
site.py      the hazard of the site: what a limit state asks for, return period and risk class of what is borne
borne.py     the acceleration of the ground that is just borne
spectra.py   the spectra of a check as curves, each a Spectrum of spectrum.py
verdicts.py  demand against capacity, and the one verdict that follows: result and confidence
code.py      the declaration of a code
codes        a file each: Circolare 7 of 2019, C8.7.1.2.1; Circolare 617 of 2009, C8A.4; EN 1998-1:2004, 4.3.5, with EN 1998-3:2005
"""
