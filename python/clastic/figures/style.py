"""Letters, lines, sizes, and scales of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Width of a figure, inches: 84 mm, a column of many journals.
WIDTH = 84.0 / 25.4

#: Room for numbers and label below axes, inches.
BELOW = 28.0 / 72.0

#: Colours of curves, legible with any colour vision (Okabe and Ito).
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#000000", "#999999")
#: Colours of tension, shear and rolling.
MODES = {"tension": "#d7191c", "shear": "#1a1a1a", "rolling": "#d68a00"}

#: Settings of matplotlib: letters of 8 pt that stay text in PDF and SVG.
SETTINGS: dict[str, Any] = {
    "font.size": 8.0,
    "font.family": "sans-serif",
    "font.sans-serif": ["Arial", "Liberation Sans", "Helvetica", "DejaVu Sans"],
    "axes.labelsize": 8.0,
    "axes.titlesize": 8.0,
    "axes.linewidth": 0.6,
    "xtick.labelsize": 7.0,
    "ytick.labelsize": 7.0,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "legend.fontsize": 7.0,
    "legend.frameon": False,
    "legend.handlelength": 1.6,
    "lines.linewidth": 1.1,
    "figure.dpi": 150.0,
    "savefig.dpi": 300.0,
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.02,
    "pdf.fonttype": 42,
    "svg.fonttype": "none",
    "image.cmap": "viridis",
}


@contextmanager
def style() -> Iterator[None]:
    """The style of the figures, for figures of your own."""
    import logging

    import matplotlib
    from cycler import cycler

    # A machine without the first fonts of the list takes the next, which is no news.
    logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)
    ours = {**SETTINGS, "axes.prop_cycle": cycler(color=COLORS)}
    # No more than these, since a notebook sets others while its first figure is made.
    before = {name: matplotlib.rcParams[name] for name in ours}
    matplotlib.rcParams.update(ours)
    try:
        yield
    finally:
        matplotlib.rcParams.update(before)


def new_axes(aspect: float, ax: Axes | None, **settings: Any) -> Axes:
    """The axes that are given, or those of a new figure with this height over width."""
    if ax is not None:
        return ax
    import matplotlib.pyplot as plt

    size = WIDTH, aspect * WIDTH
    # Of the two layouts, "compressed" is the one that counts with axes to scale.
    _, ax = plt.subplots(figsize=size, layout="compressed", subplot_kw=settings or None)
    return ax


def legend_below(ax: Axes, **settings: Any) -> None:
    """A legend below the numbers and the label of the axes: it hides nothing, and a title has its place.
    It has as many columns as there is room for below the axes, and no more than ``ncols``.
    """
    from matplotlib.transforms import ScaledTranslation

    figure = ax.figure
    below = ScaledTranslation(0.0, -BELOW if ax.axison else 0.0, figure.dpi_scale_trans)
    place = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "bbox_transform": ax.transAxes + below}
    for columns in range(settings.pop("ncols", 2), 0, -1):
        legend = ax.legend(**place, ncols=columns, **settings)
        if legend.get_window_extent(figure.canvas.get_renderer()).width <= 1.1 * ax.bbox.width:
            break


def close(ax: Axes) -> None:
    """Closes the figure of axes, for programs that draw many."""
    import matplotlib.pyplot as plt

    plt.close(ax.figure)


def prefix(value: float, unit: str) -> tuple[str, float]:
    """The unit in which a value has one to three digits before the point, and its size."""
    if not unit or unit == "%" or not np.isfinite(value) or value == 0.0:
        return unit, 1.0
    sizes = [("G", 1e9), ("M", 1e6), ("k", 1e3), ("", 1.0), ("m", 1e-3), ("µ", 1e-6)]
    for name, size in sizes:
        if abs(value) >= 0.9995 * size:
            return name + unit, size
    return "n" + unit, 1e-9


def round_up(value: float) -> float:
    """The next number of few digits that is not below a value; 1 for 0."""
    if not (np.isfinite(value) and value > 0.0):
        return 1.0
    size = int(np.floor(np.log10(value)))
    for step in (1.0, 1.2, 1.6, 2.0, 2.4, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0):
        # By text, since a power of ten times a step has digits of round-off.
        end = float(f"{step}e{size}")
        if end >= value * (1.0 - 1e-9):
            return end
    return value


def end_of(values: np.ndarray) -> float:
    """End of a scale: the round number above 98 % of the magnitudes, so that a few large ones do not
    take all the colours.
    """
    there = np.sort(np.abs(values[np.isfinite(values)]))
    return round_up(there[min(len(there) * 49 // 50, len(there) - 1)] if len(there) else 0.0)
