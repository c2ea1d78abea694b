# SPDX-License-Identifier: GPL-3.0-or-later
"""Which processor kernels are compiled for, and that results depend neither on numpy's choice of loops by the processor nor on BLAS."""

from __future__ import annotations

import os
import subprocess
import sys

import llvmlite.binding
import pytest
from places import ROOT

from benchmarks.bits.cases import HERE
from benchmarks.bits.other_processor import other_processor
from masonry_cd.foundation import processor

TARGET = "from masonry_cd.foundation import jit, processor; print(*processor.target())"
CHOICES = (processor.SWITCH, "NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
STEPS = """
import hashlib
from pathlib import Path
import numpy as np
from masonry_cd.app.case import prepare
from masonry_cd.app.scene import read_scene
from masonry_cd.mechanics.dynamics.moreau_jean import Stepper

def digest(*arrays):
    return hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()

numbers = np.random.default_rng(0).random((60, 60))
print(digest(numbers @ numbers))
case = prepare(read_scene(Path({scene!r})))
loads = case.loading
stepper = Stepper(case.assembly, loads.support_velocity, loads.acceleration, case.scene.run, forces=loads.forces)
for _ in range(25):
    stepper.step()
    state = stepper.state
    print(digest(state.position, state.orientation, state.velocity))
"""

MEASURES = """
import numpy as np
from loads.signal.baseline import integrate
from loads.signal.directions import RULES
from loads.signal.measures import parse

numbers = np.random.default_rng(0).integers(-1000, 1000, (2, 4000)) / 997.0
print(np.linalg.norm(numbers @ numbers.T).hex())
motion = dict(zip("xy", (integrate(a, 0.005) for a in numbers)))
for name in ("PGA", "PGV", "PGD", "Arias", "CAV", "D5-95", "Sa(0.3)", "AvgSA(0.1,1)", "Housner", "FIV3(0.31)"):
    for rule in (rule for rule in RULES if rule != "z"):
        print(parse(name, rule=rule).value(motion).hex())
"""


def printed(program: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """A program in a process of its own, whose environment chooses no processor but what is given here."""
    plain = {name: value for name, value in os.environ.items() if name not in CHOICES} | {"PYTHONPATH": str(ROOT)}
    return subprocess.run([sys.executable, "-c", program], env=plain | environment, capture_output=True, text=True, check=True)


@pytest.fixture
def native() -> str:
    """LLVM's name of this processor; skips where it has no AVX2 and FMA."""
    found = llvmlite.binding.get_host_cpu_features()
    if not (found.get("avx2") and found.get("fma")):
        pytest.skip("this processor has no AVX2 and FMA")
    return str(llvmlite.binding.get_host_cpu_name())


def test_kernels_are_compiled_for_any_processor_with_avx2_and_fma(native):
    assert printed(TARGET).stdout == "x86-64-v3 +avx2,+fma,+bmi,+bmi2,+f16c,+lzcnt,+movbe\n"


def test_the_environment_chooses_this_very_processor_or_another(native):
    assert printed(TARGET, MASONRY_CD_NATIVE="1").stdout.split()[0] == native
    assert printed(TARGET, NUMBA_CPU_NAME="generic").stdout == "generic \n"


def test_numba_that_was_used_before_keeps_its_processor_with_a_warning(native):
    done = printed("import numba; numba.njit(lambda: None); " + TARGET)
    assert done.stdout.split()[0] == native
    assert "before masonry_cd was imported" in done.stderr


def test_a_processor_without_avx2_keeps_to_itself():
    program = (
        "import llvmlite.binding as b; found = b.get_host_cpu_features(); found['avx2'] = False; b.get_host_cpu_features = lambda: found; "
    )
    assert not printed(program + TARGET).stdout.startswith(processor.NAME)


@pytest.mark.slow(reason="two processes load the kernels anew")
def test_results_depend_neither_on_loops_of_numpy_nor_on_blas(native, tmp_path):
    """An arch under an artificial accelerogram, which takes elementary functions, least squares and exponentials of matrices to draw."""
    text = (HERE / "record.toml").read_text().replace("duration = 0.6", "duration = 0.05").replace("voussoirs = 27", "voussoirs = 7")
    (tmp_path / "arch.toml").write_text(text)
    program, other = STEPS.format(scene=str(tmp_path / "arch.toml")), other_processor("Prescott")
    first, second = printed(program).stdout.split(), printed(program, **other).stdout.split()
    assert first[0] != second[0]  # BLAS does choose otherwise
    assert first[1:] == second[1:] and len(first) == 1 + 25


def test_intensity_measures_depend_on_neither(native):
    first, second = (printed(MEASURES, **environment).stdout.split() for environment in ({}, other_processor("Prescott")))
    assert first[0] != second[0]
    assert first[1:] == second[1:] and len(first) == 1 + 10 * 6
