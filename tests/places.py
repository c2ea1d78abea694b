# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the checkout is, and what lies in it and next to it."""

from __future__ import annotations

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
SHARED = ROOT.parent / "shared"  # reference data next to the checkout; tests that need them skip where they are absent
