"""Parameters of grains and bonds that give a specimen the properties of a material.

Most of a calibration is similarity, which takes no search: in statics without gravity a modulus follows all
stiffnesses, and a strength all strengths of bonds, each by one factor. Runs seek the ratios that are left, such as
k_t/k_n. Five rules keep their number small:

- A ratio is fitted with those tests alone that it acts on, tests of few ratios first: k_t/k_n with an elastic test.
- A test that the first difference of a ratio has not changed is not repeated for it until the end of a search.
- Gauss-Newton steps need differences once. Afterwards every run improves the derivatives (Broyden's update).
- All seeds are run at once and their mean is searched: a peak of one specimen scatters by several per cent under
  round-off alone, and a search by one seed follows its scatter.
- A run lies in a folder that is named by the hash of its scene, and is never made twice.

SciPy solves for a step. Its own searches repeat the differences for each step, or know no limits.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ._folders import Folders
from ._scene import Scene, Settings, _nested
from .results import Run
from .targets import POINTS, Curve, Parameter, Target, scale

if TYPE_CHECKING:
    import pandas

#: Searches, each with a verification.
SEARCHES = 4
#: Steps as parts of the range between the limits of a parameter: of the first differences, the longest, and the
#: shortest. Results jump where another bond breaks first, so that the derivatives of a step have half their weight
#: where it is as long as JUMPS, and less where it is shorter.
DIFFERENCE, MAXIMUM, MINIMUM, JUMPS = 0.15, 0.25, 0.005, 0.04
#: Relative change of a result below which a ratio does not act on its test.
SAME = 1e-3


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
    folders: Folders
    #: Logarithms of the factors on stiffnesses and strengths that the runs have.
    factors: np.ndarray = field(default_factory=lambda: np.zeros(2))
    #: Tests and names of ratios that do not act on them, and the ratios with which such tests were made.
    idle: set[tuple[str, str]] = field(default_factory=set)
    held: dict[str, float] = field(default_factory=dict)
    #: Latest runs by test and seed.
    last: dict[tuple[str, int | None], Run | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.sought = [p for p in self.parameters if p.scales is None]

    def values(self, parts: np.ndarray) -> dict[str, float]:
        """Values of all parameters, of nine digits: values that differ by round-off make one run."""
        found = {p.name: p.value(part) for p, part in zip(self.sought, parts)}
        scaled = {p.name: p.start * scale(p.scales, self.factors) for p in self.parameters if p.scales}
        return {p.name: float(f"{(found | scaled)[p.name]:.9g}") for p in self.parameters}

    def results(self, parts: np.ndarray, chosen: Sequence[int], searching: bool = False) -> list[list]:
        """What the chosen targets measure, by target and seed; NaN where a run failed. A search keeps the ratios
        that do not act on a test.
        """
        every = self.values(parts)

        def values(test: str) -> dict[str, float]:
            keeps = {name for of, name in self.idle if of == test} if searching else ()
            return every | {name: self.held[name] for name in keeps}

        tests = [name for name in self.tests if any(name in self.targets[i].tests for i in chosen)]
        work = [(test, seed) for test in tests for seed in self.seeds]
        specimens = dict(zip(self.seeds, self.folders.map(self.specimen, self.seeds)))
        made = self.folders.map(lambda w: self.test(*w, values(w[0]), specimens[w[1]]), work)
        runs = dict(zip(work, made))
        self.last = runs
        measured = []
        for target in (self.targets[i] for i in chosen):
            of = [[runs[test, seed] for test in target.tests] for seed in self.seeds]
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
        done = self.folders.run({"test": "prepare", "seed": seed}, scene, {**sets, **at_seed})
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
        names = [t.name for t in self.targets if test in t.tests]
        return self.folders.run({"test": test, "seed": seed, **values}, scene, settings, names)

    def errors(self, measured: list[list], chosen: Sequence[int], factors: np.ndarray) -> list[np.ndarray]:
        """Errors of the chosen targets of all seeds once the results are scaled by more factors."""
        return [self.targets[i].errors(seeds, factors) for i, seeds in zip(chosen, measured)]

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
        """Errors of the chosen targets, with the factors that suit them best."""
        self.measured = self.results(parts, chosen, searching=True)
        return np.concatenate(self.errors(self.measured, chosen, self.similar(self.measured, chosen)))

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

        self.held = self.values(parts)
        error = self.trial(parts, chosen)
        box = MAXIMUM
        while free and np.linalg.norm(error) > goal and box > MINIMUM and self.folders.made < most:
            if slopes is None:
                start = self.measured
                slopes = np.column_stack([self.slope(parts, i, chosen, error, start) for i in free])
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

    def learn(self, ratio: str, chosen: list[int], start: list[list]) -> None:
        """Remembers the tests whose results are those of the start, although the ratio is another."""
        acts = {
            test
            for k, old, new in zip(chosen, start, self.measured)
            if np.shape(old[0]) != np.shape(new[0]) or not np.allclose(old[0], new[0], rtol=SAME, atol=0.0)
            for test in self.targets[k].tests
        }
        every = {test for k in chosen for test in self.targets[k].tests}
        self.idle |= {(test, ratio) for test in every - acts}

    def slope(
        self, parts: np.ndarray, i: int, chosen: list[int], error: np.ndarray, start: list[list]
    ) -> np.ndarray:
        """Derivative of the errors by a parameter, by a difference to the side that has more room, or else to
        the other; zero where both runs fail. ``start`` is what the errors were measured from.
        """
        inward = DIFFERENCE if parts[i] < 0.5 else -DIFFERENCE
        for step in (inward, -inward):
            there = parts.copy()
            there[i] = np.clip(parts[i] + step, 0.0, 1.0)
            if there[i] != parts[i]:
                slope = (self.trial(there, chosen) - error) / (there[i] - parts[i])
                if np.isfinite(slope).all():
                    self.learn(self.sought[i].name, chosen, start)
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
    by test where it does not act on all. Runs then have the parameters and factors that were found, and are
    searched again from there where their means over the seeds are not within the tolerance.

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
        Number of runs after which no other step is made.
    out
        Directory of the runs, which have the names of hashes of their scenes: what is there already
        is not run again.
    jobs
        Maximum number of simultaneous runs.

    Raises
    ------
    ValueError
        If a target or a parameter names no test, a target no key result, or if nothing may change.
    """
    import pandas

    def pair(scene: Scene | tuple[Scene, Settings]) -> tuple[Scene, Settings]:
        return scene if isinstance(scene, tuple) else (scene, {})

    for target in targets:
        if unknown := [name for name in target.tests if name not in tests]:
            raise ValueError(f"the target {target.name} names no test: `{unknown[0]}`")
    for p in parameters:
        if unknown := [
            name for name in (p.paths if isinstance(p.paths, Mapping) else ()) if name not in tests
        ]:
            raise ValueError(f"the parameter {p.name} names no test: `{unknown[0]}`")
    if not targets or not parameters:
        raise ValueError("give targets and parameters")
    names = [p.name for p in parameters]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"two parameters are named {twice[0]}")
    if not tolerance > 0.0:
        raise ValueError(f"tolerance is {tolerance!r}; give a relative error above 0")
    search = _Search(
        {name: pair(scene) for name, scene in tests.items()},
        targets,
        parameters,
        list(seeds) or [None],
        seed_paths,
        None if prepare is None else pair(prepare),
        Folders(out, jobs),
    )
    parts = np.array([p.part(p.start) for p in search.sought])
    every = list(range(len(targets)))
    allowed = tolerance * np.array([t.weight for t in targets])
    groups = search.groups()
    slopes: list[np.ndarray | None] = [None] * len(groups)
    best, message = (np.inf, {}, []), "no search brought the results nearer"
    for _ in range(SEARCHES):
        before = len(search.folders.rows)
        for k, (free, chosen) in enumerate(groups):
            # Two targets that pull in opposite directions then have half the tolerance each.
            goal = np.sqrt(0.5) * allowed[chosen].min()
            parts, slopes[k] = search.fit(parts, free, chosen, slopes[k], goal, max_runs)
        # All tests, which are there, give the factors.
        measured = search.results(parts, every, searching=True)
        search.factors = search.factors + search.similar(measured, every)
        measured = search.results(parts, every)
        errors = [t.errors(seeds, np.zeros(2)) for t, seeds in zip(targets, measured)]
        # Errors are logarithms.
        worst = float(np.max([np.linalg.norm(np.expm1(e)) / a for e, a in zip(errors, allowed)]))
        if not best[2] or worst < best[0]:
            best = (worst, search.values(parts), measured)
        if worst <= 1.0:
            message = "all targets are within the tolerance"
            break
        if missing := [t for t, e in zip(targets, errors) if not np.isfinite(e).all()]:
            message = search.doubt(missing[0])
            break
        if search.folders.made >= max_runs:
            message = f"{max_runs} runs were made"
            break
        if len(search.folders.rows) == before:
            break
    else:
        message = f"{SEARCHES} searches were made"
    worst, values, measured = best
    ends = [p.name for p in search.sought if not MINIMUM < p.part(values[p.name]) < 1.0 - MINIMUM]
    if worst > 1.0 and ends:
        message += f"; at a limit: {', '.join(ends)}"
    table = pandas.DataFrame(
        {"test": ", ".join(t.tests), "result": t.name, "target": t.value, **t.row(seeds)}
        for t, seeds in zip(targets, measured)
    )
    runs = pandas.DataFrame(search.folders.rows.values())
    return Calibration(
        parameters=values,
        targets=table,
        runs=runs,
        made=search.folders.made,
        cached=len(runs) - search.folders.made,
        success=worst <= 1.0,
        message=message,
    )
