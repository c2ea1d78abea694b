# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of a calibration: tables, a picture and a page."""
