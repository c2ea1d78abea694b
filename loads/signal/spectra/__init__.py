# SPDX-License-Identifier: GPL-3.0-or-later
"""Elastic response spectra, one file each: of a code, its keys, equations by number and tables; or a table of ordinates."""
