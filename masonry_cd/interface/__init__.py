# SPDX-License-Identifier: GPL-3.0-or-later
"""The Python interface, ``import masonry_cd as mc``: scenes and runs as values, for notebooks and scripts.

What of it ``masonry_cd`` shows, its own __init__ lists; each name is imported on first use. Everything here calls what the command
line calls: the same checks with the same words, the same files in the folder of a run, the same bits.
"""
