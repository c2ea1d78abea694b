# SPDX-License-Identifier: GPL-3.0-or-later
"""The friction problem of one step: its data, Coulomb's law at one contact, its operators and error measures."""
