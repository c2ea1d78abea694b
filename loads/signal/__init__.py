"""Accelerograms: filters, baselines, spectra, intensity."""
