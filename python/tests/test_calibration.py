"""Parameters of grains and bonds from targets of the specimen."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import program

import clastic
from clastic import Parameter, Target
from clastic._folders import Folders

EXAMPLES = Path(__file__).parents[1] / "examples"
#: No figures, which take longer than these runs.
QUICK = {"output.plots": False}


def uniaxial() -> tuple[str, list[Parameter]]:
    """The scene of `clastic new uniaxial`, and its parameters but ratios."""
    places = ["walls.bottom.contact", "walls.top.contact", "materials.rock.contact", "materials.rock.bond"]
    stiffness = [f"{place}.{kind}_stiffness" for place in places for kind in ("normal", "tangential")]
    parameters = [
        Parameter("stiffness", stiffness, 2.0e10, "stiffness"),
        Parameter("cohesion", ["let.cohesion"], 50.0e6, "strength"),
        Parameter("tensile", ["let.tensile"], 30.0e6, "strength"),
        Parameter("step", ["let.step"], 1.2e-6, "strain"),
    ]
    return program("new", "uniaxial").stdout, parameters


def test_a_calibration_needs_few_runs_where_similarity_suffices(tmp_path: Path) -> None:
    """Modulus and strength of a compression test by two factors; a target that no factor changes."""
    text, parameters = uniaxial()
    targets = [
        Target("compression", "youngs_modulus_pa", 25.0e9, "stiffness"),
        Target("compression", "peak_stress_pa", 90.0e6, "strength"),
    ]
    tests = {"compression": text}
    found = clastic.calibrate(tests, targets, parameters, out=tmp_path)
    assert found.success and found.targets["error"].abs().max() < 0.02
    assert found.made <= 3 and found.cached == 0
    assert found.parameters["tensile"] / found.parameters["cohesion"] == pytest.approx(0.6)
    again = clastic.calibrate(tests, targets, parameters, out=tmp_path)
    assert again.made == 0 and again.parameters == found.parameters
    with pytest.raises(ValueError, match="names no test"):
        clastic.calibrate(tests, [Target("shear", "x", 1.0)], parameters, out=tmp_path)
    with pytest.raises(ValueError, match="parameter friction names no test: `shear`"):
        friction = Parameter("friction", {"shear": ["let.friction"]}, 0.5, low=0.1, high=1.0)
        clastic.calibrate(tests, targets, [friction], out=tmp_path)
    with pytest.raises(ValueError, match="did you mean 'strength'"):
        Target("compression", "peak_stress_pa", 1.0, "strengh")
    with pytest.raises(ValueError, match="give a function of several"):
        Target(["compression", "tension"], "peak_stress_pa", 1.0)
    with pytest.raises(ValueError, match="give low and high"):
        Parameter("friction", ["let.friction"], 0.5)
    with pytest.raises(ValueError, match="start 2.0 is not between 0.1 and 1.0"):
        Parameter("friction", ["let.friction"], 2.0, low=0.1, high=1.0)
    with pytest.raises(ValueError, match="give a value that is not 0"):
        Target("compression", "peak_stress_pa", 0.0)
    with pytest.raises(ValueError, match="two parameters are named"):
        clastic.calibrate(tests, targets, [*parameters, parameters[0]], out=tmp_path)
    with pytest.raises(ValueError, match="is no key result of compression; did you mean 'peak_stress_pa'"):
        clastic.calibrate(tests, [Target("compression", "peak_stres_pa", 1.0)], parameters, out=tmp_path)
    failed = clastic.calibrate(
        tests, [Target("compression", "friction_angle_rad", 0.5)], parameters, out=tmp_path
    )
    assert not failed.success and np.isnan(failed.targets["reached"][0])
    assert failed.message.startswith("friction_angle_rad of compression is not defined: ")
    assert failed.message.endswith(clastic.open(failed.runs["directory"][0]).reasons["friction_angle_rad"])


def test_a_curve_of_an_experiment_gives_both_factors(tmp_path: Path) -> None:
    """By similarity stresses in proportion to the strengths, strains to strengths over stiffnesses."""
    text, parameters = uniaxial()
    # Long after the peak round-off decides, and curves of similar specimens part.
    short = QUICK | {"stages.load.increments": 60}
    known = {path: p.start for p in parameters for path in p.paths} | short
    points = clastic.run(text, known, tmp_path / "known", progress=False).curve("axial_stress_pa")
    file = tmp_path / "experiment.csv"
    header = "axial_strain,axial_stress_pa"
    np.savetxt(file, points * (0.8 / 1.5, 0.8), delimiter=",", header=header, comments="")
    found = clastic.calibrate(
        {"compression": (text, short)},
        [clastic.Curve("compression", file)],
        parameters,
        out=tmp_path / "runs",
    )
    assert found.success and found.made <= 3
    for p, factor in zip(parameters, (1.5, 0.8, 0.8, 0.8 / 1.5)):
        assert found.parameters[p.name] == pytest.approx(factor * p.start, rel=1e-2)
    # Its error is the root mean square of the differences over the peak.
    curve = clastic.Curve("compression", [(0.0, 0.0), (1.0, 2.0)])
    assert curve.row([np.array([(0.0, 0.2), (1.0, 2.2)])])["error"] == pytest.approx(0.1)
    with pytest.raises(ValueError, match="no column axial_stress_pa; it has strain"):
        file.write_text("strain,axial_strain\n0,0\n")
        clastic.Curve("compression", file)
    with pytest.raises(ValueError, match="two or more pairs"):
        clastic.Curve("compression", [1.0, 2.0])


class Peak:
    """In place of a run."""

    def __init__(self, sigma_3: float, sigma_1: float) -> None:
        self.peak_stresses = lambda: (sigma_3, sigma_1)


def test_strengths_on_an_envelope_give_its_parameters() -> None:
    n = (1.0 + np.sin(np.radians(35.0))) / (1.0 - np.sin(np.radians(35.0)))
    runs = [Peak(s, 2.0 * 4e6 * np.sqrt(n) + n * s) for s in (0.0, 1e6, 5e6)]
    assert clastic.friction_angle(*runs) == pytest.approx(35.0)
    assert clastic.cohesion(*runs) == pytest.approx(4e6)
    runs = [Peak(s, s + np.sqrt(100e6**2 + 12.0 * 100e6 * s)) for s in (0.0, 5e6, 20e6)]
    assert clastic.hoek_brown_m(*runs) == pytest.approx(12.0)
    with pytest.raises(ValueError, match="one lateral stress: give several, and measure `lateral_stress`"):
        clastic.friction_angle(*(Peak(0.0, 1e6) for _ in range(2)))
    with pytest.raises(ValueError, match="no sigma_ci"):
        clastic.hoek_brown_m(Peak(1e6, 1e6), Peak(2e6, 12e6))


def test_the_friction_angle_of_two_tests_is_a_target(tmp_path: Path) -> None:
    def at(stress: float) -> tuple[str, dict[str, object]]:
        walls = {f"stages.confine.walls.{name}.stress": stress for name in ("left", "right", "top", "bottom")}
        return "biaxial_small", {"stages.load.increments": 22, **walls, **QUICK}

    found = clastic.calibrate(
        {"low": at(1e5), "high": at(2e5)},
        [Target(["low", "high"], clastic.friction_angle, 30.0)],
        [Parameter("friction", ["materials.sand.contact.friction"], 0.3, low=0.1, high=1.0)],
        out=tmp_path,
    )
    assert found.success and found.made <= 14
    last = found.runs[found.runs["friction"] == found.parameters["friction"]]
    phi = clastic.friction_angle(*map(clastic.open, last["directory"]))
    assert phi == found.targets["reached"][0] == pytest.approx(30.0, rel=0.02)


def rock(out: Path, nu: float) -> clastic.Calibration:
    """Modulus and Poisson's ratio of two packings."""
    return clastic.calibrate(
        {"elastic": (EXAMPLES / "rock.ron", {"let.increments": 4, **QUICK})},
        [
            Target("elastic", "youngs_modulus_pa", 40e9, "stiffness"),
            Target("elastic", "poissons_ratio", nu),
        ],
        [
            Parameter("stiffness", ["let.stiffness"], 5e10, "stiffness"),
            Parameter("shear", ["let.shear"], 0.4, low=0.1, high=1.0),
        ],
        seeds=(1, 2),
        prepare=(EXAMPLES / "rock_packing.ron", QUICK),
        out=out,
    )


def test_a_specimen_is_prepared_once_a_seed(tmp_path: Path) -> None:
    found = rock(tmp_path / "runs", 0.22)
    assert found.success
    assert list(found.runs["test"]).count("prepare") == 2
    # Both seeds at the start, a difference, a step and the verification.
    assert found.made <= 2 + 4 * 2
    # Poisson's ratio falls with k_t/k_n; its starting value gives less than 0.22.
    assert found.parameters["shear"] < 0.4
    # Runs stay what they are where the directory moves.
    shutil.move(tmp_path / "runs", tmp_path / "moved")
    again = rock(tmp_path / "moved", 0.22)
    assert again.made == 0 and again.parameters == found.parameters


def test_a_target_out_of_reach_names_the_parameter_at_its_limit(tmp_path: Path) -> None:
    found = rock(tmp_path, 0.45)
    assert not found.success and found.parameters["shear"] == pytest.approx(0.1)
    assert found.message.endswith("at a limit: shear")
    assert found.targets["error"][1] < -0.02


def test_four_properties_of_a_rock_take_less_than_forty_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = EXAMPLES / "calibrate.py"
    names: dict[str, Any] = {"__file__": str(file), "__name__": "calibrate"}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["calibrate.py", "marble"])
    exec(file.read_text(), names)
    found: clastic.Calibration = names["found"]
    assert found.success and found.targets["error"].abs().max() <= 0.05
    assert found.made < 40
    # What does not act on a test does not repeat it.
    elastic = found.runs[found.runs["test"] == "elastic"]
    assert not elastic.duplicated(["seed", "stiffness", "shear"]).any()
    # Nor does a ratio that turns out not to act: of its steps tension has the difference alone.
    count = found.runs["test"].value_counts()
    assert count["tension"] < count["compression"]
    # The targets of the table are the means of its last runs.
    last = found.runs[
        (found.runs["test"] == "tension") & (found.runs["tensile"] == found.parameters["tensile"])
    ]
    assert len(last) == 2 and last["strength_pa"].mean() == found.targets["reached"][3]


def test_a_specimen_stored_anew_under_its_name_is_run_anew(tmp_path: Path) -> None:
    """A run is found again by its scene and by what the file of the specimen has in it."""
    scene, stored = tmp_path / "fall.ron", tmp_path / "grains.csv"
    scene.write_text(
        '(version: 1, title: "fall", analysis: Dynamic(dt: 1.0e-3), gravity: (0.0, -9.81), '
        'materials: {"a": ()}, specimen: File(path: "grains.csv"), '
        'stages: [Load(name: "fall", increments: 2)])'
    )
    made = []
    for radius in (0.01, 0.01, 0.02):
        stored.write_text(f"x_m,y_m,radius_m\n0.0,1.0,{radius}\n")
        folders = Folders(tmp_path / "runs", 1)
        folders.map(lambda _, folders=folders: folders.run({}, scene, QUICK), [0])
        made.append(folders.made)
    assert made == [1, 0, 1]
