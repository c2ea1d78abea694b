# SPDX-License-Identifier: GPL-3.0-or-later
"""Studies: what many runs say together. It reads a study's folder, fits fragilities, and writes tables, pictures and a page."""
