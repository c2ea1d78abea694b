# SPDX-License-Identifier: GPL-3.0-or-later
"""Where blocks touch: candidate pairs, contact points, gaps, and the joints that blocks share at rest."""
