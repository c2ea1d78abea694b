# SPDX-License-Identifier: GPL-3.0-or-later
"""Block-sparse factorisations over the graph of bodies: ordering, symbolic and numeric factors, triangular solves, threads."""
