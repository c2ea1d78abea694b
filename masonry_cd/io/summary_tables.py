# SPDX-License-Identifier: GPL-3.0-or-later
"""The tables and rows of summary.json (:mod:`masonry_cd.io.summary`): each key with its unit and meaning."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, Strict

from masonry_cd.foundation.fields import Flag
from masonry_cd.foundation.json_files import plain
from masonry_cd.foundation.units import Unit

Real = Annotated[float, Strict(), BeforeValidator(lambda value: math.nan if value is None else value)]
Count = Annotated[int, Strict(), Field(lt=2**53, gt=-(2**53))]  # as a float holds it
Metres = Annotated[Real, Unit("m")]
Speed = Annotated[Real, Unit("m/s")]
Seconds = Annotated[Real, Unit("s")]
Newtons = Annotated[Real, Unit("N")]
Stress = Annotated[Real, Unit("Pa")]
Joules = Annotated[Real, Unit("J")]
Stiffness = Annotated[Real, Unit("N/m")]


class SummaryTable(BaseModel):
    """A table of summary.json; it takes keys that it does not know."""

    model_config = ConfigDict(extra="allow", frozen=True)

    def has(self, name: str) -> bool:
        """True for a key that was written."""
        return name in self.model_fields_set

    def as_dict(self) -> dict[str, Any]:
        """The keys that were written, as JSON has them."""
        return dict(plain(self.model_dump(exclude_unset=True)))


class Solver(SummaryTable):
    """How the contact forces of the steps were found."""

    name: Annotated[str, "the method"] = ""
    threads: Annotated[Count, "number that pays off for the contacts of the run"] = 1
    tolerance: Annotated[Real, "natural map error that each step was to reach"] = 0.0
    seed: Annotated[Count, "of random orders"] = 0
    iterations_mean: Annotated[Real, "of a step"] = 0.0
    iterations_max: Annotated[Count, "of a step"] = 0
    error_max: Annotated[Real, "largest natural map error of a step"] = 0.0
    error_mean: Annotated[Real, "mean natural map error of a step"] = 0.0
    violation_max: Annotated[Speed | None, "fastest motion against the contact laws in a step"] = None
    false_slip_max: Annotated[Metres | None, "slip that such motions have added up to at a contact that friction should have held"] = None
    false_slip_where: Annotated[str, "its blocks and time, where it is large enough against the size of the structure to count"] = ""
    false_opening_max: Annotated[Metres | None, "opening that such a motion has left at a contact"] = None
    steps_missed: Annotated[Count, "steps whose error is above the tolerance"] = 0
    accept: Annotated[Real, "error up to which a step that missed its tolerance is accepted"] = 0.0
    steps_accepted: Annotated[Count, "steps that missed the tolerance and are accepted"] = 0
    reasons: Annotated[dict[str, Count], "why the solver ended its steps, and in how many; # stands for numbers"] = {}
    error_reached: Annotated[Real | None, "error that all but a hundredth of the steps reached"] = None
    tolerance_sound: Annotated[Real | None, "tolerance up to which ensembles of buildings on such joints show no bias"] = None


class IslandCounts(SummaryTable):
    """Groups of blocks that touch one another only through supports."""

    mean: Annotated[Real, "number of them in a step"] = 0.0
    max: Annotated[Count, "largest number of them in a step"] = 0
    sleeping_mean: Annotated[Real, "share of the blocks that slept, since they were at rest"] = 0.0


class SkippedWork(SummaryTable):
    """Work that the steps did not have to do."""

    steps_without_iterations: Annotated[Count, "steps that the impulses of the step before solved"] = 0
    broad_phases: Annotated[Count, "searches for pairs of blocks that were made after all"] = 0
    pairs_not_looked_at: Annotated[Count, "pairs that could not have met"] = 0
    pairs_with_points_kept: Annotated[Count, "pairs that had not moved"] = 0
    pairs_with_points_found: Annotated[Count, "pairs whose contact points were found"] = 0
    pairs_with_faces_searched: Annotated[Count, "pairs whose faces were searched for the touching ones"] = 0


class ClosingSteps(SummaryTable):
    """Steps that left contacts closing, so that overlaps grow."""

    steps: Annotated[Count, "how many"] = 0
    speed_max: Annotated[Speed, "of the fastest contact"] = 0.0
    jam: Annotated[str, "what leaves such steps no solution; empty where nothing is known to"] = ""


class Energy(SummaryTable):
    """Totals at the end of the run, and how well they balance."""

    kinetic_end: Annotated[Joules, "kinetic energy"] = 0.0
    elastic: Annotated[Joules, "energy in springs of joints and in blocks that deform"] = 0.0
    friction: Annotated[Joules, "dissipated by friction"] = 0.0
    impact: Annotated[Joules, "lost in impacts"] = 0.0
    damping: Annotated[Joules, "lost to damping"] = 0.0
    bond: Annotated[Joules, "taken by bonds that soften"] = 0.0
    crushing: Annotated[Joules, "dissipated where joints crush"] = 0.0
    ground: Annotated[Joules, "energy in springs of the ground below footings"] = 0.0
    radiation: Annotated[Joules, "taken by the dashpots of that ground"] = 0.0
    base_work: Annotated[Joules, "work of the supports"] = 0.0
    gravity_work: Annotated[Joules, "work of gravity and of what pulls at all blocks alike"] = 0.0
    force_work: Annotated[Joules, "work of forces on blocks"] = 0.0
    change_work: Annotated[Joules, "energy that changes of the model put in; below zero: took out"] = 0.0
    correction: Annotated[Joules, "work of lifting blocks out of overlaps, which is not part of the balance"] = 0.0
    balance: Annotated[Joules, "what is put in less where it went"] = 0.0
    balance_error: Annotated[Real, "largest imbalance over the largest work done, or kinetic energy reached"] = 0.0
    balance_max: Annotated[Joules, "largest imbalance"] = 0.0
    at_rest: Annotated[Flag, "works stayed below what solving to the tolerance leaves, so that they are no measure"] = False
    lift_share: Annotated[Real, "work of lifting blocks out of overlaps over the largest work"] = 0.0


class ActedLoad(SummaryTable):
    """How much of a load has acted by the end of the run."""

    load: Annotated[str, "its place in the scene"] = ""
    measure: Annotated[str, "what it is a share of, Arias intensity for example"] = ""
    share: Annotated[Real, "from 0 to 1"] = 1.0


class BaseMotion(SummaryTable):
    """How the supports are driven."""

    motions: Annotated[Count, "how many different ones"] = 1
    peak_speed: Annotated[Speed, "largest"] = 0.0
    end_speed: Annotated[Speed, "at the end of the loads"] = 0.0
    peak_displacement: Annotated[tuple[Metres, ...], "largest, along x, y and z"] = ()
    end_displacement: Annotated[tuple[Metres, ...], "at the end of the loads"] = ()
    largest_difference: Annotated[Metres, "by which supports come apart"] = 0.0
    peak_rotation: Annotated[Real, Unit("degrees"), "largest angle by which one turns"] = 0.0


class LoadSummary(SummaryTable):
    """The loads that acted on the structure."""

    tables: Annotated[tuple[dict[str, Any], ...], "each load in the order of the scene, by numbers of its kind"] = ()
    base: Annotated[BaseMotion, "how the supports are driven"] = BaseMotion()
    acted: Annotated[tuple[ActedLoad, ...] | None, "how much of each load has acted"] = None


class TimeStep(SummaryTable):
    """The lengths of steps that adapt."""

    shortest: Annotated[Seconds, "step"] = 0.0
    median: Annotated[Seconds, "step"] = 0.0
    longest: Annotated[Seconds, "step"] = 0.0
    dt_min: Annotated[Seconds, "shortest that is allowed"] = 0.0
    dt_max: Annotated[Seconds, "longest that is allowed"] = 0.0
    tolerance: Annotated[Metres, "local error aimed at"] = 0.0
    local_error_max: Annotated[Metres, "largest local error of a step that stands"] = 0.0
    repeated_for_error: Annotated[Count, "attempts that were undone for their local error"] = 0
    repeated_for_solver: Annotated[Count, "attempts that were undone since the solver missed its tolerance"] = 0
    steps_wanted_shorter: Annotated[Count, "steps of the shortest length whose error asked for a shorter one"] = 0
    base_drift_max: Annotated[Metres, "largest distance of a support from its prescribed motion"] = 0.0
    steps_by_length: Annotated[tuple[dict[str, Real], ...], "lengths dt [s] and how many steps had them"] = ()


class Beds(SummaryTable):
    """The joints whose points do not resolve the part of the depth that carries while they are open."""

    share_least: Annotated[Real | None, "least share of the depth of a joint that carried; null where none was open"] = None
    unresolved: Annotated[Count, "joints that have too few points"] = 0
    share: Annotated[Real, "of the depth of the worst of them that carried"] = 0.0
    points: Annotated[Count, "of the worst"] = 0
    resolved: Annotated[Real, "share that these points resolve"] = 0.0
    where: Annotated[str, "the blocks of the worst"] = ""


ALIKE = 1e-4  # share by which both ends of what Coulomb's law allows may differ and be one


class LimitBracket(SummaryTable):
    """The load factor by limit analysis."""

    least_found: Annotated[Real | None, "least without dilation; null where no start of the search came to an end"] = None
    associated: Annotated[Real | None, "with dilation; null where it is not finite"] = None

    @property
    def one(self) -> bool:
        """True where both agree, so that a run can find no other factor."""
        least, upper = self.least_found, self.associated
        return least is not None and upper is not None and upper - least <= ALIKE * abs(upper)


class LoadFactor(SummaryTable):
    """The factor of a push or a tilt that grows."""

    end: Annotated[Real, "at the end of the run"] = 0.0
    limit: Annotated[Metres, "displacement from which on a block counts as moved"] = 0.0
    given_way: Annotated[Real | None, "largest that was carried; null where the structure had not given way"] = None
    given_way_time: Annotated[Seconds | None, "when it was carried"] = None
    rigid: Annotated[Flag, "joints are rigid, so that several factors may be possible"] = False
    given_way_displacement: Annotated[Metres | None, "of the block that had moved farthest then"] = None
    limit_analysis: Annotated[LimitBracket | None, "of few rigid blocks"] = None


class TieTension(SummaryTable):
    """The tension that a tie had to bear."""

    name: Annotated[str, "its name, or those of its blocks"] = ""
    blocks: Annotated[tuple[str, ...], "that its strongest bar holds, two"] = ()
    bars: Annotated[Count, "of which it consists"] = 1
    length: Annotated[Metres, "of its strongest bar"] = 0.0
    area: Annotated[Annotated[Real, Unit("m2")], "of its section"] = 0.0
    yield_force: Annotated[Newtons | None, "null where it never yields"] = None
    tension_start: Annotated[Newtons, "after the first step"] = 0.0
    tension_max: Annotated[Newtons, "largest"] = 0.0
    tension_max_time: Annotated[Seconds, "when it was largest"] = 0.0
    stress_max: Annotated[Stress, "largest tension over the section"] = 0.0
    tension_end: Annotated[Newtons, "after the last step"] = 0.0
    yielded: Annotated[Flag, "A bar of it yielded"] = False
    yield_time: Annotated[Seconds | None, "from when on"] = None


class Check(SummaryTable):
    """A check that a run makes of itself."""

    check: Annotated[str, "its name"]
    verdict: Annotated[str, "good, look or doubtful"]
    why: Annotated[str, "with its numbers"]


class RunVerdict(SummaryTable):
    """The verdict on the run."""

    verdict: Annotated[str, "of the worst check: good, look or doubtful; unknown without checks"] = ""
    grade: Annotated[str, "of damage, D0 to D5, or not graded"] = ""
    means: Annotated[str, "what the grade means"] = ""
    because: Annotated[str, "what gives the grade"] = ""
    sure: Annotated[str, "as verdict"] = ""
    words: Annotated[str, "how sure the grade is"] = ""
    why: Annotated[str, "what decides how sure it is"] = ""
    checks: Annotated[tuple[Check, ...], "all of them"] = ()


class End(SummaryTable):
    """How the structure moves at the end."""

    time: Annotated[Seconds, "of the last frame"] = 0.0
    speed: Annotated[Speed, "of the fastest block that stands"] = 0.0
    block: Annotated[str, "which block that is"] = ""
    base_speed: Annotated[Speed, "of the fastest support"] = 0.0
    rattles: Annotated[str, "A loose block that moves to and fro in its place, with its speed"] = ""


class JointCounts(SummaryTable):
    """How many joints opened and slid, and how far."""

    joints_opened: Annotated[Count, "joints whose word is opened"] = 0
    joints_slid: Annotated[Count, "joints whose word is slid"] = 0
    joints_separated: Annotated[Count, "joints without contact at the end"] = 0
    joints_only_opened: Annotated[Count, "joints that opened and did not slide"] = 0
    joints_only_slid: Annotated[Count, "joints that slid and did not open"] = 0
    joints_opened_and_slid: Annotated[Count, "joints that did both"] = 0
    collapsed_blocks: Annotated[Count, "blocks that have fallen"] = 0
    opening_max: Annotated[Metres, "widest opening of a joint at any time"] = 0.0
    sliding_max: Annotated[Metres, "farthest sliding of a joint at any time"] = 0.0


class ShockDamage(JointCounts):
    """The damage after a shock of a sequence and its rest, that of earlier ones included."""

    name: Annotated[str, "of the shock"] = ""
    start: Annotated[Seconds, "when it began"] = 0.0
    end: Annotated[Seconds, "when it ended"] = 0.0
    rest_end: Annotated[Seconds, "when its rest was over"] = 0.0
    residual_opening_max: Annotated[Metres, "widest opening after the rest"] = 0.0
    residual_sliding_max: Annotated[Metres, "farthest sliding after the rest"] = 0.0


class Event(SummaryTable):
    """An event of the scene."""

    name: Annotated[str, "of the event"] = ""
    cause: Annotated[str, "when it comes"] = ""
    change: Annotated[str, "what it changes"] = ""
    time: Annotated[Seconds | None, "of the loads at which it came; null where it did not"] = None


class Cycle(SummaryTable):
    """A cycle of a push by displacement, from one passage through zero to the next."""

    begin: Seconds = 0.0
    end: Seconds = 0.0
    displacement_max: Metres = 0.0
    displacement_min: Metres = 0.0
    force_max: Newtons = 0.0
    force_min: Newtons = 0.0
    dissipated: Annotated[Joules, "energy"] = 0.0
    damping: Annotated[Real, "equivalent viscous damping"] = 0.0


class Bilinear(SummaryTable):
    """The bilinear idealisation of a push by displacement."""

    stiffness: Annotated[Stiffness, "through 60 % of the peak"] = 0.0
    yield_force: Newtons = 0.0
    yield_displacement: Metres = 0.0
    ultimate_displacement: Metres = 0.0
    ductility: Annotated[Real, "ultimate over yield displacement"] = 0.0


class Push(SummaryTable):
    """A push by displacement, as a laboratory reports it."""

    name: Annotated[str, "of the push"] = ""
    direction: Annotated[tuple[Real, ...], "unit vector along which it goes"] = ()
    energy: Annotated[Joules, "put in"] = 0.0
    inertia_share: Annotated[Real, "largest inertia over the largest force"] = 0.0
    cycles: Annotated[tuple[Cycle, ...], "whole ones"] = ()
    peak_force: Annotated[Newtons | None, "null where it has met none"] = None
    peak_displacement: Annotated[Metres, "at the peak"] = 0.0
    stiffness: Annotated[Stiffness | None, "between 10 and 40 % of the peak; null of rigid joints"] = None
    ultimate_displacement: Annotated[Metres | None, "after the peak, where 80 % of it are left; null where it does not fall so far"] = None
    bilinear: Annotated[Bilinear | None, "its idealisation; null of rigid joints"] = None


class Strength(SummaryTable):
    """Stress against the strength of the masonry."""

    least: Annotated[Stress, "strength of a block"] = 0.0
    blocks_compared: Count = 0
    joints_compared: Count = 0
    ratio_max: Annotated[Real | None, "largest mean stress of a block over its strength"] = None
    blocks_above: Annotated[Count, "blocks whose mean stress is above their strength"] = 0
    blocks_above_names: Annotated[tuple[str, ...], "the gravest of them"] = ()
    joints_above: Annotated[Count, "joints whose stress at the edge is above their strength"] = 0
    joints_above_open: Annotated[Count, "those of them that were open then"] = 0
    joints_above_numbers: Annotated[tuple[Count, ...], "the gravest of them"] = ()
    crushed_share_max: Annotated[Real | None, "largest share of a joint that its force takes at the strength"] = None


class StressPeak(SummaryTable):
    """The largest stresses."""

    compression_max: Stress = 0.0
    compression_max_block: Annotated[str, "where"] = ""
    compression_max_time: Annotated[Seconds, "when"] = 0.0
    tension_max: Annotated[Stress, "0 where it is no more than rounding"] = 0.0
    tension_max_block: Annotated[str, "where"] = ""
    tension_max_time: Annotated[Seconds, "when"] = 0.0


class ElementStressSummary(StressPeak):
    """Stress of the elements of meshed blocks."""

    count: Annotated[Count, "elements"] = 0
    compared: Annotated[Count | None, "elements whose strength is known"] = None
    ratio_max: Annotated[Real | None, "largest stress over strength"] = None
    above: Annotated[Count, "elements above their strength"] = 0
    blocks_above: Annotated[Count, "blocks that they lie in"] = 0
    blocks_above_names: Annotated[tuple[str, ...], "the gravest of these"] = ()


class StressSummary(StressPeak):
    """Stress of blocks, means over the time between frames, and of joints at their edges."""

    interval: Annotated[Seconds, "between frames"] = 0.0
    joints_at_edge: Annotated[Count, "joints in which the force came to an edge, where rigid joints leave no finite stress"] = 0
    joints_at_edge_open: Annotated[Count, "those of them that were open then"] = 0
    edge_max: Annotated[Stress | None, "largest compression at the edge of a joint that is finite"] = None
    edge_max_joint: Annotated[Count | None, "in which joint"] = None
    edge_max_blocks: Annotated[tuple[str, ...], "its blocks"] = ()
    strength: Annotated[Strength | None, "against the strength, where it is known"] = None
    elements: Annotated[ElementStressSummary | None, "of meshed blocks"] = None


class PartInShort(SummaryTable):
    """A part of the structure, as in damage.csv; the last row is the structure as a whole."""

    part: Annotated[str, "its name"] = ""
    blocks: Annotated[Count, "free ones"] = 0
    joints: Annotated[Count, "that it owns"] = 0
    grade: Annotated[str, "D0 to D5, or not graded"] = ""
    grade_label: Annotated[str, "what the grade means"] = ""
    grade_reason: Annotated[str, "what gives it"] = ""
    mechanism: Annotated[str, "how it gave way"] = ""
    opened: Annotated[Count, "joints whose word is opened"] = 0
    slid: Annotated[Count, "joints whose word is slid"] = 0
    separated: Annotated[Count, "joints without contact at the end"] = 0
    lost_blocks: Annotated[Count, "that have fallen"] = 0
    max_opening: Metres = 0.0
    max_sliding: Metres = 0.0
    residual_opening: Metres = 0.0
    residual_sliding: Metres = 0.0
    residual_drift: Annotated[Real, "horizontal displacement over height"] = 0.0
    only_opened: Annotated[Count, "joints that opened and did not slide"] = 0
    only_slid: Annotated[Count, "joints that slid and did not open"] = 0
    opened_and_slid: Annotated[Count, "joints that did both"] = 0
    provisional: Annotated[str, "why what is left is not the last"] = ""


class ElasticBasis(SummaryTable):
    """The values from which the elastic period was estimated."""

    young: Annotated[Stress, "modulus of elasticity"] = 0.0
    named: Annotated[Flag, "the scene names the masonry"] = False
    direction: Annotated[tuple[Real, ...], "unit vector along which the structure sways"] = ()
