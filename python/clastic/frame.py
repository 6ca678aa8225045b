"""The specimen at one moment."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import _engine

if TYPE_CHECKING:
    import pandas

Floats = NDArray[np.float64]
#: Lower left and upper right corner, m: x0, y0, x1, y1.
Box = tuple[float, float, float, float]

#: Words for the column ``state`` of pairs.
STATES = ("contact", "bond", "broken in tension", "broken in shear", "broken in rolling")
#: Sectors of a rose over half a turn.
SECTORS = 18
_NONE = np.iinfo(np.uint32).max


class Fabric(NamedTuple):
    """Directions of the contacts between disks that carry compression (Rothenburg and Bathurst,
    Geotechnique 39, 1989).
    """

    #: Number of contacts.
    contacts: int
    #: Mean number of contacts of a disk, 2 N_c / N.
    coordination: float
    #: Fabric tensor, the mean of n n, shape (2, 2).
    tensor: Floats
    #: Anisotropy a = 2 (F_1 - F_2) and its direction (rad) of the density of normals,
    #: E(t) = (1 + a cos 2(t - t_a)) / 2 pi.
    a: float
    direction: float
    #: Anisotropy and direction of the mean normal force, f(t) = f_0 (1 + a_n cos 2(t - t_n)).
    a_n: float
    force_direction: float


class Frame:
    """The specimen at one moment: a file of the folder ``frames`` of a run, or the state of a
    simulation. All numbers are SI; compression, contraction and anticlockwise rotation are positive.
    Most have seven digits. ``arrays`` has everything under the names of the reference of frames.

    Parameters
    ----------
    source
        The path of a ``.npz`` file, or its arrays by name.
    """

    def __init__(self, source: str | os.PathLike[str] | dict[str, np.ndarray]) -> None:
        if isinstance(source, dict):
            self.arrays = source
        else:
            with np.load(source) as file:
                self.arrays = {name: file[name] for name in file.files}
        if not str(self.arrays.get("format", "")).startswith("clastic frame"):
            raise ValueError(f"{source}: not a frame; give a file of the folder `frames` of a run")

    def __repr__(self) -> str:
        return f"Frame of {len(self)} disks after increment {self.increment} ({self.stage})"

    def __len__(self) -> int:
        return len(self.ids)

    @property
    def increment(self) -> int:
        """Increment after which it was taken."""
        return int(self.arrays["increment"])

    @property
    def stage(self) -> str:
        """Its stage."""
        return str(self.arrays["stage"])

    @property
    def time(self) -> float:
        """Time since the start, s."""
        return float(self.arrays["time_s"])

    @property
    def thickness(self) -> float:
        """Thickness h out of the plane, m."""
        return float(self.arrays["thickness_m"])

    @property
    def axial_strain(self) -> float:
        """Axial strain; not a number where the scene does not define one, and before the first
        increment of the reference stage, from whose start it counts.
        """
        return float(self.arrays["axial_strain"])

    @property
    def axial_stress(self) -> float:
        """Axial stress, Pa; not a number where the scene does not define one."""
        return float(self.arrays["axial_stress_pa"])

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Identities of the disks, shape (n), ascending."""
        return self.arrays["bodies.id"]

    @property
    def positions(self) -> Floats:
        """Centres, m, shape (n, 2)."""
        return self.arrays["origin_m"] + self.arrays["bodies.offset_m"].astype(float)

    @property
    def radii(self) -> Floats:
        """Radii, m, shape (n)."""
        return self.arrays["bodies.radius_m"].astype(float)

    @property
    def displacements(self) -> Floats:
        """Displacements since the start of the first run, m, shape (n, 2)."""
        return self.arrays["bodies.displacement_m"].astype(float)

    @property
    def rotations(self) -> Floats:
        """Rotations since then, rad, shape (n)."""
        return self.arrays["bodies.rotation_rad"].astype(float)

    @property
    def velocities(self) -> Floats:
        """Velocities, m/s, shape (n, 2)."""
        return self.arrays["bodies.velocity_m_s"].astype(float)

    @property
    def stresses(self) -> Floats:
        """Mean stress of each disk, components xx, yy and xy, Pa, shape (n, 3)."""
        return self.arrays["bodies.stress_pa"].astype(float)

    @property
    def materials(self) -> NDArray[np.str_]:
        """Name of the material of each disk, shape (n)."""
        return self.arrays["materials.name"][self.arrays["bodies.material"]]

    @property
    def fragments(self) -> NDArray[np.uint32]:
        """Fragment of each disk: the lowest identity of those that intact bonds hold together."""
        return self.arrays["bodies.fragment"]

    @property
    def pairs(self) -> dict[str, np.ndarray]:
        """Contacts and bonds, intact and broken: ``a``, ``b``, ``bond``, ``state`` (an index of
        :data:`STATES`), ``p_n``, ``q_n``, ``tau_nm``, ``gap_m``, ``angle_rad``, each of shape (c).
        """
        return {k[6:]: v for k, v in self.arrays.items() if k.startswith("pairs.")}

    def contacts(self) -> pandas.DataFrame:
        """:attr:`pairs` as a table, with states in words and -1 for no bond."""
        import pandas

        columns: dict[str, Any] = dict(self.pairs)
        columns["state"] = np.array(STATES)[columns["state"]]
        columns["bond"] = np.where(columns["bond"] == _NONE, -1, columns["bond"].astype(np.int64))
        return pandas.DataFrame(columns)

    def rows(self, ids: np.ndarray) -> NDArray[np.intp]:
        """Rows of disks by identity; -1 where there is none, as for walls."""
        if len(self) == 0:
            return np.full(np.shape(ids), -1)
        rows = np.minimum(np.searchsorted(self.ids, ids), len(self) - 1)
        return np.where(self.ids[rows] == ids, rows, -1)

    @property
    def bounds(self) -> Box:
        """Box around the disks."""
        x, r = self.positions, self.radii[:, None]
        low, high = (x - r).min(axis=0), (x + r).max(axis=0)
        return float(low[0]), float(low[1]), float(high[0]), float(high[1])

    def _branches(self) -> tuple[Floats, Floats, Floats]:
        """Starts and branches (m) of the pairs, and the forces (N) on their first bodies, reversed."""
        pairs, x, r = self.pairs, self.positions, self.radii
        a, b = self.rows(pairs["a"]), self.rows(pairs["b"])
        angle = pairs["angle_rad"].astype(float)
        normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        length = r[a] + pairs["gap_m"] + np.where(b >= 0, r[b], 0.0)
        force = pairs["p_n"][:, None] * normal + pairs["q_n"][:, None] * tangent
        return x[a], length[:, None] * normal, force.astype(float)

    def stress(self, box: Box | None = None) -> Floats:
        """Average stress of a rectangle, Pa, shape (2, 2): sum of f (x) l / (A h) over all contacts
        and bonds (Love, Weber), each by the part of its branch l that lies inside. Without ``box`` it
        is the box around the disks.

        Raises
        ------
        ValueError
            If the rectangle is empty, or lies outside of the box around the disks.
        """
        a0, b0, a1, b1 = bounds = self.bounds
        x0, y0, x1, y1 = box or bounds
        if not (max(x0, a0) < min(x1, a1) and max(y0, b0) < min(y1, b1)):
            raise ValueError(f"no part of the specimen lies in {box}; give x0, y0, x1, y1 within {bounds}")
        start, branch, force = self._branches()
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (np.array([x0, y0]) - start) / branch
            second = (np.array([x1, y1]) - start) / branch
        enter = np.nan_to_num(np.minimum(first, second), nan=0.0).max(axis=1).clip(min=0.0)
        leave = np.nan_to_num(np.maximum(first, second), nan=1.0).min(axis=1).clip(max=1.0)
        inside = (leave - enter).clip(min=0.0)
        area = (x1 - x0) * (y1 - y0) * self.thickness
        return np.einsum("k,ki,kj->ij", inside, force, branch) / area

    def strain(self, since: Frame, box: Box | None = None) -> Floats:
        """Mean strain of a rectangle since another frame, shape (2, 2): -(H + H^T)/2 of the
        displacement gradient H that fits best, by least squares, the displacements of the disks
        whose centres were inside in the frame ``since``.
        """
        gradient = self._gradient(since, box)
        return -0.5 * (gradient + gradient.T)

    def rotation(self, since: Frame, box: Box | None = None) -> float:
        """Mean rotation of a rectangle since another frame, rad: that of the same gradient."""
        gradient = self._gradient(since, box)
        return 0.5 * float(gradient[1, 0] - gradient[0, 1])

    def _gradient(self, since: Frame, box: Box | None) -> Floats:
        now = self.rows(since.ids)
        x = since.positions
        x0, y0, x1, y1 = box or since.bounds
        inside = (x >= (x0, y0)).all(axis=1) & (x <= (x1, y1)).all(axis=1) & (now >= 0)
        if inside.sum() < 3:
            raise ValueError("less than three disks lie in the rectangle")
        u = self.displacements[now[inside]] - since.displacements[inside]
        x = x[inside]
        arms, moves = x - x.mean(axis=0), u - u.mean(axis=0)
        solution, _, rank, _ = np.linalg.lstsq(arms, moves, rcond=None)
        if rank < 2:
            raise ValueError("the disks in the rectangle lie in a row")
        return solution.T

    def moved(self, since: Frame) -> Floats:
        """Displacements since another frame, m, shape (n, 2); NaN for disks that were not there."""
        return self._since(self.displacements, since, since.displacements)

    def turned(self, since: Frame) -> Floats:
        """Rotations since another frame, rad, shape (n)."""
        return self._since(self.rotations, since, since.rotations)

    def _since(self, now: Floats, since: Frame, before: Floats) -> Floats:
        rows = since.rows(self.ids)
        change = now - before[rows]
        change[rows < 0] = np.nan
        return change

    def strains(self, since: Frame) -> Floats:
        """Volumetric strain e_1 + e_2 and maximum shear strain e_1 - e_2 around each disk since
        another frame, shape (n, 2): means, by area, over the triangles of the Delaunay triangulation
        of the centres in that frame, in which displacements are linear. NaN for disks without one.
        """
        return _engine.strains(self._disks(), since._disks())

    def _disks(self) -> tuple[np.ndarray, Floats, Floats, Floats]:
        return self.ids, self.positions, self.radii, self.displacements

    def _compression(self) -> tuple[Floats, Floats]:
        """Directions (rad) and normal forces (N) of contacts between disks that carry compression."""
        pairs = self.pairs
        chosen = (pairs["p_n"] > 0.0) & (self.rows(pairs["b"]) >= 0)
        return pairs["angle_rad"][chosen].astype(float), pairs["p_n"][chosen].astype(float)

    def rose(self) -> tuple[NDArray[np.intp], Floats]:
        """Number and mean normal force (N) of the contacts between disks that carry compression, by
        the direction of their normal: :data:`SECTORS` sectors over half a turn from the x axis.
        """
        angle, force = self._compression()
        sector = np.minimum((angle % np.pi) / np.pi * SECTORS, SECTORS - 1).astype(int)
        number = np.bincount(sector, minlength=SECTORS)
        sums = np.bincount(sector, weights=force, minlength=SECTORS)
        return number, sums / np.maximum(number, 1)

    def fabric(self) -> Fabric:
        """Fabric of the contacts between disks.

        Raises
        ------
        ValueError
            If no contact between two disks carries compression.
        """
        angle, _ = self._compression()
        if len(angle) == 0:
            raise ValueError("no contact between two disks carries compression")
        n = np.stack([np.cos(angle), np.sin(angle)], axis=1)
        double = np.exp(2j * angle).mean()
        number, mean = self.rose()
        there = number > 0
        middle = (np.arange(SECTORS)[there] + 0.5) * np.pi / SECTORS
        force = 2.0 * (mean[there] * np.exp(2j * middle)).sum() / mean[there].sum()
        half = lambda z: float((0.5 * np.angle(z)) % np.pi)
        return Fabric(
            contacts=len(angle),
            coordination=2.0 * len(angle) / len(self),
            tensor=n.T @ n / len(n),
            a=2.0 * float(abs(double)),
            direction=half(double),
            a_n=float(abs(force)),
            force_direction=half(force),
        )
