# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of a run: results, checkpoints, the lock of a folder; and those of friction problems."""
