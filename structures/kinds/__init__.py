# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of structure, one file each: from a table of keys to blocks."""
