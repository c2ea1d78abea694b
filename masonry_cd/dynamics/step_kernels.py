"""v = v_free + M^-1 H^T p."""

from __future__ import annotations

import numpy as np

from masonry_cd.jit import entry


@entry()
def new_velocity(impulse, bodies, jacobian, inverse_mass, v_free, v):
    """v = v_free + M^-1 H^T p, (B, n)."""
    contacts, m, n = impulse.shape[0], jacobian.shape[2], jacobian.shape[3]
    push = np.zeros_like(v_free)
    for c in range(contacts):
        for side in range(2):
            b = bodies[c, side]
            if b >= 0:
                for i in range(m):
                    for j in range(n):
                        push[b, j] += jacobian[c, side, i, j] * impulse[c, i]
    for b in range(v_free.shape[0]):
        for j in range(n):
            value = v_free[b, j]
            for k in range(n):
                value += inverse_mass[b, j, k] * push[b, k]
            v[b, j] = value
