"""Directions of cracks, contacts and forces."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..frame import SECTORS, Frame
from ..results import Run
from .specimen import frame_of
from .style import MODES, new_axes, prefix, style

if TYPE_CHECKING:
    from matplotlib.projections.polar import PolarAxes

BARS = "#739abf"
LINE = "#d7191c"


def _axes(ax: PolarAxes | None) -> PolarAxes:
    ax = new_axes(1.0, ax, projection="polar")
    ax.set_xticks(np.radians([0, 30, 60, 90, 120, 150, 180, 210, 240, 270, 300, 330]))
    ax.set_rlabel_position(15)
    ax.grid(lw=0.4, color="#cccccc")
    ax.tick_params(pad=0)
    ax.spines["polar"].set_linewidth(0.6)
    ax.set_axisbelow("line")
    return ax


def _end(ax: PolarAxes, columns: int, whole: bool = False) -> PolarAxes:
    """Few circles, with numbers that can be read over the bars."""
    from matplotlib.patheffects import withStroke
    from matplotlib.ticker import MaxNLocator

    ax.yaxis.set_major_locator(MaxNLocator(3, integer=whole, min_n_ticks=2))
    ax.set_ylim(bottom=0)
    for label in ax.get_yticklabels():
        label.set(size=6, path_effects=[withStroke(linewidth=1.5, foreground="white")], zorder=10)
    ax.legend(loc="upper center", bbox_to_anchor=(0.5, -0.06), ncols=columns)
    return ax


def _bars(ax: PolarAxes, values: np.ndarray, bottom: np.ndarray | float, **settings) -> None:
    """Bars of half a turn, on both sides."""
    middle = (np.arange(2 * SECTORS) + 0.5) * np.pi / SECTORS
    ax.bar(
        middle,
        np.tile(values, 2),
        width=np.pi / SECTORS,
        bottom=np.tile(bottom, 2) if np.ndim(bottom) else bottom,
        edgecolor="white",
        linewidth=0.4,
        **settings,
    )


def _fit(ax: PolarAxes, a: float, direction: float, label: str) -> None:
    t = np.linspace(0.0, 2.0 * np.pi, 361)
    ax.plot(t, np.maximum(1.0 + a * np.cos(2.0 * (t - direction)), 0.0), color=LINE, label=label)


def crack_rose(run: Run, *, until: int | None = None, ax: PolarAxes | None = None) -> PolarAxes:
    """Number of cracks by the direction of the crack as it broke, and by mode, in sectors of 10
    degrees. ``until`` is the last increment that counts.
    """
    events = run.events
    if until is not None:
        events = events[events["increment"] <= until]
    if len(events) == 0:
        raise ValueError(f"{run.path}: no bond has broken")
    with style():
        ax = _axes(ax)
        # A crack lies across the normal of its contact.
        angle = np.arctan2(events["normal_x"], -events["normal_y"]) % np.pi
        sector = np.minimum(angle / np.pi * SECTORS, SECTORS - 1).astype(int).to_numpy()
        below = np.zeros(SECTORS)
        for mode, color in MODES.items():
            chosen = (events["mode"] == mode).to_numpy()
            if chosen.any():
                number = np.bincount(sector[chosen], minlength=SECTORS).astype(float)
                _bars(ax, number, below, color=color, label=f"{chosen.sum()} in {mode}")
                below += number
        return _end(ax, 3, whole=True)


def contact_rose(of: Run | Frame, at: int | str = "end", *, ax: PolarAxes | None = None) -> PolarAxes:
    """Density of the contacts between disks that carry compression, by the direction of their
    normal, over its mean; and the line 1 + a cos 2(t - t_a).
    """
    frame = frame_of(of, at)
    fabric = frame.fabric()
    number, _ = frame.rose()
    with style():
        ax = _axes(ax)
        _bars(ax, number / number.mean(), 0.0, color=BARS, label=f"{fabric.contacts} contacts")
        angle = np.degrees(fabric.direction)
        _fit(ax, fabric.a, fabric.direction, f"$a$ = {fabric.a:.3f}, $t_a$ = {angle:.1f}°")
        return _end(ax, 2)


def force_rose(of: Run | Frame, at: int | str = "end", *, ax: PolarAxes | None = None) -> PolarAxes:
    """Mean normal force of these contacts in a sector, over the mean f_0 of the sectors; and the line
    1 + a_n cos 2(t - t_n).
    """
    frame = frame_of(of, at)
    fabric = frame.fabric()
    number, mean = frame.rose()
    overall = mean[number > 0].mean()
    unit, size = prefix(overall, "N")
    with style():
        ax = _axes(ax)
        _bars(ax, mean / overall, 0.0, color=BARS, label=f"mean {overall / size:.3g} {unit}")
        angle = np.degrees(fabric.force_direction)
        _fit(ax, fabric.a_n, fabric.force_direction, f"$a_n$ = {fabric.a_n:.3f}, $t_n$ = {angle:.1f}°")
        return _end(ax, 2)
