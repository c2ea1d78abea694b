# SPDX-License-Identifier: GPL-3.0-or-later
"""The seismic hazard of a site: how often an intensity is exceeded, and what follows for a capacity or a fragility.

table.py      the keys of [hazard], from which a Hazard is made
curve.py      the Hazard: return period of an intensity, intensity of a return period, both bounded by its rows
life.py       reference life and return period of a limit state, NTC 2018
files.py      tables in CSV files, our own and the hazard curves of OpenQuake
frequency.py  how often a lognormal fragility is exceeded, in closed form
risk.py       the Italian risk class: IS-V, PAM and the worse of the two
"""
