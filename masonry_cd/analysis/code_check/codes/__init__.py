# SPDX-License-Identifier: GPL-3.0-or-later
"""The codes by which a mechanism is checked, a file each: its clauses by number, and what of ``[limit.check]`` it takes."""
