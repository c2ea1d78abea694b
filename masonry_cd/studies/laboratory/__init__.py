# SPDX-License-Identifier: GPL-3.0-or-later
"""Tests of the laboratory, and other programs' results, to hold the program against: ``masonry-cd validate NAME`` repeats one."""
