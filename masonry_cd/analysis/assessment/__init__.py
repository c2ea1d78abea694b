# SPDX-License-Identifier: GPL-3.0-or-later
"""What the runs of an assessment say: how far each assumption moves each answer, beside what chance does.

assessment   the runs by assumption, the bars of a tornado   verdict   the same in words
"""
