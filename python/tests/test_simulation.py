"""Stepping and changes."""

from __future__ import annotations

import pickle
import threading
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from conftest import SETS

import clastic

R = 0.0316227766
SLOPE = Path(__file__).parents[1] / "examples" / "slope.ron"
MORE = 'Load(name: "more", increments: 2, walls: {"top": Displacement(0.0, -1.0e-4)})'


def test_stepping_has_the_rows_of_the_run(biaxial: clastic.Run) -> None:
    sim = clastic.Simulation("biaxial_small", set=SETS)
    rows = list(sim)
    history = biaxial.history
    assert sim.status == "completed" and sim.step() is None
    assert len(rows) == len(history) and list(rows[0]) == list(history.columns)
    for row, (_, written) in zip(rows, history.iterrows()):
        for name, value in row.items():
            empty = written[name] != written[name]
            assert (value in (None, "")) if empty else value == written[name], name
    state = biaxial.state()
    assert (sim.positions == state["particles.position_m"]).all()
    assert (sim.rotations == state["particles.rotation_rad"]).all()
    assert (sim.contacts["p_n"] == state["contacts.p_n"]).all()
    assert (sim.bonds["state"] == state["bonds.state"]).all()
    end = biaxial.frame("end").arrays
    assert all((sim.frame().arrays[name] == end[name]).all() for name in ("pairs.p_n", "bodies.offset_m"))


def test_a_state_goes_on_to_the_same_numbers() -> None:
    sim = clastic.Simulation("biaxial_small", set={"stages.load.increments": 4})
    rows = [sim.step() for _ in range(6)]
    state, branch = pickle.loads(pickle.dumps(sim.save())), sim.branch()
    rest = sim.run()
    assert branch.run() == rest and len(rest) > 2
    assert (branch.positions == sim.positions).all()
    sim.restore(state)
    assert sim.status == "running" and sim.run() == rest
    whole = clastic.Simulation("biaxial_small", set={"stages.load.increments": 4}).run()
    assert whole == rows + rest
    # A stage that is added continues as if the scene had it.
    sim.stage(MORE)
    more = sim.run()
    place = len(sim.stages) - 1
    longer = {
        "stages.load.increments": 4,
        f"stages[{place}]": MORE,
        "reference_stage": "load",
    }
    assert clastic.Simulation("biaxial_small", set=longer).run() == whole + more
    with pytest.raises(ValueError, match="not a state"):
        sim.restore(clastic.State(b"nothing"))
    with pytest.raises(clastic.SceneError, match="did you mean `increments`"):
        sim.stage('Load(name: "again", incremnts: 2)')


def test_a_state_that_changed_keeps_its_changes(scene: Path) -> None:
    sim = clastic.Simulation(scene)
    sim.gravity = (0.0, -10.0)
    sim.step()
    sim.strength = 0.5
    sim.gravity = (0.0, -10.0)
    sim.set_contact("m", friction=0.1)
    other = sim.branch()
    assert (other.gravity, other.strength) == ((0.0, -10.0), 0.5)
    assert other.step() == sim.step()


def test_gravity_loads_walls_and_motions(scene: Path) -> None:
    sim = clastic.Simulation(scene)
    sim.step()
    weight = 2000.0 * np.pi * R**2 * 9.81
    sim.gravity = (0.0, -9.81)
    assert sim.step()["floor.force_y_n"] == pytest.approx(weight, rel=1e-6)
    sim.set_loads(sim.ids, (0.0, -5.0))
    assert sim.step()["floor.force_y_n"] == pytest.approx(weight + 5.0, rel=1e-6)
    assert sim.forces[0] == pytest.approx([0.0, -5.0, 0.0], abs=1e-9)
    # The floor rises under a disk that is held: p = k u on top of what it carries.
    sim.set_motions(sim.ids, (0.0, 0.0, 0.0))
    sim.set_wall("floor", displacement=(0.0, 1e-5))
    before = sim.contacts["p_n"][0]
    sim.step()
    assert sim.contacts["p_n"][0] - before == pytest.approx(1e6 * 1e-5, rel=1e-6)
    # Free again, it is pressed against the floor by a force of its own.
    sim.set_motions(sim.ids, (np.nan, np.nan, np.nan))
    sim.set_wall("floor", force=weight + 5.0)
    assert sim.step()["status"] == "solved"
    assert sim.contacts["p_n"][0] == pytest.approx(weight + 5.0, rel=1e-6)
    with pytest.raises(ValueError, match="give one of"):
        sim.set_wall("floor")
    with pytest.raises(ValueError, match="no wall is called `roof`"):
        sim.set_wall("roof", fixed=True)
    with pytest.raises(ValueError, match="no particle has the identity 7"):
        sim.set_loads([7], (0.0, 0.0))


def test_a_load_by_a_function_is_that_of_a_spring(scene: Path) -> None:
    """Under a force F and a spring k beside the floor of stiffness K: u = F / (k + K)."""
    sim = clastic.Simulation(scene)
    start = sim.positions[0, 1]
    k, force = 3.0e5, -40.0
    calls = []

    def spring(trial: SimpleNamespace) -> tuple[np.ndarray, np.ndarray]:
        calls.append(trial.fraction)
        n = len(trial.ids)
        forces, stiffness = np.zeros((n, 3)), np.zeros((n, 3))
        forces[:, 1] = force - k * (trial.positions[:, 1] - start)
        stiffness[:, 1] = k
        return forces, stiffness

    sim.set_load_function(spring)
    for _ in range(3):
        sim.step()
    assert sim.positions[0, 1] - start == pytest.approx(force / (k + 1e6), rel=1e-6)
    assert sim.contacts["p_n"][0] == pytest.approx(-force * 1e6 / (k + 1e6), rel=1e-6)
    assert len(calls) >= 3

    def wrong(trial: SimpleNamespace) -> np.ndarray:
        return np.zeros((2, 2))

    place = sim.positions
    sim.set_load_function(wrong)
    with pytest.raises(ValueError, match=r"give \(1, 2\) for forces"):
        sim.step()
    sim.set_load_function(lambda trial: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        sim.step()
    sim.set_load_function(lambda trial: sim.positions)
    with pytest.raises(RuntimeError, match="cannot use the simulation"):
        sim.step()
    # Nothing of these increments was committed, and the simulation goes on.
    assert (sim.positions == place).all()
    sim.set_load_function(None)
    assert sim.step()["status"] == "solved"


def test_a_load_function_of_time_is_a_mean_over_the_increment(scene: Path) -> None:
    """A disk that nothing holds has the velocity (F_0 / m w) (1 - cos w t) under F_0 sin w t."""
    kind = 'Load(name: "shake", increments: 130, analysis: Dynamic(dt: 1.0e-3, theta: 0.5))'
    sim = clastic.Simulation(
        scene, set={"stages[0]": kind, "specimen": f"Particles([(position: (0.0, 1.0), radius: {R})])"}
    )
    force, w, times = 2.0, 10.0 * np.pi, []

    def shake(trial: SimpleNamespace) -> np.ndarray:
        times.append((trial.time, trial.time_end))
        return np.array([[force * np.sin(w * 0.5 * (trial.time + trial.time_end)), 0.0]])

    sim.set_load_function(shake)
    sim.run()
    expected = force / (sim.masses[0] * w) * (1.0 - np.cos(w * times[-1][1]))
    assert sim.time == pytest.approx(0.13) and times[0] == (0.0, pytest.approx(1e-3))
    assert sim.velocities[0, 0] == pytest.approx(expected, rel=1e-3)


def test_a_disk_slides_at_the_strength_that_friction_needs(scene: Path) -> None:
    """A disk that cannot roll carries T = 0.3 N by friction 0.5 down to a factor of 0.6."""
    for strength, status in [(0.61, "solved"), (0.59, "collapsed")]:
        sim = clastic.Simulation(scene)
        sim.gravity = (0.0, -10.0)
        sim.step()
        sim.set_motions(sim.ids, (np.nan, np.nan, 0.0))
        sim.gravity = (3.0, -10.0)
        assert sim.step()["status"] == "solved"
        sim.strength = strength
        assert sim.step()["status"] == status


def test_bonds_weaken_and_heal(scene: Path) -> None:
    # Two disks, of which the upper one hangs by its bond: tension 5 N, strength 2 r sigma_t.
    sim = clastic.Simulation(scene)
    sim.step()  # The stage begins here, and frees all.
    (second,) = sim.add([[0.0, 3 * R]], [R], "m")
    assert list(sim.ids) == [0, second]
    (bond,) = sim.cement([[0, second]])
    assert sim.bonds["a"][0] == 0 and sim.bonds["b"][0] == second
    sim.set_motions([0], (0.0, 0.0, 0.0))
    sim.set_motions([second], (0.0, np.nan, 0.0))
    sim.set_loads([second], (0.0, 5.0))
    sim.step()
    held = sim.positions[1, 1]
    sim.set_bonds([bond], tensile_strength=6.0 / (2 * R))
    assert sim.step()["bonds"] == 1
    sim.set_bonds(tensile_strength=[6.0 / (2 * R)], normal_stiffness=0.5e6)
    assert sim.step()["bonds"] == 1
    # Half the stiffness, twice the elongation.
    assert sim.positions[1, 1] - held == pytest.approx(5.0 / 1e6, rel=1e-5)
    state = sim.save()
    sim.set_bonds(tensile_strength=4.0 / (2 * R))
    row = sim.step()
    assert row["status"] == "collapsed" or row["broken_tension"] == 1
    # Healing: a new bond where the old one broke.
    sim.restore(state)
    sim.remove_bonds([bond])
    sim.set_loads([second], (0.0, -5.0))
    assert sim.step()["bonds"] == 0
    (other,) = sim.cement([[0, second]])
    assert other != bond and sim.step()["bonds"] == 1
    sim.remove([second])
    assert list(sim.ids) == [0] and sim.step()["bonds"] == 0
    with pytest.raises(ValueError, match="nothing would be left"):
        sim.remove([0])
    with pytest.raises(ValueError, match="it has normal_stiffness"):
        sim.set_contact("m", frction=0.1)
    with pytest.raises(ValueError, match="no material is called `x`"):
        sim.add([[0.0, 1.0]], [R], "x")


def test_a_value_without_a_meaning_is_said_and_mended(scene: Path) -> None:
    sim = clastic.Simulation(scene)
    sim.step()
    sim.gravity = (float("nan"), 0.0)
    with pytest.raises(ValueError, match="gravity") as error:
        sim.step()
    assert "Clastic" not in str(error.value)
    sim.gravity = (0.0, -1.0)
    sim.set_load_function(lambda trial: np.full((len(trial.ids), 2), np.nan))
    with pytest.raises(
        ValueError, match="a load of the function on particle 0 has force = NaN: give"
    ) as error:
        sim.step()
    assert "entity" not in str(error.value)
    sim.set_load_function(None)
    place = sim.positions
    for factor in (-1.0, np.nan, np.inf):
        sim.strength = factor
        with pytest.raises(ValueError, match="has strength = "):
            sim.step()
        assert (sim.positions == place).all()
    sim.strength = 0.5
    assert sim.step()["status"] == "solved"


def test_the_slope_of_the_example_slides(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names: dict[str, object] = {"__file__": str(SLOPE.with_name("slope.py")), "__name__": "slope"}
    monkeypatch.chdir(tmp_path)
    exec(SLOPE.with_name("slope.py").read_text(), names)
    assert (tmp_path / "slope.png").stat().st_size > 2000
    # Where it slides, the elastic solution of the increment before is far from there: bonds broke.
    assert 1.5 < names["factor"] < 3.0 and names["broken"] > 50
    # What slides most is the face, whose crest is at x = 7.1 m; the slide ends at the ground that is held.
    x, moved = names["rest"].positions[:, 0], names["moved"]
    assert x[moved > 0.5 * moved.max()].mean() < 7.1 and moved[x > 14.4].max() < names["SLIDES"]


def test_arrays_are_copies_and_python_is_free_during_a_solve(scene: Path) -> None:
    sim = clastic.Simulation(scene)
    sim.positions[:] = 7.0
    assert sim.positions.max() < 1.0
    # While one thread solves, another one counts.
    large = clastic.Simulation("biaxial_small", set={"stages.load.increments": 8})
    counted = 0
    solver = threading.Thread(target=large.run)
    solver.start()
    while solver.is_alive():
        counted += 1
    assert large.status == "completed" and counted > 10_000


def test_a_saved_state_is_a_specimen(scene: Path, tmp_path: Path) -> None:
    sim = clastic.Simulation(scene)
    sim.gravity = (0.0, -9.81)
    sim.step()
    sim.write(tmp_path / "state.npz")
    with np.load(tmp_path / "state.npz") as state:
        assert (state["particles.position_m"] == sim.positions).all()
    text = scene.read_text()
    start, end = text.index("specimen:"), text.index("walls:")
    again = tmp_path / "again.ron"
    again.write_text(text[:start] + 'specimen: State(path: "state.npz"),\n' + text[end:])
    assert (clastic.Simulation(again).positions == sim.positions).all()


def test_loads_stay_where_they_are_when_a_stage_is_ended() -> None:
    """Ending a stage once brought a load of 50 N to its target of 100 N in one increment."""
    sim = clastic.Simulation(
        """(version: 1, title: "pressed disk",
        materials: {"m": (density: 1000.0, contact: (normal_stiffness: 1.0e6))},
        specimen: Particles([(position: (0.0, 0.01), radius: 0.01)]),
        walls: [
            (name: "floor", start: (-1.0, 0.0), end: (1.0, 0.0), contact: (normal_stiffness: 1.0e6)),
            (name: "top", start: (1.0, 0.02), end: (-1.0, 0.02), contact: (normal_stiffness: 1.0e6)),
        ],
        stages: [
            Load(name: "press", increments: 10, walls: {"top": Force(100.0)}),
            Load(name: "hold", increments: 2),
        ],
        measures: [(name: "floor_n", of: WallForce(wall: "floor", along: Normal))])"""
    )
    rows = [sim.step() for _ in range(5)]
    sim.end_stage()
    rows += sim.run()
    assert [row["stage"] for row in rows] == ["press"] * 5 + ["hold"] * 2
    assert [row["floor_n"] for row in rows] == pytest.approx([10.0, 20.0, 30.0, 40.0, 50.0, 50.0, 50.0], abs=1e-5)
