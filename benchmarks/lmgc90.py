# SPDX-License-Identifier: GPL-3.0-or-later
r"""Step a scene with LMGC90, as the wheel ``compas_lmgc90`` ships it, and write down what it did.

    python lmgc90.py scene.json result.npz [--seconds 60]

This file runs under the peer's own Python and needs numpy and ``compas_lmgc90`` only (measured with 0.1.11). Defaults of the
wheel throughout: contact law IQS_CLB, detection STO, NLGS in blocks of 50 sweeps until its QM/16 test passes at 1.666e-4, no
option of ours. The clock runs around the step alone; reading back what it found does not count.

Written per step: seconds, sweeps, contacts. Written for the sampled steps: all that the friction problem of the step needs, to be
judged by our measure, see ``lmgc90_error.py``. LMGC90 gives forces [N]; impulses are dt times them. Its axes of a contact are
(t, n, s), n from the antagonist to the candidate.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import time
from typing import Any

import numpy as np

TAGS = ["cdan", "icdan", "cdbdy", "icdbdy", "anbdy", "ianbdy", "cdtac", "icdtac", "antac", "iantac", "icdsci", "iansci", "behav", "status"]
VECTORS = [("coor", 3), ("uc", 9), ("rloc", 3), ("vloc", 3), ("gap", 1)]


class Interaction(ctypes.Structure):
    """One contact as ``lmgc90_get_all_inters`` fills it: names of five letters, indices from 1, vectors."""

    _fields_ = [
        *((tag, ctypes.c_int if tag.startswith("i") else ctypes.c_char * 5) for tag in TAGS),
        *((name, ctypes.c_double * size) for name, size in VECTORS),
        ("nb_int", ctypes.c_int),
        ("internals", ctypes.c_double * 19),
    ]


KEPT = ["icdbdy", "ianbdy", *(name for name, _ in VECTORS)]
LAYOUT = np.dtype(
    {
        "names": KEPT,
        "formats": ["<i4", "<i4", *(("<f8", (size,)) for _, size in VECTORS)],
        "offsets": [getattr(Interaction, name).offset for name in KEPT],
        "itemsize": ctypes.sizeof(Interaction),
    }
)


class Lmgc90:
    """One LMGC90 model: the wheel's own set-up calls, and its C entry points for stepping and reading back."""

    def __init__(self, scene: dict[str, Any], law: str = "IQS_CLB", alert: float = 1e-3) -> None:
        from compas_lmgc90 import _lmgc90

        self.library = ctypes.CDLL(_lmgc90.__file__)  # the image that the module has loaded already
        self.blocks = len(scene["blocks"])
        self._solver = _lmgc90.LMGC90Solver()
        solver = self._solver
        solver.initialize(scene["dt"], scene["theta"], False)
        solver.add_one_tact_behav("iqsc0", law, [float(scene["friction"])])
        densities = np.unique([float(block["density"]) for block in scene["blocks"]])
        solver.set_materials(densities)
        solver.set_see_tables(alert)
        solver.set_nb_bodies(self.blocks)
        velocity = np.asarray(scene["base_velocity"], dtype=float)
        table = np.concatenate([scene["dt"] * np.arange(len(velocity)), velocity])
        for index, block in enumerate(scene["blocks"]):
            material = f"s{int(np.searchsorted(densities, block['density'])) + 1:0>4}"
            self._add(index, block, material, table)
        solver.close_before_computing()

    def _add(self, index: int, block: dict[str, Any], material: str, table: np.ndarray) -> None:
        """Add a block, its faces cut into triangles; the base moves along x as the table says and in no other way."""
        vertices = np.asarray(block["vertices"], dtype=float)
        middle = vertices.mean(axis=0)
        triangles = [(face[0], face[i], face[i + 1]) for face in block["faces"] for i in range(1, len(face) - 1)]
        driven = 6 if block["fixed"] else 0
        self._solver.set_one_polyr(
            material, middle.tolist(), (np.array(triangles) + 1).ravel().tolist(), (vertices - middle).ravel().tolist(), driven, 0
        )
        for freedom in range(1, driven + 1):
            moves = freedom == 1 and table[len(table) // 2 :].any()
            self._solver.set_drvdof(index + 1, freedom, table if moves else np.zeros(6), True, bool(moves))

    def step(self) -> float:
        """Take one time step; return its seconds."""
        begin = time.perf_counter()
        self.library.lmgc90_compute_one_step()
        return time.perf_counter() - begin

    def sweeps(self) -> int:
        """Gauss-Seidel sweeps of the last step; 0 where the library does not say."""
        try:
            ask = getattr(self.library, "__nlgs_3d_MOD_get_nlgs3d_loop")  # as a string: a name is mangled in a class
        except AttributeError:
            return 0
        count, contacts, errors = ctypes.c_int(0), ctypes.c_int(0), [ctypes.c_double(0.0) for _ in range(3)]
        ask(ctypes.byref(count), *map(ctypes.byref, errors), ctypes.byref(contacts))
        return count.value

    def bodies(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres of mass (B, 3) [m] and axes of inertia (B, 3, 3), one per row."""
        out = np.empty((self.blocks, 12))
        self.library.lmgc90_get_all_bodies(ctypes.c_void_p(out.ctypes.data), ctypes.c_int(self.blocks))
        return out[:, :3].copy(), out[:, 3:].reshape(-1, 3, 3).copy()

    def contacts(self) -> np.ndarray:
        """Contacts of the last step, in :data:`LAYOUT`."""
        count = self.library.lmgc90_get_nb_inters()
        out = np.zeros(count, LAYOUT)
        if count:
            self.library.lmgc90_get_all_inters(ctypes.c_void_p(out.ctypes.data), ctypes.c_int(count))
        return out


def sampled(steps: int, wanted: int = 10) -> set[int]:
    """Steps, counted from 1, whose contacts are kept: spread evenly, the last among them."""
    return {round(k) for k in np.linspace(1, steps, min(steps, wanted))}


def run(scene: dict[str, Any], seconds: float) -> dict[str, np.ndarray]:
    """Step through a scene until its end or the time box; return the arrays of the result file."""
    model = Lmgc90(scene)
    keep, begin = sampled(scene["steps"]), time.perf_counter()
    wall, sweeps, contacts = [], [], []
    position, axes = ([part] for part in model.bodies())
    out: dict[str, np.ndarray] = {}
    for k in range(1, scene["steps"] + 1):
        wall.append(model.step())
        sweeps.append(model.sweeps())
        found = model.contacts()
        contacts.append(len(found))
        for history, part in zip((position, axes), model.bodies(), strict=True):
            history.append(part)
        over = time.perf_counter() - begin > seconds
        if k in keep or over:
            out |= {f"{name}_{k}": found[name] for name in KEPT}
        if over:
            break
    out["sampled"] = np.array(sorted({int(name.split("_")[1]) for name in out}))
    return out | {
        "seconds": np.array(wall),
        "sweeps": np.array(sweeps),
        "contacts": np.array(contacts),
        "position": np.array(position),
        "axes": np.array(axes),
    }


def main() -> None:
    """The command line, see the head of this file."""
    parser = argparse.ArgumentParser(description="Step a benchmark scene with LMGC90.")
    parser.add_argument("scene")
    parser.add_argument("result")
    parser.add_argument("--seconds", type=float, default=1e9, help="end after the step during which this time has passed")
    given = parser.parse_args()
    with open(given.scene, encoding="utf-8") as file:
        scene = json.load(file)
    result = run(scene, given.seconds)
    np.savez_compressed(given.result, allow_pickle=False, **result)
    print(f"{len(result['seconds'])} steps, {1e3 * np.median(result['seconds']):.3g} ms each")


if __name__ == "__main__":
    main()
