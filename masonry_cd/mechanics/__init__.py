# SPDX-License-Identifier: GPL-3.0-or-later
"""The mechanics: model < linalg < contact | friction < solvers < dynamics. Nothing here reads a scene or writes a file."""
