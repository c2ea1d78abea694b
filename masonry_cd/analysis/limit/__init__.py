# SPDX-License-Identifier: GPL-3.0-or-later
"""Limit analysis: the largest load that a structure of rigid blocks bears, and the mechanism by which it gives way."""
