"""Acoustic emission: the avalanches of runs as a seismologist counts them.

An emission is a row of ``avalanches.csv``. Its energy E is the energy that it releases, J, its size
the number of bonds, and its magnitude

    M = 2/3 log10(E / 1 J)

The 2/3 is that of the moment magnitude. With a density of energies ~ E^-a, the number of emissions
above M falls as 10^(-b M) with b = 3/2 (a - 1).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from .results import Run

if TYPE_CHECKING:
    import pandas

#: A lower cut-off that is sought leaves at least this many values above it.
LEAST = 10
#: Part of the range of the strain by which a specimen must go back to count as unloaded.
UNLOADED = 0.02
#: 95 % quantile of chi squared with one degree of freedom.
QUANTILE = 3.841458820694124


def emissions(*runs: Run) -> pandas.DataFrame:
    """The avalanches of runs with a released energy, in one table: the columns of ``avalanches.csv``,
    ``run`` (number, from 0), ``bonds`` (size), ``energy_j`` and ``magnitude``.

    Raises
    ------
    ValueError
        If no avalanche of a run has an energy.
    """
    import pandas

    tables = []
    for k, run in enumerate(runs):
        table = run.avalanches
        if len(table) == 0:
            raise ValueError(
                f"{run.path}: no avalanche; bonds must break one by one (`rupture: (order: Events)`)"
            )
        if table["released_j"].isna().all():
            raise ValueError(
                f"{run.path}: no avalanche has a released energy; where loads do work the scene needs "
                "`output: (energy: true)`"
            )
        tables.append(table.assign(run=k))
    if not tables:
        raise ValueError("give a run")
    table = pandas.concat(tables, ignore_index=True)
    table = table[table["released_j"] > 0.0].reset_index(drop=True)
    return table.assign(
        bonds=sum(table[f"broken_{mode}"] for mode in ("tension", "shear", "rolling")),
        energy_j=table["released_j"],
        magnitude=2.0 / 3.0 * np.log10(table["released_j"]),
    )


@dataclass(frozen=True)
class PowerLaw:
    """A power law above a lower cut-off: density ~ x^-a of numbers, probability ~ k^-a of whole numbers.

    ``distance`` is the greatest difference between the distributions of law and values (Kolmogorov and
    Smirnov).
    """

    exponent: float
    minimum: float
    distance: float
    #: Values, ascending, those below the cut-off too.
    values: np.ndarray
    #: Whether the cut-off was sought.
    sought: bool

    @property
    def is_discrete(self) -> bool:
        """Whether values are whole numbers."""
        return self.values.dtype.kind in "iu"

    @cached_property
    def error(self) -> float:
        """Standard error of the exponent, by the curvature of the likelihood."""
        h = 1e-4 * (self.exponent - 1.0)
        near = [self._log_likelihood(self.exponent + k * h) for k in (-1, 0, 1)]
        return float(h / np.sqrt(2.0 * near[1] - near[0] - near[2]))

    @cached_property
    def interval(self) -> tuple[float, float]:
        """Bounds of the exponent with 95 % confidence, if the cut-off is known: where the logarithm of
        the likelihood is half of the 95 % quantile of chi squared below the greatest.
        """
        from scipy.optimize import brentq

        best = self.exponent
        within = lambda a: 0.5 * QUANTILE - self._log_likelihood(best) + self._log_likelihood(a)
        low, high = best, best
        while within(low) > 0.0:
            low = 1.0 + 0.5 * (low - 1.0)
        while within(high) > 0.0:
            high += self.error
        return brentq(within, low, best), brentq(within, best, high)

    def _log_likelihood(self, exponent: float) -> float:
        return _log_likelihood(exponent, self.above, self.minimum)

    @cached_property
    def above(self) -> np.ndarray:
        """The values that the law describes."""
        return self.values[self.values >= self.minimum]

    def tail(self, x: np.ndarray) -> np.ndarray:
        """Probability of a value of at least x, of those above the cut-off."""
        return _tail(self.exponent, np.asarray(x), self.minimum, self.is_discrete)

    def sample(self, count: int, seed: np.random.Generator | int = 0) -> np.ndarray:
        """Random values of the law."""
        u = 1.0 - np.random.default_rng(seed).random(count)
        if not self.is_discrete:
            return self.minimum * u ** (-1.0 / (self.exponent - 1.0))
        # The largest whole number whose tail is at least u, by bisection.
        low = np.full(count, int(self.minimum), np.int64)
        high = 2 * low
        while (more := self.tail(high) >= u).any():
            low, high = np.where(more, high, low), np.where(more, 2 * high, high)
        while ((high - low) > 1).any():
            middle = (low + high) // 2
            more = self.tail(middle) >= u
            low, high = np.where(more, middle, low), np.where(more, high, middle)
        return low

    def p_value(self, repeats: int = 200, seed: int = 0) -> float:
        """Share of samples of this law that a law describes no better than the values (Clauset, Shalizi
        and Newman 2009, 4.1); below 0.1 a power law is implausible. Samples have as many values below
        the cut-off, drawn from those that there are, and their cut-off is sought if this one was. One
        whose values are all the same has no law and does not count; not a number if none counts.
        """
        random = np.random.default_rng(seed)
        below = self.values[self.values < self.minimum]
        distances = []
        for _ in range(repeats):
            n = random.binomial(len(self.values), len(self.above) / len(self.values))
            drawn = [self.sample(n, random)]
            if len(below):
                drawn.append(random.choice(below, len(self.values) - n))
            try:
                again = power_law(np.concatenate(drawn), None if self.sought else self.minimum)
            except ValueError:
                continue
            distances.append(again.distance)
        return float(np.mean(np.array(distances) >= self.distance)) if distances else np.nan


def _tail(exponent: float, x: np.ndarray, minimum: float, is_discrete: bool) -> np.ndarray:
    if not is_discrete:
        return (x / minimum) ** (1.0 - exponent)
    from scipy.special import zeta

    return zeta(exponent, x) / zeta(exponent, minimum)


def power_law(values: np.ndarray, minimum: float | None = None) -> PowerLaw:
    """The power law of the largest likelihood (Clauset, Shalizi and Newman 2009). Whole numbers
    (``numpy`` integers) have a zeta distribution.

    Parameters
    ----------
    values
        Positive energies or sizes.
    minimum
        Lower cut-off. Without it, that of the smallest Kolmogorov-Smirnov distance.

    Raises
    ------
    ValueError
        If fewer than two different values are left, or one is not above 0.
    """
    values = np.sort(np.asarray(values))
    if len(values) and not values[0] > 0:
        raise ValueError("values must be above 0")
    if minimum is not None:
        if not minimum > 0:
            raise ValueError("the cut-off must be above 0")
        return _fit(values, np.ceil(minimum) if values.dtype.kind in "iu" else minimum, False)
    # The largest values alone have no spread.
    starts = [start for start in np.unique(values[: max(len(values) - LEAST + 1, 0)]) if start < values[-1]]
    if not starts:
        raise ValueError(
            f"{len(values)} values; a cut-off is sought above which at least {LEAST} lie, not all the same"
        )
    return min((_fit(values, start, True) for start in starts), key=lambda fit: fit.distance)


def _log_likelihood(exponent: float, above: np.ndarray, minimum: float) -> float:
    """Up to a constant."""
    logs, n = float(np.log(above / minimum).sum()), len(above)
    if above.dtype.kind not in "iu":
        return n * np.log(exponent - 1.0) - exponent * logs
    from scipy.special import zeta

    return -exponent * (logs + n * np.log(minimum)) - n * np.log(zeta(exponent, minimum))


def _fit(values: np.ndarray, minimum: float, sought: bool) -> PowerLaw:
    from scipy.optimize import minimize_scalar

    is_discrete = values.dtype.kind in "iu"
    above = values[np.searchsorted(values, minimum) :]
    if len(above) < 2 or above[0] == above[-1]:
        raise ValueError(f"{len(above)} values of at least {minimum:g}: too few, or all the same")
    if is_discrete:
        loss = lambda exponent: -_log_likelihood(exponent, above, minimum)
        # Near that of a density from minimum - 1/2 on.
        near = 1.0 / np.log(above / (minimum - 0.5)).mean()
        bounds = 1.0 + 0.2 * near, 1.0 + 4.0 * near
        exponent = minimize_scalar(loss, bounds=bounds, method="bounded", options={"xatol": 1e-9}).x
    else:
        exponent = 1.0 + 1.0 / np.log(above / minimum).mean()
    x, counts = np.unique(above, return_counts=True)
    # Both distributions jump at whole numbers, that of the values at each of them.
    share = np.append(np.cumsum(counts[::-1])[::-1], 0) / len(above)
    law = _tail(exponent, x, minimum, is_discrete)
    beyond = _tail(exponent, x + 1, minimum, True) if is_discrete else law
    distance = max(np.abs(law - share[:-1]).max(), np.abs(beyond - share[1:]).max())
    return PowerLaw(float(exponent), float(minimum), float(distance), values, sought)


def b_values(table: pandas.DataFrame, minimum: float, window: int = 25) -> pandas.DataFrame:
    """b against strain: of every ``window`` consecutive emissions of at least ``minimum`` (J) in a table
    of :func:`emissions`, each half a window after the one before. By the estimator of Aki (1965),
    b = log10(e)/(mean of M - M of the cut-off), with the bounds of :func:`power_law`.

    Returns columns ``strain_from``, ``strain_to`` (of the first and last emission), ``b``, ``error``,
    ``low``, ``high``, ``emissions``.

    Raises
    ------
    ValueError
        If there are fewer emissions than in a window.
    """
    import pandas

    counted = table[table["energy_j"] >= minimum].sort_values("axial_strain", kind="stable")
    if len(counted) < window:
        raise ValueError(f"{len(counted)} emissions of at least {minimum:g} J; give a window below {window}")
    rows = []
    for start in range(0, len(counted) - window + 1, max(window // 2, 1)):
        part = counted.iloc[start : start + window]
        fit = power_law(part["energy_j"].to_numpy(), minimum)
        strain = part["axial_strain"]
        b, low, high = (1.5 * (a - 1.0) for a in (fit.exponent, *fit.interval))
        rows.append((strain.iloc[0], strain.iloc[-1], b, 1.5 * fit.error, low, high, window))
    names = ["strain_from", "strain_to", "b", "error", "low", "high", "emissions"]
    return pandas.DataFrame(rows, columns=names)


def cycles(run: Run) -> pandas.DataFrame:
    """Loadings of a test that is unloaded and loaded again, for the Kaiser effect. A loading ends where
    the axial strain begins to fall by more than 2 % of its range. In a test in tension, whose strain is
    negative where it is largest, strains and stresses are those of tension.

    Returns a row per loading: ``increment_from``, ``increment_to``, ``borne_pa`` (the largest stress
    before it; not a number in the first), ``highest_pa`` (its own), ``emissions``, ``energy_j``, of these
    ``emissions_below`` and ``energy_below_j`` before the stress exceeds the one borne, ``onset_pa`` (the
    stress at the first emission), ``felicity`` (onset over borne; at least 1 if the rock remembers), and
    ``emissions_unloading`` (after it, until the next).

    Raises
    ------
    ValueError
        If the scene measures no axial strain and stress.
    """
    import pandas

    rows = run.history
    rows = rows[rows["axial_strain"].notna() & rows["axial_stress_pa"].notna()]
    if len(rows) == 0:
        raise ValueError(f"{run.path}: no row has an axial strain and stress; the scene must measure them")
    strain, stress, increment = (rows[c].to_numpy() for c in ("axial_strain", "axial_stress_pa", "increment"))
    table = emissions(run)
    at, before, energy = (table[c].to_numpy() for c in ("increment", "axial_stress_before_pa", "energy_j"))
    sign = np.sign(strain[np.abs(strain).argmax()]) or 1.0
    strain, stress, before = sign * strain, sign * stress, sign * before
    ends = [0, *_turns(strain), len(strain) - 1]
    loadings = []
    for start, end, last in zip(ends[::2], ends[1::2], [*ends[2::2], len(strain) - 1]):
        first = increment[start] if start else -1
        inside = (at > first) & (at <= increment[end])
        after = (at > increment[end]) & (at <= increment[last])
        earlier = [stress[: start + 1], before[at <= first]]
        borne = float(np.concatenate(earlier).max()) if start else np.nan
        above = [increment[start : end + 1][stress[start : end + 1] > borne], at[inside & (before > borne)]]
        below = inside & (at < np.concatenate(above).min(initial=np.iinfo(np.int64).max)) & (start > 0)
        onset = before[inside][0] if inside.any() else np.nan
        loadings.append({
            "increment_from": increment[start], "increment_to": increment[end], "borne_pa": borne,
            "highest_pa": np.concatenate([stress[start : end + 1], before[inside]]).max(),
            "emissions": inside.sum(), "energy_j": energy[inside].sum(),
            "emissions_below": below.sum(), "energy_below_j": energy[below].sum(),
            "onset_pa": onset, "felicity": onset / borne, "emissions_unloading": after.sum(),
        })  # fmt: skip
    return pandas.DataFrame(loadings)


def _turns(strain: np.ndarray) -> list[int]:
    """Places of the extremes between which the strain goes back and forth, a maximum first."""
    least = UNLOADED * np.ptp(strain)
    turns: list[int] = []
    sign, best = 1.0, 0
    for k, x in enumerate(strain):
        if sign * (x - strain[best]) >= 0.0:
            best = k
        elif sign * (strain[best] - x) > least:
            turns.append(best)
            sign, best = -sign, k
    return turns
