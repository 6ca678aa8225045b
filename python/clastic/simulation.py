"""A scene that Python steps and changes."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _engine
from ._scene import Scene, Settings, settings, source
from .errors import RunWarning
from .frame import Frame

Floats = NDArray[np.float64]
Row = dict[str, Any]


@dataclass(frozen=True)
class State:
    """A simulation between two increments, for :meth:`Simulation.restore` and
    :meth:`Simulation.of`. It can be pickled, and belongs to the version of clastic that made it.
    """

    content: bytes

    def __repr__(self) -> str:
        return f"State of {len(self.content)} bytes"

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes the state into a file."""
        with open(path, "wb") as file:
            file.write(self.content)

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> State:
        """The state in a file."""
        with open(path, "rb") as file:
            return cls(file.read())


class Simulation:
    """A scene under way, without files.

    ::

        sim = clastic.Simulation("biaxial_small")
        for row in sim:
            if (row["axial_strain"] or 0.0) > 0.01:
                for side in ("left", "right"):
                    sim.set_wall(side, stress=300e3)

    Units are SI; compression, contraction and anticlockwise rotation are positive. What the scene
    defines holds until it is changed here. A stage that begins sets gravity, strength, the walls that
    it names, and the motions of particles anew.

    All arrays are copies: writing into them changes nothing. Particles and bonds go by their
    identities (:attr:`ids`), which stay when others are removed. A value without a meaning raises
    ``ValueError`` in the next :meth:`step`; nothing of that increment is then committed, and the
    simulation goes on once the value is mended.

    Parameters
    ----------
    scene
        A file, the name of a scene that ships (``clastic list``), or the text of a scene.
    set
        Settings by their paths, ``{"materials.sand.contact.friction": 0.3}``. A text is RON:
        ``{"stages.confine.walls.top": "Stress(stress: 1e5)"}``.
    threads
        Maximum number of threads of a solve; results do not depend on it.

    Raises
    ------
    SceneError
        If the scene or a setting is wrong.
    """

    def __init__(self, scene: Scene, *, set: Settings | None = None, threads: int | None = None) -> None:
        text, is_text = source(scene)
        self._engine = _engine.Simulation(text, is_text, settings(set), None, False, 0, threads)

    @classmethod
    def of(cls, state: State, *, threads: int | None = None) -> Simulation:
        """A new simulation that goes on from a state: a branch."""
        sim = cls.__new__(cls)
        sim._engine = _engine.Simulation.restored(state.content, threads)
        return sim

    # Stepping

    def step(self) -> Row | None:
        """Makes the next increment and returns its row: a dictionary with the columns of
        ``history.csv``, values that are not defined being None. Returns None once the scene has
        ended. Where bonds break, an increment may be a part of a whole one (``fraction``).
        """
        had_ended = self.status != "running"
        row = self._engine.step()
        outcome = None if row is not None or had_ended else self._engine.outcome()
        if outcome and outcome["status"] in ("undecided", "refused"):
            warnings.warn(f"{outcome['status']}: {outcome['message']}", RunWarning, stacklevel=2)
        return row

    def __iter__(self) -> Iterator[Row]:
        """Rows of the increments up to the end of the scene."""
        while (row := self.step()) is not None:
            yield row

    def run(self) -> list[Row]:
        """Runs to the end of the scene and returns the rows."""
        return list(self)

    def stage(self, stage: str) -> Simulation:
        """Adds a stage after those of the scene, in the words of a scene:
        ``sim.stage('Load(name: "unload", increments: 20)')``. It begins after the present one.
        ``record``, which writes files, has no effect. Returns the simulation.
        """
        self._engine.stage(stage)
        return self

    def end_stage(self) -> None:
        """Ends the present stage: the next one begins with the next increment."""
        self._engine.end_stage()

    @property
    def status(self) -> str:
        """``running``, ``completed``, ``collapsed``, ``undecided`` or ``refused``. A collapse ends
        its stage, and ``row["status"]`` of its increment is ``collapsed``; the status of the
        simulation is, once all stages have ended.
        """
        outcome = self._engine.outcome()
        return outcome["status"] if outcome else "running"

    @property
    def message(self) -> str | None:
        """Why the simulation ended; None while it runs, and where it completed."""
        outcome = self._engine.outcome()
        return outcome["message"] if outcome else None

    @property
    def progress(self) -> tuple[str, float, float]:
        """Name of the stage, its increments that are done (a fraction counts as such), and all of them.
        A stage that ends early, as by a collapse or a stop condition, ends with all done.
        """
        return self._engine.progress()

    @property
    def stages(self) -> list[str]:
        """Names of the stages."""
        return self._engine.stages()

    @property
    def text(self) -> str:
        """The scene, with settings and added stages."""
        return self._engine.text()

    @property
    def time(self) -> float:
        """Time since the start, s. It passes in dynamic stages alone."""
        return self._engine.time()

    # States

    def save(self) -> State:
        """The state after the last increment. It has the bodies, bonds, forces, the laws of contacts
        and bonds, gravity and strength, and the place among the stages, but no function of loads.
        """
        return State(self._engine.save())

    def restore(self, state: State) -> None:
        """Goes to a state of this or of another simulation. A function of loads stays."""
        self._engine.restore(state.content)

    def branch(self) -> Simulation:
        """A copy that goes its own way. It has no function of loads."""
        return Simulation.of(self.save())

    def write(self, path: str | os.PathLike[str]) -> None:
        """Writes a saved state (``.npz``), from which a scene starts by ``State(path: ...)``."""
        self._engine.write(os.fspath(path))

    # Arrays

    @property
    def ids(self) -> NDArray[np.uint32]:
        """Identities of the particles, shape (n), ascending."""
        return self._engine.ids()

    @property
    def positions(self) -> Floats:
        """Centres of the particles, m, shape (n, 2)."""
        return self._engine.particles("positions")

    @property
    def rotations(self) -> Floats:
        """Rotations since the start, rad, shape (n)."""
        return self._engine.particles("rotations")

    @property
    def velocities(self) -> Floats:
        """Velocities, m/s, shape (n, 2). Static stages leave them as they are."""
        return self._engine.particles("velocities")

    @property
    def angular_velocities(self) -> Floats:
        """Angular velocities, rad/s, shape (n)."""
        return self._engine.particles("angular_velocities")

    @property
    def radii(self) -> Floats:
        """Radii, m, shape (n)."""
        return self._engine.particles("radii")

    @property
    def masses(self) -> Floats:
        """Masses, kg, shape (n)."""
        return self._engine.particles("masses")

    @property
    def forces(self) -> Floats:
        """Force (N) and moment (N m) of the outside world on each particle in the last increment,
        without gravity, shape (n, 3).
        """
        return self.arrays("particles.external_force")["particles.external_force"]

    def _columns(self, table: str) -> dict[str, np.ndarray]:
        all = self.arrays(table + ".")
        return {name[len(table) + 1 :]: array for name, array in all.items()}

    @property
    def contacts(self) -> dict[str, np.ndarray]:
        """Contacts and intact bonds that carry force: identities ``a``, ``b``, forces ``p_n``
        (normal, compression positive) and ``q_n`` (shear), ``tau_nm``, ``normal`` (c, 2) from a to b,
        ``gap_m``, ``bond``.
        """
        return self._columns("contacts")

    @property
    def bonds(self) -> dict[str, np.ndarray]:
        """All bonds: ``id``, ``a``, ``b``, ``state`` (0 intact, broken in 1 tension, 2 shear,
        3 rolling), ``initial_gap_m`` and their laws.
        """
        return self._columns("bonds")

    @property
    def walls(self) -> dict[str, np.ndarray]:
        """The walls: ``id``, ``name``, ``position_m``, ``external_force`` (w, 3) and more."""
        return self._columns("walls")

    def arrays(self, prefix: str = "") -> dict[str, np.ndarray]:
        """The arrays of a saved state whose names begin with ``prefix``, as in the reference of saved
        states: ``particles.position_m``, ``contacts.p_n`` and so on.
        """
        return self._engine.arrays(prefix)

    def frame(self) -> Frame:
        """The specimen now, for figures, stresses, strains and fabric."""
        return Frame(self._engine.frame())

    # Changes

    @property
    def gravity(self) -> tuple[float, float]:
        """Acceleration of gravity, m/s^2. It may be set; a stage that begins sets it to its own."""
        return self._engine.analysis()[0]

    @gravity.setter
    def gravity(self, gravity: tuple[float, float]) -> None:
        x, y = gravity
        self._engine.set_gravity((float(x), float(y)))

    @property
    def strength(self) -> float:
        """Factor on cohesion, tensile strength and friction of all contacts and bonds. It may be
        set; a stage that begins sets it to 1, and one with ``scale`` to its own in every increment.
        """
        return self._engine.analysis()[1]

    @strength.setter
    def strength(self, factor: float) -> None:
        self._engine.set_strength(float(factor))

    def set_contact(self, of: str, **law: float) -> None:
        """Changes the law of contacts between grains of a material, or that of a wall:
        ``normal_stiffness``, ``tangential_stiffness``, ``rolling_stiffness`` (N/m, N m/rad; infinity
        is rigid), ``friction``, ``rolling_friction``, ``restitution``.
        """
        self._engine.set_contact(of, {name: float(value) for name, value in law.items()})

    def set_bonds(self, ids: ArrayLike | None = None, **law: ArrayLike) -> None:
        """Changes the law of bonds: of those with these identities, or of all that are intact.
        ``normal_stiffness``, ``tangential_stiffness``, ``rolling_stiffness``, ``friction``,
        ``rolling_friction``, ``cohesion`` and ``tensile_strength`` (Pa): one value, or one a bond.

        A bond with another normal stiffness carries another force at the same elongation; shear
        force and moment stay. The next increment balances them.
        """
        rows = None if ids is None else _identities(ids)
        columns = {name: _numbers(np.atleast_1d(value)) for name, value in law.items()}
        self._engine.set_bonds(rows, columns)

    def set_wall(
        self,
        name: str,
        *,
        stress: float | None = None,
        force: float | None = None,
        displacement: ArrayLike | None = None,
        velocity: ArrayLike | None = None,
        rotation: tuple[ArrayLike, float] | None = None,
        fixed: bool = False,
        between: tuple[str, str] | None = None,
    ) -> None:
        """Controls a wall from the next increment on. Give one of

        - ``stress`` (Pa) or ``force`` (N) along its inward normal. ``between`` names the two walls
          whose distance is the length that the stress acts on; without it the length is that of a
          stress control before, or that of the drawn wall.
        - ``displacement`` (x, y; m) or ``rotation`` ((x, y), angle; m, rad) per increment
        - ``velocity`` (x, y; m/s) in dynamic stages
        - ``fixed=True``
        """
        given: dict[str, list[float]] = {}
        if stress is not None:
            given["stress"] = [float(stress)]
        if force is not None:
            given["force"] = [float(force)]
        if displacement is not None:
            given["displacement"] = _numbers(displacement)
        if velocity is not None:
            given["velocity"] = _numbers(velocity)
        if rotation is not None:
            given["rotation"] = [*_numbers(rotation[0]), float(rotation[1])]
        if fixed:
            given["fixed"] = []
        if len(given) != 1:
            raise ValueError("give one of stress, force, displacement, velocity, rotation and fixed=True")
        ((kind, values),) = given.items()
        self._engine.set_wall(name, kind, values, between)

    def set_loads(self, ids: ArrayLike, loads: ArrayLike) -> None:
        """Loads particles from the next increment on, until their loads change: forces x, y (N) and,
        if given, moments (N m), shape (k, 2) or (k, 3), or one row for all.
        """
        rows = _identities(ids)
        self._engine.load(rows, _rows(loads, len(rows)))

    def set_motions(self, ids: ArrayLike, motions: ArrayLike) -> None:
        """Moves particles by (x, y, rotation; m, m, rad) in every increment, shape (k, 3), or one row
        for all. NaN leaves a degree of freedom free, 0 holds it. A stage that begins frees all.
        """
        rows = _identities(ids)
        self._engine.drive(rows, _rows(motions, len(rows)))

    def set_load_function(self, function: Callable[[Any], Any] | None) -> None:
        """Sets a function that loads the particles, or takes it away (None).

        It is called once per trial, that is for every fraction of an increment that is tried and
        after every step of a followed motion, with ``ids``, ``positions``, ``velocities``,
        ``rotations``, ``radii``, ``masses``, ``time``, ``time_end``, ``increments_done`` (of the stage)
        and ``fraction`` (of the trial, of a whole increment) as attributes of its argument. These are
        at the start of the trial, which ends at ``time_end`` (s), in static stages at
        ``increments_done + fraction``.

        It returns forces, shape (n, 2), or with moments (n, 3), N and N m. In a static stage they are
        those at the end of the trial, in a dynamic one their mean over it: they change the momentum by
        ``force * (time_end - time)``. It may return a pair of such arrays, of which the second are
        stiffnesses k >= 0 (N/m, N m/rad): then the force is ``force - k u`` at the displacement u of
        the trial. In a dynamic stage this is of first order in the time step and takes energy, also
        with theta = 1/2. None loads nothing.

        The function must depend on its argument alone, since a trial may be repeated. It cannot use
        the simulation. An exception in it ends the step, of which nothing is committed.
        """
        self._engine.set_load_function(function)

    def remove(self, ids: ArrayLike) -> None:
        """Takes particles away with their contacts and bonds."""
        self._engine.remove(_identities(ids))

    def add(
        self,
        positions: ArrayLike,
        radii: ArrayLike,
        material: str,
        velocities: ArrayLike = (0.0, 0.0),
    ) -> NDArray[np.uint32]:
        """Adds disks: centres (k, 2), m, radii (k), m, of a material of the scene, with velocities
        (k, 2), m/s. Returns their identities.
        """
        centres = np.atleast_2d(np.asarray(positions, float))
        shape = (len(centres), 1)
        radius = np.broadcast_to(np.asarray(radii, float).reshape(-1, 1), shape)
        speed = np.broadcast_to(np.asarray(velocities, float), centres.shape)
        disks = np.hstack([centres, radius, speed]).tolist()
        return np.array(self._engine.add(disks, material), np.uint32)

    def cement(self, pairs: ArrayLike) -> NDArray[np.uint32]:
        """Bonds pairs of particles, shape (k, 2), whatever their gap, by the laws of their materials.
        What a contact carries its bond goes on carrying. Pairs with an intact bond stay as they are.
        Returns the identities of the new bonds; :meth:`set_bonds` gives them other laws.
        """
        rows = np.atleast_2d(np.asarray(pairs, np.uint32)).tolist()
        return np.array(self._engine.cement([tuple(row) for row in rows]), np.uint32)

    def remove_bonds(self, ids: ArrayLike) -> None:
        """Takes bonds away. They do not count as broken; what their pairs carry is lost."""
        self._engine.remove_bonds(_identities(ids))


def _identities(ids: ArrayLike) -> list[int]:
    return np.atleast_1d(np.asarray(ids, np.uint32)).tolist()


def _numbers(values: ArrayLike) -> list[float]:
    return np.asarray(values, float).ravel().tolist()


def _rows(values: ArrayLike, rows: int) -> list[list[float]]:
    """Rows of three numbers; a third that is left out is 0."""
    table = np.atleast_2d(np.asarray(values, float))
    if table.shape[1] == 2:
        table = np.hstack([table, np.zeros((len(table), 1))])
    if table.shape[1] != 3 or len(table) not in (1, rows):
        raise ValueError(f"the shape {np.shape(values)} is not (2), (3), ({rows}, 2) or ({rows}, 3)")
    return np.broadcast_to(table, (rows, 3)).tolist()
