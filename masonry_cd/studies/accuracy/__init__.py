# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time.

solver_rows   the solvers on one problem          scene_runs   single runs of a scene over time step and tolerance
ensemble      ensembles of them, by the engine of studies
measurement   what each of these comes to, and its files       picture   the work-precision diagram of all
command       masonry-cd accuracy
"""
