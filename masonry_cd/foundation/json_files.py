# SPDX-License-Identifier: GPL-3.0-or-later
"""Files of JSON that every reader takes: what is not a finite number is null."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from masonry_cd.foundation.atomic import replacing


def write_json(path: Path, found: object, digits: int = 0) -> None:
    """Write a file, with some digits of floats where they are given: a processor that rounds otherwise then writes the same file."""
    with replacing(path) as part:
        part.write_text(as_json(found, digits), encoding="utf-8")


def as_json(found: object, digits: int = 0) -> str:
    """The text of such a file."""
    return json.dumps(plain(found, digits), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def plain(value: Any, digits: int = 0) -> Any:
    """A value as JSON can hold it."""
    if isinstance(value, Mapping):
        return {str(key): plain(one, digits) for key, one in value.items()}
    if isinstance(value, (list, tuple, np.ndarray)):
        return [plain(one, digits) for one in value]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float):
        return None if not math.isfinite(value) else float(f"{value:.{digits}g}") if digits else value
    return value
