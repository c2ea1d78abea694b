r"""The strains of blocks that deform, over a step: six more unknowns of a block in space, three in a plane.

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

In a plane the block is free to widen across it: the stresses are plane, and the strain across follows from those in the plane.

**Energy.** The elastic energy e K e / 2 is exact; what viscosity takes, and theta above 1/2, is the work of the force of the step over the
mean of both rates less what the elastic energy gained.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from masonry_cd.dynamics.contact_arrays import ContactRows
from masonry_cd.dynamics.planar import Plane
from masonry_cd.jit import borrower, entry
from masonry_cd.linalg.small_blocks import inverses, size_tuple
from masonry_cd.model.blocks import Assembly
from masonry_cd.model.deformation import SHEARS, Deformation
from masonry_cd.model.geometry import inverse_row

PAIRS = np.array(SHEARS)  # axes of the shear strains


class StrainArrays(NamedTuple):
    """The D blocks that deform as the kernels read them, with s unknown strains each."""

    place: np.ndarray  # (B,) of each block among those that deform; -1: it is rigid
    axes: np.ndarray  # (D, 3, 3) by column, in the body frame
    share: np.ndarray  # (D, 3)
    columns: np.ndarray  # (s,) which of the six strains are unknowns


class StrainWork(NamedTuple):
    """The energies of the strains after a step [J]."""

    kinetic: float = 0.0
    elastic: float = 0.0
    before: float = 0.0  # elastic, before the step
    lost: float = 0.0  # in the step, by viscosity and theta


@dataclass(frozen=True, eq=False)
class Strains:
    """What is constant of the strains in steps of one length."""

    deformation: Deformation
    arrays: StrainArrays
    free: np.ndarray  # (D,) places among the free blocks
    stiffness: np.ndarray  # (D, s, s) [J]
    across: np.ndarray  # (D, s) the strain across the plane by those in it; (D, 0) in space
    normal: int  # which strain that is; -1: none
    step: float  # h [s]
    inverse: np.ndarray  # (D, s, s) of M^

    @classmethod
    def of(cls, assembly: Assembly, plane: Plane | None, step: float) -> Strains | None:
        """Those of an assembly in steps of length h [s]; None: all blocks are rigid."""
        deformation = assembly.deformation
        if deformation is None:
            return None
        columns = np.arange(6) if plane is None else np.array([*(d for d in range(3) if d != plane.axis), 3 + plane.axis])
        stiffness = deformation.stiffness[:, columns[:, None], columns]
        across, normal = np.zeros((len(deformation.block), 0)), -1
        if plane is not None:
            normal = plane.axis
            coupling = deformation.stiffness[:, normal, columns]
            across = -coupling / deformation.stiffness[:, normal, normal, None]
            stiffness = stiffness + coupling[:, :, None] * across[:, None, :]
        place = np.full(assembly.count, -1)
        place[deformation.block] = np.arange(len(deformation.block))
        free = (np.cumsum(~assembly.fixed) - 1)[deformation.block]
        arrays = StrainArrays(place, deformation.axes, deformation.share, columns)
        bare = cls(deformation, arrays, free, stiffness, across, normal, step, np.empty(0))
        return bare.with_step(step)

    def with_step(self, step: float) -> Strains:
        """The same in steps of length h [s]."""
        theta, beta = self.deformation.theta, self.deformation.retardation
        implicit = (theta * step * (theta * step + beta))[:, None, None] * self.stiffness
        implicit += self.mass[:, :, None] * np.eye(len(self.arrays.columns))
        return replace(self, step=step, inverse=inverses(implicit, size_tuple(len(self.arrays.columns))))

    @property
    def mass(self) -> np.ndarray:
        """(D, s) diagonal of M [kg m2]."""
        return self.deformation.mass[:, self.arrays.columns]

    def rates(self, v: np.ndarray) -> np.ndarray:
        """Strain rates (D, s) of the blocks that deform, in velocities (F, n) [1/s]."""
        return v[self.free, -len(self.arrays.columns) :]

    def set_unknowns(self, out: np.ndarray, values: np.ndarray) -> None:
        """Put values (D, s) in the places of the strain rates among unknowns (F, n)."""
        out[self.free, -len(self.arrays.columns) :] = values

    def forces(self, virial: np.ndarray, rotation: np.ndarray, maps: np.ndarray) -> np.ndarray:
        """What forces do along the strains, (D, s) [N m]: of sums of force (x) arm (B, 3, 3), with rotations and maps (B, 3, 3)."""
        own, share = self.deformation.block, self.arrays.share
        back = inverses(maps[own], size_tuple(3))  # arms without the strain, in the body frames
        t = np.einsum("dki,dkl,dml,dmj->dij", self._turned(rotation), virial[own], back, self.arrays.axes)
        i, j = PAIRS.T
        every = np.concatenate([t[:, [0, 1, 2], [0, 1, 2]], share * t[:, i, j] + (1.0 - share) * t[:, j, i]], axis=1)
        return np.asarray(every[:, self.arrays.columns])

    def fastest(self, v: np.ndarray, reach: np.ndarray) -> float:
        """Bound on the speed that strain rates in velocities (F, n) give a point of a block [m/s]; ``reach`` (F,) of free blocks [m]."""
        return float((np.sqrt((self.rates(v) ** 2).sum(axis=1)) * reach[self.free]).max(initial=0.0))

    def at_q_m(self, strain: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Strains (B, 6) at q_m from those at the beginning of the step and the velocities (F, n)."""
        return self._moved(strain, (1.0 - self.deformation.theta) * self.step * self.rates(v))

    def after(self, at_q_m: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Strains (B, 6) at the end of the step from those at q_m and the new velocities (F, n)."""
        return self._moved(at_q_m, self.deformation.theta * self.step * self.rates(v))

    def free_rates(self, strain: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Strain rates (D, s) at the end of the step without contact, from strains (B, 6) and velocities (F, n) at its beginning."""
        theta, beta, h, rate = self.deformation.theta, self.deformation.retardation, self.step, self.rates(v)
        stretch = h * self._own(strain) + h * (theta * h + beta)[:, None] * rate
        return np.asarray(rate - np.einsum("dij,djk,dk->di", self.inverse, self.stiffness, stretch))

    def work(self, before: np.ndarray, after: np.ndarray, v: np.ndarray, v_new: np.ndarray) -> StrainWork:
        """The energies over a step between strains (B, 6) and velocities (F, n)."""
        e, e_new, rate, rate_new = self._own(before), self._own(after), self.rates(v), self.rates(v_new)
        stretch = self._mean(e, e_new) + self.deformation.retardation[:, None] * self._mean(rate, rate_new)
        taken = 0.5 * self.step * float(np.einsum("di,dij,dj->", rate + rate_new, self.stiffness, stretch))
        elastic = [0.5 * float(np.einsum("di,dij,dj->", each, self.stiffness, each)) for each in (e, e_new)]
        return StrainWork(0.5 * float((self.mass * rate_new**2).sum()), elastic[1], elastic[0], taken - (elastic[1] - elastic[0]))

    def stresses(self, at_q_m: np.ndarray, v: np.ndarray, v_new: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Stress over a step, viscosity included, of the blocks that deform, (D, 3, 3) [Pa], in the world frame.

        Strains (B, 6) and rotations (B, 3, 3) at q_m; velocities (F, n) at the beginning and the end of the step.
        """
        theta, h, rate, rate_new = self.deformation.theta, self.step, self.rates(v), self.rates(v_new)
        middle = self._own(at_q_m)
        stretch = self._mean(middle - (1.0 - theta) * h * rate, middle + theta * h * rate_new)
        stretch += self.deformation.retardation[:, None] * self._mean(rate, rate_new)
        every = np.zeros((len(middle), 6))
        every[:, self.arrays.columns] = np.einsum("dij,dj->di", self.stiffness, stretch) / self.deformation.volume[:, None]
        own, (i, j) = np.zeros((len(middle), 3, 3)), PAIRS.T
        own[:, [0, 1, 2], [0, 1, 2]] = every[:, :3]
        own[:, i, j] = own[:, j, i] = every[:, 3:]
        turn = self._turned(rotation)
        return np.asarray(np.einsum("dik,dkl,djl->dij", turn, own, turn))

    def _mean(self, before: np.ndarray, after: np.ndarray) -> np.ndarray:
        """What the force of a step takes of a quantity."""
        theta = self.deformation.theta
        return np.asarray(theta * after + (1.0 - theta) * before)

    def _turned(self, rotation: np.ndarray) -> np.ndarray:
        """Principal axes in the world (D, 3, 3), by column, with rotations (B, 3, 3)."""
        return np.einsum("dij,djk->dik", rotation[self.deformation.block], self.arrays.axes)

    def _own(self, strain: np.ndarray) -> np.ndarray:
        """The unknown strains (D, s) among all (B, 6)."""
        return strain[self.deformation.block[:, None], self.arrays.columns]

    def _moved(self, strain: np.ndarray, by: np.ndarray) -> np.ndarray:
        """Strains (B, 6) with the unknown ones changed by (D, s)."""
        out = strain.copy()
        own = self._own(strain) + by
        out[self.deformation.block[:, None], self.arrays.columns] = own
        if self.normal >= 0:
            out[self.deformation.block, self.normal] = (self.across * own).sum(axis=1)
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
    """Fill the last s columns of H of all contacts, see the head of this file; those on rigid blocks become zero.

    Points of all contacts found (., 3) [m]; positions (B, 3) [m], rotations and maps (B, 3, 3) at q_m; ``plane_axis``: -1 in space.
    """
    place, jacobian, frame, s = arrays.place, rows.jacobian, rows.frame, len(arrays.columns)
    first = jacobian.shape[3] - s
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
    for i in range(3):
        along[i] = 0.0
        for k in range(3):
            for l in range(3):  # noqa: E741
                along[i] += axes[d, k, i] * rotation[block, l, k] * unit[l]


@borrower()
def _rate_along(along, inner, share, column):
    """How fast a point moves along a direction with strain number ``column``; both (3,) in the principal axes, shares (3,)."""
    if column < 3:
        return along[column] * inner[column]
    i, j = PAIRS[column - 3, 0], PAIRS[column - 3, 1]
    a = share[column - 3]
    return along[i] * a * inner[j] + along[j] * (1.0 - a) * inner[i]
