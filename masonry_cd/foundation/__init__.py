# SPDX-License-Identifier: GPL-3.0-or-later
"""What everything else stands on and what knows nothing of masonry: errors, files, tables of keys, compiled kernels."""
