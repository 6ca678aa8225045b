"""Figures of the acoustic emission."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..emission import PowerLaw, b_values, cycles, emissions, power_law
from ..results import Run
from .curves import STRAIN
from .style import COLORS, legend_below, new_axes, prefix, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def emission_sizes(
    *runs: Run, column: str = "energy_j", minimum: float | None = None, ax: Axes | None = None
) -> Axes:
    """Share of the emissions of all runs with at least an energy, or with at least a number of ``bonds``,
    and the power law above its cut-off (:func:`clastic.emission.power_law`), which is ``ax.law``.
    """
    values = np.sort(emissions(*runs)[column].to_numpy())
    law = power_law(values, minimum)
    x, first = np.unique(values, return_index=True)
    share = 1.0 - first / len(values)
    with style():
        ax = new_axes(0.75, ax)
        ax.loglog(x, share, ls="", marker="o", ms=2.5, mfc="none", mew=0.6, label=f"{len(values)} emissions")
        line = np.geomspace(law.minimum, x[-1], 100)
        part = len(law.above) / len(values)
        ax.loglog(line, part * law.tail(line), color="black", lw=0.9, label=_words(law))
        names = {"energy_j": "released energy (J)", "bonds": "broken bonds"}
        ax.set(xlabel=names.get(column, column), ylabel="share at least as large")
        ax.law = law  # type: ignore[attr-defined]
        legend_below(ax)
    return ax


def _words(law: PowerLaw) -> str:
    low, high = law.interval
    return f"exponent {law.exponent:.2f} ({low:.2f} to {high:.2f}), {len(law.above)} values"


def b_value(*runs: Run, minimum: float | None = None, window: int = 25, ax: Axes | None = None) -> Axes:
    """b of the emissions of all runs against axial strain, in windows that overlap by half
    (:func:`clastic.emission.b_values`): a step over the strains of every window, and its 95 % interval.
    Without ``minimum`` (J), the cut-off is that of the power law of all.
    """
    table = emissions(*runs)
    if minimum is None:
        minimum = power_law(table["energy_j"].to_numpy()).minimum
    b = b_values(table, minimum, window)
    with style():
        ax = new_axes(0.75, ax)
        ends = 100.0 * b["strain_from"], 100.0 * b["strain_to"]
        middle = 0.5 * (ends[0] + ends[1])
        ax.hlines(b["b"], *ends, color=COLORS[0], lw=0.6)
        spread = [b["b"] - b["low"], b["high"] - b["b"]]
        ax.errorbar(middle, b["b"], spread, color=COLORS[0], lw=1.1, elinewidth=0.6, marker="o", ms=2.5)
        ax.set(xlabel=STRAIN, ylabel=f"b of {window} emissions")
        ax.set_ylim(bottom=0)
    return ax


def emission_cycles(run: Run, *, energy: bool = False, ax: Axes | None = None) -> Axes:
    """Sum of the emissions, or of their energies, against the axial stress of each loading
    (:func:`clastic.emission.cycles`). A dashed line is the largest stress borne before a loading: by
    the Kaiser effect its curve rises only from there.
    """
    table, loadings = emissions(run), cycles(run)
    amount = table["energy_j"].to_numpy() if energy else np.ones(len(table))
    total = np.cumsum(amount)
    stress, at = table["axial_stress_before_pa"].to_numpy(), table["increment"].to_numpy()
    unit, size = prefix(loadings["highest_pa"].max(), "Pa")
    with style():
        ax = new_axes(0.75, ax)
        before = 0.0
        for k, row in enumerate(loadings.itertuples()):
            color = COLORS[k % len(COLORS)]
            chosen = (at <= row.increment_to) & ((at > row.increment_from) | (k == 0))
            x, y = [0.0, *stress[chosen]], [before, *total[chosen]]
            if not chosen.any():
                x, y = [0.0, row.highest_pa], [before, before]
            ax.step(np.array(x) / size, y, where="post", color=color, label=f"loading {k + 1}")
            if not np.isnan(row.borne_pa):
                ax.axvline(row.borne_pa / size, color=color, lw=0.7, ls="--")
            before = y[-1]
        ax.set(xlabel=f"axial stress ({unit})", ylabel="released energy (J)" if energy else "emissions")
        if energy:
            ax.set_yscale("log")
        else:
            ax.set_ylim(bottom=0)
        if len(loadings) > 1:
            legend_below(ax)
    return ax
