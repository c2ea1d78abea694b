# SPDX-License-Identifier: GPL-3.0-or-later
"""Crack maps: joints coloured by what they suffered, cut open, in sequence, with lines of thrust."""
