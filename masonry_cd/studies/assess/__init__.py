# SPDX-License-Identifier: GPL-3.0-or-later
"""What an answer rests on: one scene, each of its assumptions varied by itself, and an ensemble that shows what chance does.

assumptions   which levels a scene's assumptions have   plan   the runs, by the engine of studies
task          a run, as a worker makes it                command   masonry-cd assess
"""
