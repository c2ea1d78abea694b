# SPDX-License-Identifier: GPL-3.0-or-later
"""Many runs of one scene: error against run time, vibration sweeps."""
