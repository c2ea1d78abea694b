# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis of a scene: its load factor and mechanisms, those of its parts, and their code check.

The whole of a structure is the part that holds everything, so that one :class:`~masonry_cd.limit.case.LimitCase` has the mechanisms of the
whole and of all parts in one table, and one verdict.

case.py        a scene becomes a LimitCase
whole.py       the whole under the load that the scene multiplies
parts.py       the requested macro-elements and their analysis
checked.py     each mechanism with its code check, and the verdict of the governing one
search.py      how far the least factor is searched for
left_state.py  the blocks where a run left them
vehicle.py     the worst place of a vehicle
curve.py       the capacity curve
words.py       the lines that the terminal shows
facts.py       limit.json
assumed.py     the load factor with what is assumed otherwise
kept.py        parts that are done with, for --resume
pictures.py    mechanisms, forces and spectra drawn
files.py       tables, pictures and page
command.py     masonry-cd limit

The mathematics is in :mod:`masonry_cd.analysis.limit`, the clauses of codes in :mod:`masonry_cd.analysis.code_check`, the keys of the scene
in :mod:`masonry_cd.app.limit_table`.
"""
