# SPDX-License-Identifier: GPL-3.0-or-later
"""Values of a model that explain what was observed of a building: a posterior as weights over a study.

plan      a study file with [[observations]]        predicted   what a sample predicts for each, as a worker finds it
command   masonry-cd calibrate: rounds of samples, each drawn where the last ones were likely
"""
