"""Runs into directories, and what is read from them."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import SETS, program

import clastic


def files(folder: Path) -> dict[str, bytes]:
    """Content of all files but the times of the clock."""
    found = (path for path in folder.rglob("*") if path.is_file() and path.name != "timings.csv")
    return {str(path.relative_to(folder)): path.read_bytes() for path in found}


def test_a_run_has_the_bytes_of_the_program(biaxial: clastic.Run, tmp_path: Path) -> None:
    out = tmp_path / "program"
    sets = ["--set=stages.load.increments=24", "--set=output.frames_every=5", "--set=output.energy=true"]
    program("run", "biaxial_small", "--quiet", "--out", str(out), *sets)
    ours, theirs = files(biaxial.path), files(out)
    assert ours.keys() == theirs.keys() and len(ours) > 20
    assert [name for name in ours if ours[name] != theirs[name]] == []


def test_an_interrupted_run_goes_on_to_the_same_bytes(biaxial: clastic.Run, tmp_path: Path) -> None:
    out = tmp_path / "interrupted"
    code = (
        "import clastic, sys, warnings; warnings.simplefilter('ignore')\n"
        f"clastic.run('biaxial_small', {SETS!r}, {str(out)!r}, progress=False, checkpoint_every=1)"
    )
    process = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE)
    for _ in range(2000):
        if (out / "checkpoint.bin").exists() and (out / "history.csv").read_bytes().count(b"\n") > 5:
            break
        time.sleep(0.005)
    process.send_signal(signal.SIGINT)
    message = process.communicate()[1].decode()
    assert process.returncode != 0 and "KeyboardInterrupt: clastic.resume(" in message, message
    assert clastic.open(out).status == "interrupted" and (out / "checkpoint.bin").exists()
    run = clastic.resume(out, progress=False)
    assert run.status == "completed"
    ours, theirs = files(out), files(biaxial.path)
    assert [name for name in theirs if ours.get(name) != theirs[name]] == []


def test_a_directory_with_results_is_kept(biaxial: clastic.Run) -> None:
    with pytest.raises(
        OSError, match="not empty; choose another directory with `out`, or .* with `force=True`"
    ):
        clastic.run("biaxial_small", out=biaxial.path)


def test_tables_and_key_results(biaxial: clastic.Run) -> None:
    history, events = biaxial.history, biaxial.events
    broken = history.iloc[-1][["broken_tension", "broken_shear", "broken_rolling"]].sum()
    assert len(events) == broken > 0
    assert history["axial_stress_pa"].max() == biaxial.results["peak_stress_pa"]
    table = biaxial.key_results()
    assert table.loc["peak_stress_pa", "value"] == biaxial.results["peak_stress_pa"]
    assert "test ends too close to the peak" in table.loc["residual_strength_pa", "reason"]
    assert [frame.increment for frame in biaxial.frames()][0] == biaxial.frame("start").increment
    assert len(biaxial.state()["particles.id"]) == 400
    pairs = biaxial.contacts()
    assert (pairs["state"] == "bond").sum() == history.iloc[-1]["bonds"]
    with pytest.raises(FileNotFoundError, match="it has those of"):
        biaxial.frame(9999)
    with pytest.raises(FileNotFoundError, match="run.json"):
        clastic.open(biaxial.path / "frames")
    assert "<img" in biaxial._repr_html_() and "peak_stress_pa" in biaxial._repr_html_()
    assert biaxial._repr_png_().startswith(b"\x89PNG")


def test_a_run_without_stress_has_the_peak_of_its_force(tmp_path: Path) -> None:
    run = clastic.run("tension", {"output.frames_every": 1}, tmp_path / "tension", progress=False)
    (drive,) = run.drives()
    increment = drive[2][np.abs(drive[2][:, 2]).argmax(), 0]
    assert 1 < increment < run.history["increment"].iloc[-1]
    assert run.frame("peak").increment == increment


def test_stress_and_strain_of_a_frame_are_those_of_the_walls(biaxial: clastic.Run) -> None:
    end, start = biaxial.frame("end"), biaxial.frame("start")
    row = biaxial.history.iloc[-1]
    stress = end.stress()
    # The box around the disks differs from that of the walls by the overlaps there.
    assert stress[1, 1] == pytest.approx(row["axial_stress_pa"], rel=0.02)
    assert stress[0, 0] == pytest.approx(row["lateral_stress_pa"], rel=0.02)
    # The mean of the disks by volume is the same stress.
    area = np.pi * end.radii**2
    x0, y0, x1, y1 = end.bounds
    mean = (end.stresses * area[:, None]).sum(axis=0) / ((x1 - x0) * (y1 - y0))
    assert mean[1] == pytest.approx(stress[1, 1], rel=0.02)
    strain = end.strain(start)
    assert strain[1, 1] == pytest.approx(row["axial_strain"], rel=0.1)
    with pytest.raises(ValueError, match="no part of the specimen lies in"):
        end.stress((x1 + 0.1, y0, x1 + 0.2, y1))
    # Two halves have the stress of the whole.
    middle = 0.5 * (y0 + y1)
    halves = end.stress((x0, y0, x1, middle)) + end.stress((x0, middle, x1, y1))
    assert np.allclose(0.5 * halves, stress, rtol=1e-6)


def test_strains_and_fabric_of_known_frames(biaxial: clastic.Run) -> None:
    start = biaxial.frame("start")
    gradient = np.array([[0.01, 0.02], [0.0, -0.03]])
    arrays = dict(start.arrays)
    moved = start.displacements + start.positions @ gradient.T
    arrays["bodies.displacement_m"] = moved
    now = clastic.Frame(arrays)
    strains = now.strains(start)
    there = np.isfinite(strains[:, 0])
    assert there.sum() > 390
    assert np.allclose(strains[there], [0.02, np.hypot(0.04, 0.02)], atol=1e-9)
    assert np.allclose(now.strain(start), -0.5 * (gradient + gradient.T), atol=1e-9)
    assert now.rotation(start) == pytest.approx(-0.01, abs=1e-9)
    # One direction alone is as anisotropic as can be.
    arrays["pairs.angle_rad"] = np.full_like(arrays["pairs.angle_rad"], 0.3)
    fabric = clastic.Frame(arrays).fabric()
    assert fabric.a == pytest.approx(2.0) and fabric.direction == pytest.approx(0.3)
    assert np.trace(fabric.tensor) == pytest.approx(1.0)


def test_errors_of_scenes_have_places_and_remedies(tmp_path: Path) -> None:
    scene = tmp_path / "bad.ron"
    scene.write_text('(\n    version: 1,\n    title: "a",\n    materials: { "m": (desnity: 1.0) },\n)')
    with pytest.raises(clastic.SceneError, match="did you mean `density`") as error:
        clastic.check(scene)
    misspelt = [d for d in error.value.diagnostics if "desnity" in d["path"]]
    assert (misspelt[0]["line"], misspelt[0]["column"]) == (4, 24)
    with pytest.raises(clastic.SceneError, match="no such field"):
        clastic.check("tension", {"materials.nothing.density": 1.0})
    with pytest.raises(OSError, match="did you mean `tension`"):
        clastic.check("tensoin")
    with pytest.raises(ValueError, match="nan is no number"):
        clastic.check("tension", {"thickness": float("nan")})
    found = clastic.check("biaxial_small", {"stages.load.increments": 7})
    assert found["particles"] == 400 and found["stages"][-1] == "load"


def test_a_study_and_an_envelope_are_tables(tmp_path: Path) -> None:
    study = clastic.sweep(
        scene="tension",
        grid={"k": [4.0e6, 8.0e6]},
        names={"k": "materials.cemented.bond.normal_stiffness"},
        out=tmp_path / "study",
        progress=False,
    )
    assert list(study.table["k"]) == [4.0e6, 8.0e6] and set(study.table["status"]) == {"completed"}
    assert [run.status for run in study.runs()] == ["completed"] * 2
    walls = [f"stages.confine.walls.{name}.stress" for name in ("left", "right", "top", "bottom")]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        envelope = clastic.envelope(
            "biaxial_small",
            [1e5, 2e5],
            fields=walls,
            set={"stages.load.increments": 22},
            out=tmp_path / "envelope",
            progress=False,
        )
    peaks = envelope.peaks["peak_pa"]
    assert peaks[1] > peaks[0] > 1e5
    cohesion, phi = envelope.mohr_coulomb()
    # sigma_1 = 2 c sqrt(N) + N sigma_3 goes through both points.
    n = (1 + np.sin(np.radians(phi))) / (1 - np.sin(np.radians(phi)))
    assert np.allclose(2 * cohesion * np.sqrt(n) + n * np.array([1e5, 2e5]), peaks)
    assert "envelopes of 2 peaks at confining stresses from 0.1 to 0.2 MPa" in str(envelope)
    assert f"  phi       {phi:.2f} degrees" in str(envelope)
    with pytest.raises(clastic.RunError, match="unknown field `nothing`"):
        clastic.sweep(scene="tension", grid={"nothing": [1]}, out=tmp_path / "bad", progress=False)


def test_the_envelope_of_a_cemented_sand_is_near_that_of_its_bonds(tmp_path: Path) -> None:
    """The cement of the scene has a cohesion of 50 kPa and a friction of 0.5 (26.6 degrees); contacts that rearrange
    add to both."""
    walls = [f"stages.confine.walls.{name}.stress" for name in ("left", "right", "bottom", "top")]
    fields = [word for wall in walls for word in ("--field", wall)]
    stop = ["--set", 'stages.load.stop=[Above("axial_strain", 0.02)]']
    found = ["--confining", "50e3,100e3,200e3", "--out", str(tmp_path), "--quiet"]
    said = program("envelope", "biaxial_small", *found, *fields, *stop).stdout
    value = {line.split()[0]: float(line.split()[1]) for line in said.splitlines() if line.startswith("  ") and "not" not in line}
    assert 0.03 < value["c"] < 0.08 and 25.0 < value["phi"] < 36.0, said
    assert "the envelopes include 3 runs with marks" in said
    assert len((tmp_path / "envelope.csv").read_text().splitlines()) == 4


def test_an_envelope_prepares_the_specimen_of_each_seed_once(tmp_path: Path) -> None:
    scenes = Path(__file__).parents[2] / "scenes"
    walls = [f"stages.confine.walls.{name}.stress" for name in ("left", "right", "bottom", "top")]
    fields = [word for wall in walls for word in ("--field", wall)]
    packing = ["--prepare", str(scenes / "prepare_and_branch.ron"), "--seeds", "7,8", "--seed-field", "specimen.seed"]
    found = ["--confining", "50e3,100e3", "--set", "stages.shear.increments=10", "--out", str(tmp_path), "--quiet"]
    scene = str(scenes / "prepare_and_branch_100kPa.ron")
    said = program("envelope", scene, *packing, *fields, *found).stdout
    assert "envelopes of 4 peaks at confining stresses from 0.05 to 0.1 MPa" in said
    assert "standard deviation over 2 seeds" in said
    runs = [run for run in tmp_path.iterdir() if (run / "run.json").exists()]
    assert len(runs) == 4 + 2, "a packing of each seed, and two tests of it"
    rows = [line.split(",")[:2] for line in (tmp_path / "envelope.csv").read_text().splitlines()[1:]]
    assert rows == [["7", "50000.0"], ["8", "50000.0"], ["7", "100000.0"], ["8", "100000.0"]]


def test_an_envelope_of_runs_without_a_peak_is_none(tmp_path: Path) -> None:
    """Packings that jam have no peaks: the command told of "0 peaks from inf to -inf MPa"."""
    rig = Path(__file__).parents[2] / "rigs" / "biaxial.ron"
    envelope = clastic.envelope(
        rig, [50e3, 100e3], set={"stages.compact.target": "Porosity(0.12)"}, out=tmp_path, progress=False
    )
    assert "no run has a peak" in str(envelope) and "inf" not in str(envelope)


def test_an_envelope_says_what_it_needs(tmp_path: Path) -> None:
    two = ["--confining", "1e5,2e5", "--out", str(tmp_path)]
    for arguments, code, told in (
        (["--confining", "1e5"], 3, "two confining stresses"),
        ([*two, "--seeds", "1,x"], 2, "write whole numbers"),
        (two, 1, "--field"),
    ):
        assert told in program("envelope", "biaxial_small", *arguments, code=code).stderr


def test_the_program_comes_with_the_package() -> None:
    assert "biaxial_small" in program("list").stdout
    program("check", "no_such_scene", code=1)
    assert os.environ.get("MPLBACKEND")
