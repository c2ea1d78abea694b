# SPDX-License-Identifier: GPL-3.0-or-later
"""Blocks from and to files."""
