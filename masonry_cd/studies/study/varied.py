# SPDX-License-Identifier: GPL-3.0-or-later
r"""Variation of a key of the scene: by a list, by an even range, or by a distribution.

    [vary]
    "material.friction" = {distribution = "lognormal", median = 0.6, beta = 0.15}
    "structure.thickness" = [0.35, 0.40, 0.45]
    "loads[0].amplitude" = {from = 0.1, to = 0.4, count = 4}

Distributions are drawn by their quantiles, x = F^-1(u):

    uniform      low + u (high - low)
    normal       mean + std z,                 z = Phi^-1(u)
    lognormal    median exp(beta z)

With ``low`` or ``high`` the last two are truncated: u then runs from F(low) to F(high). Keys of a ``[[correlation]]`` share a Gaussian
copula: z = L w with L L^T = R, R one on its diagonal and rho elsewhere. A uniform one without bounds has the range that the kind of masonry
has for its key. ``from = "posterior.parquet"`` draws rows of a table by their weights: all its keys together.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, model_validator

from masonry_cd.foundation.errors import InputError, parse_table, suggest
from masonry_cd.foundation.fields import Count, Number, Table
from masonry_cd.foundation.files import read_bytes
from masonry_cd.studies.study.study_units import varied_in_si

FROM, WEIGHT = "from", "weight"  # key of [vary] that names a table of samples, and the column of their weights
FAR = 1e-6  # quantile that stands for the end of a distribution without bounds
NEEDED = {"uniform": ("low", "high"), "normal": ("mean", "std"), "lognormal": ("median", "beta")}
ENDS = {"distribution", "from", "to", "count"}  # keys of what varies, which distinguish it from a table of such
OPTIONAL = {"uniform": (), "normal": ("low", "high"), "lognormal": ("low", "high")}


class Even(Table):
    """Numbers at even distances."""

    begin: Annotated[Number, Field(alias="from")]
    """The first."""
    to: Number
    """The last."""
    count: Annotated[Count, Field(ge=2, le=100_000)]
    """How many, both included."""

    def values(self) -> list[Any]:
        """The numbers."""
        return [float(value) for value in np.linspace(self.begin, self.to, self.count)]


class Distribution(Table):
    """A random number."""

    distribution: Literal["uniform", "normal", "lognormal"]
    """Kind of the distribution."""
    low: Number | None = None
    """Lower bound; of a normal or lognormal one, where it is truncated."""
    high: Number | None = None
    """Upper bound."""
    mean: Number | None = None
    """Mean of a normal one."""
    std: Annotated[Number, Field(gt=0)] | None = None
    """Standard deviation of a normal one."""
    median: Annotated[Number, Field(gt=0)] | None = None
    """Median of a lognormal one."""
    beta: Annotated[Number, Field(gt=0)] | None = None
    """Standard deviation of the logarithm of a lognormal one."""

    @model_validator(mode="after")
    def _complete(self) -> Distribution:
        name = self.distribution
        for key in NEEDED[name]:
            if getattr(self, key) is None:
                raise ValueError(f"{key}: missing, a {name} distribution needs it")
        for key in ("low", "high", "mean", "std", "median", "beta"):
            if getattr(self, key) is not None and key not in (*NEEDED[name], *OPTIONAL[name]):
                raise ValueError(f"{key}: does not apply to a {name} distribution")
        if self.low is not None and self.high is not None and not self.low < self.high:
            raise ValueError(f"low {self.low:g} is not below high {self.high:g}")
        if name != "uniform" and not self._ends()[0] < self._ends()[1]:
            raise ValueError("nothing of it lies between low and high")
        return self

    def quantile(self, u: float) -> float:
        """The number that a share ``u`` of all draws lies below; 0 < u < 1."""
        if self.distribution == "uniform":
            assert self.low is not None
            assert self.high is not None
            return self.low + u * (self.high - self.low)
        from scipy.special import ndtri

        below, above = self._ends()
        z = float(ndtri(below + u * (above - below)))
        found = self._at(z)
        return min(max(found, -math.inf if self.low is None else self.low), math.inf if self.high is None else self.high)

    def extremes(self) -> tuple[float, float]:
        """The ends of its range; those that one draw in a million passes where it has none."""
        return self.quantile(FAR if self.low is None else 0.0), self.quantile(1.0 - FAR if self.high is None else 1.0)

    def _at(self, z: float) -> float:
        if self.distribution == "normal":
            assert self.mean is not None
            assert self.std is not None
            return self.mean + self.std * z
        assert self.median is not None
        assert self.beta is not None
        return self.median * math.exp(self.beta * z)

    def _ends(self) -> tuple[float, float]:
        """F(low) and F(high)."""
        from scipy.special import ndtr

        return (0.0 if self.low is None else float(ndtr(self._z(self.low)))), (
            1.0 if self.high is None else float(ndtr(self._z(self.high)))
        )

    def _z(self, x: float) -> float:
        if self.distribution == "normal":
            assert self.mean is not None
            assert self.std is not None
            return (x - self.mean) / self.std
        assert self.median is not None
        assert self.beta is not None
        return math.log(x / self.median) / self.beta if x > 0.0 else -math.inf


class Samples(Table):
    """A random number that is one of N samples."""

    values: tuple[float, ...]
    """Numbers of the samples."""
    below: tuple[float, ...]
    """Weight of each and all before it, up to 1."""

    def quantile(self, u: float) -> float:
        """The sample at which a share ``u`` of all draws ends."""
        return self.values[min(int(np.searchsorted(self.below, u)), len(self.values) - 1)]

    def extremes(self) -> tuple[float, float]:
        """The least and the largest."""
        return min(self.values), max(self.values)


Random = Distribution | Samples


class KeyCorrelation(Table):
    """Keys of ``[vary]`` that vary together."""

    keys: Annotated[list[str], Field(min_length=2)]
    """Keys of distributions."""
    rho: Annotated[Number, Field(gt=-1, lt=1)]
    """Correlation of any two of them, as normal numbers."""


class Varied:
    """All that varies: ``lists`` by key, and ``random`` by key."""

    def __init__(self, lists: Mapping[str, list[Any]], random: Mapping[str, Random], correlations: Sequence[KeyCorrelation]) -> None:
        self.lists, self.random = dict(lists), dict(random)
        self._together = [place for place, one in enumerate(self.random.values()) if isinstance(one, Samples)]
        self._correlations = [(tuple(self.keys.index(key) for key in group.keys), _factor(group)) for group in correlations]

    @property
    def keys(self) -> list[str]:
        """Keys of the distributions, in the order of the file."""
        return list(self.random)

    @property
    def columns(self) -> list[str]:
        """All keys."""
        return [*self.lists, *self.random]

    @property
    def follow(self) -> list[int]:
        """Places of distributions that follow another one: keys of one table of samples the first of them."""
        return self._together[1:]

    def draw(self, u: np.ndarray) -> dict[str, float]:
        """A value for each distribution, from independent numbers (d,) between 0 and 1."""
        from scipy.special import ndtr, ndtri

        u = np.clip(np.array(u, dtype=float), FAR * 1e-3, 1.0 - FAR * 1e-3)
        for places, factor in self._correlations:
            own = list(places)
            u[own] = ndtr(np.sum(factor * ndtri(u[own])[None, :], axis=1))
        u[self.follow] = u[self._together[:1]]
        return {key: self.random[key].quantile(float(value)) for key, value in zip(self.keys, u, strict=True)}


def _factor(group: KeyCorrelation) -> np.ndarray:
    """L of R = L L^T, lower triangular."""
    n = len(group.keys)
    if not group.rho > -1.0 / (n - 1):
        raise InputError("correlation.rho", f"{group.rho:g} is not possible between {n} keys, only above {-1.0 / (n - 1):.3g}")
    return np.linalg.cholesky(np.full((n, n), group.rho) + (1.0 - group.rho) * np.eye(n))


def read_varied(
    table: Mapping[str, Any],
    correlations: Sequence[KeyCorrelation],
    unit_of_key: Callable[[str], str] = lambda _: "",
    folder: Path = Path(),
    ranges: Mapping[str, tuple[float, float]] | None = None,
) -> Varied:
    """Read ``[vary]``.

    Args:
        table: as it stands in the file.
        correlations: between its keys.
        unit_of_key: of the scene, for values that are texts with a unit.
        folder: in which a table of samples is.
        ranges: by key of the scene, of the masonry's kind, where a uniform distribution has no bounds.

    Raises:
        InputError: names the key as ``vary.KEY``.
    """
    lists: dict[str, list[Any]] = {}
    random: dict[str, Random] = {}
    if FROM in table:
        random |= _samples(table[FROM], folder)
    for key, given in varied_in_si(_flat({key: given for key, given in table.items() if key != FROM}), unit_of_key):
        where = f'vary."{key}"'
        if key in random:
            raise InputError(where, f"the table of vary.{FROM} has it, too")
        if isinstance(given, list):
            if not given:
                raise InputError(where, "an empty list")
            lists[key] = given
        elif isinstance(given, Mapping) and "distribution" in given:
            unbound = given["distribution"] == "uniform" and not {"low", "high"} & given.keys()
            own = dict(zip(("low", "high"), (ranges or {})[key], strict=True)) if unbound and key in (ranges or {}) else {}
            random[key] = parse_table(Distribution, {**given, **own}, where)
        elif isinstance(given, Mapping):
            even = parse_table(Even, given, where)
            whole = all(isinstance(given[end], int) for end in ("from", "to")) and all(v == round(v) for v in even.values())
            lists[key] = [round(v) for v in even.values()] if whole else even.values()
        else:
            raise InputError(where, 'should be a list, { from, to, count } or { distribution = "lognormal", ... }')
    for i, group in enumerate(correlations):
        for key in group.keys:
            if not isinstance(random.get(key), Distribution):
                raise InputError(f"correlation[{i}].keys", f'"{key}" is not a distribution of [vary]{suggest(key, random)}')
    named = [key for group in correlations for key in group.keys]
    if len(set(named)) < len(named):
        raise InputError("correlation", "a key is named twice")
    return Varied(lists, random, correlations)


def _samples(name: object, folder: Path) -> dict[str, Random]:
    """The keys of a table of samples, Parquet or CSV, with their values and weights.

    Raises:
        InputError: no such table, or one without weights or with what is not a number.
    """
    from pyarrow import ArrowInvalid, BufferReader, csv, parquet

    where = f"vary.{FROM}"
    if not isinstance(name, str):
        raise InputError(where, 'should be a file, "posterior.parquet"')
    path = folder / name
    try:
        content = BufferReader(read_bytes(path))
        table = csv.read_csv(content) if path.suffix == ".csv" else parquet.read_table(content)
        columns = {key: np.array(table[key].to_pylist(), dtype=float) for key in table.column_names}
    except (OSError, ArrowInvalid, ValueError, TypeError) as failure:
        raise InputError(where, f"{path}: no table of samples that can be read: {failure}") from None
    weight = columns.pop(WEIGHT, np.zeros(0))
    if not (len(weight) and columns and (weight >= 0.0).all() and 0.0 < weight.sum() < math.inf):
        raise InputError(where, f'{path}: should have keys of the scene as columns, and a column "{WEIGHT}" of numbers from 0')
    if not all(np.isfinite(values).all() for values in columns.values()):
        raise InputError(where, f"{path}: has a value that is not a number")
    below = tuple((np.cumsum(weight) / weight.sum()).tolist())
    return {key: Samples(values=tuple(values.tolist()), below=below) for key, values in columns.items()}


def _flat(table: Mapping[str, Any], above: str = "") -> list[tuple[str, Any]]:
    """Keys with dots, whether they were quoted or not: ``material.friction = [...]`` is a table in a table to TOML."""
    found: list[tuple[str, Any]] = []
    for key, value in table.items():
        ends = not isinstance(value, Mapping) or not value or not ENDS.isdisjoint(value)
        found += [(above + key, value)] if ends else _flat(value, f"{above}{key}.")
    return found


def uniform_numbers(seed: int, words: Sequence[object], count: int) -> np.ndarray:
    """Numbers (count,) between 0 and 1 that follow from a seed and from words alone, so that they are the same in whatever order asked."""
    digest = hashlib.sha256(repr((seed, *words)).encode()).digest()
    return np.random.Generator(np.random.PCG64(int.from_bytes(digest[:16], "little"))).random(count)
