# SPDX-License-Identifier: GPL-3.0-or-later
"""Assumptions on which an answer rests: one scene, each of them varied by itself, and an ensemble that shows the effect of chance.

assumptions   which levels a scene's assumptions have   plan   the runs, by the engine of studies
task          a run, as a worker makes it                command   masonry-cd assess
"""
