# SPDX-License-Identifier: GPL-3.0-or-later
r"""The strains of blocks that deform, over a step: six more unknowns of a block in space, three in a plane, and the warps of meshed ones.

With theta of the strains, their mass M, stiffness K and viscosity beta K (``model/deformation.py``), a step goes from (e, e.) to

    e_m = e + h (1 - theta) e.,        e+ = e_m + h theta e.+,

    M (e.+ - e.) = -h K (theta e+ + (1 - theta) e) - h beta K (theta e.+ + (1 - theta) e.) + H^T p,

that is, with  M^ = M + theta h (theta h + beta) K  in the place of M,

    M^ e.+ = M^ e._free + H^T p,        e._free = e. - h M^^-1 K (e + (theta h + beta) e.),

the friction problem of rigid blocks with more unknowns: a stiffness limits no time step, and with K -> infinity the strain vanishes. A
mode too stiff for the step decays by (1 - theta) / theta in each, as one of elastic joints does.

The row of H of a contact at X = x + map Y along t is the rate of X with each strain, along t: with s and y the components of R^T t and Y
in the principal axes of the block, it is

    s_i y_i        for e_ii,        s_i a y_j + s_j (1 - a) y_i        for g_ij, with its share a.

Blocks of one strain and meshed blocks differ in nothing but how many unknowns they have: e stands for the strains and, after them, for the
warps (``model/warping.py``), whose rows are in ``warps.py``. All blocks have room for as many as the largest mesh needs; what a block has
no use for has mass and no stiffness, zeros for its rows, and stays zero.

In a plane the block is free to widen across it: the stresses are plane, and the strain across follows from those in the plane.

**Energy.** The elastic energy e K e / 2 is exact; what viscosity takes, and theta above 1/2, is the work of the force of the step over the
mean of both rates less what the elastic energy gained.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from masonry_cd.foundation.jit import borrower, entry
from masonry_cd.mechanics.dynamics.contact_arrays import ContactRows
from masonry_cd.mechanics.dynamics.planar import Plane
from masonry_cd.mechanics.dynamics.strain_kernels import StrainLaw, fill_free_strains, move_strains, strain_energies
from masonry_cd.mechanics.dynamics.warps import Warps, warps_of
from masonry_cd.mechanics.linalg.small_blocks import inverses, size_tuple
from masonry_cd.mechanics.model.blocks import Assembly
from masonry_cd.mechanics.model.deformation import SHEARS, STRAINS, Deformation
from masonry_cd.mechanics.model.geometry import inverse_row

PAIRS = np.array(SHEARS)  # axes of the shear strains


class StrainArrays(NamedTuple):
    """The D blocks that deform as the kernels read them, with s unknown strains each, and r warps behind them."""

    place: np.ndarray  # (B,) of each block among those that deform; -1: it is rigid
    axes: np.ndarray  # (D, 3, 3) by column, in the body frame
    share: np.ndarray  # (D, 3)
    columns: np.ndarray  # (s,) which of the six strains are unknowns
    warps: int  # r


class StrainWork(NamedTuple):
    """The energies of the strains after a step [J]."""

    kinetic: float = 0.0
    elastic: float = 0.0
    before: float = 0.0  # elastic, before the step
    lost: float = 0.0  # in the step, by viscosity and theta


@dataclass(frozen=True, eq=False)
class Strains:
    """Constants of the strains in steps of one length."""

    deformation: Deformation
    arrays: StrainArrays
    warps: Warps | None  # of meshed blocks
    columns: np.ndarray  # (S,) the s unknown strains and r warps in a row of the state
    free: np.ndarray  # (D,) places among the free blocks
    mass: np.ndarray  # (D, S) diagonal of M [kg m2], of warps [kg]
    stiffness: np.ndarray  # (D, S, S) [J]
    across: np.ndarray  # (D, s) the strain across the plane by those in it; (D, 0) in space
    normal: int  # which strain that is; -1: none
    step: float  # h [s]
    inverse: np.ndarray  # (D, S, S) of M^

    @classmethod
    def of(cls, assembly: Assembly, plane: Plane | None, step: float) -> Strains | None:
        """Those of an assembly in steps of length h [s]; None: all blocks are rigid."""
        deformation = assembly.deformation
        if deformation is None:
            return None
        strains = np.arange(6) if plane is None else np.array([*(d for d in range(3) if d != plane.axis), 3 + plane.axis])
        stiffness = deformation.stiffness[:, strains[:, None], strains]
        across, normal = np.zeros((len(deformation.block), 0)), -1
        if plane is not None:
            normal = plane.axis
            coupling = deformation.stiffness[:, normal, strains]
            across = -coupling / deformation.stiffness[:, normal, normal, None]
            stiffness = stiffness + coupling[:, :, None] * across[:, None, :]
        place = np.full(assembly.count, -1)
        place[deformation.block] = np.arange(len(deformation.block))
        free = (np.cumsum(~assembly.fixed) - 1)[deformation.block]
        mass, warps = deformation.mass[:, strains], Warps.of(assembly, plane, (6 if plane is None else 3) + len(strains))
        count = 0 if warps is None else warps.count
        if warps is not None:
            mass = np.concatenate([mass, np.repeat(assembly.mass[deformation.block, None], count, axis=1)], axis=1)
            stiffness = _with_warps(deformation, warps, strains, stiffness)
        arrays = StrainArrays(place, deformation.axes, deformation.share, strains, count)
        columns = np.concatenate([strains, np.arange(STRAINS, STRAINS + count)])
        mass, stiffness, across = (np.ascontiguousarray(values) for values in (mass, stiffness, across))  # one kind for the kernels, always
        bare = cls(deformation, arrays, warps, columns, free, mass, stiffness, across, normal, step, np.empty(0))
        return bare.with_step(step)

    def with_step(self, step: float) -> Strains:
        """These strains in steps of length h [s], with the inverses (D, S, S) that belong to it."""
        theta, beta = self.deformation.theta, self.deformation.retardation
        implicit = (theta * step * (theta * step + beta))[:, None, None] * self.stiffness
        implicit += self.mass[:, :, None] * np.eye(len(self.columns))
        return replace(self, step=step, inverse=inverses(implicit, self._size()))

    def _size(self) -> tuple[int, ...] | np.ndarray:
        """An object whose length is the number of unknowns S: an array for meshed blocks, so that all meshes share one kernel."""
        return size_tuple(len(self.columns)) if self.warps is None else np.empty(len(self.columns))

    def with_room(self, strain: np.ndarray) -> np.ndarray:
        """Strains (B, 6) of a start, with warps that are zero (B, 6 + r)."""
        return np.pad(strain, ((0, 0), (0, STRAINS + self.arrays.warps - strain.shape[1])))

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Strain rates (D, S) of the blocks that deform, in velocities (F, n) [1/s]."""
        return v[self.free, -len(self.columns) :]

    def set_unknowns(self, out: np.ndarray, values: np.ndarray) -> None:
        """Put values (D, S) in the places of the strain rates among unknowns (F, n)."""
        out[self.free, -len(self.columns) :] = values

    def forces(self, virial: np.ndarray, warped: np.ndarray, rotation: np.ndarray, maps: np.ndarray) -> np.ndarray:
        """Return the forces along the strains, (D, S) [N m]: of sums of force (x) arm (B, 3, 3), with rotations and maps (B, 3, 3).

        ``warped`` (B, r) is what they do along the warps [N].
        """
        own, share = self.deformation.block, self.arrays.share
        back = inverses(maps[own], size_tuple(3))  # arms without the strain, in the body frames
        t = np.einsum("dki,dkl,dml,dmj->dij", self._turned(rotation), virial[own], back, self.arrays.axes)
        i, j = PAIRS.T
        every = np.concatenate([t[:, [0, 1, 2], [0, 1, 2]], share * t[:, i, j] + (1.0 - share) * t[:, j, i]], axis=1)
        return np.concatenate([every[:, self.arrays.columns], warped[own]], axis=1)

    def fastest(self, v: np.ndarray, reach: np.ndarray) -> float:
        """Bound on the speed that strain rates in velocities (F, n) give a point of a block [m/s]; ``reach`` (F,) of free blocks [m]."""
        strains = self.rates(v)[:, : len(self.arrays.columns)]
        fastest = float((np.sqrt((strains**2).sum(axis=1)) * reach[self.free]).max(initial=0.0))
        return fastest if self.warps is None else fastest + self.warps.farthest(self._warp_rates(v))

    def farthest(self, strain: np.ndarray) -> float:
        """Largest warp of a surface in strains (B, 6 + r) [m]."""
        return 0.0 if self.warps is None else self.warps.farthest(strain[:, STRAINS:])

    def at_q_m(self, strain: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Strains (B, 6 + r) at q_m from those at the beginning of the step and the velocities (F, n)."""
        return self._moved(strain, v, (1.0 - self.deformation.theta) * self.step)

    def after(self, at_q_m: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Strains (B, 6 + r) at the end of the step from those at q_m and the new velocities (F, n)."""
        return self._moved(at_q_m, v, self.deformation.theta * self.step)

    def fill_free(self, strain: np.ndarray, v: np.ndarray, inverse_mass: np.ndarray, v_free: np.ndarray) -> None:
        """Fill in what stands for the mass of the strains in M^-1 (F, n, n), and their rates without contact in v_free (F, n).

        From strains (B, 6 + r) and velocities (F, n) at the beginning of the step. The strains of rigid blocks stay zero.
        """
        own = np.full(len(v), -1)
        own[self.free] = np.arange(len(self.free))
        fill_free_strains(self._law, own, strain, v, inverse_mass, v_free)

    def work(self, before: np.ndarray, after: np.ndarray, v: np.ndarray, v_new: np.ndarray) -> StrainWork:
        """The energies over a step between strains (B, 6 + r) and velocities (F, n)."""
        kinetic, elastic, at_start, taken = strain_energies(self._law, before, after, v, v_new)
        return StrainWork(kinetic, elastic, at_start, taken - (elastic - at_start))

    def stretches(self, at_q_m: np.ndarray, v: np.ndarray, v_new: np.ndarray) -> np.ndarray:
        """Strains and warps (D, S) whose elastic force is that of a step, viscosity included.

        Strains (B, 6 + r) at q_m; velocities (F, n) at the beginning and the end of the step.
        """
        theta, h, rate, rate_new = self.deformation.theta, self.step, self.rates(v), self.rates(v_new)
        middle = self._own(at_q_m)
        out = self._mean(middle - (1.0 - theta) * h * rate, middle + theta * h * rate_new)
        return np.asarray(out + self.deformation.retardation[:, None] * self._mean(rate, rate_new))

    def stresses(self, at_q_m: np.ndarray, v: np.ndarray, v_new: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Stress over a step, viscosity included, of the blocks that deform, in the mean of each, (D, 3, 3) [Pa], in the world frame.

        Strains (B, 6 + r) and rotations (B, 3, 3) at q_m; velocities (F, n) at the beginning and the end of the step.
        """
        stretch = self.stretches(at_q_m, v, v_new)
        every = np.zeros((len(stretch), 6))
        work = np.einsum("dij,dj->di", self.stiffness[:, : len(self.arrays.columns)], stretch)  # of the mean stress, on a uniform strain
        every[:, self.arrays.columns] = work / self.deformation.volume[:, None]
        own, (i, j) = np.zeros((len(stretch), 3, 3)), PAIRS.T
        own[:, [0, 1, 2], [0, 1, 2]] = every[:, :3]
        own[:, i, j] = own[:, j, i] = every[:, 3:]
        turn = self._turned(rotation)
        return np.asarray(np.einsum("dik,dkl,djl->dij", turn, own, turn))

    def _mean(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """Return the mean of a quantity that the force of a step takes."""
        theta = self.deformation.theta
        return np.asarray(theta * after + (1.0 - theta) * before)

    def _turned(self, rotation: np.ndarray) -> np.ndarray:
        """Principal axes in the world (D, 3, 3), by column, with rotations (B, 3, 3)."""
        return np.einsum("dij,djk->dik", rotation[self.deformation.block], self.arrays.axes)

    def _own(self, strain: np.ndarray) -> np.ndarray:
        """The unknown strains (D, S) among all (B, 6 + r)."""
        return strain[self.deformation.block[:, None], self.columns]

    def _moved(self, strain: np.ndarray, v: np.ndarray, time: float) -> np.ndarray:
        """Strains (B, 6 + r) moved with velocities (F, n) for a time [s]."""
        out = strain.copy()
        move_strains(self._law, out, v, time)
        return out

    @property
    def _law(self) -> StrainLaw:
        """The constants as the kernels read them."""
        own = self.deformation
        return StrainLaw(
            own.block, self.free, self.columns, self.mass, self.stiffness, self.inverse, self.across, self.normal, own.retardation,
            own.theta, self.step,
        )  # fmt: skip

    def _warp_rates(self, v: np.ndarray) -> np.ndarray:
        """Rates of the warps of all blocks (B, r), in velocities (F, n) [m/s]."""
        out = np.zeros((len(self.arrays.place), self.arrays.warps))
        out[self.deformation.block] = self.rates(v)[:, len(self.arrays.columns) :]
        return out


def unknowns_of_strain(assembly: Assembly, plane: Plane | None) -> int:
    """How many more unknowns each block has than a rigid one; 0: all are rigid.

    Raises:
        InputError: a block cannot be meshed.
    """
    if assembly.deformation is None:
        return 0
    rigid, strains = (6, 6) if plane is None else (3, 3)
    return strains + warps_of(assembly, plane, rigid + strains)


def _with_warps(deformation: Deformation, warps: Warps, strains: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """Stiffness (D, s + r, s + r) of the blocks that deform [J]: ``stiffness`` (D, s, s) for their strains, that of the meshes beyond."""
    s, every = len(strains), np.eye(STRAINS)[strains]
    rooms = [np.broadcast_to(row, (len(warps.of_block), STRAINS)) for row in every]
    gradients = np.stack([deformation.gradients(np.ascontiguousarray(row)) for row in rooms], axis=1)  # (B, s, 3, 3)
    known: dict[tuple[int, bytes, bytes], np.ndarray] = {}
    out = np.zeros((len(stiffness), s + warps.count, s + warps.count))
    for d, b in enumerate(deformation.block):
        if warps.of_block[b] >= 0:
            law = stiffness[d] / deformation.volume[d]
            key = (int(warps.of_block[b]), law.tobytes(), gradients[b].tobytes())
            if key not in known:
                known[key] = warps.stiffness(b, law, gradients[b])
            out[d] = deformation.volume[d] * known[key]
        out[d, :s, :s] = stiffness[d]
    return out


@entry()
def fill_strain_rows(
    arrays: StrainArrays,
    point: np.ndarray,
    position: np.ndarray,
    rotation: np.ndarray,
    maps: np.ndarray,
    plane_axis: int,
    rows: ContactRows,
) -> None:
    """Fill the columns of H of the s strains, see the head of this file; those on rigid blocks become zero.

    Points of all contacts found (., 3) [m]; positions (B, 3) [m], rotations and maps (B, 3, 3) at q_m; ``plane_axis``: -1 in space.
    """
    place, jacobian, frame, s = arrays.place, rows.geometry.jacobian, rows.frame, len(arrays.columns)
    first = jacobian.shape[3] - s - arrays.warps
    arm, inner, along = np.empty(3), np.empty(3), np.empty(3)
    for c in range(len(rows.active)):
        for side in range(2):
            block, sign = rows.blocks[c, side], 1.0 - 2.0 * side
            d = place[block]
            for k in range(3):
                arm[k] = 0.0 if k == plane_axis else point[rows.active[c], k] - position[block, k]
            if d >= 0:
                _in_axes(maps, block, arm, arrays.axes, d, inner)
            for i in range(jacobian.shape[2]):
                if d >= 0:
                    _turned_back(rotation, block, frame[c, i], arrays.axes, d, along)
                for k in range(s):
                    value = _rate_along(along, inner, arrays.share[d], arrays.columns[k]) if d >= 0 else 0.0
                    jacobian[c, side, i, first + k] = sign * value


@borrower()
def _in_axes(maps, block, arm, axes, d, inner):
    """Fill inner (3,) with the place of a point in the principal axes of a block without its strain; ``arm`` (3,) from its centre."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(3):
        rx, ry, rz = inverse_row(maps, block, k)
        value = rx * arm[0] + ry * arm[1] + rz * arm[2]
        x, y, z = x + axes[d, k, 0] * value, y + axes[d, k, 1] * value, z + axes[d, k, 2] * value
    inner[0], inner[1], inner[2] = x, y, z


@borrower()
def _turned_back(rotation, block, unit, axes, d, along):
    """Fill along (3,) with the components of a unit vector (3,) in the principal axes of a block."""
    x, y, z = 0.0, 0.0, 0.0
    for k in range(3):
        value = rotation[block, 0, k] * unit[0] + rotation[block, 1, k] * unit[1] + rotation[block, 2, k] * unit[2]
        x, y, z = x + axes[d, k, 0] * value, y + axes[d, k, 1] * value, z + axes[d, k, 2] * value
    along[0], along[1], along[2] = x, y, z


@borrower()
def _rate_along(along, inner, share, column):
    """How fast a point moves along a direction with strain number ``column``; both (3,) in the principal axes, shares (3,)."""
    if column < 3:
        return along[column] * inner[column]
    i, j = PAIRS[column - 3, 0], PAIRS[column - 3, 1]
    a = share[column - 3]
    return along[i] * a * inner[j] + along[j] * (1.0 - a) * inner[i]
