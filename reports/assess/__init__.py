# SPDX-License-Identifier: GPL-3.0-or-later
"""Reports of an assessment: a table, a tornado chart and a page."""
