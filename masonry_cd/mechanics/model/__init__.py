# SPDX-License-Identifier: GPL-3.0-or-later
"""What is constant during a run, and the state: blocks, materials, positions and velocities."""
