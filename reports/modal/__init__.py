# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic modes of companions built on the same blocks."""
