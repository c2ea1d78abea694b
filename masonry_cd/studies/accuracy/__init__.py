# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against run time.

solver_rows   the solvers on one problem          scene_runs   single runs of a scene over time step and tolerance
ensemble      ensembles of them, by the engine of studies
picture       what each of these comes to: its files, and the work-precision diagram         command   masonry-cd accuracy
"""
