# SPDX-License-Identifier: GPL-3.0-or-later
r"""Observations of a building, and their likelihood where a model predicts something.

    [[observations]]
    what = "frequency"           # [Hz]
    mode = 1
    value = 3.42
    share = 0.02                 # standard deviation of the error, as a share of the value

With a prediction f, a value y and a standard deviation s each observation has a likelihood of its own,

    normal       exp(-(y - f)^2 / (2 s^2))
    lognormal    exp(-(ln y - ln f)^2 / (2 s^2)),     0 where f is not positive
    seen or not  1 - e where the prediction is as seen, e where it is not: once for each block or joint that is named

A shape counts by 1 - MAC, and a history by its relative RMS, of which 0 is observed. An observation without a value is predicted only.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.analysis.fragility.limits import OF_PARTS, QUANTITIES
from masonry_cd.analysis.outputs import STUDY, units_in
from masonry_cd.foundation.errors import suggest
from masonry_cd.foundation.fields import Count, Flag, Number, Table, two_blocks

GAUGE = ("gauge", "joint")
KEYS: Mapping[str, tuple[tuple[tuple[str, ...], ...], tuple[str, ...]]] = {  # groups of which it has one key each, and those it may have
    "frequency": ((("mode", "direction"),), ("modes",)),
    "mode_shape": ((("mode",), ("modes",)), ()),
    "gauge": ((GAUGE, ("column",)), ("at",)),
    "open": ((GAUGE,), ("above", "at")),
    "fallen": ((("blocks",),), ()),
    "quantity": ((("quantity",),), ()),
    "history": ((GAUGE, ("column",), ("file",)), ()),
}
OF_KINDS = ("mode", "direction", "modes", "gauge", "joint", "column", "at", "above", "blocks", "quantity", "file")
SEEN = ("open", "fallen")
MODAL = ("frequency", "mode_shape")
MISFITS = ("mode_shape", "history")  # predicted is how far they are off, and 0 is observed
OPENED = 1e-4  # [m] from which a joint counts as open where nothing else is said
Positive = Annotated[Number, Field(gt=0)]


class Observation(Table):
    """A table ``[[observations]]``."""

    what: Literal["frequency", "mode_shape", "gauge", "open", "fallen", "quantity", "history"]
    """Kind: a natural frequency; a mode shape; a displacement, crack width or force of a gauge; a joint that is open or not; blocks that
    have fallen or not; a column of runs.csv, such as a drift; a measured history of a gauge."""
    name: Annotated[str, Field(min_length=1, max_length=60)] | None = None
    """Name in tables and pictures; made of the other keys when not given."""
    value: Number | Flag | None = None
    """Value that was observed, true or false for open or fallen; without one the observation is predicted only."""
    error: Positive | None = None
    """Standard deviation of measurement and model together, in the unit of the value; of what is seen, the share of wrong answers."""
    share: Positive | None = None
    """Standard deviation as a share of the value instead; for a lognormal error that of the logarithm."""
    spread: Literal["normal", "lognormal"] = "normal"
    """Distribution of the error; lognormal for values that cannot be negative, such as widths."""
    mode: Annotated[Count, Field(ge=1, le=500)] | None = None
    """Number of the mode: of the model, or of the file in ``modes``."""
    direction: Literal["x", "y", "z"] | None = None
    """Direction in which the mode moves more mass than any other, instead of its number."""
    modes: str | None = None
    """File of measured modes: its mode is compared with the one of the model that has the most similar shape, and gives the value."""
    gauge: str | None = None
    """Name of a point, joint, crack or support of [output]."""
    joint: tuple[str, str] | None = Field(None, strict=False)
    """Two blocks whose joint it is, instead of a gauge."""
    column: str | None = None
    """Column of the gauge: "ux" of a point, "opening" or "sliding" of a joint, "opening" or "slip" of a crack, "fz" of a support."""
    at: Literal["end", "largest"] = "end"
    """Instant: the end of the run, or the largest size over all steps."""
    above: Positive = OPENED
    """Opening from which a joint counts as open [m]."""
    blocks: Annotated[list[str], Field(min_length=1)] | None = None
    """Names of blocks that all have fallen, or all have not."""
    quantity: str | None = None
    """Column of runs.csv, as in [limit_states]: "drift", "residual_drift", "max_opening", "PART.drift"."""
    file: str | None = None
    """CSV of a measured history: time, and values under a heading with their unit; resampled to the steps of the run."""

    @model_validator(mode="after")
    def _complete(self) -> Observation:
        if self.joint is not None:
            two_blocks(self.joint)
        needed, more = KEYS[self.what]
        for group in needed:
            if sum(getattr(self, key) is not None for key in group) != 1:
                raise ValueError(f'{group[0]}: "{self.what}" needs {" or ".join(group)}{", one of them" if len(group) > 1 else ""}')
        known = {key for group in needed for key in group} | set(more)
        for key in OF_KINDS:
            if key in self.model_fields_set and key not in known:
                raise ValueError(f'{key}: does not apply to "{self.what}"')
        if self.quantity is not None and self.quantity not in QUANTITIES and not self.quantity.endswith(OF_PARTS):
            raise ValueError(f'quantity: unknown "{self.quantity}"{suggest(self.quantity, QUANTITIES)}; one of {", ".join(QUANTITIES)}')
        self._check_value()
        self._check_error()
        return self

    def _check_value(self) -> None:
        if self.value is not None and isinstance(self.value, bool) != (self.what in SEEN):
            raise ValueError(f'value: "{self.what}" takes {"true or false" if self.what in SEEN else "a number"}')
        if self.value is not None and (self.what in MISFITS or self.modes is not None):
            raise ValueError("value: the file has what was measured")
        if self.modes is not None and self.mode is None:
            raise ValueError("mode: missing, the number of the mode in the file")

    def _check_error(self) -> None:
        if (self.error is None) == (self.share is None):
            raise ValueError("error: give exactly one of error and share")
        if self.what in (*SEEN, *MISFITS) and (self.error is None or self.spread != "normal"):
            raise ValueError(f'error: "{self.what}" takes error alone')
        if self.what in SEEN and not (self.error or 0.0) < 0.5:
            raise ValueError("error: the share of wrong answers, must be below 0.5")
        if self.spread == "lognormal" and (self.share is None or (self.value is not None and self.value <= 0)):
            raise ValueError("spread: lognormal takes a value above 0, and share, the standard deviation of the logarithm")

    @property
    def title(self) -> str:
        """The name, or one made of the other keys."""
        of = (self.joint and " - ".join(self.joint)) or self.gauge or self.quantity or ", ".join(self.blocks or ())
        at = {"end": "", "largest": "largest"}[self.at]
        mode = self.mode and f"mode {self.mode}", self.direction and f"along {self.direction}"
        words = (self.what if self.what not in ("gauge", "quantity") else "", *mode, of, at, self.column)
        return self.name or " ".join(str(word) for word in words if word)

    @property
    def known(self) -> bool:
        """True of what was observed; False of what is predicted only."""
        return self.value is not None

    def deviation(self, around: float) -> float:
        """The standard deviation s, where it is a share that of the value, or of ``around`` where there is none."""
        if self.error is not None:
            return self.error
        assert self.share is not None
        return self.share if self.spread == "lognormal" else self.share * abs(around if self.value is None else float(self.value))

    def off(self, predicted: np.ndarray) -> np.ndarray:
        """Value less predictions (N,) over s, (N,); infinite where a lognormal prediction is not positive."""
        assert self.value is not None
        value, s = float(self.value), self.deviation(float(self.value))
        if self.spread == "normal":
            return np.asarray((value - predicted) / s)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(predicted > 0.0, (np.log(value) - np.log(predicted)) / s, np.inf)

    def log_likelihood(self, predicted: np.ndarray) -> np.ndarray:
        """The logarithm of the likelihood of predictions (N,), (N,); -inf where there is none."""
        if self.what in SEEN:
            assert self.error is not None
            wrong = predicted if not self.value else len(self.blocks or (0,)) - predicted
            right = len(self.blocks or (0,)) - wrong
            found = wrong * np.log(self.error) + right * np.log1p(-self.error)
        else:
            found = -0.5 * self.off(predicted) ** 2
        return np.where(np.isfinite(predicted), found, -np.inf)


def unit_of(table: Mapping[str, Any]) -> str:
    """The unit of a value of a table ``[[observations]]``; empty where it has none."""
    from masonry_cd.analysis.gauge_histories import unit_of_column

    if table.get("what") == "frequency":
        return "Hz"
    return unit_of_column(str(table["column"])) if "column" in table else units_in(STUDY).get(str(table.get("quantity")), "")
