# SPDX-License-Identifier: GPL-3.0-or-later
"""The risk sheet of a site and a structure, from the folders of limit analyses and of a study."""
