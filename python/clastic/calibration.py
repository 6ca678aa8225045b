"""Parameters of grains and bonds that give a specimen the properties of a material."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._scene import Scene, Settings
from .results import Run
from .run import check, run

if TYPE_CHECKING:
    import pandas

#: What a target is proportional to: stiffness (a modulus), strength (a stress), or nothing.
SCALES = ("stiffness", "strength", "strain")
#: Residual of a target that a run has not reached: a factor of e^3.
FAILED = 3.0


def _check_scales(name: str, scales: str | None) -> None:
    if scales not in (None, *SCALES):
        raise ValueError(f"{name}: scales is {scales!r}; {_meant(scales, SCALES)}")


def _meant(word: Any, words: Sequence[str]) -> str:
    """The word that was probably meant, or all that there are."""
    near = get_close_matches(str(word), words, 1)
    return f"did you mean {near[0]!r}?" if near else f"give one of {', '.join(words)}"


@dataclass(frozen=True)
class Parameter:
    """A parameter of the scenes.

    Parameters
    ----------
    name
        Its name in the result.
    paths
        Fields of the scenes that have its value; by name of the test where scenes differ.
    start
        Value of the first run.
    scales
        ``stiffness`` of stiffnesses, ``strength`` of stresses that limit bonds, ``strain`` of steps of
        displacement, None of a number without such a unit. Parameters of one kind keep their ratios:
        one factor for each kind follows from similarity and takes no further runs.
    low, high
        Limits of a parameter that is sought by runs: one with ``scales=None``, or one that is a ratio
        to the first parameter of its kind (``ratio=True``).
    ratio
        Whether its ratio to the first parameter of its kind is sought. ``start``, ``low`` and
        ``high`` are then those of the ratio.
    """

    name: str
    paths: Sequence[str] | Mapping[str, Sequence[str]]
    start: float
    scales: str | None = None
    low: float | None = None
    high: float | None = None
    ratio: bool = False

    @property
    def is_sought(self) -> bool:
        """Whether runs seek it."""
        return self.ratio or self.scales is None

    def __post_init__(self) -> None:
        _check_scales(self.name, self.scales)
        if self.is_sought and not (self.low is not None and self.high is not None):
            raise ValueError(f"{self.name}: give low and high, between which it is sought")


@dataclass(frozen=True)
class Target:
    """A property that the specimen is to have.

    Parameters
    ----------
    test
        Name of the test.
    result
        Key result of ``run.json``, such as ``youngs_modulus_pa`` or ``strength_pa``.
    value
        Wanted value; its sign is that of the result.
    scales
        ``stiffness`` of a modulus, ``strength`` of a stress, ``strain`` of a strain at rupture, None of
        another number without unit.
    weight
        Weight of the relative error.
    """

    test: str
    result: str
    value: float
    scales: str | None = None
    weight: float = 1.0

    def __post_init__(self) -> None:
        _check_scales(f"target {self.result}", self.scales)


@dataclass
class Calibration:
    """Result of :func:`calibrate`."""

    #: Values of the parameters.
    parameters: dict[str, float]
    #: Targets with what was reached: the mean over the seeds of a last run, and its relative error.
    targets: pandas.DataFrame
    #: All runs: test, seed, parameters, directory, whether it was there already, marks, results.
    runs: pandas.DataFrame
    #: Number of runs that were made, and of those that were there already.
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
    targets: Sequence[Target]
    parameters: Sequence[Parameter]
    seeds: Sequence[int]
    seed_paths: Sequence[str]
    out: Path
    jobs: int | None
    rows: list[dict[str, Any]] = field(default_factory=list)

    def values(self, sought: Sequence[float], factors: Mapping[str, float]) -> dict[str, float]:
        """Values of all parameters, of which the sought ones are given."""
        of = iter(sought)
        found: dict[str, float] = {}
        first: dict[str, float] = {}
        for p in self.parameters:
            if p.scales is not None and not p.ratio:
                found[p.name] = p.start * factors.get(p.scales, 1.0)
                first.setdefault(p.scales, found[p.name])
        for p in self.parameters:
            if p.is_sought:
                x = float(next(of))
                found[p.name] = x * first[p.scales] if p.ratio and p.scales else x
        return found

    def run_all(self, values: Mapping[str, float]) -> dict[tuple[str, str], float]:
        """Mean key results over the seeds, by test and name; NaN where a run failed."""
        work = [(test, seed) for test in self.tests for seed in (self.seeds or [None])]
        with ThreadPoolExecutor(self.jobs or os.cpu_count()) as pool:
            runs = list(pool.map(lambda w: self.run_one(*w, values), work))
        means = {}
        for target in self.targets:
            of_test = [run for (test, _), run in zip(work, runs) if test == target.test]
            names = next((list(run.results) for run in of_test if run), [target.result])
            if target.result not in names:
                what = f"{target.result} is no key result of {target.test}"
                raise ValueError(f"{what}; {_meant(target.result, names)}")
            found = [run.results.get(target.result) if run else None for run in of_test]
            numbers = [np.nan if value is None else float(value) for value in found]
            means[target.test, target.result] = float(np.mean(numbers))
        return means

    def run_one(self, test: str, seed: int | None, values: Mapping[str, float]) -> Run | None:
        """A run, unless one of the same text is there. None if it failed."""
        scene, sets = self.tests[test]
        settings = dict(sets)
        for p in self.parameters:
            paths = p.paths.get(test, ()) if isinstance(p.paths, Mapping) else p.paths
            settings.update({path: values[p.name] for path in paths})
        if seed is not None:
            settings.update({path: seed for path in self.seed_paths})
        text = check(scene, settings)["text"]
        folder = self.out / hashlib.sha256(text.encode()).hexdigest()[:16]
        ended = ("completed", "collapsed", "undecided", "refused")
        there = (folder / "run.json").exists() and Run(folder).status in ended
        with warnings.catch_warnings():
            # Doubts are in the column `marks`.
            warnings.simplefilter("ignore")
            found = (
                Run(folder) if there else run(scene, settings, folder, force=True, threads=1, progress=False)
            )
        row = {"test": test, "seed": seed, **values, "directory": str(folder), "cached": there}
        row |= {"status": found.status, "marks": "; ".join(found.marks)}
        row |= {t.result: found.results.get(t.result) for t in self.targets if t.test == test}
        self.rows.append(row)
        return found if found.status in ("completed", "collapsed") else None

    def factors(self, means: Mapping[tuple[str, str], float]) -> dict[str, float]:
        """Factors on stiffnesses and strengths that bring the results nearest to their targets."""
        factors = {}
        for kind in ("stiffness", "strength"):
            ratios = [(t.weight, t.value / means[t.test, t.result]) for t in self.targets if t.scales == kind]
            logs = [(w, np.log(r)) for w, r in ratios if np.isfinite(r) and r > 0.0]
            total = sum(w for w, _ in logs)
            factors[kind] = float(np.exp(sum(w * x for w, x in logs) / total)) if total else 1.0
        # Displacements at rupture go with strength over stiffness.
        factors["strain"] = factors["strength"] / factors["stiffness"]
        return factors

    def errors(self, means: Mapping[tuple[str, str], float], factors: Mapping[str, float]) -> np.ndarray:
        """Weighted errors of the targets once the results are scaled."""
        errors = []
        for t in self.targets:
            ratio = means[t.test, t.result] * factors.get(t.scales or "", 1.0) / t.value
            error = np.log(ratio) if np.isfinite(ratio) and ratio > 0.0 else FAILED
            errors.append(t.weight * float(np.clip(error, -FAILED, FAILED)))
        return np.array(errors)


def calibrate(
    tests: Mapping[str, Scene | tuple[Scene, Settings]],
    targets: Sequence[Target],
    parameters: Sequence[Parameter],
    *,
    seeds: Sequence[int] = (),
    seed_paths: Sequence[str] = ("let.seed",),
    tolerance: float = 0.02,
    max_evaluations: int = 30,
    out: str | os.PathLike[str] = "runs/calibration",
    jobs: int | None = None,
) -> Calibration:
    """Finds parameters of grains and bonds for which tests of a specimen have given results.

    Two factors take no search. In statics without gravity a modulus is proportional to the
    stiffnesses, all in one ratio, and a strength without confining stress to the strengths of the
    bonds, as long as strains are small. What runs must seek are the other parameters: ratios, and
    friction. They are found by least squares of the logarithms of the results over their targets
    (``scipy.optimize.least_squares``), in which the two factors are the best for each trial. A last
    set of runs has the parameters that were found, and its results are those of the table; where it
    is not within the tolerance, because strains are not small, the factors are applied once more.

    Parameters
    ----------
    tests
        Scenes by name, each a scene or a pair of a scene and its settings.
    targets, parameters
        What is to be reached, and what may change.
    seeds
        Seeds of the specimen: each test runs with each, and the means count.
    seed_paths
        Fields of the scenes that are the seed.
    tolerance
        Relative error within which a target counts as reached.
    max_evaluations
        Maximum number of steps of the least squares. A step has a trial, and one for each parameter that is
        sought; a trial has a run for every test and seed.
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
    from scipy.optimize import least_squares

    pairs = {k: v if isinstance(v, tuple) else (v, {}) for k, v in tests.items()}
    for target in targets:
        if target.test not in pairs:
            raise ValueError(f"the target {target.result} names no test: `{target.test}`")
    if not targets or not parameters:
        raise ValueError("give targets and parameters")
    search = _Search(pairs, targets, parameters, seeds, seed_paths, Path(out), jobs)
    sought = [p for p in parameters if p.is_sought]
    low, high = (np.array([getattr(p, end) for p in sought], float) for end in ("low", "high"))
    into = lambda x: (np.asarray(x, float) - low) / (high - low)
    back = lambda u: low + np.asarray(u) * (high - low)
    unit: dict[str, float] = {}

    def trial(u: np.ndarray) -> np.ndarray:
        means = search.run_all(search.values(back(u), unit))
        return search.errors(means, search.factors(means))

    message = "similarity alone"
    best = np.array([p.start for p in sought])
    if sought:
        # Results have steps where another bond breaks first: differences must be larger.
        found = least_squares(
            trial,
            np.clip(into(best), 0.01, 0.99),
            bounds=(0.0, 1.0),
            diff_step=0.05,
            xtol=1e-3,
            ftol=1e-4,
            max_nfev=max_evaluations,
        )
        best, message = back(found.x), found.message
    factors = {"stiffness": 1.0, "strength": 1.0, "strain": 1.0}
    for _ in range(4):
        values = search.values(best, factors)
        means = search.run_all(values)
        reached = np.abs(search.errors(means, {}))
        if (reached <= tolerance * np.array([t.weight for t in targets])).all():
            break
        factors = {kind: factors[kind] * x for kind, x in search.factors(means).items()}
    table = pandas.DataFrame(
        [
            {
                "test": t.test,
                "result": t.result,
                "target": t.value,
                "reached": means[t.test, t.result],
                "error": means[t.test, t.result] / t.value - 1.0,
            }
            for t in targets
        ]
    )
    runs = pandas.DataFrame(search.rows)
    return Calibration(
        parameters=values,
        targets=table,
        runs=runs,
        made=int((~runs["cached"]).sum()),
        cached=int(runs["cached"].sum()),
        success=bool((table["error"].abs() <= 1.01 * tolerance).all()),
        message=message,
    )
