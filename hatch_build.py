# SPDX-License-Identifier: GPL-3.0-or-later
"""Puts compiled kernels into a wheel, which is then one for this minor version of Python on Linux: ``make wheel``.

MASONRY_CD_KERNELS names the folder with the files of ``masonry_cd/foundation/kernel_store.py``. Without it the wheel is pure, and kernels
are compiled where it is installed.
"""

import os
import sys
from pathlib import Path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

FOLDER = "MASONRY_CD_KERNELS"
PLATFORM = "manylinux_2_28_x86_64"  # what numba's own wheels need; kernels call the C library's mathematics and nothing else of the system


class KernelHook(BuildHookInterface):
    """Adds the kernels to what goes into the wheel, and to its name what they are for."""

    def initialize(self, version, build_data):
        folder = os.environ.get(FOLDER)
        if not folder or version == "editable":
            return
        files = sorted(Path(folder).glob("*.nbc"))
        if not files:
            raise FileNotFoundError(f"{FOLDER}: {folder} holds no compiled kernels")
        python = f"cp{sys.version_info[0]}{sys.version_info[1]}"
        build_data["pure_python"] = False
        build_data["tag"] = f"{python}-{python}-{PLATFORM}"
        build_data["force_include"] |= {str(file): f"masonry_cd/compiled/{file.name}" for file in files}
