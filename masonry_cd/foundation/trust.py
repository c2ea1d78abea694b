# SPDX-License-Identifier: GPL-3.0-or-later
"""Trust in code that a scene names: it runs only where the user allows it, by --trust on the command line or ``mc.trust()`` in Python.

Processes of a study inherit it, so it is kept in their environment; a scene cannot set it.
"""

from __future__ import annotations

import os

from masonry_cd.foundation.errors import InputError

VARIABLE = "MASONRY_CD_TRUST"


def trust(given: bool = True) -> None:
    """Let code that scenes name run in this process and those that it starts, or no longer."""
    if given:
        os.environ[VARIABLE] = "1"
    else:
        os.environ.pop(VARIABLE, None)


def is_trusted() -> bool:
    """Return True if such code may run."""
    return os.environ.get(VARIABLE) == "1"


def require_trust(key: str, name: str, what: str, otherwise: str = "") -> None:
    """Refuse code that nobody vouches for.

    Args:
        key: of the scene that names it.
        name: of its file.
        what: it is, and may do.
        otherwise: how to go without, at the end of the message.

    Raises:
        InputError: says to pass --trust.
    """
    if not is_trusted():
        raise InputError(key, f"{name} is {what}; if you trust it, pass --trust{otherwise}")
