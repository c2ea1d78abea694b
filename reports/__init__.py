# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports: what a run did to the joints, in numbers and in pictures.

They read a result file alone (:class:`masonry_cd.io.results.Results`); the scene is not needed. The heavy libraries are imported
inside the functions that draw, so a run without a picture never loads VTK or matplotlib.
"""
