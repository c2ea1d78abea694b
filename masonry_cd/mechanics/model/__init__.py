# SPDX-License-Identifier: GPL-3.0-or-later
"""Constants of a run, and its state: blocks, materials, positions and velocities."""
