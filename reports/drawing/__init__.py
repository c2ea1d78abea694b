# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures: rendering, the figure around a model, structures and refused blocks."""
