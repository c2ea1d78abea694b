# SPDX-License-Identifier: GPL-3.0-or-later
"""Coulomb's cone by its definition."""

from __future__ import annotations

import numpy as np


def project(x: np.ndarray, mu: float) -> np.ndarray:
    """Project one vector onto Coulomb's cone, by the definition: inside, polar, or onto the nearest generator."""
    normal, tangent = x[0], np.linalg.norm(x[1:])
    if normal >= 0.0 and tangent <= mu * normal:
        return x
    if mu * tangent <= -normal:
        return np.zeros_like(x)
    generator = np.concatenate([[1.0], mu * x[1:] / tangent]) / np.hypot(1.0, mu)
    return generator * (x @ generator)
