# SPDX-License-Identifier: GPL-3.0-or-later
"""Differences between operating systems, in one place: signals that end a run, locks between processes, and limits of child processes.

Windows has no fcntl, no resource, no process groups and few signals; macOS has no /proc. Nothing else in the program names any of these, so
that all of it can be imported everywhere. What a system lacks is made up for by psutil, which is loaded there alone.
"""

from __future__ import annotations

import ctypes
import os
import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

try:
    import fcntl
    import resource
except ImportError:  # Windows
    fcntl = resource = None  # type: ignore[assignment]
try:
    import msvcrt
except ImportError:  # everything else
    msvcrt = None  # type: ignore[assignment]

PROC = Path("/proc")  # of Linux: its processes, as files
PR_SET_PDEATHSIG = 1  # of prctl, see linux/prctl.h
LOOK = 0.2  # between two looks at a child that the system does not limit by itself [s]
KILLED = -9  # exit code of a child that used too much memory, whichever system ended it
GUARD = "run.lock.guard"  # file that a system without locks on folders locks instead

INHERITS = (
    "fork" if hasattr(os, "fork") else "spawn"
)  # how processes of a pool begin: with all that is in memory, or with what they are sent
RENAMES_OPEN_FILES = os.name == "posix"  # Windows does not

# Those by which a user, a shell or a batch system ends a run; SIGBREAK is Ctrl-Break on Windows
STOPPING: tuple[int, ...] = tuple(
    getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGBREAK") if hasattr(signal, name)
)


def stays_ignored(number: int) -> bool:
    """Return True if a signal is a hangup that whoever started the program has it ignore, as nohup does."""
    return number == getattr(signal, "SIGHUP", None) and signal.getsignal(number) == signal.SIG_IGN


# --- locks ----------------------------------------------------------------------------------------------------------------------------


@contextmanager
def one_process_in(folder: Path) -> Iterator[None]:
    """Keep other processes out of the same body for the same folder; without effect on network file systems that know no locks."""
    if msvcrt is not None:
        with (folder / GUARD).open("a+b") as file:
            file.seek(0)
            with suppress(OSError):  # it waits ten seconds, far longer than a body takes
                msvcrt.locking(file.fileno(), msvcrt.LK_LOCK, 1)  # type: ignore[attr-defined, unused-ignore]
            yield
        return
    handle = os.open(folder, os.O_RDONLY)  # type: ignore[unreachable, unused-ignore]
    try:
        with suppress(OSError):
            if fcntl is not None:
                fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)


def hold(file: Path) -> int | None:
    """Lock a file until its handle, which is returned, is closed or the process ends, however it ends; None where the system cannot.

    The kernel keeps this lock: it counts in all containers of a machine, whatever their names and processes are called, and on network
    file systems that know locks also on other machines.

    Raises:
        BlockingIOError: another process holds it.
    """
    if fcntl is None:
        return None  # type: ignore[unreachable, unused-ignore]
    handle = os.open(file, os.O_RDWR)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        os.close(handle)
        raise
    except OSError:
        os.close(handle)
        return None
    return handle


def started(pid: int) -> str:
    """When a process was started, as text that no other process of this number shares; empty where there is no such process.

    On Linux in ticks of the clock since which boot, which no change of the clock moves.
    """
    if (PROC / "self").exists():
        try:
            after_name = (PROC / str(pid) / "stat").read_text().rpartition(")")[2].split()
            return f"{after_name[19]} {(PROC / 'sys/kernel/random/boot_id').read_text().strip()}"
        except (OSError, IndexError):
            return ""
    import psutil

    try:
        return str(psutil.Process(pid).create_time())
    except psutil.Error:
        return ""


# --- child processes ------------------------------------------------------------------------------------------------------------------


def limit_this_process(seconds: float, memory: int, output: int) -> None:
    """Set limits of processor time [s], addresses [B] and size of a file [B], where the system keeps them; lower ones stay.

    Where it does not, :func:`wait` of the parent looks after time and memory.
    """
    if resource is None:
        return  # type: ignore[unreachable, unused-ignore]
    whole = max(1, round(seconds))
    limits = (("RLIMIT_CPU", whole, whole + 1), ("RLIMIT_AS", memory, memory), ("RLIMIT_FSIZE", output, output), ("RLIMIT_CORE", 0, 0))
    for name, soft, hard in limits:
        what = getattr(resource, name)
        own = resource.getrlimit(what)[1]
        most = hard if own == resource.RLIM_INFINITY else min(hard, own)
        with suppress(ValueError, OSError):  # macOS refuses some
            resource.setrlimit(what, (min(soft, most), most))


def end_with_parent() -> None:
    """Have the kernel end this process when its parent is killed (Linux; elsewhere its limits do)."""
    with suppress(AttributeError, OSError, TypeError):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)


def wait(child: subprocess.Popen[bytes], longest: float, seconds: float, memory: int) -> int | None:
    """The exit code of a child, negative for a signal; None where it was not done in time.

    Args:
        child: that has called :func:`limit_this_process`.
        longest: how long to wait, wall time [s].
        seconds: processor time that it may take, where the system does not limit it [s].
        memory: that it may take, where the system does not limit it [B].
    """
    if resource is not None:
        with suppress(subprocess.TimeoutExpired):
            code = child.wait(longest)
            return None if code == -signal.SIGXCPU else code
        return None
    import psutil  # type: ignore[unreachable, unused-ignore]

    begin = time.monotonic()
    while time.monotonic() - begin < longest:
        with suppress(subprocess.TimeoutExpired):
            return child.wait(LOOK)
        with suppress(psutil.Error):
            process = psutil.Process(child.pid)
            if process.memory_info().rss > memory:
                return KILLED
            if sum(process.cpu_times()[:2]) > seconds:
                return None
    return None


def end(child: subprocess.Popen[Any]) -> None:
    """End a child that leads a session, and what it has started itself: on Windows, that only while the child lives."""
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError):
            os.killpg(child.pid, signal.SIGKILL)
    elif child.poll() is None:
        import psutil

        with suppress(psutil.Error):
            for process in psutil.Process(child.pid).children(recursive=True):
                process.kill()
        child.kill()
    child.wait()


def name_of_crash(code: int) -> str:
    """Name the cause of a child's end by its exit code: a signal or, on Windows, the system's number; empty where it ended by itself."""
    if code < 0:
        with suppress(ValueError):
            return signal.Signals(-code).name
        return f"signal {-code}"
    return f"{code:#x}" if code >= 2**31 else ""  # such as 0xc0000005, of an address that is not its own
