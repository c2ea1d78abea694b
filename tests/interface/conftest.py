# SPDX-License-Identifier: GPL-3.0-or-later
"""Fixtures of the tests of the interface."""

from __future__ import annotations

from typing import Any

import pytest
from two_blocks import two_blocks


@pytest.fixture
def tables() -> dict[str, Any]:
    """Tables of a scene; the blocks are arrays."""
    return two_blocks()
