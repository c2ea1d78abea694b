# SPDX-License-Identifier: GPL-3.0-or-later
"""A set of records for a site, chosen from a folder of them."""
