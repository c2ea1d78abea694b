# SPDX-License-Identifier: GPL-3.0-or-later
r"""The crack map: the structure as it stands at a frame, its joints coloured by what is left open and what has slid.

An open joint is a solid band coloured by its opening, a slid one is dashed and coloured by its sliding, in another hue; where both
happened the dashes lie on the band; the dashes of a joint that was crushed are magenta. So a colour-blind reader can distinguish them,
and so can one of a grey print. Cracks within stones are green. The classes of both scales run 1-2-5 from the threshold of damage to
``largest``: equal thresholds give equal colours, and the maps of two runs can be laid side by side; what opened less, a hairline of under
0.1 mm by default, is not a crack. Faces of standing blocks that have parted are dark. Where nothing would be seen at true scale,
displacements relative to the base are drawn amplified by a factor that the sheet states; the shape at rest lies behind as a pale shadow.
A cut takes away what lies before a plane (:mod:`reports.drawing.cut`); the forces are drawn on request (:mod:`reports.maps.thrust`).

The maps of one :class:`Framing` share view, amplification, window and colours: what changes between them is damage.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from masonry_cd.analysis.damage.end_state import end_state
from masonry_cd.analysis.damage.joint_damage import displacement_max, in_words, joint_damage
from masonry_cd.analysis.damage.macro_elements import DamageSnapshot
from masonry_cd.analysis.damage.stones import cracked
from masonry_cd.analysis.deformed import Pose, Solids, solids_of
from masonry_cd.foundation.quantities import force
from masonry_cd.io.layout import CRUSHED
from masonry_cd.io.results import Results
from masonry_cd.mechanics.model.joints import Joints
from reports.drawing import palette
from reports.drawing.bands import DrawnJoints
from reports.drawing.figure import LABELLED, in_metres
from reports.drawing.parts import BEHIND, KeyPanel, Sign, Surface, Ties, painted
from reports.drawing.scene import PictureScene
from reports.drawing.solids import block_layers, fill_layer, structure_window, two_colours, within_sight
from reports.maps.framing import Framing, MapStyle, largest_displacement, view_and_cut
from reports.maps.thrust import ribbons
from reports.ties import ties_at

BAND = 6.0  # width of a closed joint's band [pixels]
BAND_OF_BLOCK = 0.2  # ... but no more than this share of a block's smallest extent
LEAST_BAND = 2.5  # ... and no less than this [pixels]


@dataclass(frozen=True, eq=False)
class MapSubject:
    """Subject of a map at a frame."""

    framed: Framing
    joints: Joints
    solids: Solids
    snapshot: DamageSnapshot
    crushed: np.ndarray  # (J,) bool: shorter for good, of those on blocks that stand
    cracked: np.ndarray  # (J,) bool: planes within stones that are cracked, likewise
    last: bool  # the last frame
    drawn: np.ndarray  # (V, 3) vertices where they are drawn [m]
    ties: Ties
    fill: Surface | None  # of bridges, where it is drawn
    provisional: str = ""  # of the last frame: why it is not the end, as text
    suffered: str = ""  # of the last frame: the damage over all steps, as text

    @classmethod
    def of(cls, results: Results, frame: int, framed: Framing) -> MapSubject:
        """Collect it."""
        solids, thresholds = solids_of(results.blocks), framed.style.thresholds
        snapshot, last, suffered = DamageSnapshot.at(results, frame, thresholds), frame == results.frames - 1, ""
        if last and framed.alone:
            joints = f", {in_words(joint_damage(results, thresholds))}" if results.joints.count else ""
            suffered = f"largest displacement {in_metres(displacement_max(results))}{joints}"
        crushed = snapshot.live & ~snapshot.separated
        crushed &= (results.joints_at(CRUSHED, frame) > 0.0) if results.has_joint_history(CRUSHED) else False
        return cls(
            framed=framed,
            joints=results.joints,
            solids=solids,
            snapshot=snapshot,
            crushed=crushed,
            cracked=snapshot.live & ~snapshot.separated & cracked(results, frame),
            last=last,
            drawn=within_sight(solids, snapshot.pose.moved(solids, solids.vertices, solids.vertex_block, framed.factor)),
            ties=ties_at(results, solids, snapshot.pose, framed.factor),
            fill=fill_at(results, solids, snapshot.pose, framed.factor),
            provisional=end_state(results, thresholds).provisional if last else "",
            suffered=suffered,
        )

    @property
    def pose(self) -> Pose:
        """Where the blocks are."""
        return self.snapshot.pose

    @property
    def largest(self) -> float:
        """Largest displacement of a free block relative to the base at this frame [m]."""
        return largest_displacement(self.pose, self.solids)

    @property
    def has_moved(self) -> bool:
        """Return True if the shape at rest can be seen behind the drawn one."""
        return self.framed.factor * self.largest > 2 * self.framed.pixel

    @property
    def colours(self) -> np.ndarray:
        """(B, 3) of the blocks, 0..1."""
        return two_colours(self.solids, self.snapshot.down, palette.FALLEN, palette.STONE)

    def scene(self, joints: DrawnJoints, colours: np.ndarray, faces: np.ndarray | None = None) -> PictureScene:
        """The blocks in colours (B, 3) over their shape at rest, some faces in others (F, 3), with joints and ties; without words."""
        solids = self.solids  # its free blocks at rest, pale, behind everything: seen only where they have moved away
        pale = painted(palette.SHADOW, len(solids.face_block))
        shadow = Surface(solids.vertices, solids.loops, solids.loop_start, pale, lit=False, place=BEHIND)
        layers = [shadow.some(~solids.fixed[solids.face_block]), *block_layers(self.solids, self.drawn, colours, faces)]
        layers += [self.fill] if self.fill is not None else []
        return PictureScene(self.framed.view, self.framed.window, layers, joints, self.ties, self.framed.cut)

    def drawn_joints(self) -> DrawnJoints:
        """The joints, none shown."""
        return DrawnJoints.at(self.joints, self.solids, self.pose, self.framed.factor, band_width(self.solids, self.framed.pixel))

    def damaged_joints(self) -> DrawnJoints:
        """The joints that are open, that slid, and the faces of separated ones on blocks that stand."""
        snapshot, joints = self.snapshot, self.drawn_joints()
        opening, sliding = (scale(values) for scale, values in zip(self.framed.scales, (snapshot.opening, snapshot.sliding), strict=True))
        opened, slid = snapshot.open[:, None], snapshot.slid[:, None]
        first = np.where(opened, opening, sliding)
        second = np.where(~slid, opening, np.where(opened, sliding, 255))
        first = np.where((self.crushed & ~snapshot.open & ~snapshot.slid)[:, None], 255, first)
        second = np.where(self.crushed[:, None], painted(palette.CRUSHED, 1), second)
        first, second = (np.where(self.cracked[:, None], painted(palette.CRACKED, 1), colour) for colour in (first, second))
        return replace(
            joints,
            shown=snapshot.open | snapshot.slid | self.crushed | self.cracked,
            colours=(first.astype(np.uint8), second.astype(np.uint8)),
            parted=snapshot.separated & ~snapshot.down[joints.blocks],
            plate=painted(palette.PARTED, 1)[0],
        )


def fill_at(results: Results, solids: Solids, pose: Pose, factor: float) -> Surface | None:
    """The fill of bridges, each piece of which moves with the block that it lies on; None where there is none."""
    fill = results.fill
    if fill is None:
        return None
    return fill_layer(fill, lambda points, block: pose.moved(solids, points, block, factor), len(solids.centre))


def crack_scene(results: Results, frame: int, framed: Framing) -> PictureScene:
    """The crack map of a frame."""
    subject = MapSubject.of(results, frame, framed)
    scene = subject.scene(subject.damaged_joints(), subject.colours)
    layers, forces = list(scene.layers), []
    if framed.style.thrust:
        line, largest = ribbons(results, subject.solids, subject.pose, subject.snapshot, frame, framed.factor, framed.view, framed.pixel)
        layers.append(line)
        forces = [
            Sign("band", f"normal force, widest {force(largest)}", (palette.THRUST,)),
            Sign("", "through where it acts in each joint"),
        ]
    key = [*_scales(subject), KeyPanel(_signs(subject)), KeyPanel([*forces, *fill_signs(subject)], ruler=True)]
    return replace(scene, layers=layers, title=results.title or "Crack map", facts=_facts(subject), key=key)


def at_rest(results: Results, style: MapStyle) -> PictureScene:
    """The structure as it was built, without words.

    Raises:
        InputError: no such view or plane.
    """
    solids = solids_of(results.blocks)
    view, cut = view_and_cut(solids, style)
    framed = Framing(style, view, cut, 0.0, structure_window(solids, view), alone=True)
    joints = DrawnJoints.at(results.joints, solids, Pose.of(results, solids, 0), 0.0, band_width(solids, framed.pixel))
    standing = two_colours(solids, np.zeros(len(solids.centre), bool), palette.FALLEN, palette.STONE)
    return PictureScene(view, framed.window, block_layers(solids, within_sight(solids, solids.vertices), standing), joints, cut=cut)


def band_width(solids: Solids, pixel: float) -> float:
    """Return the width of a closed joint [m], for a size of a pixel [m]."""
    smallest = float(np.median(solids.sizes[~solids.fixed].min(axis=1))) if not solids.fixed.all() else np.inf
    return max(LEAST_BAND * pixel, min(BAND * pixel, BAND_OF_BLOCK * smallest))


def _scales(subject: MapSubject) -> list[KeyPanel]:
    """The scales of opening and sliding; of a structure without joints, such as a packing of spheres, none."""
    if not subject.joints.count:
        return [KeyPanel(), KeyPanel()]
    when = "Present" if not (subject.last and subject.framed.alone) else "Provisional" if subject.provisional else "Residual"
    opening, sliding = subject.framed.scales
    return [KeyPanel(scale=(f"{when} opening [mm]", opening)), KeyPanel(scale=(f"{when} sliding [mm]", sliding), dashed=True)]


def _signs(subject: MapSubject) -> list[Sign]:
    """The signs with their numbers; a map that stands alone names only what it shows."""
    snapshot, alone, (opening, sliding) = subject.snapshot, subject.framed.alone, subject.framed.scales
    opened, slid = snapshot.open & ~subject.cracked, snapshot.slid & ~subject.cracked
    both = opened & slid
    joints = [
        Sign("band", f"joint open ({int((opened & ~both).sum())})", (opening.middle,)),
        Sign("band", f"joint slid ({int((slid & ~both).sum())})", (sliding.middle, "#ffffff")),
        Sign("band", f"open and slid ({int(both.sum())})", (opening.middle, sliding.middle)),
        Sign("band", f"separated ({int(snapshot.separated.sum())})", (palette.PARTED,)),
    ]
    if stones := int(subject.cracked.sum()):
        joints.append(Sign("band", f"crack in a stone ({stones})", (palette.CRACKED,)))
    if crushed := int(subject.crushed.sum()):
        joints.append(Sign("band", f"crushed ({crushed})", ("#ffffff", palette.CRUSHED)))
    rows, down, window, solids = joints if subject.joints.count else [], int(snapshot.down.sum()), subject.framed.shown, subject.solids
    x, y = subject.framed.view.plane(subject.drawn).T
    inside = (x > window.left) & (x < window.right) & (y > window.bottom) & (y < window.top)
    seen = np.bincount(solids.vertex_block, inside, minlength=len(solids.centre)) > 0
    outside = int((~seen & ~solids.fixed).sum())
    if down or not alone:
        rows.append(Sign("box", f"fallen block ({down})" + (f", {outside} not in view" if outside else ""), (palette.FALLEN,)))
    return [*rows, *other_signs(subject, always=not alone)]


def other_signs(subject: MapSubject, always: bool = False) -> list[Sign]:
    """Those of the shape at rest, where it is seen or ``always``, and of ties."""
    rows = [Sign("box", "shape at rest", (palette.SHADOW,))] if subject.has_moved or always else []
    ties = len(subject.ties.ends)
    return rows + [Sign("line", "tie, with its tension" if ties <= LABELLED else "tie", (palette.PULLING,))] * bool(ties)


def fill_signs(subject: MapSubject) -> list[Sign]:
    """The entry of fill in the key, where there is some."""
    return [Sign("box", "fill", (palette.FILL,))] if subject.fill is not None else []


def shape_in_words(subject: MapSubject) -> str:
    """View, cut and amplification."""
    framed = subject.framed
    cut = f", cut at {framed.cut.text}" if framed.cut else ""
    return f"{framed.view.name} view{cut} · {'true shape' if framed.factor == 1 else f'displacements × {framed.factor:g}'}"


def _facts(subject: MapSubject) -> str:
    """Time, view, amplification, how far blocks are displaced at this time, and what they suffered, in two lines."""
    return (
        f"t = {subject.pose.time:.4g} s{' (last frame)' if subject.last else ''} · {shape_in_words(subject)}, relative to the base, "
        f"at this time at most {in_metres(subject.largest)}"
        + (f"\nover all time steps: {subject.suffered}" if subject.suffered else "")
        + (f" · {subject.provisional}" if subject.provisional else "")
    )
