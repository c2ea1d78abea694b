# SPDX-License-Identifier: GPL-3.0-or-later
r"""Newton's restitution of rigid contacts, u_n+ = -e u_n-, where a scene asks for it.

A contact that is about to be hit (see ``impacts.py``) is brought to touch in the step of the impact, so that the bounce begins at the right
place, and thrown back in the next. In free flight the velocity of a step is that of the middle between two q_m, so with the closing speeds
c_0 before and c_1 after gravity has acted for the step, and the time f h from q_m to the impact,

    u_n- = c_1 + (f - 1/2) (c_1 - c_0),        then        u_n >= e u_n- - 1/2 (c_1 - c_0),        p_n >= 0,    the one or the other.

Impacts slower than FAST times what gravity gives in a step are plastic, so that a block comes to rest.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from masonry_cd.mechanics.contact.contact_set import ContactSet
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.free_motion import Prediction
from masonry_cd.mechanics.dynamics.impacts import AT_ONCE, CLOSED, FAST
from masonry_cd.mechanics.dynamics.system import MotionState, System
from masonry_cd.mechanics.friction.problem import FrictionProblem


def thrown_back(
    system: System, last: MotionState, predicted: Prediction, found: ContactSet, rows: ContactRows, problem: FrictionProblem
) -> tuple[FrictionProblem, np.ndarray]:
    """The problem of rigid contacts of which some are thrown back, and the speeds (N,) [m/s] at which others of all found are hit."""
    approach, restitution = np.zeros(max(1, len(found.gap))), system.assembly.restitution[rows.groups[:, 0], rows.groups[:, 1]]
    on = np.flatnonzero(restitution > 0.0)
    if not len(on):
        return problem, approach
    h, own, place, gap = system.constants.step, problem.subset(on), rows.active[on], np.maximum(rows.gap[on], 0.0)
    before, after = (gap / h - own.relative_velocity(v)[:, 0] for v in (last.v, predicted.v_free))
    hit = (after > FAST * predicted.pull * h) & (gap < h * after)
    at_once = gap <= AT_ONCE * h * after
    share = np.divide(gap, h * after, out=np.zeros_like(gap), where=hit)
    speed = np.where(hit, np.maximum(after + (share - 0.5) * (after - before), 0.0), 0.0)
    previous = found.previous[place]
    known = (previous >= 0) & (previous < len(last.approach))
    remembered = np.where(known, np.append(last.approach, 0.0)[np.where(known, previous, -1)], 0.0)
    remembered[(before <= 0.0) | (gap > CLOSED * predicted.pull * h * h)] = 0.0  # something else has stopped it
    thrown = np.where(remembered > 0.0, remembered, np.where(at_once, speed, 0.0))
    approach[place] = np.where(thrown > 0.0, 0.0, speed)
    offset = problem.offset.copy()
    offset[on, 0] -= np.where(thrown > 0.0, np.maximum(restitution[on] * thrown - 0.5 * (after - before), 0.0), 0.0)
    return replace(problem, offset=offset), approach
