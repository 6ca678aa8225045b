"""Parameters of grains and bonds that give a specimen the properties of a material.

Most of a calibration is similarity, which takes no search: in statics without gravity a modulus follows all stiffnesses,
and a strength all strengths of bonds, each by one factor. Runs seek the ratios that are left, such as k_t/k_n. Four rules
keep their number small:

- A ratio is fitted with those tests alone that it acts on, tests of few ratios first: k_t/k_n with an elastic test.
- Gauss-Newton steps need differences once. Afterwards every run improves the derivatives (Broyden's update).
- The first seed alone is searched, with the distance of all seeds from it at the start of a fit. All seeds verify the end.
- A run lies in a folder that is named by the hash of its scene, and is never made twice.

SciPy solves for a step. Its own searches repeat the differences for each step, or know no limits.
"""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _engine
from ._scene import Scene, Settings, _nested
from .errors import RunWarning
from .results import Run
from .run import check, run

if TYPE_CHECKING:
    import pandas

#: What a quantity is proportional to: stiffness (a modulus), strength (a stress), their ratio (a strain).
SCALES = ("stiffness", "strength", "strain")
#: Searches, each with a verification by all seeds.
SEARCHES = 4
#: Steps as parts of the range between the limits of a parameter: of the first differences, the longest, and the
#: shortest. Results jump where another bond breaks first, so that the derivatives of a step have half their weight
#: where it is as long as JUMPS, and less where it is shorter.
DIFFERENCE, MAXIMUM, MINIMUM, JUMPS = 0.15, 0.25, 0.005, 0.04
#: Strains at which a curve is compared.
POINTS = 50


def _check_scales(name: str, scales: str | None) -> None:
    if scales not in (None, *SCALES):
        raise ValueError(f"{name}: scales is {scales!r}; {_meant(scales, SCALES)}")


def _meant(word: Any, words: Sequence[str]) -> str:
    """The word that was probably meant, or all that there are."""
    near = get_close_matches(str(word), words, 1)
    return f"did you mean {near[0]!r}?" if near else f"give one of {', '.join(words)}"


def _scale(scales: str | None, factors: np.ndarray) -> float:
    """Factor on a quantity, of the logarithms of the factors on stiffnesses and strengths."""
    stiffness, strength = factors
    logs = {"stiffness": stiffness, "strength": strength, "strain": strength - stiffness}
    return float(np.exp(logs.get(scales or "", 0.0)))


@dataclass(frozen=True)
class Parameter:
    """A parameter of the scenes.

    Parameters
    ----------
    name
        Its name in the result.
    paths
        Fields that have its value in all scenes, or by the names of the tests that it acts on.
    start
        Value of the first run.
    scales
        ``stiffness`` of stiffnesses, ``strength`` of stresses that limit bonds, ``strain`` of steps of
        displacement: these keep their ratios, and one factor for each kind follows from similarity. None of
        a number that runs seek. A ratio of two parameters is such a number where the scene has
        ``let: {"ratio": 3.0, "cohesion": ratio * tensile}``.
    low, high
        Limits of a number that runs seek. Above zero its logarithm is sought.
    """

    name: str
    paths: Sequence[str] | Mapping[str, Sequence[str]]
    start: float
    scales: str | None = None
    low: float | None = None
    high: float | None = None

    def __post_init__(self) -> None:
        _check_scales(self.name, self.scales)
        if self.scales is None and (self.low is None or self.high is None or not self.low < self.high):
            raise ValueError(f"{self.name}: give low and high, between which it is sought")

    def paths_of(self, test: str) -> Sequence[str]:
        """Fields of the scene of a test that have its value."""
        return self.paths.get(test, ()) if isinstance(self.paths, Mapping) else self.paths

    def part(self, value: float) -> float:
        """Part of the way from low to high, 0 to 1."""
        low, high, at = self._ends(value)
        return (at - low) / (high - low)

    def value(self, part: float) -> float:
        """The value at a part of the way."""
        low, high, _ = self._ends(self.start)
        at = low + part * (high - low)
        return float(np.exp(at)) if self.low > 0.0 else float(at)

    def _ends(self, value: float) -> Sequence[float]:
        ends = self.low, self.high, np.clip(value, self.low, self.high)
        return np.log(ends) if self.low > 0.0 else ends


@dataclass(frozen=True)
class Target:
    """A property that the specimen is to have.

    Parameters
    ----------
    test
        Name of the test, or names of several.
    result
        Key result of ``run.json``, such as ``youngs_modulus_pa`` or ``strength_pa``; or a function of
        the runs of the tests, such as :func:`friction_angle`.
    value
        Wanted value; its sign is that of the result.
    scales
        ``stiffness`` of a modulus, ``strength`` of a stress, ``strain`` of a strain at rupture, None of
        another number without unit.
    weight
        Weight of the relative error.
    """

    test: str | Sequence[str]
    result: str | Callable[..., float]
    value: float
    scales: str | None = None
    weight: float = 1.0

    def __post_init__(self) -> None:
        _check_scales(f"target {self.name}", self.scales)
        if isinstance(self.result, str) and len(self.tests) != 1:
            raise ValueError(f"target {self.name}: a key result has one test; give a function of several")

    @property
    def tests(self) -> Sequence[str]:
        """Names of its tests."""
        return [self.test] if isinstance(self.test, str) else list(self.test)

    @property
    def name(self) -> str:
        """Key result, or name of the function."""
        return self.result if isinstance(self.result, str) else self.result.__name__

    def measure(self, runs: Sequence[Run]) -> float:
        """Value of the runs of one seed; NaN where it is not defined."""
        if callable(self.result):
            try:
                return float(self.result(*runs))
            except ValueError:
                return np.nan
        results = runs[0].results
        if self.result not in results:
            what = f"{self.result} is no key result of {self.test}"
            raise ValueError(f"{what}; {_meant(self.result, list(results))}")
        return np.nan if results[self.result] is None else float(results[self.result])

    def doubt(self, runs: Sequence[Run | None]) -> str:
        """Why it has no error for the runs of a seed."""
        if failed := [test for test, run in zip(self.tests, runs) if run is None]:
            return f"{failed[0]} failed"
        if callable(self.result):
            try:
                self.result(*runs)
            except ValueError as error:
                return str(error)
        return runs[0].reasons.get(self.name, "its sign is not that of the target")

    def errors(self, measured: Sequence[float], factors: np.ndarray) -> np.ndarray:
        """Weighted logarithm of the mean over the seeds, after scaling, over the value."""
        ratio = np.mean(measured) * _scale(self.scales, factors) / self.value
        return np.array([self.weight * np.log(ratio) if ratio > 0.0 else np.nan])

    def row(self, measured: Sequence[float]) -> dict[str, Any]:
        """Row of the table of targets."""
        reached = float(np.mean(measured))
        deviation = float(np.std(measured, ddof=1)) if len(measured) > 1 else np.nan
        return {"reached": reached, "deviation": deviation, "error": reached / self.value - 1.0}


@dataclass(frozen=True)
class Curve:
    """A whole curve of an experiment that a test is to follow.

    The residuals are the differences of the stress in the middle of 50 equal steps of strain up to the last
    of the experiment, over its largest stress; beyond its end a run keeps its last stress. The error of the
    curve is their root mean square.

    Parameters
    ----------
    test
        Name of the test.
    points
        Strains and stresses (Pa), shape (k, 2), with the signs of the test; or a CSV file with the columns
        ``axial_strain`` and ``axial_stress_pa``.
    weight
        Weight of the error.
    """

    test: str
    points: Any
    weight: float = 1.0
    name: str = "curve"

    def __post_init__(self) -> None:
        points = self.points
        if isinstance(points, (str, os.PathLike)):
            import pandas

            table = pandas.read_csv(points)
            columns = ["axial_strain", "axial_stress_pa"]
            if missing := [name for name in columns if name not in table]:
                raise ValueError(f"{points}: no column {missing[0]}; it has {', '.join(table)}")
            points = table[columns].to_numpy()
        points = np.array(points, float)
        if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 2 or not np.isfinite(points).all():
            raise ValueError(f"curve of {self.test}: give two or more pairs of a strain and a stress")
        object.__setattr__(self, "points", points)

    #: Its strains and stresses have both factors.
    scales = "curve"
    value = 0.0

    @property
    def tests(self) -> Sequence[str]:
        """Name of its test."""
        return [self.test]

    def measure(self, runs: Sequence[Run]) -> np.ndarray:
        """Strains and stresses of a run, from its initial state on."""
        return runs[0].curve("axial_stress_pa")

    def doubt(self, runs: Sequence[Run | None]) -> str:
        """Why it has no error for the run of a seed."""
        return "the run has no axial strains and stresses" if runs[0] else f"{self.test} failed"

    def start(self, measured: Sequence[np.ndarray]) -> np.ndarray:
        """Factors that bring the peak of the first seed to that of the experiment."""
        wanted, found = (c[np.abs(c[:, 1]).argmax()] for c in (self.points, measured[0]))
        strain, strength = np.log(np.abs(wanted / found))
        return np.array([strength - strain, strength])

    def errors(self, measured: Sequence[np.ndarray], factors: np.ndarray) -> np.ndarray:
        """Weighted differences of the mean curve over the seeds, after scaling, over the peak."""
        if not all(np.ndim(curve) == 2 and len(curve) > 1 for curve in measured):
            return np.full(POINTS, np.nan)
        strains = (np.arange(POINTS) + 0.5) / POINTS * self.points[-1, 0]
        stresses = [
            np.interp(*_rising(strains, curve[:, 0] * _scale("strain", factors)), curve[:, 1])
            for curve in measured
        ]
        wanted = np.interp(*_rising(strains, self.points[:, 0]), self.points[:, 1])
        found = np.mean(stresses, axis=0) * _scale("strength", factors)
        return self.weight * (found - wanted) / np.abs(self.points[:, 1]).max() / np.sqrt(POINTS)

    def row(self, measured: Sequence[np.ndarray]) -> dict[str, Any]:
        """Row of the table of targets."""
        error = float(np.linalg.norm(self.errors(measured, np.zeros(2)))) / self.weight
        return {"reached": error, "deviation": np.nan, "error": error}


def _rising(strains: np.ndarray, of_curve: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Both with the sign that lets them rise. Strains that go back, as in an avalanche, stand still."""
    sign = 1.0 if strains[-1] > 0.0 else -1.0
    return sign * strains, np.maximum.accumulate(sign * of_curve)


def _peaks(runs: Sequence[Run]) -> list[tuple[float, float]]:
    """Lateral and axial stresses (Pa) at the peaks."""
    peaks = [run.peak_stresses() for run in runs]
    if np.ptp([sigma_3 for sigma_3, _ in peaks]) == 0.0:
        raise ValueError("the runs have one lateral stress: give several, and measure `lateral_stress`")
    return peaks


def cohesion(*runs: Run) -> float:
    """Cohesion (Pa) of the peaks of runs with different lateral stresses, by least squares of sigma_1.

    Raises
    ------
    ValueError
        If a run has no peak, or all have one lateral stress. It is the `lateral_stress` of the scene at the
        peak, and 0 where the scene measures none.
    """
    return _engine.mohr_coulomb(_peaks(runs))[0]


def friction_angle(*runs: Run) -> float:
    """Friction angle (degrees) of the same line. Errors are those of :func:`cohesion`."""
    return _engine.mohr_coulomb(_peaks(runs))[1]


def hoek_brown_m(*runs: Run) -> float:
    """m_i of the peaks of runs with different lateral stresses, by least squares of
    (sigma_1 - sigma_3)^2 = sigma_ci^2 + m_i sigma_ci sigma_3.

    Raises
    ------
    ValueError
        As :func:`cohesion`, or if the line gives no sigma_ci.
    """
    sigma_3, sigma_1 = np.transpose(_peaks(runs))
    slope, square = np.polyfit(sigma_3, (sigma_1 - sigma_3) ** 2, 1)
    if square <= 0.0:
        raise ValueError("the strengths of these runs have no sigma_ci: the line begins below zero")
    return float(slope / np.sqrt(square))


@dataclass
class Calibration:
    """Result of :func:`calibrate`."""

    #: Values of the parameters.
    parameters: dict[str, float]
    #: Targets with what was reached: the mean over the seeds, their standard deviation (n - 1), and the
    #: relative error of the mean; of a curve the root mean square of its differences over its peak.
    targets: pandas.DataFrame
    #: All runs: test, seed, parameters, directory, whether it was there already, status, marks, results.
    runs: pandas.DataFrame
    #: Number of runs that were made, preparations among them, and of those that were there already.
    made: int = 0
    cached: int = 0
    #: Whether all targets were reached within the tolerance.
    success: bool = False
    #: How it ended.
    message: str = ""

    def _repr_html_(self) -> str:
        return self.targets._repr_html_()


@dataclass
class _Search:
    tests: Mapping[str, tuple[Scene, Settings]]
    targets: Sequence[Target | Curve]
    parameters: Sequence[Parameter]
    seeds: Sequence[int | None]
    seed_paths: Sequence[str]
    prepare: tuple[Scene, Settings] | None
    out: Path
    jobs: int | None
    #: Logarithms of the factors on stiffnesses and strengths that the runs have.
    factors: np.ndarray = field(default_factory=lambda: np.zeros(2))
    #: What the errors of all seeds differ by from those of the first.
    offsets: list[Any] = field(default_factory=list)
    rows: dict[Path, dict[str, Any]] = field(default_factory=dict)
    found: dict[Path, Run | None] = field(default_factory=dict)
    #: Latest runs by test and seed.
    last: dict[tuple[str, int | None], Run | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.sought = [p for p in self.parameters if p.scales is None]
        self.offsets = [0.0 for _ in self.targets]

    @property
    def made(self) -> int:
        """Number of runs that were made."""
        return sum(not row["cached"] for row in self.rows.values())

    def values(self, parts: np.ndarray) -> dict[str, float]:
        """Values of all parameters."""
        found = {p.name: p.value(part) for p, part in zip(self.sought, parts)}
        scaled = {p.name: p.start * _scale(p.scales, self.factors) for p in self.parameters if p.scales}
        return {p.name: (found | scaled)[p.name] for p in self.parameters}

    def results(self, parts: np.ndarray, chosen: Sequence[int], seeds: Sequence[int | None]) -> list[list]:
        """What the chosen targets measure, by target and seed; NaN where a run failed."""
        values = self.values(parts)
        tests = [name for name in self.tests if any(name in self.targets[i].tests for i in chosen)]
        work = [(test, seed) for test in tests for seed in seeds]
        with ThreadPoolExecutor(self.jobs or os.cpu_count()) as pool, warnings.catch_warnings():
            # Doubts are in the column `marks`.
            warnings.simplefilter("ignore", RunWarning)
            specimens = dict(zip(seeds, pool.map(self.specimen, seeds)))
            runs = dict(zip(work, pool.map(lambda w: self.test(*w, values, specimens[w[1]]), work)))
        self.last = runs
        measured = []
        for target in (self.targets[i] for i in chosen):
            of = [[runs[test, seed] for test in target.tests] for seed in seeds]
            measured.append([target.measure(some) if all(some) else np.nan for some in of])
        return measured

    def doubt(self, target: Target | Curve) -> str:
        """Why a target has no error in the latest runs of all seeds."""
        of = {seed: [self.last[test, seed] for test in target.tests] for seed in self.seeds}
        seed = next(
            (s for s, runs in of.items() if not all(runs) or np.isnan(target.measure(runs)).any()),
            self.seeds[0],
        )
        where = ", ".join(target.tests) + ("" if seed is None else f", seed {seed}")
        return f"{target.name} of {where} is not defined: {target.doubt(of[seed])}"

    def specimen(self, seed: int | None) -> Settings | None:
        """Settings of the tests of a seed; None if its preparation failed."""
        at_seed = {} if seed is None else {path: seed for path in self.seed_paths}
        if self.prepare is None:
            return at_seed
        scene, sets = self.prepare
        done = self.run({"test": "prepare", "seed": seed}, scene, {**sets, **at_seed})
        return done and {"specimen.path": _nested(str(done.path / "final_state.npz"))}

    def test(
        self, test: str, seed: int | None, values: Mapping[str, float], specimen: Settings | None
    ) -> Run | None:
        """A test; None if it failed."""
        if specimen is None:
            return None
        scene, sets = self.tests[test]
        settings = {**sets, **specimen}
        settings |= {path: values[p.name] for p in self.parameters for path in p.paths_of(test)}
        return self.run({"test": test, "seed": seed, **values}, scene, settings)

    def run(self, row: dict[str, Any], scene: Scene, settings: Settings) -> Run | None:
        """A run, unless one of the same text is there. None if it failed."""
        # The directory may be moved, and its runs stay what they are.
        text = check(scene, settings)["text"].replace(str(self.out), "")
        folder = self.out / hashlib.sha256(f"{_engine.__version__}\n{text}".encode()).hexdigest()[:16]
        if folder in self.rows:
            return self.found[folder]
        ended = ("completed", "collapsed", "undecided", "refused")
        there = (folder / "run.json").exists() and Run(folder).status in ended
        done = Run(folder) if there else run(scene, settings, folder, force=True, threads=1, progress=False)
        row |= {"directory": str(folder), "cached": there, "status": done.status}
        row |= {"marks": "; ".join(done.marks)}
        row |= {
            t.name: done.results[t.name]
            for t in self.targets
            if row["test"] in t.tests and t.name in done.results
        }
        self.rows[folder] = row
        self.found[folder] = done if done.status in ("completed", "collapsed") else None
        return self.found[folder]

    def errors(self, measured: list[list], chosen: Sequence[int], factors: np.ndarray) -> list[np.ndarray]:
        """Errors of the chosen targets of all seeds once the results are scaled by more factors."""
        of = zip(chosen, measured)
        return [self.targets[i].errors(seeds, factors) + self.offsets[i] for i, seeds in of]

    def similar(self, measured: list[list], chosen: Sequence[int]) -> np.ndarray:
        """More factors, which bring the results nearest to the targets."""
        from scipy.optimize import least_squares

        kinds = [
            any(p.scales == kind for p in self.parameters)
            and any(self.targets[i].scales in (kind, "strain", "curve") for i in chosen)
            for kind in ("stiffness", "strength")
        ]
        start = np.zeros(2)
        for i, seeds in zip(chosen, measured):
            if isinstance(self.targets[i], Curve) and np.ndim(seeds[0]) == 2:
                start = np.where(kinds, self.targets[i].start(seeds), 0.0)
        if not any(kinds):
            return start

        def errors(some: np.ndarray) -> np.ndarray:
            factors = np.zeros(2)
            factors[kinds] = some
            every = np.concatenate(self.errors(measured, chosen, factors))
            return every[defined]

        defined = np.isfinite(np.concatenate(self.errors(measured, chosen, start)))
        if defined.any():
            start[kinds] = least_squares(errors, start[kinds], x_scale="jac").x
        return start

    def trial(self, parts: np.ndarray, chosen: Sequence[int]) -> np.ndarray:
        """Errors of the chosen targets at the first seed, with the factors that suit them best."""
        measured = self.results(parts, chosen, self.seeds[:1])
        return np.concatenate(self.errors(measured, chosen, self.similar(measured, chosen)))

    def compare(self, parts: np.ndarray, chosen: Sequence[int]) -> None:
        """Finds by what the errors of all seeds differ from those of the first."""
        measured = self.results(parts, chosen, self.seeds)
        for i, seeds in zip(chosen, measured):
            every, first = (self.targets[i].errors(some, np.zeros(2)) for some in (seeds, seeds[:1]))
            self.offsets[i] = np.nan_to_num(every - first)

    def groups(self) -> list[tuple[list[int], list[int]]]:
        """Sought parameters with the targets that they are fitted to, in the order of the fits. The last group
        has all targets.
        """
        acts = [
            {i for i, p in enumerate(self.sought) if any(p.paths_of(test) for test in t.tests)}
            for t in self.targets
        ]
        groups, done = [], set()
        for size in sorted({len(some) for some in acts}):
            chosen = [k for k, some in enumerate(acts) if len(some) <= size]
            free = set().union(*(acts[k] for k in chosen)) - done
            # Similarity takes one equation for each kind of scale.
            equations = sum(POINTS if isinstance(self.targets[k], Curve) else 1 for k in chosen)
            equations -= len({self.targets[k].scales for k in chosen} - {None})
            last = size == max(len(some) for some in acts)
            if last or (free and equations >= len(done | free)):
                groups.append((sorted(free), chosen))
                done |= free
        return groups

    def fit(
        self,
        parts: np.ndarray,
        free: list[int],
        chosen: list[int],
        slopes: np.ndarray | None,
        goal: float,
        most: int,
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """Gauss-Newton steps of the free parameters within a box, which shrinks where a step fails."""
        from scipy.optimize import lsq_linear

        error = self.trial(parts, chosen)
        box = MAXIMUM
        while free and np.linalg.norm(error) > goal and box > MINIMUM and self.made < most:
            if slopes is None:
                slopes = np.column_stack([self.slope(parts, i, chosen, error) for i in free])
            here = parts[free]
            low, high = np.maximum(-box, -here), np.minimum(box, 1.0 - here)
            step = lsq_linear(slopes, -error, (low - 1e-12, high + 1e-12)).x
            if np.abs(step).max() < MINIMUM:
                break
            there = parts.copy()
            there[free] = np.clip(here + step, 0.0, 1.0)
            next_error = self.trial(there, chosen)
            if np.isfinite(next_error).all():
                surprise = np.outer(next_error - error - slopes @ step, step)
                slopes = slopes + surprise / (step @ step + JUMPS**2)
            if np.linalg.norm(next_error) < np.linalg.norm(error):
                parts, error = there, next_error
            else:
                box = 0.5 * np.abs(step).max()
        return parts, slopes

    def slope(self, parts: np.ndarray, i: int, chosen: list[int], error: np.ndarray) -> np.ndarray:
        """Derivative of the errors by a parameter, by a difference to the side that has more room, or else to
        the other; zero where both runs fail.
        """
        inward = DIFFERENCE if parts[i] < 0.5 else -DIFFERENCE
        for step in (inward, -inward):
            there = parts.copy()
            there[i] = np.clip(parts[i] + step, 0.0, 1.0)
            if there[i] != parts[i]:
                slope = (self.trial(there, chosen) - error) / (there[i] - parts[i])
                if np.isfinite(slope).all():
                    return slope
        return np.zeros_like(error)


def calibrate(
    tests: Mapping[str, Scene | tuple[Scene, Settings]],
    targets: Sequence[Target | Curve],
    parameters: Sequence[Parameter],
    *,
    seeds: Sequence[int] = (),
    seed_paths: Sequence[str] = ("let.seed",),
    prepare: Scene | tuple[Scene, Settings] | None = None,
    tolerance: float = 0.02,
    max_runs: int = 100,
    out: str | os.PathLike[str] = "runs/calibration",
    jobs: int | None = None,
) -> Calibration:
    """Finds parameters of grains and bonds for which tests of a specimen have given results.

    Two factors take no search. In statics without gravity a modulus is proportional to the
    stiffnesses, all in one ratio, and a strength without confining stress to the strengths of the
    bonds, as long as strains are small. The other parameters are sought by Gauss-Newton steps on the
    logarithms of the results over their targets, in which the two factors are the best for each trial.
    A parameter is fitted before others if the targets that it alone acts on suffice: give its ``paths``
    by test where it does not act on all. The search has the first seed. Runs of all seeds then have the
    parameters that were found, and are searched again from there where their means are not within the
    tolerance.

    Parameters
    ----------
    tests
        Scenes by name, each a scene or a pair of a scene and its settings.
    targets, parameters
        What is to be reached, and what may change.
    seeds
        Seeds of the specimen: each test runs with each, and the means count.
    seed_paths
        Fields that are the seed, of the preparation if there is one, else of the tests.
    prepare
        A scene, or a pair with its settings, whose final state is the specimen of all tests of a seed
        (``specimen: State(path: ...)``). It has none of the parameters and is run once a seed.
    tolerance
        Relative error within which a target counts as reached.
    max_runs
        Number of runs after which no other search begins.
    out
        Directory of the runs, which have the names of hashes of their scenes: what is there already
        is not run again.
    jobs
        Maximum number of simultaneous runs.

    Raises
    ------
    ValueError
        If a target names no test or no key result, or if nothing may change.
    """
    import pandas

    def pair(scene: Scene | tuple[Scene, Settings]) -> tuple[Scene, Settings]:
        return scene if isinstance(scene, tuple) else (scene, {})

    for target in targets:
        if unknown := [name for name in target.tests if name not in tests]:
            raise ValueError(f"the target {target.name} names no test: `{unknown[0]}`")
    if not targets or not parameters:
        raise ValueError("give targets and parameters")
    search = _Search(
        {name: pair(scene) for name, scene in tests.items()},
        targets,
        parameters,
        list(seeds) or [None],
        seed_paths,
        None if prepare is None else pair(prepare),
        Path(out).absolute(),
        jobs,
    )
    parts = np.array([p.part(p.start) for p in search.sought])
    every = list(range(len(targets)))
    allowed = tolerance * np.array([t.weight for t in targets])
    groups = search.groups()
    slopes: list[np.ndarray | None] = [None] * len(groups)
    best, message = (np.inf, {}, []), "no search brought the results nearer"
    for _ in range(SEARCHES):
        before = len(search.rows)
        for k, (free, chosen) in enumerate(groups):
            search.compare(parts, chosen)
            # Two targets that pull in opposite directions then have half the tolerance each.
            goal = np.sqrt(0.5) * allowed[chosen].min()
            parts, slopes[k] = search.fit(parts, free, chosen, slopes[k], goal, max_runs)
        # All tests of the first seed, most of which are there, give the factors.
        measured = search.results(parts, every, search.seeds[:1])
        search.factors = search.factors + search.similar(measured, every)
        measured = search.results(parts, every, search.seeds)
        errors = [t.errors(seeds, np.zeros(2)) for t, seeds in zip(targets, measured)]
        worst = float(np.max([np.linalg.norm(e) / a for e, a in zip(errors, allowed)]))
        if not best[2] or worst < best[0]:
            best = (worst, search.values(parts), measured)
        if worst <= 1.0:
            message = "all targets are within the tolerance"
            break
        if missing := [t for t, e in zip(targets, errors) if not np.isfinite(e).all()]:
            message = search.doubt(missing[0])
            break
        if search.made >= max_runs:
            message = f"{max_runs} runs were made"
            break
        if len(search.rows) == before:
            break
    worst, values, measured = best
    ends = [p.name for p in search.sought if not MINIMUM < p.part(values[p.name]) < 1.0 - MINIMUM]
    if worst > 1.0 and ends:
        message += f"; at a limit: {', '.join(ends)}"
    table = pandas.DataFrame(
        {"test": ", ".join(t.tests), "result": t.name, "target": t.value, **t.row(seeds)}
        for t, seeds in zip(targets, measured)
    )
    runs = pandas.DataFrame(search.rows.values())
    return Calibration(
        parameters=values,
        targets=table,
        runs=runs,
        made=search.made,
        cached=len(runs) - search.made,
        success=worst <= 1.0,
        message=message,
    )
