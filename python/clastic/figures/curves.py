"""Figures of the history."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..results import Run
from ..strengths import mohr_coulomb
from .style import legend_below, new_axes, prefix, style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

STRAIN = "axial strain (%)"
#: Difference of two confining stresses over the peak that is that of the walls' control.
SAME = 1e-3
#: Second curve of a figure.
SECOND = "#c82828"


def _names(runs: tuple[Run, ...]) -> list[str]:
    names = [run.path.name for run in runs]
    return [f"{run.path.parent.name}/{n}" if names.count(n) > 1 else n for run, n in zip(runs, names)]


def _runs(runs: tuple[Run, ...]) -> None:
    if not runs:
        raise ValueError("give a run")


def _absent(run: Run, what: str) -> ValueError:
    return ValueError(f"{run.path}: {what}")


def stress_strain(*runs: Run, ax: Axes | None = None, bonds: bool = True) -> Axes:
    """Stresses and the sum of the broken bonds against axial strain, from the initial state on; of
    several runs the axial stress. ``bonds=False`` leaves the broken bonds out; their axes are
    ``ax.second``.
    """
    _runs(runs)
    curves = [run.curve("axial_stress_pa") for run in runs]
    for run, curve in zip(runs, curves):
        if len(curve) == 0:
            raise _absent(run, "no row has an axial strain and stress; the scene must measure them")
    with style():
        ax = new_axes(0.75, ax)
        if len(runs) == 1:
            lateral = runs[0].curve("lateral_stress_pa")
            curves = [curves[0], *([lateral] if len(lateral) else [])]
            names = ["axial stress", "lateral stress"]
        else:
            names = _names(runs)
        unit, size = prefix(max(np.abs(c[:, 1]).max() for c in curves), "Pa")
        for name, curve in zip(names, curves):
            ax.plot(100.0 * curve[:, 0], curve[:, 1] / size, label=name)
        ax.set(xlabel=STRAIN, ylabel=f"{'stress' if len(runs) == 1 else 'axial stress'} ({unit})")
        ax.margins(x=0.02)
        broken = _broken(runs[0]) if bonds and len(runs) == 1 else None
        if broken is not None:
            ax.second = ax.twinx()  # type: ignore[attr-defined]
            ax.second.plot(100.0 * broken[:, 0], broken[:, 1], color=SECOND, lw=0.8, ls="--")
            ax.second.set_ylabel("broken bonds", color=SECOND)
            ax.second.tick_params(axis="y", colors=SECOND)
            ax.second.set_ylim(bottom=0)
        if len(curves) > 1:
            legend_below(ax)
    return ax


def _broken(run: Run) -> np.ndarray | None:
    modes = [run.curve(f"broken_{mode}") for mode in ("tension", "shear", "rolling")]
    total = np.column_stack([modes[0][:, 0], sum(mode[:, 1] for mode in modes)])
    return total if total[:, 1].any() else None


def volumetric(*runs: Run, ax: Axes | None = None) -> Axes:
    """Volumetric strain, 1 - (1 - axial)(1 - lateral), against axial strain."""
    _runs(runs)
    with style():
        ax = new_axes(0.75, ax)
        for run, name in zip(runs, _names(runs)):
            curve = run.curve("volumetric_strain")
            if len(curve) == 0:
                raise _absent(run, "no row has axial and lateral strains; the scene must measure them")
            ax.plot(100.0 * curve[:, 0], 100.0 * curve[:, 1], label=name)
        ax.axhline(0.0, color="#999999", lw=0.5, zorder=0)
        ax.set(xlabel=STRAIN, ylabel="volumetric strain (%)")
        ax.margins(x=0.02)
        if len(runs) > 1:
            legend_below(ax)
    return ax


def force_displacement(*runs: Run, ax: Axes | None = None) -> Axes:
    """Force of the outside world on the probes against their displacement since the start of the
    test, along the axis with the most work and positive in the direction of the largest displacement.
    """
    _runs(runs)
    drives = [(run, run.drives()) for run in runs]
    for run, list in drives:
        if not list:
            raise _absent(run, 'no probe moves against a force; give a wall `probe: "NAME"`, and move it')
    turns = {d in ("clockwise", "anticlockwise") for _, list in drives for _, d, _ in list}
    directions = {d for _, list in drives for _, d, _ in list}
    if len(turns) > 1:
        raise ValueError("in some of the runs the probes turn, in others they do not")
    with style():
        ax = new_axes(0.75, ax)
        points = [p for _, list in drives for *_, p in list]
        unit, size = (
            ("rad", 1.0) if turns == {True} else prefix(max(np.abs(p[:, 1]).max() for p in points), "m")
        )
        force_unit, force_size = prefix(
            max(np.abs(p[:, 2]).max() for p in points), "N m" if turns == {True} else "N"
        )
        for (run, list), name in zip(drives, _names(runs)):
            for probe, direction, p in list:
                parts = [name] if len(runs) > 1 else []
                parts += [probe] if len(list) > 1 or len(runs) == 1 else []
                parts += [direction] if len(directions) > 1 else []
                ax.plot(p[:, 1] / size, p[:, 2] / force_size, label=", ".join(parts))
        what, force = ("rotation", "moment") if turns == {True} else ("displacement", "force")
        along = f" along {directions.pop()}" if len(directions) == 1 else ""
        ax.set(xlabel=f"{what}{along} ({unit})", ylabel=f"{force} ({force_unit})")
        # Two platens often have one curve.
        for line, shape in zip(ax.lines[1:], ("--", ":", "-.")):
            line.set_linestyle(shape)
        if len(points) > 1:
            legend_below(ax)
    return ax


def energies(run: Run, ax: Axes | None = None) -> Axes:
    """Terms of the energy ledger, for scenes with ``output: (energy: true)``, against axial strain,
    time, or the number of the increment. Terms below 0.2 % of the largest are left out.
    """
    history = run.history
    columns = [c for c in history.columns if c.startswith("energy_")]
    if not columns:
        raise _absent(run, "its history has no energies; give `output: (energy: true)`")
    strained = history["axial_strain"].notna().any()
    time = history["time_s"]
    along, label, factor = ("increment", "increment", 1.0)
    if strained:
        along, label, factor = ("axial_strain", STRAIN, 100.0)
    elif time.iloc[-1] > time.iloc[0]:
        along, label = ("time_s", "time (s)")
    largest = history[columns].abs().to_numpy().max()
    unit, size = prefix(largest, "J")
    with style():
        ax = new_axes(0.9, ax)
        styles = ("-", "--", ":")
        shown = [c for c in columns if history[c].abs().max() > 2e-3 * largest]
        for k, column in enumerate(shown):
            if strained:
                x, y = run.curve(column).T
            else:
                x, y = history[along].to_numpy(), history[column].to_numpy()
            name = column.removeprefix("energy_").removesuffix("_j").replace("_", " ")
            ax.plot(factor * x, y / size, label=name, ls=styles[k // 8])
        ax.set(xlabel=label, ylabel=f"energy ({unit})")
        ax.margins(x=0.02)
        legend_below(ax, ncols=3)
    return ax


def fabric(run: Run, ax: Axes | None = None) -> Axes:
    """Anisotropies a and a_n, and the coordination 2 N_c / N, in all frames of a run, against axial
    strain, time, or the number of the increment. The axes of the coordination are ``ax.second``.
    """
    found = []
    for frame in run.frames():
        try:
            found.append((frame, frame.fabric()))
        except ValueError:
            # A frame without contacts has no fabric.
            continue
    strained = any(np.isfinite(frame.axial_strain) for frame, _ in found)
    if strained:
        first = next(k for k, (frame, _) in enumerate(found) if np.isfinite(frame.axial_strain))
        # The frame before the first strain is that of the start.
        found = found[max(first - 1, 0) :]
    if len(found) < 2:
        raise _absent(run, "two frames with contacts are needed; give `output: (frames_every: N)`")
    timed = found[-1][0].time > found[0][0].time
    label = STRAIN if strained else "time (s)" if timed else "increment"
    x = [
        100.0 * np.nan_to_num(f.axial_strain) if strained else f.time if timed else f.increment
        for f, _ in found
    ]
    with style():
        ax = new_axes(0.75, ax)
        mark = "o" if len(x) < 40 else None
        ax.plot(x, [f.a for _, f in found], label="contacts, $a$", marker=mark, ms=2.5)
        ax.plot(x, [f.a_n for _, f in found], label="normal forces, $a_n$", marker=mark, ms=2.5)
        ax.set(xlabel=label, ylabel="anisotropy")
        ax.set_ylim(bottom=0)
        ax.second = ax.twinx()  # type: ignore[attr-defined]
        coordination = [f.coordination for _, f in found]
        ax.second.plot(x, coordination, color=SECOND, lw=0.8, ls="--")
        ax.second.set_ylabel("coordination $2N_c/N$", color=SECOND)
        ax.second.tick_params(axis="y", colors=SECOND)
        ax.second.margins(y=0.2)
        legend_below(ax)
    return ax


def mohr(*runs: Run, ax: Axes | None = None) -> Axes:
    """Half circles between the lateral and the axial stress at the peak of every run, and the line
    tau = c + sigma tan phi by least squares of sigma_1. Runs with one confining stress have no line.

    Raises
    ------
    ValueError
        If sigma_1 rises less than sigma_3, to which no friction angle belongs.
    """
    _runs(runs)
    strengths = [run.peak_stresses() for run in runs]
    unit, size = prefix(max(peak for _, peak in strengths), "Pa")
    with style():
        ax = new_axes(0.75, ax)
        angle = np.linspace(0.0, np.pi, 181)
        for confining, peak in sorted(strengths):
            centre, radius = 0.5 * (peak + confining) / size, 0.5 * abs(peak - confining) / size
            small, per = prefix(confining, "Pa")
            ax.plot(
                centre + radius * np.cos(angle),
                radius * np.sin(angle),
                label=rf"$\sigma_3$ = {confining / per:.4g} {small}",
            )
        low = min(0.0, *(c / size for c, _ in strengths))
        high = max(p / size for _, p in strengths)
        ax.set_xlim(low, 1.04 * high)
        if np.ptp([confining for confining, _ in strengths]) > SAME * max(peak for _, peak in strengths):
            cohesion, phi = mohr_coulomb(strengths)
            x = np.array([low, high])
            c_unit, c_size = prefix(cohesion, "Pa")
            ax.plot(
                x,
                cohesion / size + np.tan(np.radians(phi)) * x,
                color="black",
                lw=0.8,
                label=rf"$c$ = {cohesion / c_size:.3g} {c_unit}, $\varphi$ = {phi:.1f}°",
            )
        ax.set(xlabel=f"normal stress ({unit})", ylabel=f"shear stress ({unit})")
        ax.set_ylim(bottom=0)
        ax.set_aspect("equal", adjustable="box")
        legend_below(ax)
    return ax
