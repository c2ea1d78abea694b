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
    """The solution of the contact forces of the steps."""

    name: Annotated[str, "name of the method"] = ""
    threads: Annotated[Count, "number of threads that pays off for the contacts of the run"] = 1
    tolerance: Annotated[Real, "natural map error required in each step"] = 0.0
    seed: Annotated[Count, "seed of random orders"] = 0
    iterations_mean: Annotated[Real, "mean number of iterations of a step"] = 0.0
    iterations_max: Annotated[Count, "largest number of iterations of a step"] = 0
    error_max: Annotated[Real, "largest natural map error of a step"] = 0.0
    error_mean: Annotated[Real, "mean natural map error of a step"] = 0.0
    violation_max: Annotated[Speed | None, "largest velocity that violates the contact laws in a step"] = None
    false_slip_max: Annotated[Metres | None, "largest slip from such velocities, at a contact that friction should have held"] = None
    false_slip_where: Annotated[str, "blocks and time of that slip, if it is large compared with the structure"] = ""
    false_opening_max: Annotated[Metres | None, "largest opening that such a velocity left at a contact"] = None
    steps_missed: Annotated[Count, "steps whose error is above the tolerance"] = 0
    accept: Annotated[Real, "error up to which a step that missed its tolerance is accepted"] = 0.0
    steps_accepted: Annotated[Count, "steps that missed the tolerance and are accepted"] = 0
    reasons: Annotated[dict[str, Count], "reasons why the solver ended steps, with the number of steps; # is a number"] = {}
    error_reached: Annotated[Real | None, "error that 99 % of the steps reached"] = None
    tolerance_sound: Annotated[Real | None, "tolerance below which ensembles of buildings on such joints show no bias"] = None


class IslandCounts(SummaryTable):
    """Islands: groups of blocks that touch each other only through supports."""

    mean: Annotated[Real, "mean number of islands in a step"] = 0.0
    max: Annotated[Count, "largest number of islands in a step"] = 0
    sleeping_mean: Annotated[Real, "mean share of the blocks that slept because they were at rest"] = 0.0


class SkippedWork(SummaryTable):
    """Work that the steps did not need."""

    steps_without_iterations: Annotated[Count, "steps that the impulses of the previous step solved"] = 0
    broad_phases: Annotated[Count, "searches for pairs of blocks that were necessary"] = 0
    pairs_not_looked_at: Annotated[Count, "pairs that could not have met"] = 0
    pairs_with_points_kept: Annotated[Count, "pairs that had not moved, with their points kept"] = 0
    pairs_with_points_found: Annotated[Count, "pairs whose contact points were found"] = 0
    pairs_with_faces_searched: Annotated[Count, "pairs whose faces were searched for those in contact"] = 0


class ClosingSteps(SummaryTable):
    """Steps that left contacts closing, so that overlaps grow."""

    steps: Annotated[Count, "number of such steps"] = 0
    speed_max: Annotated[Speed, "speed of the fastest closing contact"] = 0.0
    jam: Annotated[str, "reason why such steps have no solution; empty if none is known"] = ""


class Energy(SummaryTable):
    """Energies at the end of the run, and the error of their balance."""

    kinetic_end: Annotated[Joules, "kinetic energy"] = 0.0
    elastic: Annotated[Joules, "energy in the springs of joints and in deformed blocks"] = 0.0
    friction: Annotated[Joules, "dissipated by friction"] = 0.0
    impact: Annotated[Joules, "lost in impacts"] = 0.0
    damping: Annotated[Joules, "lost to damping"] = 0.0
    bond: Annotated[Joules, "dissipated by bonds that soften"] = 0.0
    crushing: Annotated[Joules, "dissipated by joints that crush"] = 0.0
    ground: Annotated[Joules, "energy in the springs of the ground below footings"] = 0.0
    radiation: Annotated[Joules, "dissipated by the dashpots of the ground"] = 0.0
    base_work: Annotated[Joules, "work of the supports"] = 0.0
    gravity_work: Annotated[Joules, "work of gravity and of other accelerations of all blocks"] = 0.0
    force_work: Annotated[Joules, "work of forces on blocks"] = 0.0
    change_work: Annotated[Joules, "energy added by changes of the model; negative if they removed energy"] = 0.0
    correction: Annotated[Joules, "work of lifting blocks out of overlaps, which is not part of the balance"] = 0.0
    balance: Annotated[Joules, "work done less stored and dissipated energy"] = 0.0
    balance_error: Annotated[Real, "largest imbalance over the largest work done or kinetic energy"] = 0.0
    balance_max: Annotated[Joules, "largest imbalance"] = 0.0
    at_rest: Annotated[Flag, "the work is too small, compared with the tolerance of the solver, to judge the balance"] = False
    lift_share: Annotated[Real, "work of lifting blocks out of overlaps over the largest work"] = 0.0


class ActedLoad(SummaryTable):
    """The share of a load that has acted by the end of the run."""

    load: Annotated[str, "name of the load by its place in the scene"] = ""
    measure: Annotated[str, "quantity of which the share is taken, such as Arias intensity"] = ""
    share: Annotated[Real, "share that has acted, from 0 to 1"] = 1.0


class BaseMotion(SummaryTable):
    """The motion of the supports."""

    motions: Annotated[Count, "number of different motions"] = 1
    peak_speed: Annotated[Speed, "largest speed of a support"] = 0.0
    end_speed: Annotated[Speed, "largest speed at the end of the loads"] = 0.0
    peak_displacement: Annotated[tuple[Metres, ...], "largest displacement along x, y and z"] = ()
    end_displacement: Annotated[tuple[Metres, ...], "displacement at the end of the loads, along x, y and z"] = ()
    largest_difference: Annotated[Metres, "largest relative displacement of two supports"] = 0.0
    peak_rotation: Annotated[Real, Unit("degrees"), "largest rotation of a support"] = 0.0


class LoadSummary(SummaryTable):
    """The loads that acted on the structure."""

    tables: Annotated[tuple[dict[str, Any], ...], "each load in the order of the scene, with the numbers of its kind"] = ()
    base: Annotated[BaseMotion, "how the supports are driven"] = BaseMotion()
    acted: Annotated[tuple[ActedLoad, ...] | None, "share of each load that has acted"] = None


class TimeStep(SummaryTable):
    """The lengths of adaptive time steps."""

    shortest: Annotated[Seconds, "shortest step"] = 0.0
    median: Annotated[Seconds, "median step"] = 0.0
    longest: Annotated[Seconds, "longest step"] = 0.0
    dt_min: Annotated[Seconds, "shortest step allowed"] = 0.0
    dt_max: Annotated[Seconds, "longest step allowed"] = 0.0
    tolerance: Annotated[Metres, "target of the local error"] = 0.0
    local_error_max: Annotated[Metres, "largest local error of an accepted step"] = 0.0
    repeated_for_error: Annotated[Count, "steps repeated because of their local error"] = 0
    repeated_for_solver: Annotated[Count, "steps repeated because the solver missed its tolerance"] = 0
    steps_wanted_shorter: Annotated[Count, "steps of the shortest length whose error required a shorter one"] = 0
    base_drift_max: Annotated[Metres, "largest distance of a support from its prescribed motion"] = 0.0
    steps_by_length: Annotated[tuple[dict[str, Real], ...], "step lengths dt [s], with the number of steps of each"] = ()


class Beds(SummaryTable):
    """Open joints whose points do not resolve the loaded part of their depth."""

    share_least: Annotated[Real | None, "smallest share of the depth of a joint that carried load; null where no joint was open"] = None
    unresolved: Annotated[Count, "number of joints with too few points"] = 0
    share: Annotated[Real, "share of the depth that carried load in the worst of them"] = 0.0
    points: Annotated[Count, "number of points of the worst joint"] = 0
    resolved: Annotated[Real, "smallest share that these points resolve"] = 0.0
    where: Annotated[str, "blocks of the worst joint"] = ""


ALIKE = 1e-4  # share by which both ends of what Coulomb's law allows may differ and be one


class LimitBracket(SummaryTable):
    """The load factor by limit analysis."""

    least_found: Annotated[Real | None, "least factor without dilation; null where no start of the search converged"] = None
    associated: Annotated[Real | None, "factor with dilation; null where it is not finite"] = None

    @property
    def one(self) -> bool:
        """True where both agree, so that a run can find no other factor."""
        least, upper = self.least_found, self.associated
        return least is not None and upper is not None and upper - least <= ALIKE * abs(upper)


class LoadFactor(SummaryTable):
    """The factor of a push or a tilt that grows."""

    end: Annotated[Real, "factor at the end of the run"] = 0.0
    limit: Annotated[Metres, "displacement beyond which a block counts as moved"] = 0.0
    given_way: Annotated[Real | None, "largest factor that was carried; null where the structure did not fail"] = None
    given_way_time: Annotated[Seconds | None, "time at which it was carried"] = None
    rigid: Annotated[Flag, "the joints are rigid, so that several factors may be possible"] = False
    given_way_displacement: Annotated[Metres | None, "displacement at that time of the block that had moved farthest"] = None
    limit_analysis: Annotated[LimitBracket | None, "factors of limit analysis, of structures with few rigid blocks"] = None


class TieTension(SummaryTable):
    """The tension of a tie."""

    name: Annotated[str, "name of the tie, or of its blocks"] = ""
    blocks: Annotated[tuple[str, ...], "the two blocks that its strongest bar joins"] = ()
    bars: Annotated[Count, "number of its bars"] = 1
    length: Annotated[Metres, "length of its strongest bar"] = 0.0
    area: Annotated[Annotated[Real, Unit("m2")], "area of its section"] = 0.0
    yield_force: Annotated[Newtons | None, "force at which it yields; null where it never yields"] = None
    tension_start: Annotated[Newtons, "tension after the first step"] = 0.0
    tension_max: Annotated[Newtons, "largest tension"] = 0.0
    tension_max_time: Annotated[Seconds, "time of the largest tension"] = 0.0
    stress_max: Annotated[Stress, "largest tension over the section"] = 0.0
    tension_end: Annotated[Newtons, "tension after the last step"] = 0.0
    yielded: Annotated[Flag, "one of its bars yielded"] = False
    yield_time: Annotated[Seconds | None, "time of first yield"] = None


class Check(SummaryTable):
    """A check of the run itself."""

    check: Annotated[str, "name of the check"]
    verdict: Annotated[str, "good, look or doubtful"]
    why: Annotated[str, "reason, with its numbers"]


class RunVerdict(SummaryTable):
    """The verdict on the run."""

    verdict: Annotated[str, "worst verdict of the checks: good, look or doubtful; unknown without checks"] = ""
    grade: Annotated[str, "grade of damage, D0 to D5, or not graded"] = ""
    means: Annotated[str, "meaning of the grade"] = ""
    because: Annotated[str, "measure that gives the grade"] = ""
    sure: Annotated[str, "as the key verdict"] = ""
    words: Annotated[str, "reliability of the grade"] = ""
    why: Annotated[str, "reason for this reliability"] = ""
    checks: Annotated[tuple[Check, ...], "all checks"] = ()


class End(SummaryTable):
    """The motion of the structure at the end."""

    time: Annotated[Seconds, "time of the last frame"] = 0.0
    speed: Annotated[Speed, "speed of the fastest standing block"] = 0.0
    block: Annotated[str, "name of that block"] = ""
    base_speed: Annotated[Speed, "speed of the fastest support"] = 0.0
    rattles: Annotated[str, "loose block that rattles in its place, with its speed"] = ""


class JointCounts(SummaryTable):
    """How many joints opened and slid, and how far."""

    joints_opened: Annotated[Count, "joints whose state is opened"] = 0
    joints_slid: Annotated[Count, "joints whose state is slid"] = 0
    joints_separated: Annotated[Count, "joints without contact at the end"] = 0
    joints_only_opened: Annotated[Count, "joints that opened and did not slide"] = 0
    joints_only_slid: Annotated[Count, "joints that slid and did not open"] = 0
    joints_opened_and_slid: Annotated[Count, "joints that did both"] = 0
    collapsed_blocks: Annotated[Count, "blocks that have fallen"] = 0
    opening_max: Annotated[Metres, "widest opening of a joint at any time"] = 0.0
    sliding_max: Annotated[Metres, "farthest sliding of a joint at any time"] = 0.0


class ShockDamage(JointCounts):
    """The damage after a shock of a sequence and its rest, including that of earlier shocks."""

    name: Annotated[str, "name of the shock"] = ""
    start: Annotated[Seconds, "time of its start"] = 0.0
    end: Annotated[Seconds, "time of its end"] = 0.0
    rest_end: Annotated[Seconds, "time of the end of its rest"] = 0.0
    residual_opening_max: Annotated[Metres, "widest opening after the rest"] = 0.0
    residual_sliding_max: Annotated[Metres, "farthest sliding after the rest"] = 0.0


class Event(SummaryTable):
    """An event of the scene."""

    name: Annotated[str, "name of the event"] = ""
    cause: Annotated[str, "condition for it"] = ""
    change: Annotated[str, "change that it makes"] = ""
    time: Annotated[Seconds | None, "time of the loads at which it came; null where it did not"] = None


class Cycle(SummaryTable):
    """A cycle of a push by displacement, from one passage through zero to the next."""

    begin: Seconds = 0.0
    end: Seconds = 0.0
    displacement_max: Metres = 0.0
    displacement_min: Metres = 0.0
    force_max: Newtons = 0.0
    force_min: Newtons = 0.0
    dissipated: Annotated[Joules, "dissipated energy"] = 0.0
    damping: Annotated[Real, "equivalent viscous damping"] = 0.0


class Bilinear(SummaryTable):
    """The bilinear idealisation of a push by displacement."""

    stiffness: Annotated[Stiffness, "stiffness through 60 % of the peak"] = 0.0
    yield_force: Newtons = 0.0
    yield_displacement: Metres = 0.0
    ultimate_displacement: Metres = 0.0
    ductility: Annotated[Real, "ultimate over yield displacement"] = 0.0


class Push(SummaryTable):
    """A push by displacement, as a laboratory reports it."""

    name: Annotated[str, "name of the push"] = ""
    direction: Annotated[tuple[Real, ...], "unit vector of its direction"] = ()
    energy: Annotated[Joules, "energy put in"] = 0.0
    inertia_share: Annotated[Real, "largest inertia over the largest force"] = 0.0
    cycles: Annotated[tuple[Cycle, ...], "its complete cycles"] = ()
    peak_force: Annotated[Newtons | None, "largest force; null where it met no resistance"] = None
    peak_displacement: Annotated[Metres, "displacement at the peak"] = 0.0
    stiffness: Annotated[Stiffness | None, "stiffness between 10 and 40 % of the peak; null for rigid joints"] = None
    ultimate_displacement: Annotated[Metres | None, "displacement at 80 % of the peak, after it; null if the force stays above that"] = None
    bilinear: Annotated[Bilinear | None, "bilinear idealisation; null for rigid joints"] = None


class Strength(SummaryTable):
    """Stress against the strength of the masonry."""

    least: Annotated[Stress, "least strength of a block"] = 0.0
    blocks_compared: Count = 0
    joints_compared: Count = 0
    ratio_max: Annotated[Real | None, "largest mean stress of a block over its strength"] = None
    blocks_above: Annotated[Count, "blocks whose mean stress is above their strength"] = 0
    blocks_above_names: Annotated[tuple[str, ...], "the most stressed of them"] = ()
    joints_above: Annotated[Count, "joints whose stress at the edge is above their strength"] = 0
    joints_above_open: Annotated[Count, "those that were open at that time"] = 0
    joints_above_numbers: Annotated[tuple[Count, ...], "the most stressed of them"] = ()
    crushed_share_max: Annotated[Real | None, "largest share of a joint that its force occupies at the strength"] = None


class StressPeak(SummaryTable):
    """The largest stresses."""

    compression_max: Stress = 0.0
    compression_max_block: Annotated[str, "block of the largest compression"] = ""
    compression_max_time: Annotated[Seconds, "time of the largest compression"] = 0.0
    tension_max: Annotated[Stress, "largest tension; 0 where it is only rounding"] = 0.0
    tension_max_block: Annotated[str, "block of the largest tension"] = ""
    tension_max_time: Annotated[Seconds, "time of the largest tension"] = 0.0


class ElementStressSummary(StressPeak):
    """Stress of the elements of meshed blocks."""

    count: Annotated[Count, "number of elements"] = 0
    compared: Annotated[Count | None, "elements whose strength is known"] = None
    ratio_max: Annotated[Real | None, "largest ratio of stress to strength"] = None
    above: Annotated[Count, "elements above their strength"] = 0
    blocks_above: Annotated[Count, "blocks of these elements"] = 0
    blocks_above_names: Annotated[tuple[str, ...], "the most stressed of these blocks"] = ()


class StressSummary(StressPeak):
    """Stress of blocks, means over the time between frames, and of joints at their edges."""

    interval: Annotated[Seconds, "time between frames"] = 0.0
    joints_at_edge: Annotated[Count, "joints whose force reached an edge, where rigid joints give no finite stress"] = 0
    joints_at_edge_open: Annotated[Count, "those that were open at that time"] = 0
    edge_max: Annotated[Stress | None, "largest finite compression at the edge of a joint"] = None
    edge_max_joint: Annotated[Count | None, "number of that joint"] = None
    edge_max_blocks: Annotated[tuple[str, ...], "blocks of that joint"] = ()
    strength: Annotated[Strength | None, "comparison with the strength, where it is known"] = None
    elements: Annotated[ElementStressSummary | None, "stress of the elements of meshed blocks"] = None


class PartInShort(SummaryTable):
    """A part of the structure, as in damage.csv; the last row is the structure as a whole."""

    part: Annotated[str, "name of the part"] = ""
    blocks: Annotated[Count, "number of its free blocks"] = 0
    joints: Annotated[Count, "number of its joints"] = 0
    grade: Annotated[str, "grade of damage, D0 to D5, or not graded"] = ""
    grade_label: Annotated[str, "meaning of the grade"] = ""
    grade_reason: Annotated[str, "measure that gives the grade"] = ""
    mechanism: Annotated[str, "mechanism of the damage"] = ""
    opened: Annotated[Count, "joints whose state is opened"] = 0
    slid: Annotated[Count, "joints whose state is slid"] = 0
    separated: Annotated[Count, "joints without contact at the end"] = 0
    lost_blocks: Annotated[Count, "blocks that have fallen"] = 0
    max_opening: Metres = 0.0
    max_sliding: Metres = 0.0
    residual_opening: Metres = 0.0
    residual_sliding: Metres = 0.0
    residual_drift: Annotated[Real, "horizontal displacement over height"] = 0.0
    only_opened: Annotated[Count, "joints that opened and did not slide"] = 0
    only_slid: Annotated[Count, "joints that slid and did not open"] = 0
    opened_and_slid: Annotated[Count, "joints that did both"] = 0
    provisional: Annotated[str, "why the residual values are provisional"] = ""


class ElasticBasis(SummaryTable):
    """The values from which the elastic period was estimated."""

    young: Annotated[Stress, "modulus of elasticity"] = 0.0
    named: Annotated[Flag, "the scene names the masonry"] = False
    direction: Annotated[tuple[Real, ...], "unit vector along which the structure sways"] = ()
