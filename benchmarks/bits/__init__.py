# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the program still computes the same bits: short scenes, run by the command line, and a hash of each result. See ``__main__``."""
