# SPDX-License-Identifier: GPL-3.0-or-later
"""Systems without what POSIX has, and other processors: everything imports, runs and locks there, and results are the same."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
from pathlib import Path

import llvmlite.binding
import pytest
from places import EXAMPLES, ROOT

from benchmarks.bits.cases import HERE
from benchmarks.bits.other_processor import other_processor
from masonry_cd.foundation import processor, system

PACKAGES = ("masonry_cd", "structures", "loads", "reports")
OF_ONE_SYSTEM = {"fcntl", "resource", "msvcrt", "winreg", "_winapi", "pwd", "grp", "termios", "tty", "pty", "posix", "syslog"}
NOT_EVERYWHERE = {
    "signal": {
        "SIGHUP", "SIGQUIT", "SIGKILL", "SIGXCPU", "SIGUSR1",
        "SIGUSR2", "SIGBREAK", "SIGALRM", "alarm", "setitimer", "pthread_kill",
    },
    "os": {
        "fork", "forkpty", "killpg", "getpgid", "setsid", "getuid",
        "geteuid", "nice", "statvfs", "getloadavg", "mkfifo", "uname", "wait4",
    },
}  # fmt: skip
EVERYTHING = """
import importlib, pkgutil, masonry_cd, structures, loads, reports
for package in (masonry_cd, structures, loads, reports):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
from masonry_cd.foundation import system
assert (system.fcntl, system.resource, len(system.STOPPING)) == (None, None, 2), "nothing is hidden: the test shows nothing"
"""


def elsewhere(*arguments: str | Path, folder: Path) -> subprocess.CompletedProcess[str]:
    """Python as on a system without what POSIX alone has."""
    path = os.pathsep.join(map(str, (ROOT / "tests" / "other_system", ROOT)))
    environment = os.environ | {"PYTHONPATH": path}
    return subprocess.run([sys.executable, *map(str, arguments)], cwd=folder, env=environment, capture_output=True, text=True, check=False)


def names_of_one_system(source: str) -> list[str]:
    """List the names in a source that not every system has; a name that ``hasattr`` asks for first is a matter of reading, not of this."""
    found = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            found += [name.name for name in node.names if name.name in OF_ONE_SYSTEM]
        elif isinstance(node, ast.ImportFrom) and node.module in OF_ONE_SYSTEM:
            found.append(str(node.module))
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.attr in NOT_EVERYWHERE.get(node.value.id, ()):
            found.append(f"{node.value.id}.{node.attr}")
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("get_context"):
            found += [way for argument in node.args for way in ("fork", "forkserver") if f"'{way}'" in ast.unparse(argument)]
    return found


def test_one_file_alone_names_what_not_every_system_has() -> None:
    named = {}
    for package in PACKAGES:
        for file in (ROOT / package).rglob("*.py"):
            if names := names_of_one_system(file.read_text(encoding="utf-8")):
                named[str(file.relative_to(ROOT))] = names
    assert list(named) == ["masonry_cd/foundation/system.py"], named


def test_every_module_can_be_imported_elsewhere(tmp_path: Path) -> None:
    ended = elsewhere("-c", EVERYTHING, folder=tmp_path)
    assert ended.returncode == 0, ended.stderr[-2000:]


def test_a_run_elsewhere_holds_its_folder(tmp_path: Path) -> None:
    """A second run in the same folder is refused for as long as the first one lives, and no longer."""
    scene = EXAMPLES / "trilithon.toml"
    words = "--set run.duration=0.02 --set loads=[] --set report.crack_map=false -o"
    command = ("-m", "masonry_cd", "run", scene, "-q", *words.split())
    ended = elsewhere(*command, tmp_path / "out", folder=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    held = (
        "import subprocess, sys; from pathlib import Path; from masonry_cd.io.lock import locked\n"
        "with locked(Path('held')):\n    sys.exit(subprocess.run([sys.executable, *sys.argv[1:], 'held']).returncode)\n"
    )
    ended = elsewhere("-c", held, *command, folder=tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.startswith("masonry-cd: error: held: another run is writing to this folder (process ")
    ended = elsewhere(*command, tmp_path / "held", folder=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, ""), "the lock of a process that has ended is not taken over"


NEVER = 3600.0  # [s]


@pytest.mark.parametrize(
    ("code", "limits", "ended"),
    [
        ("import time\nwhile time.process_time() < 20.0: pass\nraise SystemExit(5)", (NEVER, 0.4, 2**33), None),
        ("import time; time.sleep(60)", (2.0, NEVER, 2**33), None),  # it computes nothing, so that only the wall time ends it
        (
            "kept = bytearray(2**29); kept[::4096] = b'1' * len(kept[::4096]); import time; time.sleep(60)",
            (NEVER, NEVER, 2**28),
            system.KILLED,
        ),
        ("raise SystemExit(3)", (NEVER, NEVER, 2**33), 3),
    ],
)
def test_a_child_that_the_system_does_not_limit_is_watched(monkeypatch: pytest.MonkeyPatch, code, limits, ended) -> None:
    monkeypatch.setattr(system, "resource", None)
    monkeypatch.delattr(os, "killpg", raising=False)
    child = subprocess.Popen([sys.executable, "-S", "-c", code])
    try:
        assert system.wait(child, *limits) == ended
    finally:
        system.end(child)
    assert child.poll() is not None


def test_a_process_is_known_by_when_it_was_started(monkeypatch: pytest.MonkeyPatch) -> None:
    """As psutil knows it, and as Linux does; a number that no process has is known by nothing."""
    with subprocess.Popen([sys.executable, "-S", "-c", "input()"], stdin=subprocess.PIPE) as child:
        for place in (Path("/proc"), Path("/nowhere")):
            monkeypatch.setattr(system, "PROC", place)
            own = system.started(os.getpid())
            assert own == system.started(os.getpid()) != ""
            assert system.started(child.pid) not in ("", own)
            assert system.started(2**22 + 1) == ""


@pytest.mark.parametrize(
    ("code", "named"), [(-signal.SIGSEGV, "SIGSEGV"), (0xC0000005, "0xc0000005"), (1, ""), (0, ""), (-9999, "signal 9999")]
)
def test_a_crash_is_named_as_the_system_has_it(code: int, named: str) -> None:
    assert system.name_of_crash(code) == named


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


@pytest.mark.slow(reason="two processes load the kernels again")
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
