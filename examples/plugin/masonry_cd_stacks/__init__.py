# SPDX-License-Identifier: GPL-3.0-or-later
"""An example of a plug-in for masonry-cd, a module for each of the points where one can add something."""
