# SPDX-License-Identifier: GPL-3.0-or-later
"""The least strengthening of a scene: ties from candidates that bring every mechanism to a load factor, or to a share of a code's motion.

goal.py      what is asked of each mechanism
asked.py     a scene becomes candidates, target and the limit analyses that have to reach it
design.py    cuts, forces, verification, bars
facts.py     strengthen.json and the tables
files.py     tables, pictures, page and the strengthened scene
command.py   masonry-cd strengthen

The mathematics is in :mod:`masonry_cd.analysis.limit.strengthening`, the keys in :mod:`masonry_cd.app.strengthen_table`.
"""
