# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene becomes a case: its blocks and joints are built, its loads summed, all of it is checked, and the kernels are compiled.

Structures and loads are imported inside the functions, when a scene has passed its own checks.
"""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache, cached_property
from typing import TYPE_CHECKING

from masonry_cd.app import time_step_checks
from masonry_cd.app.doubts import doubts, structure_doubts
from masonry_cd.app.output_gauges import gauges_of
from masonry_cd.app.scene import Scene
from masonry_cd.app.staying_support import refuse_turning
from masonry_cd.app.until_still import still_speed, until_still
from masonry_cd.app.warmup import SceneKind, compiling
from masonry_cd.foundation.errors import Fault, InputError, in_plain_words
from masonry_cd.foundation.jit import lost
from masonry_cd.io.gauges import Gauges, GuideGauge
from masonry_cd.mechanics.contact.find_joints import built_gap, find_joints
from masonry_cd.mechanics.dynamics.planar import Plane, find_plane
from masonry_cd.mechanics.dynamics.settings import Run
from masonry_cd.mechanics.dynamics.strain import unknowns_of_strain
from masonry_cd.mechanics.dynamics.system import RunLoads
from masonry_cd.mechanics.model.blocks import Assembly, Block
from masonry_cd.mechanics.model.joint_laws import refuse_in_a_run
from masonry_cd.mechanics.model.joint_laws.restitution import WARNING as RESTITUTION
from masonry_cd.mechanics.model.joints import Joints
from masonry_cd.mechanics.model.link_table import links_of
from masonry_cd.mechanics.model.masonry_kinds import in_words
from masonry_cd.mechanics.model.state import State
from masonry_cd.mechanics.model.strength import strength_by_group
from masonry_cd.mechanics.solvers import cores

if TYPE_CHECKING:
    from loads import Loading
    from loads.acted import Acted
    from loads.motion import LoadAction
    from masonry_cd.app.events import EventTable
    from masonry_cd.mechanics.model.fill import Fill
    from structures import MadeStructure
    from structures.ties import PlacedBar

REPORTED = 1e-8  # share of the smallest width: inexact joints as built are reported from there on; less is rounding
IN_SPACE = 'run.solver "pivoting" is for scenes that move in a plane; in space "interior" stands in for it'
FALLING = "no block of the structure is fixed, so the whole structure falls freely; give it a support"


@dataclass(frozen=True, eq=False)
class Case:
    """A scene whose every part is checked and built; nothing is written yet."""

    scene: Scene
    assembly: Assembly
    joints: Joints
    loading: Loading
    steps: int  # of the loads at most: beyond those of the duration where the run waits for its blocks to be still
    still: float  # speed below which a block counts as still at the end [m/s]
    notes: tuple[str, ...]  # what was changed in making the blocks, as text
    doubts: tuple[str, ...]  # values and blocks that are likely not what is wanted: the verdict on the run has them too
    coarse: tuple[str, ...]  # what the time step is too coarse for; likewise
    aside: tuple[str, ...]  # what changes no result: a machine that is too small
    built_gap: float  # largest gap or overlap of the joints as built that counts as none [m]
    seconds: float  # to build it
    gauges: Gauges  # what is kept in every step besides
    fills: Sequence[Fill] = ()  # of bridges
    events: tuple[EventTable, ...] = ()  # that change the model

    @property
    def reported(self) -> Assembly:
        """The blocks as results have them: supports that an event releases are free blocks, to which nothing is relative."""
        from masonry_cd.app.changes import released

        return released(self.assembly, self.events) if self.events else self.assembly

    @property
    def warnings(self) -> tuple[str, ...]:
        """All that is to be said of the case before it is run."""
        return (*self.doubts, *self.coarse, *self.aside)


@dataclass(frozen=True, eq=False)
class BuiltStructure:
    """Blocks, joints and links: all that ``[structure]``, ``[material]`` and ``[[links]]`` decide, shared by runs whose loads differ."""

    blocks: list[Block]
    notes: tuple[str, ...]  # on what was changed in making them
    bars: Sequence[PlacedBar]  # ties
    assembly: Assembly
    fills: Sequence[Fill] = ()  # of bridges

    @cached_property
    def joints(self) -> Joints:
        """The joints at rest; they take kernels to find."""
        return find_joints(self.assembly)

    @cached_property
    def built_gap(self) -> float:
        """Largest gap or overlap of the joints as built [m]."""
        return built_gap(self.assembly)

    @cached_property
    def falling(self) -> list[str]:
        """Warnings on blocks that nothing carries."""
        from structures.files.supports import HOW
        from structures.standing import standing

        return standing(self.assembly).warnings() if self.assembly.fixed.any() else [f"{FALLING}; of a file, {HOW}"]

    @cached_property
    def leaning(self) -> list[str]:
        """Warnings on walls that do not stand under their fill."""
        from structures.retaining import warnings

        return warnings(self.assembly, self.fills)

    @cached_property
    def odd_size(self) -> list[str]:
        """A line where the structure is so small or large that its unit is likely another."""
        from structures.summary import odd_size

        return odd_size(self.blocks)


def structure_of(scene: Scene) -> BuiltStructure:
    """Build the structure of a scene.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    made = make_structures(scene)
    return replace(assembled(scene, made.blocks, tuple(made.notes), made.ties), fills=made.fills)


def assembled(scene: Scene, blocks: list[Block], notes: tuple[str, ...], bars: Sequence[PlacedBar]) -> BuiltStructure:
    """Blocks with the material of a scene, lines on what was changed in making them, and ties.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    with scene.locating():
        assembly = Assembly.from_blocks(blocks, scene.material)
        return BuiltStructure(blocks, notes, bars, replace(assembly, links=links_of(scene.links, assembly)))


def on_ground(scene: Scene, structure: BuiltStructure) -> BuiltStructure:
    """A structure whose supports stand on the ground of its scene.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    from masonry_cd.app.ground import footings_of, founded, founded_blocks, on_beds

    with scene.locating():
        made = footings_of(scene.ground, structure.assembly)
        notes = (*structure.notes, *(one.line for one in made))
        lifted = next((i for i, table in enumerate(scene.ground) if table.uplift), None)
        if lifted is not None and scene.events:
            raise InputError(f"ground[{lifted}].uplift", "scenes with [[events]] have footings on springs alone")
        on_bed = replace(scene, material=on_beds(scene.material, made))
        whole = assembled(on_bed, founded_blocks(structure.blocks, made), notes, structure.bars)
        return replace(whole, assembly=founded(whole.assembly, made), fills=structure.fills)


def make_structures(scene: Scene) -> MadeStructure:
    """Make the structures of a scene, with its stones in pieces where they crack.

    Raises:
        InputError: with file and line of the scene where a key is at fault.
    """
    import structures

    with scene.locating(), _doubted(scene):
        if not scene.structures:
            made = structures.make(scene.structure, scene.material.block_density, scene.folder)
        else:
            from structures import site

            made = site.build(scene.structures, scene.material.block_density, scene.folder)
    if not scene.material.stones and not any(block.stone for block in made.blocks):
        return made
    from structures.layout.pieces import in_pieces

    with scene.locating():
        return in_pieces(made, scene.material.stones)


@contextmanager
def _doubted(scene: Scene) -> Iterator[None]:
    """Add to the faults of a structure the values of its keys that are likely in another unit, which may be why it is none.

    Faults that know their blocks stay as they are.
    """
    from masonry_cd.app.doubts import key_doubts
    from structures.geometry.checks import Unsound

    try:
        yield
    except InputError as error:
        doubts = [] if isinstance(error, Unsound) else key_doubts(scene)
        if not doubts:
            raise
        raise InputError.of([*error.faults, *(Fault("", line) for line in doubts)]) from None


def prepare(scene: Scene, structure: BuiltStructure | None = None, own: Sequence[LoadAction] = ()) -> Case:
    """Build and check all that a run needs.

    Args:
        scene: whose tables are checked.
        structure: the scene's, where it is built already.
        own: what code in addition to the scene adds to its loads.

    Raises:
        InputError: anything wrong with the structure, the material or the loads.
    """
    import loads
    from masonry_cd.app.limit_table import limit_of

    begin = time.perf_counter()
    scene.refuse_static()
    structure = structure or structure_of(scene)
    built = structure
    if scene.ground:
        structure = on_ground(scene, built)
    scene, lasting = _timed(scene, structure)
    events = _events(scene) if scene.events else ()
    with scene.locating(), _explained(scene, structure):
        if scene.limit:
            from masonry_cd.app.limit_table import limit_of

            limit_of(scene)
        strength_by_group(scene.material.strength, structure.assembly.groups)
        refuse_in_a_run(scene.material.joint_laws, scene.material.joint_moduli)
        if scene.stress:
            scene.refuse_tables("the stress of blocks, which is that by their contacts,", "links")
        if scene.report.asks or scene.report.grades or scene.report.cut:
            from reports import outputs

            outputs.check(scene.report, structure.blocks, scene.run.steps * scene.run.dt, scene.run.frame_every * scene.run.dt)
        assembly, run = structure.assembly, scene.run
        longest = run.longest_step if run.is_adaptive else None
        ties = [(bar.where, bar.load()) for bar in structure.bars]
        loading = loads.build(scene.loads, run.dt, run.steps, run.gravity, scene.folder, assembly, longest, ties, own, structure.fills)
        plane = _plane(assembly, loading, run)
        if plane is not None and any(one.gravity is not None and one.gravity[plane.axis] for one in events):
            scene, plane = replace(scene, run=run.model_copy(update={"planar": False})), None
        strained = unknowns_of_strain(assembly, plane)
    if loading.support_velocity.any() and not assembly.fixed.any():
        remedy = f"; {scene.kind.unsupported}" if scene.kind is not None and scene.kind.unsupported else ""
        raise InputError(scene.origin.path, f"loads: the base is shaken, but no block of the structure is fixed{remedy}")
    if loading.support_of is not None:
        assembly = replace(assembly, support_of=loading.support_of)
    if events:
        assembly, loading = _before_events(scene, events, assembly, loading)
    planar, by_area, spheres = plane is not None, bool(assembly.laws.by_area.any()), bool(assembly.shapes.rounding.any())
    with compiling(SceneKind(scene.run.solver, planar, by_area, scene.stress, strained, spheres)):
        joints, widest = structure.joints, structure.built_gap
    assembly, damping = _damped(scene, assembly, plane)
    failure = lost()
    if failure is not None:
        _say_once(f"compiled kernels could not be kept, the next run compiles them again: {in_plain_words(failure)}")
    gravity = math.hypot(*scene.run.gravity)
    coarse = time_step_checks.before_run(assembly, loading.support_velocity, gravity, scene.run.dt)
    falling = [*built.falling, *built.leaning] if gravity else []
    stands_in = [IN_SPACE] if scene.run.solver == "pivoting" and not planar else []
    unusual = doubts(scene, assembly, joints, loading.summary["tables"])
    thrown = [RESTITUTION] if assembly.restitution.any() else []
    doubtful = (*structure.odd_size, *unusual, *loading.warnings, *falling, *thrown)
    aside = (*stands_in, *_beyond_machine(scene.run.threads))
    masonry = () if scene.material.masonry is None else (in_words(scene.material.masonry),)
    notes = (*structure.notes, *masonry, *damping, *lasting)
    if widest > REPORTED * assembly.width:
        notes = (*notes, f"joints as built have gaps or overlaps of up to {widest:.2g} m, which are ignored")
    still = still_speed(scene.run, joints)
    with scene.locating():
        loading = until_still(scene, loading, still)
    with scene.locating():
        gauges = gauges_of(scene.output, assembly, joints)._replace(guides=_guides(loading, assembly))
        refuse_turning(gauges, assembly, loading.support_velocity, scene.run.dt, joints)
        if events:
            from masonry_cd.app.changes import ChangeableModel
            from masonry_cd.app.events import check_events

            acting = RunLoads(loading.support_velocity, loading.acceleration, loading.forces)
            first = ChangeableModel.of(assembly, acting, scene.tables["material"], scene.run.gravity)
            notes = (*notes, *check_events(events, first, scene.run, gauges, joints))
    steps, seconds = len(loading.acceleration) - 1, time.perf_counter() - begin
    return Case(
        scene, assembly, joints, loading, steps, still, notes, doubtful, tuple(coarse), aside, widest, seconds, gauges,
        structure.fills, events,
    )  # fmt: skip


def _events(scene: Scene) -> tuple[EventTable, ...]:
    from masonry_cd.app.events import parse_events

    with scene.locating():
        return parse_events(scene.events)


def _before_events(scene: Scene, events: Sequence[EventTable], assembly: Assembly, loading: Loading) -> tuple[Assembly, Loading]:
    """Blocks and loads before any event: what one puts in is not there yet."""
    from masonry_cd.app.changes import waiting

    with scene.locating():
        order = sorted(range(len(events)), key=lambda i: events[i].order)
        assembly, out = waiting(assembly, [(f"events[{i}]", events[i]) for i in order])
    return assembly, loading if loading.forces is None else replace(loading, forces=loading.forces.switched(out))


def acting_too(case: Case, acted: Sequence[Acted]) -> Case:
    """A case with what code in addition to the scene adds to its forces: how much of each has acted by a time."""
    return replace(case, loading=replace(case.loading, acted=(*case.loading.acted, *acted))) if acted else case


@contextmanager
def _explained(scene: Scene, structure: BuiltStructure) -> Iterator[None]:
    """Add to a time step that the body refuses the value that likely made it too long, where one is in another unit: a tie 30 m thick."""
    try:
        yield
    except InputError as error:
        of_step = [fault for fault in error.faults if fault.place.startswith("run.dt")]
        unusual = structure_doubts(scene, structure.blocks, ("structure", "structures", "material", "loads")) if of_step else []
        if not unusual:
            raise
        raise error.each(lambda fault: fault._replace(text=f"{fault.text}; {unusual[0]}") if fault in of_step else fault) from None


def _guides(loading: Loading, assembly: Assembly) -> tuple[GuideGauge, ...]:
    """The pushes by displacement and the props of a run."""
    guides = () if loading.forces is None else loading.forces.guides
    return tuple(
        GuideGauge(g.name, "push" if g.velocity.any() else "prop", tuple(g.direction.tolist()), tuple(assembly.names[b] for b in g.blocks))
        for g in guides
    )


def _timed(scene: Scene, structure: BuiltStructure) -> tuple[Scene, list[str]]:
    """The scene with a duration, and a line on it where it follows from the loads.

    Raises:
        InputError: no load says how long it lasts.
    """
    import loads

    if scene.run.has_duration:
        return scene, []
    with scene.locating():
        end, rest = loads.end_of(scene.loads, scene.run.dt, scene.run.gravity, scene.folder, structure.assembly, structure.fills)
        run = scene.run.lasting(end + rest)
    after = f" and a rest of {rest:g} s" if rest else ""
    return replace(scene, run=run), [f"run.duration: not given, {run.duration:.4g} s: to the end of the loads{after}"]


def _damped(scene: Scene, assembly: Assembly, plane: Plane | None) -> tuple[Assembly, list[str]]:
    """The blocks with dashpots that are stated by the first elastic period, and a line on that period.

    Raises:
        InputError: there is no such period.
    """
    if not assembly.laws.at_first_period.any():
        return assembly, []
    from masonry_cd.analysis.modal.first_period import KEY, damped_at_first_period

    with scene.locating():
        damped, period = damped_at_first_period(assembly, None if plane is None else plane.axis)
    share = float(assembly.laws.at_first_period.max())
    return damped, [f"{KEY}: {share:g} of critical at the first elastic period, {period:.4g} s ({1.0 / period:.4g} Hz)"]


@cache
def _say_once(line: str) -> None:
    print(f"masonry-cd: warning: {line}", file=sys.stderr, flush=True)


def _beyond_machine(threads: int | None) -> list[str]:
    """A line where a scene asks for more threads than there are cores; threads change no result, so it runs all the same."""
    there = cores()
    beyond = threads is not None and threads > there
    return [f"run.threads: {threads} requested, {there} used, as many as there are cores for this run"] if beyond else []


def _plane(assembly: Assembly, loading: Loading, settings: Run) -> Plane | None:
    """The plane in which the run will be solved; None: in space."""
    motion = (State.at_rest(assembly), loading.support_velocity, loading.acceleration, loading.forces)
    return find_plane(assembly, *motion) if settings.planar else None
