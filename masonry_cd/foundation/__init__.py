# SPDX-License-Identifier: GPL-3.0-or-later
"""Foundation of all packages, which knows nothing of masonry: errors, files, tables of keys, compiled kernels."""
