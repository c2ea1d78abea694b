# SPDX-License-Identifier: GPL-3.0-or-later
"""Check that the program still computes the same bits: short scenes run by the command line, a hash of each result. See ``__main__``."""
