"""Figures of the specimen to scale."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..emission import emissions
from ..frame import Box, Frame
from ..results import Run
from .style import MODES, WIDTH, end_of, legend_below, new_axes, prefix, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

#: Colours of materials, pale so that cracks stand out.
MATERIALS = ("#f3f1ec", "#9ecae1", "#fdcf9c", "#b5dfae", "#d4c5e8", "#e8dc96", "#c4c4c4", "#e3b8c4")
FRAGMENTS = ("#56b4e9", "#e69f00", "#009e73", "#f0e442", "#cc79a7", "#0072b2", "#d55e00", "#999999")
COMPRESSION, TENSION, MEMBRANE = "#14407a", "#d7191c", "#0a7f3f"
LAYERS = ("#a58cc0", "#c4c4c4")
#: Width of a crack over the mean radius.
CRACK = 0.16
#: Diameter of the circle of the largest emission over the width of the specimen.
FOCUS = 0.35
#: Number of coloured layers over the height of the specimen.
NUMBER_OF_LAYERS = 12
#: Part of the disks at either end of an axis that may be strays, and their minimum distance from the
#: others, over the extent of the others.
STRAY, APART = 0.01, 0.25


def frame_of(of: Run | Frame, at: int | str) -> Frame:
    """The frame of a run at a moment, or the frame itself."""
    return of if isinstance(of, Frame) else of.frame(at)


def view(frame: Frame) -> Box:
    """The box around the disks, without strays, and around the walls near them."""
    if len(frame) == 0:
        raise ValueError("the specimen has no disks")
    low, high = (frame.positions + s * frame.radii[:, None] for s in (-1.0, 1.0))
    last = len(frame) - 1
    strays = int(STRAY * last)
    box = []
    for k in range(2):
        inner = np.sort(low[:, k])[strays], np.sort(high[:, k])[last - strays]
        apart = APART * (inner[1] - inner[0])
        box.append(
            (
                low[:, k][low[:, k] >= inner[0] - apart].min(initial=inner[0]),
                high[:, k][high[:, k] <= inner[1] + apart].max(initial=inner[1]),
            )
        )
    (x0, x1), (y0, y1) = box
    apart = APART * np.array([x1 - x0, y1 - y0])
    for points, is_thin in _walls(frame):
        ends = points if is_thin else np.clip(points, (x0, y0) - apart, (x1, y1) + apart)
        x0, y0 = np.minimum((x0, y0), ends.min(axis=0))
        x1, y1 = np.maximum((x1, y1), ends.max(axis=0))
    return float(x0), float(y0), float(x1), float(y1)


def _walls(frame: Frame) -> list[tuple[np.ndarray, bool]]:
    first, points = frame.arrays["walls.first_point"], frame.arrays["walls.point_m"]
    thin = frame.arrays["walls.is_thin"]
    return [(points[a:b], bool(t)) for a, b, t in zip(first[:-1], first[1:], thin)]


def _joined(lines: list[np.ndarray]) -> list[np.ndarray]:
    """Lines with their ends at their corners: ends that are drawn part or cross as walls move."""
    joined = [line.copy() for line in lines]
    cross = lambda u, v: u[0] * v[1] - u[1] * v[0]
    for k, line in enumerate(lines):
        for end in range(2):
            nearest = np.inf
            for other in lines[:k] + lines[k + 1 :]:
                along, across = line[1] - line[0], other[1] - other[0]
                lengths = np.hypot(*along), np.hypot(*across)
                turn = cross(along, across)
                if abs(turn) <= 0.05 * lengths[0] * lengths[1]:
                    continue
                part = cross(other[0] - line[end], across) / turn
                corner = line[end] + part * along
                away = min(np.hypot(*(x - corner)) for x in other)
                if abs(part) <= 0.3 and away <= 0.3 * lengths[1] and abs(part) < nearest:
                    nearest, joined[k][end] = abs(part), corner
    return joined


def _strokes(starts: np.ndarray, ends: np.ndarray, widths: np.ndarray | float) -> np.ndarray:
    """Strokes of a width (m) as rectangles, shape (k, 4, 2), which keep it at any scale."""
    along = ends - starts
    length = np.hypot(along[:, 0], along[:, 1])
    across = np.stack([-along[:, 1], along[:, 0]], axis=1) / np.maximum(length, 1e-300)[:, None]
    half = 0.5 * np.broadcast_to(widths, length.shape)[:, None] * across
    return np.stack([starts - half, ends - half, ends + half, starts + half], axis=1)


class _Sheet:
    """Axes in which a specimen is drawn."""

    def __init__(self, frame: Frame, box: Box | None, ax: Axes | None) -> None:
        self.frame = frame
        x0, y0, x1, y1 = self.box = box or view(frame)
        self.x, self.r = frame.positions, frame.radii
        # Room for a scale or a legend below.
        aspect = min((y1 - y0) / (x1 - x0), 1.5)
        self.ax = new_axes(aspect + 0.18, ax)
        self.handles: list[Any] = []
        room = 0.012 * max(x1 - x0, y1 - y0)
        self.ax.set(xlim=(x0 - room, x1 + room), ylim=(y0 - room, y1 + room), aspect="equal")
        self.ax.axis("off")

    def disks(self, **settings: Any) -> Any:
        from matplotlib.collections import EllipseCollection

        if "array" not in settings:
            settings.setdefault("facecolors", "white")
        size = 2.0 * self.r
        disks = EllipseCollection(
            size,
            size,
            np.zeros(len(size)),
            units="xy",
            offsets=self.x,
            offset_transform=self.ax.transData,
            edgecolors="#888888",
            linewidths=0.25,
            **settings,
        )
        return self.ax.add_collection(disks)

    def polygons(self, corners: np.ndarray, color: str) -> None:
        from matplotlib.collections import PolyCollection

        if len(corners):
            self.ax.add_collection(PolyCollection(corners, facecolors=color, edgecolors="none"))

    def cracks(self, label: bool = True) -> None:
        pairs = self.frame.pairs
        a, b = self.frame.rows(pairs["a"]), self.frame.rows(pairs["b"])
        normal = np.stack([np.cos(pairs["angle_rad"]), np.sin(pairs["angle_rad"])], axis=1)
        middle = self.x[a] + (self.r[a] + 0.5 * pairs["gap_m"])[:, None] * normal
        half = np.where(b >= 0, np.minimum(self.r[a], self.r[b]), self.r[a])[:, None]
        along = half * np.stack([-normal[:, 1], normal[:, 0]], axis=1)
        for state, (mode, color) in enumerate(MODES.items(), start=2):
            chosen = pairs["state"] == state
            if chosen.any():
                m, u = middle[chosen], along[chosen]
                self.polygons(_strokes(m - u, m + u, CRACK * self.r.mean()), color)
                if label:
                    self.sample(color, f"{chosen.sum()} in {mode}")

    def boundary(self) -> None:
        from matplotlib.collections import LineCollection

        walls = _walls(self.frame)
        lines = _joined([points for points, is_thin in walls if not is_thin])
        lines += [points for points, is_thin in walls if is_thin]
        width, height, tilt = self.frame.arrays["cell_m"]
        if width > 0.0:
            lines.append(np.array([(0, 0), (width, 0), (width + tilt, height), (tilt, height), (0, 0)]))
        self.ax.add_collection(LineCollection(lines, colors="#222222", linewidths=1.0))
        first, points = (self.frame.arrays[f"membranes.{k}"] for k in ("first_point", "point_m"))
        closed = self.frame.arrays["membranes.is_closed"]
        chains = [points[a:b] for a, b in zip(first[:-1], first[1:])]
        chains = [np.vstack([c, c[:1]]) if is_closed else c for c, is_closed in zip(chains, closed)]
        if chains:
            self.ax.add_collection(LineCollection(chains, colors=MEMBRANE, linewidths=0.8))
            self.sample(MEMBRANE, "membrane")

    def sample(self, color: str, text: str, *, disk: bool = False, width: float = 1.2) -> None:
        from matplotlib.lines import Line2D

        if disk:
            handle = Line2D([], [], ls="", marker="o", ms=5, mfc=color, mec="#777777", mew=0.4, label=text)
        else:
            handle = Line2D([], [], color=color, lw=width, label=text)
        self.handles.append(handle)

    def bar(self, disks: Any, label: str, both: bool, exceeded: bool, inside: Axes | None) -> None:
        from matplotlib.ticker import MaxNLocator

        place: dict[str, Any] = {"fraction": 0.05, "pad": 0.02, "aspect": 30, "location": "bottom"}
        place = place | {"ax": self.ax} if inside is None else {"cax": inside, "location": "bottom"}
        end = ("both" if both else "max") if exceeded else "neither"
        bar = self.ax.figure.colorbar(disks, extend=end, label=label, **place)
        bar.ax.xaxis.set_major_locator(MaxNLocator(4 if inside is None else 2, symmetric=both))
        bar.outline.set_linewidth(0.4)
        bar.ax.tick_params(length=2, width=0.4)
        self.ax.scale = bar  # type: ignore[attr-defined]

    def end(self) -> Axes:
        if self.handles:
            # A scale of colours has the place below.
            below = self.ax.scale.ax if hasattr(self.ax, "scale") else self.ax
            columns = 2 if len(self.handles) in (2, 4) else 3
            legend_below(below, handles=self.handles, ncols=columns, columnspacing=1.2)
        return self.ax


def _field(
    frame: Frame,
    values: np.ndarray,
    name: str,
    unit: str,
    *,
    signed: bool,
    cracks: bool,
    box: Box | None,
    ax: Axes | None,
    bar_in: Axes | None = None,
) -> Axes:
    import matplotlib

    with style():
        sheet = _Sheet(frame, box, ax)
        end = end_of(values)
        shown, size = prefix(end, unit)
        low = -end if signed else 0.0
        colors = matplotlib.colormaps["RdBu_r" if signed else "YlGnBu"].with_extremes(bad="white")
        disks = sheet.disks(array=np.ma.masked_invalid(values / size), cmap=colors)
        disks.set_clim(low / size, end / size)
        if cracks:
            sheet.cracks()
        sheet.boundary()
        exceeded = bool(np.nanmax(np.abs(values), initial=0.0) > end)
        sheet.bar(disks, f"{name} ({shown})" if shown else name, signed, exceeded, bar_in)
        return sheet.end()


def specimen(
    of: Run | Frame, at: int | str = "end", *, box: Box | None = None, ax: Axes | None = None
) -> Axes:
    """Disks in the colours of their materials, and cracks: strokes across broken bonds, as long as
    the bond was wide. Red is tension, black shear, orange rolling.
    """
    with style():
        return _draw_specimen(_Sheet(frame_of(of, at), box, ax)).end()


def _draw_specimen(sheet: _Sheet) -> _Sheet:
    material = sheet.frame.arrays["bodies.material"]
    sheet.disks(facecolors=np.array(MATERIALS)[material % len(MATERIALS)])
    there = np.unique(material)
    for k in there if len(there) > 1 else ():
        name = sheet.frame.arrays["materials.name"][k]
        sheet.sample(MATERIALS[k % len(MATERIALS)], f"{(material == k).sum()} {name}", disk=True)
    sheet.cracks()
    sheet.boundary()
    return sheet


def bonds(of: Run | Frame, at: int | str = "end", *, box: Box | None = None, ax: Axes | None = None) -> Axes:
    """Intact bonds from centre to centre, and cracks."""
    frame = frame_of(of, at)
    with style():
        sheet = _Sheet(frame, box, ax)
        sheet.disks()
        start, branch, _ = frame._branches()
        intact = frame.pairs["state"] == 1
        strokes = _strokes(start[intact], (start + branch)[intact], 0.12 * sheet.r.mean())
        sheet.polygons(strokes, COMPRESSION)
        sheet.sample(COMPRESSION, f"{intact.sum()} intact bonds")
        sheet.cracks()
        sheet.boundary()
        return sheet.end()


def force_chains(
    of: Run | Frame, at: int | str = "end", *, box: Box | None = None, ax: Axes | None = None
) -> Axes:
    """Normal force of every pair, the width of its line in proportion: the force in the legend has
    the width of the mean radius, and larger ones are not wider. Blue is compression, red tension.
    """
    frame = frame_of(of, at)
    with style():
        sheet = _Sheet(frame, box, ax)
        sheet.disks()
        start, branch, _ = frame._branches()
        p = frame.pairs["p_n"].astype(float)
        end = end_of(p[p != 0.0])
        width = np.minimum(np.abs(p) / end, 1.0) * sheet.r.mean()
        unit, size = prefix(end, "N")
        for chosen, color, name in ((p > 0, COMPRESSION, "compression"), (p < 0, TENSION, "tension")):
            if chosen.any():
                strokes = _strokes(start[chosen], (start + branch)[chosen], width[chosen])
                sheet.polygons(strokes, color)
                sheet.sample(color, name, width=2.5)
        sheet.boundary()
        ax = sheet.end()
        if sheet.handles and ax.legend_ is not None:
            ax.legend_.set_title(f"as wide as the mean radius: {end / size:g} {unit}", prop={"size": 7})
        return ax


def stress(
    of: Run | Frame,
    at: int | str = "end",
    *,
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Mean stress (sigma_xx + sigma_yy)/2 of every disk, compression positive."""
    frame = frame_of(of, at)
    mean = frame.stresses[:, :2].mean(axis=1)
    # Few disks are in tension where a specimen is pressed.
    signed = mean.min(initial=0.0) < -0.02 * mean.max(initial=0.0)
    name = "mean stress of a disk, compression positive" if signed else "mean stress of a disk"
    return _field(frame, mean, name, "Pa", signed=signed, cracks=cracks, box=box, ax=ax)


def rotation(
    of: Run | Frame,
    at: int | str = "end",
    *,
    since: int | str | Frame = "start",
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Rotation between two moments, anticlockwise positive."""
    frame, before = _both(of, at, since)
    values = frame.turned(before)
    return _field(frame, values, "rotation", "rad", signed=True, cracks=cracks, box=box, ax=ax)


def displacement(
    of: Run | Frame,
    at: int | str = "end",
    *,
    since: int | str | Frame = "start",
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Magnitude of the displacement between two moments."""
    frame, before = _both(of, at, since)
    values = np.hypot(*frame.moved(before).T)
    return _field(frame, values, "displacement", "m", signed=False, cracks=cracks, box=box, ax=ax)


def shear_strain(
    of: Run | Frame,
    at: int | str = "end",
    *,
    since: int | str | Frame = "start",
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Maximum shear strain e_1 - e_2 around every disk between two moments (:meth:`Frame.strains`)."""
    frame, before = _both(of, at, since)
    values = 100.0 * frame.strains(before)[:, 1]
    name = "maximum shear strain"
    return _field(frame, values, name, "%", signed=False, cracks=cracks, box=box, ax=ax)


def volumetric_strain(
    of: Run | Frame,
    at: int | str = "end",
    *,
    since: int | str | Frame = "start",
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Volumetric strain e_1 + e_2 around every disk between two moments, contraction positive."""
    frame, before = _both(of, at, since)
    values = 100.0 * frame.strains(before)[:, 0]
    name = "volumetric strain, contraction positive"
    return _field(frame, values, name, "%", signed=True, cracks=cracks, box=box, ax=ax)


def _both(of: Run | Frame, at: int | str, since: int | str | Frame) -> tuple[Frame, Frame]:
    if isinstance(since, Frame):
        return frame_of(of, at), since
    if isinstance(of, Frame):
        raise ValueError("a frame needs another one: give `since`, a frame")
    return of.frame(at), of.frame(since)


def layers(
    of: Run | Frame,
    at: int | str = "end",
    *,
    since: int | str | Frame = "start",
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Twelve layers by the height of the disks at the moment ``since``."""
    frame, before = _both(of, at, since)
    rows = before.rows(frame.ids)
    _, low, _, high = view(before)
    height = (before.positions[rows, 1] - low) / (high - low) * NUMBER_OF_LAYERS
    # Disks of one height are in one layer, whatever the round-off of the numbers of a frame.
    colors = np.array(LAYERS)[(height + 1e-5).astype(int) % 2]
    colors[rows < 0] = "white"
    with style():
        sheet = _Sheet(frame, box, ax)
        sheet.disks(facecolors=colors)
        if cracks:
            sheet.cracks()
        sheet.boundary()
        return sheet.end()


def fragments(
    of: Run | Frame,
    at: int | str = "end",
    *,
    cracks: bool = False,
    box: Box | None = None,
    ax: Axes | None = None,
) -> Axes:
    """Sets of disks that intact bonds connect. The largest is grey, disks without a bond are white;
    the colours of others recur.
    """
    frame = frame_of(of, at)
    _, fragment, sizes = np.unique(frame.fragments, return_inverse=True, return_counts=True)
    order = np.argsort(-sizes, kind="stable")
    rank = np.argsort(order, kind="stable")[fragment]
    alone = sizes[fragment] == 1
    colors = np.array(FRAGMENTS)[(rank - 1) % len(FRAGMENTS)]
    colors[rank == 0] = "#d9d9d9"
    colors[alone] = "#ffffff"
    with style():
        sheet = _Sheet(frame, box, ax)
        sheet.disks(facecolors=colors)
        if cracks:
            sheet.cracks()
        sheet.boundary()
        whole = int((sizes > 1).sum())
        if whole:
            share = 100.0 * sizes.max() / len(frame)
            sheet.sample("#d9d9d9", f"largest: {sizes.max()} disks ({share:.1f} %)", disk=True)
        if whole > 1:
            sheet.sample(FRAGMENTS[0], f"{whole - 1} more fragments", disk=True)
        if alone.any():
            sheet.sample("#ffffff", f"{alone.sum()} disks alone", disk=True)
        return sheet.end()


def foci(run: Run, at: int | str = "peak", *, box: Box | None = None, ax: Axes | None = None) -> Axes:
    """Places of the emissions on the disks of a moment, the last ones on top. The radius of a circle is
    in proportion to the cube root of the energy, its colour is the axial strain.
    """
    import matplotlib
    from matplotlib.collections import EllipseCollection

    table = emissions(run)
    with style():
        sheet = _Sheet(run.frame(at), box, ax)
        sheet.disks(facecolors="#f3f1ec")
        sheet.boundary()
        energy = table["energy_j"].to_numpy()
        x0, y0, x1, y1 = sheet.box
        size = FOCUS * min(x1 - x0, y1 - y0) * np.cbrt(energy / energy.max())
        circles = EllipseCollection(
            size,
            size,
            np.zeros(len(size)),
            units="xy",
            offsets=table[["x_m", "y_m"]].to_numpy(),
            offset_transform=sheet.ax.transData,
            array=100.0 * table["axial_strain"].to_numpy(),
            cmap=matplotlib.colormaps["plasma"],
            alpha=0.7,
            edgecolors="#222222",
            linewidths=0.4,
            zorder=3,
        )
        sheet.ax.add_collection(circles)
        unit, part = prefix(energy.max(), "J")
        sheet.bar(circles, f"axial strain (%), largest {energy.max() / part:.3g} {unit}", False, False, None)
        return sheet.end()


def localisation(
    run: Run, at: int | str = "end", *, since: int | str = "start", box: Box | None = None
) -> np.ndarray:
    """Four panels of one scale: cracks at the peak, cracks at ``at``, layers since ``since``, and the
    rotation since the peak. Returns their axes, shape (4).
    """
    import matplotlib.pyplot as plt

    start, peak, now = run.frame(since), run.frame("peak"), run.frame(at)
    if box is None:
        boxes = np.array([view(peak), view(now)])
        x0, y0 = boxes[:, :2].min(axis=0)
        x1, y1 = boxes[:, 2:].max(axis=0)
        box = float(x0), float(y0), float(x1), float(y1)
    x0, y0, x1, y1 = box
    names = ["(a) peak", f"(b) {at}", "(c) layers", "(d) rotation since (a)"]
    with style():
        # Lengths in inches, so that all panels have one scale.
        width, gap, head, foot = 2.0 * WIDTH, 0.08, 0.2, 0.5
        each = (width - 3.0 * gap) / 4.0
        high = each * min((y1 - y0) / (x1 - x0), 2.5)
        height = head + high + foot
        figure = plt.figure(figsize=(width, height))

        def panel(k: int, bottom: float, tall: float, inset: float = 0.0) -> Axes:
            left = k * (each + gap) + inset * each
            wide = (1.0 - 2.0 * inset) * each
            return figure.add_axes((left / width, bottom / height, wide / width, tall / height))

        axes = np.array([panel(k, foot, high) for k in range(4)])
        sheets = [_draw_specimen(_Sheet(frame, box, ax)) for frame, ax in zip((peak, now), axes)]
        layers(now, since=start, box=box, ax=axes[2])
        _field(
            now,
            now.turned(peak),
            "rotation",
            "rad",
            signed=True,
            cracks=False,
            box=box,
            ax=axes[3],
            bar_in=panel(3, foot - 0.12, 0.08, 0.08),
        )
        for ax, name in zip(axes, names):
            ax.set_title(name, loc="left", pad=3)
        for sheet in sheets:
            if sheet.handles:
                sheet.ax.legend(
                    handles=sheet.handles,
                    loc="upper left",
                    bbox_to_anchor=(-0.03, 0.0),
                    borderpad=0.2,
                    labelspacing=0.2,
                )
    return axes
