# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of a mechanism by the kinematic approach of codes: what it bears, what an earthquake asks of it, and every value between.

table.py     the keys of [limit.check]
check.py     a mechanism checked by the code that they name
ground.py    the motion of the ground: the spectrum of a code, or that of a record
level.py     how high a mechanism is held, the whole and parts alike
floors.py    its motion at a height of a building
steps.py     values with symbol, unit and clause
verdicts.py  demand against capacity, and the one verdict that follows
ntc2018.py   Circolare 7 of 2019, C8.7.1.2.1
ntc2008.py   Circolare 617 of 2009, C8A.4
ec8.py       EN 1998-1:2004, 4.3.5, with the confidence factor of EN 1998-3:2005
"""
