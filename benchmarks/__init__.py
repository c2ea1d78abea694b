# SPDX-License-Identifier: GPL-3.0-or-later
"""Benchmarks: masonry_cd and its peers, cost against size, and order of accuracy. The README of this folder says how to run them."""
