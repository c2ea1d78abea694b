# SPDX-License-Identifier: GPL-3.0-or-later
"""The stress of blocks and joints: largest values, compared with a strength."""
