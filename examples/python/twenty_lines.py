# SPDX-License-Identifier: GPL-3.0-or-later
"""A block rocks on a base, is pushed, is bound by a joint law of its own, and reports when it opens; then the run is drawn."""

import math

from numba import njit

import masonry_cd as mc

post = mc.scene(
    structure={"blocks": [mc.box((-2, -1, -0.5), (2, 1, 0)), mc.box((-0.2, -0.2, 0), (0.2, 0.2, 1.2))], "fixed": "b0"},
    material={"density": 2200.0, "friction": 0.7},
    run={"dt": 2e-4, "duration": 0.4},
)


@njit
def damper(opening, slip, history, step, stress):  # a joint that resists opening by a dashpot
    stress[:, 0] = 2e4 * (opening - history[:, 0]) / step
    history[:, 0] = opening


law = mc.JointLaw(damper, stiffness=1e7, history=1)
sim = mc.Simulation(post, forces={"b1": lambda time: (1500.0 * (time < 0.2), 0, 0)}, velocities={"b1": (0.3, 0, 0)}, law=law)
sim.on("opening", lambda sim, joint: print(f"joint {joint} opens at {sim.time:.3f} s"))
sim.on("step", lambda sim: sim.stop("tilted by 5 degrees") if abs(sim.state.orientation[1, 2]) > math.sin(math.radians(2.5)) else None)
run = sim.record(progress=False)
print(run.stopped, run.reactions()["fz"], run.joint_forces()[["fx", "fz"]])
picture, mesh = run.plot.crack_map(), run.mesh()
