"""Each figure draws, into axes of its own and into those that are given."""

from __future__ import annotations

import inspect
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pandas
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import clastic
from clastic import figures

NAMES = [name for name in figures.__all__ if name not in ("WIDTH", "close", "style")]
EMISSION = ("b_value", "emission_cycles", "emission_sizes", "foci")
ROSES = [name for name in NAMES if name.endswith("rose")]


@pytest.fixture(autouse=True)
def _closed():
    yield
    plt.close("all")


@pytest.fixture
def run(name: str, request: pytest.FixtureRequest) -> Any:
    """A run that has what the figure shows, or a slope."""
    if name == "slide":
        slides = pandas.DataFrame(
            [{"directory": request.getfixturevalue("biaxial").path, "toe": (0.02, 0.02)}]
        )
        return SimpleNamespace(slides=slides, height=0.1, mechanism=clastic.log_spiral(60.0, 20.0))
    return request.getfixturevalue("cyclic" if name in EMISSION else "biaxial")


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_draws(name: str, run: Any, tmp_path: Path) -> None:
    draw = getattr(figures, name)
    drawn = np.atleast_1d(draw(run))
    for ax in drawn:
        assert isinstance(ax, Axes)
        shown = [*ax.lines, *ax.collections, *ax.patches]
        assert shown, "nothing is drawn"
        for line in ax.lines:
            assert np.isfinite(np.asarray(line.get_data(), float)).all()
    for ending in ("png", "pdf", "svg"):
        file = tmp_path / f"figure.{ending}"
        drawn[0].figure.savefig(file)
        assert file.stat().st_size > 2000
    if "ax" in inspect.signature(draw).parameters:
        polar = {"projection": "polar"} if name in ROSES else None
        _, ours = plt.subplots(subplot_kw=polar)
        assert draw(run, ax=ours) is ours and plt.get_fignums()[-1] == ours.figure.number


def fits(figure: Figure) -> bool:
    """Whether all that a figure shows is on its page as it is saved without `bbox_inches`."""
    figure.canvas.draw()
    shown, (width, height) = figure.get_tightbbox(figure.canvas.get_renderer()), figure.get_size_inches()
    return shown.x0 > -0.01 and shown.y0 > -0.01 and shown.x1 < width + 0.01 and shown.y1 < height + 0.01


@pytest.mark.parametrize("name", NAMES)
def test_a_figure_fits_its_page(name: str, run: Any) -> None:
    draw = getattr(figures, name)
    drawn = [draw(run)]
    if "cracks" in inspect.signature(draw).parameters:
        drawn.append(draw(run, cracks=True))
    for ax in drawn:
        first = np.atleast_1d(ax)[0]
        assert fits(first.figure)


def test_a_title_has_a_place_beside_the_legend(biaxial: clastic.Run) -> None:
    ax = figures.stress_strain(biaxial, biaxial)
    title = ax.set_title("a title")
    assert fits(ax.figure)
    assert not title.get_window_extent().overlaps(ax.get_legend().get_window_extent())


def test_curves_are_those_of_the_history(biaxial: clastic.Run) -> None:
    ax = figures.stress_strain(biaxial, biaxial)
    strain, stress = ax.lines[0].get_data()
    row = biaxial.history.iloc[-1]
    assert strain[-1] == pytest.approx(100 * row["axial_strain"])
    assert stress[-1] == pytest.approx(1e-3 * row["axial_stress_pa"]) and "kPa" in ax.get_ylabel()
    mohr = figures.mohr(biaxial)
    x, y = mohr.lines[0].get_data()
    lateral = biaxial.history["lateral_stress_pa"][biaxial.history["axial_stress_pa"].idxmax()]
    assert x.max() == pytest.approx(1e-3 * biaxial.results["peak_stress_pa"])
    assert x.min() == pytest.approx(1e-3 * lateral) and y.max() == pytest.approx(np.ptp(x) / 2, rel=1e-3)


class Stronger(clastic.Run):
    """A run with a peak 1 % higher at the confining stress that a servo finds to nine digits."""

    @property
    def results(self) -> dict[str, Any]:
        return {**super().results, "peak_stress_pa": self.history["axial_stress_pa"].max()}

    @property
    def history(self) -> pandas.DataFrame:
        columns = super().history
        scale = {"axial_stress_pa": 1.01, "lateral_stress_pa": 1.0 + 1e-9}
        return columns.assign(**{name: factor * columns[name] for name, factor in scale.items()})


def test_runs_with_one_confining_stress_have_no_envelope(biaxial: clastic.Run) -> None:
    assert len(figures.mohr(biaxial, Stronger(biaxial.path)).lines) == 2


def test_a_figure_is_of_a_moment_and_of_a_simulation(biaxial: clastic.Run) -> None:
    def counts(ax: Axes) -> str:
        return " ".join(text.get_text() for text in ax.get_legend().get_texts()) if ax.get_legend() else ""

    peak, end = (counts(figures.specimen(biaxial, at)) for at in ("peak", "end"))
    assert peak != end and "in shear" in end
    broken = biaxial.history.iloc[-1]["broken_shear"]
    assert f"{broken} in shear" in end
    sim = clastic.Simulation("biaxial_small", set={"stages.load.increments": 2})
    start = sim.frame()
    sim.run()
    ax = figures.displacement(sim.frame(), since=start)
    assert "displacement" in ax.scale.ax.get_xlabel()
    with pytest.raises(ValueError, match="give `since`"):
        figures.rotation(start)


def test_what_cannot_be_drawn_is_explained(tmp_path: Path) -> None:
    run = clastic.run("tension", out=tmp_path / "tension", progress=False)
    for draw, said in [
        (figures.energies, "energy: true"),
        (figures.fabric, "frames_every"),
        (figures.contact_rose, "no contact"),
        (figures.mohr, "no peak"),
    ]:
        with pytest.raises(ValueError, match=said):
            draw(run)
    with pytest.raises(ValueError, match="give a run"):
        figures.stress_strain()
