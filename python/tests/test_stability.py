"""Slopes beside the upper bound of limit analysis."""

from __future__ import annotations

import csv
import time
from pathlib import Path

import numpy as np
import pandas
import pytest

import clastic
from clastic._folders import Folders
from clastic._ramp import Ramp
from clastic.stability import _slid_before_ramp
from conftest import program

#: Two disks under a ceiling, far above a floor.
HANGING = """(
    version: 1, title: "disks that hang",
    let: {"gravity": 9.81, "share": 0.1},
    materials: {
        "weak": (density: 2000.0, contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 4.0e3, tensile_strength: 4.0e3)),
        "strong": (density: 2000.0, contact: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, friction: 0.5),
            bond: (normal_stiffness: 1.0e8, tangential_stiffness: 1.0e8, cohesion: 4.0e4, tensile_strength: 4.0e4)),
    },
    specimen: Particles([
        (position: (0.0, -0.1), radius: 0.1, material: "weak"),
        (position: (2.0, -0.5), radius: 0.5, material: "strong"),
    ]),
    walls: [
        (name: "ceiling", start: (3.0, 0.0), end: (-1.0, 0.0), contact: (normal_stiffness: 1.0e8)),
        (name: "floor", start: (-1.0, -10.5), end: (3.0, -10.5), contact: (normal_stiffness: 1.0e8, friction: 0.5)),
    ],
    stages: [
        Cement(name: "cement", length: 1.0e-6, walls: true),
        Load(name: "weight", increments: 1, gravity: (0.0, -gravity)),
        Load(name: "ramp", increments: 47, gravity: (0.0, -gravity), scale: (gravity: [(0.0, 1.0), (1.0, 4.0)]),
            stop: [Above("sliding", share)]),
    ],
    reference_stage: "weight",
    measures: [(name: "sliding", of: Grains(amount: Share, moved: 0.08))],
    output: (plots: false),
)"""

SCENES = Path(__file__).parents[2] / "scenes"
#: Ten disks over the height, and blocks of six disks: a twentieth of the work.
SLOPE = {
    "let.base": 0.5,
    "let.front": 0.6,
    "let.back": 1.4,
    "specimen.count": 252,
    "specimen.columns": 18,
    "cell.size": "(18 * 2.55 * radius, 14 * 2.55 * radius)",
}


@pytest.mark.parametrize(
    ("angle", "friction_angle", "number"),
    [
        (90.0, 0.0, 3.83),
        (60.0, 0.0, 5.24),
        (90.0, 20.0, 5.50),
        (75.0, 20.0, 7.48),
        (60.0, 20.0, 10.39),
        (45.0, 20.0, 16.16),
        (60.0, 30.0, 16.04),
        # Below the toe.
        (45.0, 0.0, 5.53),
        (30.0, 5.0, 9.13),
        (15.0, 5.0, 14.38),
    ],
)
def test_stability_numbers_are_those_of_chen(angle: float, friction_angle: float, number: float) -> None:
    """Table of Chen, Limit Analysis and Soil Plasticity (1975)."""
    assert clastic.log_spiral(angle, friction_angle).number == pytest.approx(number, rel=5e-3)


def test_a_spiral_meets_crest_and_toe_at_the_friction_angle() -> None:
    """The normality rule: its tangent and the line across the radius enclose the friction angle."""
    spiral = clastic.log_spiral(60.0, 20.0)
    x = spiral.points(4.0, (1.3, 1.0))
    assert x[-1] == pytest.approx((1.3, 1.0)) and x[0, 1] == pytest.approx(5.0)
    size = (x[0, 0] - x[-1, 0]) / (
        np.cos(spiral.start)
        - np.exp((spiral.end - spiral.start) * np.tan(spiral.friction)) * np.cos(spiral.end)
    )
    radii = np.hypot(*(x - (x[0] - size * np.array([np.cos(spiral.start), -np.sin(spiral.start)]))).T)
    turned = np.linspace(spiral.start, spiral.end, len(x))
    growth = np.polyfit(turned, np.log(radii), 1)[0]
    assert np.degrees(np.arctan(growth)) == pytest.approx(20.0, abs=1e-6)
    with pytest.raises(ValueError, match="steeper than the friction angle"):
        clastic.log_spiral(30.0, 30.0)
    # Chen finds 14.8 through the toe.
    below = clastic.log_spiral(15.0, 5.0)
    assert below.front > 0.3 and spiral.front == pytest.approx(0.0, abs=1e-6)
    assert below.points(4.0, (1.3, 1.0))[-1] == pytest.approx((1.3 - 4.0 * below.front, 1.0))


def test_factors_on_gravity_and_on_strength() -> None:
    """Without friction both are N_s c / (gamma H); with it a slope at its limit has the factor 1 by both."""
    for of in ("gravity", "strength"):
        factor, _ = clastic.critical_factor(of, 90.0, 0.0, 20e3, 50e3)
        assert factor == pytest.approx(3.83 * 20e3 / 50e3, rel=5e-3)
        limit = clastic.log_spiral(60.0, 20.0).number * 5e3
        factor, spiral = clastic.critical_factor(of, 60.0, 20.0, 5e3, limit)
        assert factor == pytest.approx(1.0, rel=1e-6)
        assert np.degrees(spiral.friction) == pytest.approx(20.0, rel=1e-6)
    factor, spiral = clastic.critical_factor("strength", 60.0, 30.0, 20e3, 100e3)
    assert np.tan(spiral.friction) == pytest.approx(np.tan(np.radians(30.0)) / factor)
    assert spiral.number * 20e3 / factor == pytest.approx(100e3, rel=1e-6)
    for of in ("gravity", "strength"):
        with pytest.raises(ValueError, match="a cohesion of -200 Pa"):
            clastic.critical_factor(of, 60.0, 30.0, -200.0, 100e3)


def test_a_slope_slides_near_the_bound_of_its_own_ground(tmp_path: Path) -> None:
    """One packing of ten disks over the height is within a factor of two of the bound."""
    words = {
        "height": 2.0,
        "toes": [(0.75, 0.6)],
        "places": [(0.1, 0.1), (1.4, 0.1)],
        "most": 20.0,
        "seeds": [1],
    }

    def stability(every: int = 1, **block: float) -> clastic.Stability:
        of_slope = SCENES / "slope.ron", {**SLOPE, "stages.ramp.record.every": every}
        of_block = SCENES / "slope_block.ron", {"let.width": 1.2, **block}
        return clastic.stability(of_slope, of_block, **words, out=tmp_path)

    found = stability()
    (slope,) = found.slides.itertuples()
    assert found.factor == slope.factor and slope.share >= 0.1
    assert found.unit_weight == pytest.approx(2000.0 * 9.81 * 0.83, rel=0.03)
    peaks = [np.array([0.0, 0.25, 0.5]) * found.factor * found.unit_weight * 2.0]
    peaks += [found.blocks[f"strength_{part}_pa"].mean() for part in ("0", "0.25", "0.5")]
    # The line of all blocks is that of their means: sigma_1 = 2 c tan(45 + phi/2) + sigma_3 tan^2(45 + phi/2).
    rise, zero = np.polyfit(peaks[0], peaks[1:], 1)
    assert found.friction_angle == pytest.approx(2.0 * np.degrees(np.arctan(np.sqrt(rise))) - 90.0, rel=1e-3)
    assert found.cohesion == pytest.approx(zero / (2.0 * np.sqrt(rise)), rel=1e-3)
    number = clastic.log_spiral(60.0, found.friction_angle).number
    assert found.bound == pytest.approx(number * found.cohesion / (found.unit_weight * 2.0))
    assert 0.5 < found.ratio < 2.0
    # What moves lies in front of the spiral, and what rests behind it.
    run = clastic.open(slope.directory)
    end, start = run.frame("end"), run.frame("start")
    slid = np.hypot(*end.moved(start).T) >= 0.04
    assert end.positions[slid, 0].mean() < end.positions[~slid, 0].mean()
    clastic.figures.slide(found).figure.savefig(tmp_path / "slide.png")
    # The command finds the same with the runs that are there, and writes it down.
    arguments = ["stability", str(SCENES / "slope.ron"), "--block", str(SCENES / "slope_block.ron"), "--height", "2.0"]
    arguments += ["--cuts", "0.75,0.6", "--places", "0.1,0.1", "1.4,0.1", "--most", "20", "--seeds", "1", "--out", str(tmp_path)]
    for path, value in {**SLOPE, "stages.ramp.record.every": 1}.items():
        arguments += ["--set", f"{path}={value}"]
    said = program(*arguments, "--set-block", "let.width=1.2").stdout
    assert f"factor on gravity: {found.factor:.2f} (slopes: 1); bound {found.bound:.2f}" in said
    (row,) = csv.DictReader((tmp_path / "slides.csv").open())
    assert (float(row["factor"]), float(row["toe_x_m"])) == (slope.factor, 0.75)
    assert row["directory"] == Path(slope.directory).name
    assert len(list(tmp_path.glob("*/run.json"))) == len(found.runs)
    (row,) = csv.DictReader((tmp_path / "summary.csv").open())
    assert float(row["bound"]) == found.bound and float(row["height"]) == 2.0 and row["of"] == "gravity"
    assert len(list(csv.DictReader((tmp_path / "blocks.csv").open()))) == 2
    assert (tmp_path / "slide.png").read_bytes().startswith(b"\x89PNG")
    # Nothing is run again, nor is the factor that of a history with every seventh row.
    again = stability(every=7)
    assert again.factor == found.factor and again.runs["cached"].all()
    with pytest.raises(ValueError, match="has not yielded: give it more increments"):
        stability(**{"stages.load.increments": 3})


def test_a_slope_that_slid_before_the_ramp_has_no_factor(tmp_path: Path) -> None:
    """A slope of 1 kPa that slides at a tenth of its weight, and lies then, had the factor infinity."""
    weak = SCENES / "slope.ron", {**SLOPE, "let.cohesion": 1.0e3}
    with pytest.raises(ValueError, match="slides in stage (settle|weight), before the ramp"):
        clastic.stability(weak, height=2.0, toes=[(0.75, 0.6)], seeds=[1], out=tmp_path)


def test_a_slide_that_the_ramp_began_is_none_before_it() -> None:
    """A folder with finished slides was refused: "it slides in stage slide_1, before the ramp"."""
    stages = ["weight", "ramp", "slide_1", "ramp"]
    history = pandas.DataFrame({"stage": stages, "sliding": [None, 0.05, 0.2, 0.3]})
    assert _slid_before_ramp(history, 0.1) is None
    assert _slid_before_ramp(history.assign(sliding=0.2), 0.1) == "weight"


@pytest.mark.parametrize("floor", ["-10.5", "-100.0"])
def test_a_grain_that_falls_is_no_slide(tmp_path: Path, floor: str) -> None:
    """Two disks hang from a ceiling. The first bond breaks at 2 r s = f rho pi r^2 g, and its disk, which is 4 % of the
    mass, falls until it lands or is set aside; the slide is the fall of the second.
    """
    radii, strengths = np.array([0.1, 0.5]), np.array([4e3, 40e3])
    first, second = 2.0 * strengths / (2000.0 * np.pi * radii * 9.81)
    assert 1.0 < first < 1.5 < second < 3.0
    load = Ramp("gravity", 4.0, height=4.0, gravity=9.81)
    hanging = HANGING.replace("-10.5", floor)
    run = clastic.run(hanging, {"stages.ramp.scale": load.table(0.0)}, tmp_path / "run", progress=False)
    # A fall that ends on a floor is followed to its end; a longer one of the second disk is a collapse.
    assert run.status == ("completed" if floor == "-10.5" else "collapsed") and len(load.ends(0.0)) - 1 == 47
    factor, run = load.follow(run)
    # To one increment, or to the tolerance of an event.
    assert (1.0 - 5e-4) * second <= factor <= 1.03 * second
    assert "Above" in run.record["stages"][-1]["stop"]
    assert run.history["sliding"].iloc[-1] == 1.0


def test_grains_that_fall_without_end_are_neither_slide_nor_rest(tmp_path: Path) -> None:
    """Two of three disks fall, 7 % of the mass: no slide, but more than half of the grains, which no static stage sets aside."""
    load = Ramp("gravity", 4.0, height=4.0, gravity=9.81)
    disk = '(position: (0.0, -0.1), radius: 0.1, material: "weak"),'
    deep = HANGING.replace("-10.5", "-100.0").replace(disk, disk + disk.replace("0.0, -0.1", "0.5, -0.1"))
    run = clastic.run(deep, {"stages.ramp.scale": load.table(0.0)}, tmp_path / "run", progress=False)
    assert run.status == "collapsed"
    with pytest.raises(ValueError, match="slide_1 ended by .* add walls that stop loose grains"):
        load.follow(run)


def test_the_table_of_runs_has_the_order_of_the_work(tmp_path: Path, scene: Path) -> None:
    """The first work ends last, and the third has the text of the first, which is its run."""
    folders = Folders(tmp_path / "runs", 3)

    def work(place: int) -> None:
        time.sleep(0.3 * (place == 0))
        folders.run(
            {"place": place}, scene, {"stages.rest.increments": (2, 1, 2)[place], "output.plots": False}
        )

    folders.map(work, range(3))
    assert [row["place"] for row in folders.rows.values()] == [0, 1] and folders.made == 2


def test_mistakes_of_a_study_of_a_slope_have_a_remedy(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="give 'gravity' or 'strength'"):
        clastic.stability(of="cohesion", out=tmp_path)
    with pytest.raises(ValueError, match="most is 1.0"):
        clastic.stability(most=1.0, out=tmp_path)


def test_the_command_says_what_is_wrong_with_its_arguments(tmp_path: Path, scene: Path) -> None:
    assert "--on {gravity,strength}" in program("stability", "--help").stdout
    out = ("--out", str(tmp_path))
    for words, code, said in (
        (("slope", "--on", "cohesion"), 2, "invalid choice: 'cohesion'"),
        (("slope", "--cuts", "1.3"), 2, "write x and y in m, as in 1.3,1.0"),
        (("slope", "--set", "let.seed"), 2, "write PATH=VALUE"),
        (("slope", "--jobs", "0"), 2, "write a whole number from 1"),
        (("nowhere", *out), 1, "no scene `nowhere`"),
        ((str(scene), *out), 3, "`let` has no number `height`; give --height"),
        (("slope", "--most", "1", *out), 3, "give a factor above 1.03"),
        (("slope", "--set", "let.hight=3", *out), 3, "hight"),
    ):
        assert said in program("stability", *words, code=code).stderr
