# SPDX-License-Identifier: GPL-3.0-or-later
"""Instructions and cycles of this process, by the counters of the processor: they do not swing with what else the machine does.

Linux only, by ``perf_event_open``; where the system does not give them (another system, a container, a virtual machine without counters)
there are none.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from dataclasses import dataclass

SYSTEM_CALL = {"x86_64": 298, "aarch64": 241}  # number of perf_event_open
CYCLES, INSTRUCTIONS = 0, 1  # of PERF_TYPE_HARDWARE
SIZE = 128  # of struct perf_event_attr that is given [B]
FLAGS_AT = 40  # of its bit field [B]
USER_ONLY = (1 << 5) | (1 << 6)  # neither kernel nor hypervisor


@dataclass(frozen=True)
class Counters:
    """Counters of the calling thread, which begin to run when they are made."""

    instructions: int  # file descriptors
    cycles: int

    @classmethod
    def open(cls) -> Counters | None:
        """Counters, or None where there are none."""
        number = SYSTEM_CALL.get(platform.machine()) if sys.platform == "linux" else None
        if number is None:
            return None
        found = [_opened(number, what) for what in (INSTRUCTIONS, CYCLES)]
        return cls(*found) if min(found) >= 0 else None

    def read(self) -> tuple[int, int]:
        """Instructions and cycles so far."""
        return _value(self.instructions), _value(self.cycles)


def _opened(number: int, what: int) -> int:
    """File descriptor of a counter of this thread on any processor, less than 0 where it is refused."""
    attributes = bytearray(SIZE)
    struct.pack_into("<IIQ", attributes, 0, 0, SIZE, what)
    struct.pack_into("<Q", attributes, FLAGS_AT, USER_ONLY)
    given = (ctypes.c_char * SIZE).from_buffer(attributes)
    return int(ctypes.CDLL(None, use_errno=True).syscall(number, given, 0, -1, -1, 0))


def _value(descriptor: int) -> int:
    return int(struct.unpack("Q", os.read(descriptor, 8))[0])
