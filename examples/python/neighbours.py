# SPDX-License-Identifier: GPL-3.0-or-later
"""A wall goes to COMPAS and to LMGC90, and its blocks come back: all three stand alike."""

import json
from pathlib import Path

import masonry_cd as mc

about = {"material": {"density": 2000.0, "friction": 0.6}, "run": {"dt": 1e-3, "duration": 0.1}}
wall = mc.scene(structure={"kind": "wall", "length": 2.0, "height": 1.0, "course_height": 0.25, "thickness": 0.3}, **about)
Path("wall.json").write_text(json.dumps(wall.to_compas()), encoding="utf-8")
of_compas = mc.scene(structure={"blocks": mc.from_compas("wall.json")}, **about)

deck = wall.to_deck("lmgc90", "lmgc90")  # DATBOX and command.py
bodies = {"kind": "file", "path": "lmgc90/DATBOX/BODIES.DAT", "units": "m", "up": "z"}
of_lmgc90 = mc.scene(structure=bodies, **about)

for scene in (wall, of_compas, of_lmgc90):
    sim = mc.Simulation(scene)
    sim.run(until=0.02)
    print(len(scene.structure), "blocks,", sum(force[2] for force in sim.reactions().values()), "N")
