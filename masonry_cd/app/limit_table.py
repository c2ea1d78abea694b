# SPDX-License-Identifier: GPL-3.0-or-later
"""The keys of the table ``[limit]``: what a limit analysis multiplies, and how it is solved."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, field_validator, model_validator

from loads.kinds.vehicle import VehicleName
from loads.motion import DirectionKey
from masonry_cd.analysis.code_check.site import completed
from masonry_cd.analysis.code_check.table import CheckTable
from masonry_cd.app.scene import Scene
from masonry_cd.foundation.errors import parse_table, suggest
from masonry_cd.foundation.fields import Count, Table
from masonry_cd.foundation.plugins import names
from masonry_cd.foundation.units import Unit

Text = Annotated[str, Field(min_length=1)]
Metres = Annotated[float, Unit("m")]
Place = Annotated[tuple[Metres, Metres, Metres], Field(strict=False)]


def _known(name: str) -> str:
    """A mechanism of ours, or of an installed package."""
    from structures.macro_elements.element import MECHANISMS

    if name not in MECHANISMS and name not in names("mechanisms"):
        every = (*MECHANISMS, *names("mechanisms"))
        raise ValueError(f'unknown mechanism "{name}"{suggest(name, every)}; one of {", ".join(every)}')
    return name


class MechanismTable(Table):
    """A table ``[[limit.mechanism]]``: one of the parts that the kind of the structure names, or a part by group, blocks or box."""

    part: Text | None = None
    """A part by the name that masonry-cd limit --macro-elements gives it: "facade, gable"."""
    group: Text | None = None
    """Or: all blocks of a group."""
    blocks: Annotated[tuple[Text, ...], Field(strict=False, min_length=1)] | None = None
    """Or: these blocks."""
    box: Annotated[tuple[Place, Place], Field(strict=False)] | None = None
    """Or: the blocks whose centres of mass lie between these two corners."""
    name: Text | None = None
    """Name of the part in tables; by default that of its blocks."""
    direction: DirectionKey | None = None
    """Direction of the push; by default those of the part, of other blocks along and against x and y."""
    mechanisms: (
        Annotated[
            tuple[
                Annotated[
                    Literal[
                        "overturning", "vertical bending", "horizontal bending", "corner overturning", "rocking and sliding of piers",
                        "in-plane shear", "hinges of an arch",
                    ]
                    | str,
                    AfterValidator(_known),
                ],
                ...,
            ],
            Field(strict=False, min_length=1),
        ]
        | None
    ) = None  # fmt: skip
    """Mechanisms of rigid bodies, in addition to the free least one, or those of a package; by default those of the part, of other blocks
    overturning and both bendings."""

    @model_validator(mode="after")
    def _one_choice(self) -> MechanismTable:
        given = [name for name in ("part", "group", "blocks", "box") if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"{' and '.join(given) or 'nothing'} given; name the blocks by one of part, group, blocks or box")
        return self


class CurveTable(Table):
    """The table ``[limit.curve]``: the mechanism followed at finite displacements, and the factor that is left."""

    control: Annotated[str, Field(min_length=1)] | None = None
    """Block whose centre of mass is followed along the load; the one that moves fastest when not given."""
    steps: Annotated[Count, Field(ge=10, le=400)] = 40
    """Approximate number of steps from start to end."""
    displacement: Annotated[float, Unit("m"), Field(gt=0.0)] | None = None
    """Displacement of the control block, at which to stop; where the factor vanishes when not given."""


class RatingTable(Table):
    """The table ``[limit.rating]``: the axle loads that a bridge bears with the load factor asked, vehicle by vehicle."""

    factor: Annotated[float, Field(gt=0.0)]
    """Load factor that is required of every vehicle, all partial factors on its load and on its dynamic effect together."""
    vehicles: Annotated[tuple[VehicleName, ...], Field(strict=False, min_length=1)] | None = None
    """Vehicles by name; all of them when not given, and that of the scene if it has axles of its own."""


class ServiceTable(Table):
    """The table ``[limit.service]``: the load factors up to which joints of a bridge need not open, and stresses stay small."""

    factor: Annotated[float, Field(gt=0.0)] = 1.0
    """Load factor of the vehicle in service, which both are to reach."""
    stress: Annotated[float, Field(gt=0.0, le=1.0)] | None = None
    """Share of the compressive strength that joints bear in service at most; stresses are not checked when not given."""


class LimitTable(Table):
    """The table ``[limit]``: what ``masonry-cd limit`` multiplies, and how it solves."""

    push: DirectionKey | None = None
    """Along this direction a body force of lambda times the weight acts on every block."""
    tilt: DirectionKey | None = None
    """Or: to this level direction the structure is tilted, lambda is the tangent of the angle."""
    live: Annotated[tuple[Annotated[Count, Field(ge=0)], ...], Field(json_schema_extra={"default": []})] = ()
    """Or: numbers of the [[loads]] of kind point or vehicle that are multiplied, from 0; the others are constant."""
    masses: Annotated[tuple[Annotated[Count, Field(ge=0)], ...], Field(json_schema_extra={"default": []})] = ()
    """Numbers of the [[loads]] of kind point that are weights of masses, which a push or a tilt moves as it moves the blocks (Q_k of
    [C8.7.1.1]); the others are forces without mass."""
    starts: Annotated[Count, Field(ge=0, le=1000)] | None = None
    """Starts of the search for the least factor of sliding without dilation. When not given: 4 in a plane; in space, where a start solves
    some ten cone programmes, 2 to 4, until two agree, with a check of up to 15,000 contact points and none else."""
    positions: Annotated[Count, Field(ge=3, le=2000)] | None = None
    """Positions tried first for the worst place of a live vehicle without a position; 60 in a plane, 16 in space when
    not given."""
    begin: Annotated[str, Field(min_length=1)] | None = Field(None, alias="from")
    """Folder of a run of these blocks, relative to the scene: the analysis begins where it left them."""
    time: Annotated[float, Unit("s"), Field(ge=0.0)] | None = None
    """Time of that run, the end when not given."""
    check: CheckTable | None = None
    """Check by the kinematic approach of a code, of the mechanism with the least a0* of those that a push or a tilt sets in motion."""
    curve: CurveTable | None = None
    """The capacity curve: the mechanism at finite displacements."""
    rating: RatingTable | None = None
    """Load rating of a bridge whose live load is a vehicle: the axle load of each vehicle at its worst place."""
    service: ServiceTable | None = None
    """Check of a bridge under a vehicle in service: the load factors at which joints have to open, and stresses pass a share of the
    strength."""
    mechanism: Annotated[tuple[MechanismTable, ...], Field(strict=False)] = ()
    """Macro-elements to analyse, each with all other blocks held, [[limit.mechanism]] each."""

    @field_validator("live", "masses", mode="before")
    @classmethod
    def _list(cls, value: object) -> object:
        if not isinstance(value, (list, tuple)):
            raise ValueError("should be a list of numbers of [[loads]], e.g. [0]")
        if len(set(map(str, value))) < len(value):
            raise ValueError("should name each of the [[loads]] once")
        return tuple(value)

    @model_validator(mode="after")
    def _one_pattern(self) -> LimitTable:
        named = [name for name in ("push", "tilt", "live") if getattr(self, name)]
        if len(named) > 1:
            raise ValueError(f"{' and '.join(named)} are given; a limit analysis takes one pattern: one direction at a time")
        if self.time is not None and self.begin is None:
            raise ValueError("time: needs from as well, the folder of a run")
        return self


def limit_table(table: Mapping[str, Any]) -> LimitTable:
    """Check a table ``[limit]``.

    Raises:
        InputError: an unknown key, or a value out of range.
    """
    return parse_table(LimitTable, table, "limit")


def limit_of(scene: Scene) -> LimitTable:
    """Check the table ``[limit]`` of a scene; its hazard gives the check what the site asks for.

    Raises:
        InputError: an unknown key, a value out of range, one that the hazard gives as well, or a hazard that cannot be read.
    """
    check = scene.limit.get("check")
    if not isinstance(check, Mapping) or scene.hazard is None or scene.site is None:
        return limit_table(scene.limit)
    return limit_table({**scene.limit, "check": completed(check, scene.site)})
