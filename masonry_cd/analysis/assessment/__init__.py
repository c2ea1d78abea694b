# SPDX-License-Identifier: GPL-3.0-or-later
"""Findings from the runs of an assessment: how far each assumption moves each answer, compared with chance.

assessment   the runs by assumption, the bars of a tornado   verdict   the same as text
"""
