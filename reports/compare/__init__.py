# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs compared side by side."""
