# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the parts of a bridge lie along the road, and what does not fit together: all of it at once, by span and place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from masonry_cd.foundation.errors import Faults, InputError
from structures.bridge.profile import SpanProfile, profile_of, rise_of, voussoirs_of
from structures.bridge.table import BridgeSupportTable, BridgeTable, SpanTable

COVER = 0.3  # of fill over the highest crown, by default [m]
LEAST_COVER = 0.02  # [m]: of walls thinner than this over a crown nothing could be cut
SAME = 1e-9  # [m]
LEAST_COURSE = 0.3  # of its course height: between two skewbacks of a pier there is no level course lower than this


@dataclass(frozen=True, eq=False)
class BridgeSupport:
    """A pier or an abutment in the x-z plane, with the joints on which arches stand."""

    name: str
    keys: BridgeSupportTable
    left: float  # x of its faces [m]
    right: float
    foot: float  # z [m]
    before: SpanProfile | None  # the arch that ends on it; None of a left abutment
    after: SpanProfile | None  # that begins on it
    shelf: float = 0.0  # of a pier that goes on next to its lower springing: depth of the bed on which a wall stands there, at most [m]

    @property
    def seats(self) -> tuple[np.ndarray, np.ndarray]:
        """Ends of the extrados on it (2,) from the left, or the back of an abutment at the height of the other [m]."""
        first = None if self.before is None else self.before.extrados[-1]
        last = None if self.after is None else self.after.extrados[0]
        if first is None:
            assert last is not None
            first = np.array([self.left, last[1]])
        return first, np.array([self.right, first[1]]) if last is None else last

    @property
    def springing(self) -> float:
        """The lower of its springings [m]."""
        return min(float(arch.intrados[end, 1]) for arch, end in ((self.before, -1), (self.after, 0)) if arch is not None)

    @property
    def rise(self) -> tuple[float, float] | None:
        """Heights between which a pier goes on next to its lower springing: from the skewback there to the foot of the other one [m].

        None where the skewbacks lie next to each other, or where only a thin slab would fit between.
        """
        if self.before is None or self.after is None:
            return None
        low, high = sorted((self.before.intrados[-1, 1], self.after.intrados[0, 1]))
        top = float(min(end[1] for end in self.seats))
        between = float(high) - top
        fits = abs(between) <= SAME or between >= LEAST_COURSE * self.keys.course_height
        return (top, float(high)) if high - low > SAME and fits else None

    @property
    def split(self) -> float:
        """x of the line between what rests on the one side and on the other [m]; of an abutment its back."""
        if self.before is None or self.after is None:
            return self.left if self.before is None else self.right
        (x0, z0), (x1, z1) = (end.tolist() for end in self.seats)
        shelf = 0.5 * (x1 - x0) if self.rise is None else min(self.shelf, 0.5 * (x1 - x0))
        return float(x1 - shelf if z1 < z0 else x0 + shelf)


@dataclass(frozen=True, eq=False)
class BridgeLayout:
    """A bridge along the road."""

    keys: BridgeTable
    profiles: tuple[SpanProfile, ...]
    supports: tuple[BridgeSupport, ...]  # abutment, piers, abutment
    deck: float  # level of the road [m]

    @cached_property
    def slant(self) -> float:
        """Tangent of the skew: x of a block grows by so much with y."""
        return math.tan(math.radians(self.keys.skew)) if self.keys.skew else 0.0

    @property
    def ends(self) -> tuple[float, float]:
        """x of the backs of the abutments [m]."""
        return self.supports[0].left, self.supports[-1].right

    @property
    def clear(self) -> float:
        """Half the width between the walls [m]."""
        return 0.5 * self.keys.width - (0.0 if self.keys.walls is None else self.keys.walls.thickness)

    def backing_level(self, support: BridgeSupport) -> float:
        """Up to where there is backing over a support [m]."""
        return support.springing + (self.keys.backing.height if self.keys.backing else 0.0)


def layout_of(keys: BridgeTable) -> BridgeLayout:
    """Put the spans on their supports.

    Raises:
        InputError: all measures that do not fit together, a line each.
    """
    faults = Faults()
    sound = [i for i, span in enumerate(keys.spans) if _is_sound(span, f"structure.spans[{i}]", faults)]
    _check_counts(keys, faults)
    _check_overlaps(keys.spans, _lefts(keys), faults)
    if not faults.found:
        made = laid_out(keys)
        _check_seats(made, faults)
        _check_deck(made, faults)
        _check_backing(made, faults)
    elif keys.deck is not None:
        _check_below(keys, keys.deck, [(i, profile_of(keys.spans[i], 0.0)) for i in sound], faults)
    _check_walls(keys, faults)
    faults.refuse()
    return made


def laid_out(keys: BridgeTable) -> BridgeLayout:
    """The spans of sound keys on their supports."""
    profiles = [profile_of(span, left) for span, left in zip(keys.spans, _lefts(keys), strict=True)]
    return BridgeLayout(keys, tuple(profiles), tuple(_supports(keys, profiles)), _deck(keys, profiles))


def _is_sound(span: SpanTable, where: str, faults: Faults) -> bool:
    """Return True if nothing is wrong with one span; adds what is to the faults."""
    half, rise, before = 0.5 * span.span, span.rise, len(faults.found)
    named = f"of {'an' if span.shape == 'elliptical' else 'a'} {span.shape} span"
    if rise is None and span.shape in ("segmental", "elliptical"):
        faults.add(f"{where}.rise", f"missing; a {span.shape} span is given by its span and its rise")
    if rise is not None and span.shape in ("segmental", "elliptical") and rise > half * (1.0 + SAME):
        faults.add(f"{where}.rise", f"{named} must be at most half the span, {half:g} m, got {rise:g}; a pointed one rises more")
    if rise is not None and span.shape == "semicircular" and abs(rise - half) > 1e-6 * half:
        faults.add(f"{where}.rise", f"{named} is half the span, {half:g} m, got {rise:g}; leave it out, or make it segmental")
    if span.shape == "pointed" and (rise is None or rise <= half):
        faults.add(f"{where}.rise", f"{named} must exceed half the span, {half:g} m, got {'none' if rise is None else f'{rise:g}'}")
    thickest = max(span.thickness, span.thickness_springing or 0.0)
    if thickest >= half:
        faults.add(f"{where}.thickness", f"must be below half the span, {half:g} m, got {thickest:g}")
    if rise is not None and rise < 0.02 * span.span:
        faults.add(f"{where}.rise", f"must be at least a fiftieth of the span, {0.02 * span.span:g} m, got {rise:g}")
    if span.shape == "pointed" and span.voussoirs is not None and span.voussoirs % 2:
        faults.add(f"{where}.voussoirs", f"{named} must be even, it has a joint at its apex; got {span.voussoirs}")
    if len(faults.found) == before and rise_of(span) and voussoirs_of(span) * span.rings > 8000:
        faults.add(f"{where}.rings", f"{span.rings} of {voussoirs_of(span)} voussoirs are too many")
    if len(faults.found) == before:
        try:
            profile_of(span, 0.0)
        except InputError as error:
            faults.found += [fault._replace(place=fault.place.replace("structure", where, 1)) for fault in error.faults]
    return len(faults.found) == before


def _check_counts(keys: BridgeTable, faults: Faults) -> None:
    """Supports that are too few or too many, and two ways to say one thing."""
    between = len(keys.spans) - 1
    if len(keys.piers) not in ({0, 1} if between == 0 else {1, between}):
        wanted = f"one for all, or one between each two of {len(keys.spans)} spans, {between}"
        faults.add("structure.piers", f"{wanted}; got {len(keys.piers)}")
    if keys.cover is not None and keys.deck is not None:
        faults.add("structure.deck", "give the level of the road or the cover over the highest crown, not both")
    gone, active = keys.fill.gone_at, keys.fill.active_at
    if gone is not None and gone <= active:
        faults.add("structure.fill.gone_at", f"must exceed active_at, {active:g}, got {gone:g}")


def _pier(keys: BridgeTable, number: int) -> BridgeSupportTable:
    """A pier by its number; of too few the last one, or one of the default measures, so that other faults are found as well."""
    known = keys.piers or (BridgeSupportTable.model_validate({}),)
    return known[0 if len(known) == 1 else min(number, len(known) - 1)]


def _lefts(keys: BridgeTable) -> list[float]:
    """x of the left springings [m]."""
    lefts = list[float]()
    for i, span in enumerate(keys.spans):
        behind = lefts[-1] + keys.spans[i - 1].span + _pier(keys, i - 1).width if i else 0.0
        lefts.append(behind if span.start is None else span.start)
    return lefts


def _check_overlaps(spans: Sequence[SpanTable], lefts: Sequence[float], faults: Faults) -> None:
    """Spans that begin where others have not ended."""
    for i in range(1, len(spans)):
        end = max(lefts[j] + spans[j].span for j in range(i))
        if lefts[i] < end + SAME:
            at = f"x = {lefts[i]:g} m, where a span before it reaches to x = {end:g} m"
            faults.add(f"structure.spans[{i}].start", f"span {i + 1} begins at {at}: they overlap, or leave no pier")


def _supports(keys: BridgeTable, profiles: Sequence[SpanProfile]) -> list[BridgeSupport]:
    first, last = keys.abutments[0], keys.abutments[-1]
    x, low = profiles[0].intrados[0]
    shelf = 0.0 if keys.walls is None else keys.walls.course_height
    made = [BridgeSupport("abutment1", first, float(x) - first.width, float(x), float(low) - first.height, None, profiles[0])]
    for i in range(len(profiles) - 1):
        (left, one), (right, other) = profiles[i].intrados[-1], profiles[i + 1].intrados[0]
        foot = float(min(one, other)) - _pier(keys, i).height
        made.append(BridgeSupport(f"pier{i + 1}", _pier(keys, i), float(left), float(right), foot, profiles[i], profiles[i + 1], shelf))
    x, low = profiles[-1].intrados[-1]
    made.append(BridgeSupport("abutment2", last, float(x), float(x) + last.width, float(low) - last.height, profiles[-1], None))
    return made


def _deck(keys: BridgeTable, profiles: Sequence[SpanProfile]) -> float:
    highest = max(profile.crown for profile in profiles)
    return highest + (COVER if keys.cover is None else keys.cover) if keys.deck is None else keys.deck


def _check_seats(made: BridgeLayout, faults: Faults) -> None:
    """Supports that are too narrow for what stands on them, or too low for the step between two springings."""
    for i, support in enumerate(made.supports):
        first, last = support.seats
        pier = support.before is not None and support.after is not None
        if first[0] > last[0] + SAME or (not pier and last[0] - first[0] < SAME):
            least = support.right - support.left + float(first[0] - last[0])
            where = f"structure.piers[{0 if len(made.keys.piers) == 1 else i - 1}]" if pier else "structure.abutments"
            at = f"{support.name}, from x = {support.left:g} to {support.right:g} m"
            faults.add(f"{where}.width", f"{at}, must be wider than {least:.4g} m for the springings that it bears")
        if support.before and support.after:
            step = abs(float(support.before.intrados[-1, 1] - support.after.intrados[0, 1]))
            if step > SAME and step > support.keys.height * 10.0:
                faults.add(f"structure.spans[{i}].springing", f"{step:g} m from that of the span before it, more than {support.name} bears")


def _check_deck(made: BridgeLayout, faults: Faults) -> None:
    """A road below an extrados, or below where one springs."""
    before = len(faults.found)
    _check_below(made.keys, made.deck, list(enumerate(made.profiles)), faults)
    highest = max(float(end[1]) for support in made.supports for end in support.seats)
    if len(faults.found) == before and made.deck <= highest:
        key = "cover" if made.keys.deck is None else "deck"
        faults.add(f"structure.{key}", f"the fill ends at {made.deck:g} m, below the springings at {highest:.4g} m")


def _check_backing(made: BridgeLayout, faults: Faults) -> None:
    """Backing that ends below where a span springs, or above a crown."""
    for support in made.supports if made.keys.backing is not None else ():
        least = max(float(end[1]) for end in support.seats) - support.springing
        most = min(arch.crown for arch in (support.before, support.after) if arch is not None) - support.springing
        if not least + LEAST_COVER <= made.backing_level(support) - support.springing <= most - LEAST_COVER:
            between = f"{least + LEAST_COVER:.4g} m, above its skewbacks, and {most - LEAST_COVER:.4g} m, below the crowns"
            faults.add("structure.backing.height", f"must be between {between}, over {support.name}")


def _check_below(keys: BridgeTable, deck: float, profiles: Sequence[tuple[int, SpanProfile]], faults: Faults) -> None:
    """A road below the extrados of spans, by their numbers."""
    key, lefts = "cover" if keys.deck is None else "deck", _lefts(keys)
    for i, profile in profiles:
        if deck < profile.crown + LEAST_COVER:
            highest = float(profile.extrados[int(np.argmax(profile.extrados[:, 1])), 0])
            place = lefts[i] + highest - float(profile.intrados[0, 0])
            above = f"{LEAST_COVER:g} m or more above the extrados of span {i + 1}, {profile.crown:.4g} m at x = {place:.4g} m"
            faults.add(f"structure.{key}", f"the fill ends at {deck:g} m, which must be {above}")


def _check_walls(keys: BridgeTable, faults: Faults) -> None:
    """Walls that leave no road between them."""
    walls = keys.walls
    if walls is None:
        return
    if 2.0 * walls.thickness >= keys.width:
        faults.add("structure.walls.thickness", f"two of {walls.thickness:g} m leave no road on a width of {keys.width:g} m")
    if walls.parapet_thickness is not None and walls.parapet_height is None:
        faults.add("structure.walls.parapet_height", "missing; it makes the parapets whose thickness is given")
    if walls.parapet_thickness is not None and walls.parapet_thickness > walls.thickness:
        faults.add("structure.walls.parapet_thickness", f"must be at most that of the walls, {walls.thickness:g} m")
