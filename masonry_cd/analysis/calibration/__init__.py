# SPDX-License-Identifier: GPL-3.0-or-later
"""Posteriors as weights over samples: what was observed, the weights, and what follows from them."""
