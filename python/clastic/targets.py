"""What a calibration changes and what it is to reach: parameters, targets and curves."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Any

import numpy as np

from .results import Run
from .strengths import hoek_brown, mohr_coulomb

#: What a quantity is proportional to: stiffness (a modulus), strength (a stress), their ratio (a strain).
SCALES = ("stiffness", "strength", "strain")
#: Strains at which a curve is compared.
POINTS = 50


def _check_scales(name: str, scales: str | None) -> None:
    if scales not in (None, *SCALES):
        raise ValueError(f"{name}: scales is {scales!r}; {_meant(scales, SCALES)}")


def _meant(word: Any, words: Sequence[str]) -> str:
    """The word that was probably meant, or all that there are."""
    near = get_close_matches(str(word), words, 1)
    return f"did you mean {near[0]!r}?" if near else f"give one of {', '.join(words)}"


def scale(scales: str | None, factors: np.ndarray) -> float:
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
        if self.scales is None and not self.low <= self.start <= self.high:
            raise ValueError(f"{self.name}: start {self.start!r} is not between {self.low!r} and {self.high!r}")
        if self.scales is not None and not self.start > 0.0:
            raise ValueError(f"{self.name}: start is {self.start!r}; a factor needs a value above 0")

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
        if not (np.isfinite(self.value) and self.value != 0.0 and self.weight > 0.0):
            raise ValueError(
                f"target {self.name}: value {self.value!r} and weight {self.weight!r}; the error is relative: give "
                "a value that is not 0, and a weight above 0"
            )
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
        ratio = np.mean(measured) * scale(self.scales, factors) / self.value
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
            np.interp(*_rising(strains, curve[:, 0] * scale("strain", factors)), curve[:, 1])
            for curve in measured
        ]
        wanted = np.interp(*_rising(strains, self.points[:, 0]), self.points[:, 1])
        found = np.mean(stresses, axis=0) * scale("strength", factors)
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
    return mohr_coulomb(_peaks(runs))[0]


def friction_angle(*runs: Run) -> float:
    """Friction angle (degrees) of the same line. Errors are those of :func:`cohesion`."""
    return mohr_coulomb(_peaks(runs))[1]


def hoek_brown_m(*runs: Run) -> float:
    """m_i of the peaks of runs with different lateral stresses, by least squares of
    (sigma_1 - sigma_3)^2 = sigma_ci^2 + m_i sigma_ci sigma_3.

    Raises
    ------
    ValueError
        As :func:`cohesion`, or if the line gives no sigma_ci.
    """
    return hoek_brown(_peaks(runs))[1]
