# SPDX-License-Identifier: GPL-3.0-or-later
"""Whether the results of a run fit on the disc: estimated from its blocks, joints, frames and steps before the first step."""

from __future__ import annotations

import shutil
from pathlib import Path

from masonry_cd.app.per_step import QUANTITIES
from masonry_cd.foundation.errors import InputError
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.joint_laws import histories
from masonry_cd.mechanics.model.joints import Joints

NUMBER = 8  # bytes
OF_BLOCK = 3 + 4 + 6  # numbers of a frame: position, orientation, velocity
OF_STRAIN = 9  # those of its gradient, where blocks deform
OF_STRESS = (6, 2)  # numbers of a frame: of a block, and of a joint
OF_SUPPORT = 6  # numbers of a frame: force and moment
OF_JOINT = 6 + 3 + 3  # numbers of a frame: six histories, the force and its place, see io/results.py; and those of their laws


def result_bytes(assembly: Assembly, joints: Joints, frames: int, steps: int, stress: bool = False, of_meshes: int = 0) -> float:
    """About how large result.h5 will be, its ties and shocks apart [B].

    ``stress``: it keeps stress; ``of_meshes``: numbers of a frame that meshed blocks then have besides, in single precision.
    """
    of_block = OF_BLOCK + (0 if assembly.deformation is None else OF_STRAIN)
    frame = 1 + of_block * assembly.count + (OF_JOINT + len(histories(assembly.laws))) * joints.count
    frame += OF_SUPPORT * int(assembly.fixed.sum())
    frame += (OF_STRESS[0] * assembly.count + OF_STRESS[1] * joints.count) * stress
    return float(NUMBER) * ((frame + 0.5 * of_meshes * stress) * frames + len(QUANTITIES) * steps)


def check_disc_space(folder: Path, needed: float, there: float = 0.0) -> None:
    """Refuse a run whose results do not fit on the disc.

    Args:
        folder: for the results; it need not exist.
        needed: of the results in all [B].
        there: what the folder holds of them already [B].

    Raises:
        InputError: names what is needed and what is free.
    """
    place = next(path for path in (folder, *folder.absolute().parents) if path.exists())
    free = float(shutil.disk_usage(place).free)
    if needed - there > free:
        raise InputError(
            "run.frames_per_second",
            f"the results would take about {needed / 1e9:.3g} GB, {free / 1e9:.3g} GB are free where {folder} lies; "
            "fewer frames, larger steps or a shorter run take less",
        )
