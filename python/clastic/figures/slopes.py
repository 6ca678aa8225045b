"""Figure of the slide of a slope."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..results import Run
from .specimen import displacement
from .style import COLORS, legend_below, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ..stability import Stability


def slide(found: Stability, row: int = 0, *, ax: Axes | None = None) -> Axes:
    """Displacement of the grains of a slope (a row of ``found.slides``) since before its weight, and the log-spiral
    of the bound.
    """
    which = found.slides.iloc[row]
    with style():
        ax = displacement(Run(which["directory"]), ax=ax)
        x, y = found.mechanism.points(found.height, which["toe"]).T
        line = ax.plot(x, y, color=COLORS[1], lw=1.5, label="log-spiral of limit analysis")
        legend_below(ax.scale.ax, handles=line)
    return ax
