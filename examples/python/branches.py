# SPDX-License-Identifier: GPL-3.0-or-later
"""A simulation is pickled in the middle and continues in two ways; the frames of a run are kept in memory."""

import pickle

import masonry_cd as mc

post = mc.scene(
    structure={"blocks": [mc.box((-2, -1, -0.5), (2, 1, 0)), mc.box((-0.2, -0.2, 0), (0.2, 0.2, 1.2))], "fixed": "b0"},
    material={"density": 2200.0, "friction": 0.7},
    loads=[{"kind": "sinusoidal", "direction": "x", "amplitude": 0.3, "frequency": 2.0, "cycles": 1}],
    run={"dt": 1e-3, "duration": 0.4},
)
sim = mc.Simulation(post)
sim.run(until=0.1)
parcel = pickle.dumps(sim)
same, pushed = pickle.loads(parcel), pickle.loads(parcel)
pushed.state = pushed.state.changed("b1", velocity=(0.5, 0, 0))
for way in (sim, same, pushed):
    way.run()
    print(way.state.position[1])  # the first two to the bit

frames = mc.Simulation(post).record(to="memory")
print(frames.position.sel(block="b1", axis="x").values, float(frames.opening.max()))
