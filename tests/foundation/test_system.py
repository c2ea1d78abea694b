# SPDX-License-Identifier: GPL-3.0-or-later
"""Systems without what POSIX alone has: everything imports, runs, locks its folder and limits its children there."""

from __future__ import annotations

import ast
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from places import EXAMPLES, ROOT

from masonry_cd.foundation import system

PACKAGES = ("masonry_cd", "structures", "loads", "reports")
OF_ONE_SYSTEM = {"fcntl", "resource", "msvcrt", "winreg", "_winapi", "pwd", "grp", "termios", "tty", "pty", "posix", "syslog"}
NOT_EVERYWHERE = {
    "signal": {
        "SIGHUP",
        "SIGQUIT",
        "SIGKILL",
        "SIGXCPU",
        "SIGUSR1",
        "SIGUSR2",
        "SIGBREAK",
        "SIGALRM",
        "alarm",
        "setitimer",
        "pthread_kill",
    },
    "os": {
        "fork",
        "forkpty",
        "killpg",
        "getpgid",
        "setsid",
        "getuid",
        "geteuid",
        "nice",
        "statvfs",
        "getloadavg",
        "mkfifo",
        "uname",
        "wait4",
    },
}
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
    """What a source names that not every system has; a name that ``hasattr`` asks for first is a matter of reading, not of this."""
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
    command = (
        "-m",
        "masonry_cd",
        "run",
        scene,
        "-q",
        "--set",
        "run.duration=0.02",
        "--set",
        "loads=[]",
        "--set",
        "report.crack_map=false",
        "-o",
    )
    ended = elsewhere(*command, tmp_path / "out", folder=tmp_path)
    assert (ended.returncode, ended.stderr) == (0, "")
    held = (
        "import subprocess, sys; from pathlib import Path; from masonry_cd.io.lock import locked\n"
        "with locked(Path('held')):\n    sys.exit(subprocess.run([sys.executable, *sys.argv[1:], 'held']).returncode)\n"
    )
    ended = elsewhere("-c", held, *command, folder=tmp_path)
    assert ended.returncode == 2
    assert ended.stderr.startswith("masonry-cd: error: held: another run writes there (process ")
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
