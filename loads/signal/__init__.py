# SPDX-License-Identifier: GPL-3.0-or-later
"""Accelerograms: filters, baselines, spectra, intensity."""
