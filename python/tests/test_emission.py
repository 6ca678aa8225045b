"""Exponents, b-values and the Kaiser effect, against samples of known laws and tables by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
import powerlaw
import pytest
from scipy import stats

import clastic
from clastic import figures
from clastic.emission import b_values, cycles, emissions, power_law


def continuous(exponent: float, count: int, random: np.random.Generator) -> np.ndarray:
    return 2.0 * (1.0 + stats.pareto.rvs(exponent - 1.0, loc=-1.0, size=count, random_state=random))


def discrete(exponent: float, count: int, random: np.random.Generator) -> np.ndarray:
    return stats.zipf.rvs(exponent, size=count, random_state=random)


@pytest.mark.parametrize("draw, minimum", [(continuous, 2.0), (discrete, 1)])
@pytest.mark.parametrize("exponent", [1.5, 2.3])
def test_the_interval_has_the_exponent_in_95_of_100_samples(draw, minimum: float, exponent: float) -> None:
    random = np.random.default_rng(7)
    fits = [power_law(draw(exponent, 150, random), minimum) for _ in range(400)]
    inside = np.mean([fit.interval[0] <= exponent <= fit.interval[1] for fit in fits])
    # Three standard deviations of 400 draws.
    assert abs(inside - 0.95) < 3.0 * np.sqrt(0.95 * 0.05 / 400)
    found = np.array([fit.exponent for fit in fits])
    assert found.mean() == pytest.approx(exponent, abs=4.0 * found.std() / 20.0 + 0.01 * (exponent - 1.0))
    assert np.mean([fit.error for fit in fits]) == pytest.approx(found.std(), rel=0.1)


def test_continuous_values_have_the_closed_form() -> None:
    values = continuous(1.7, 300, np.random.default_rng(1))
    fit = power_law(values, 2.0)
    assert fit.exponent == pytest.approx(1.0 + 300 / np.log(values / 2.0).sum(), rel=1e-12)
    assert fit.error == pytest.approx((fit.exponent - 1.0) / np.sqrt(300), rel=1e-4)


@pytest.mark.filterwarnings("ignore::DeprecationWarning:powerlaw")
def test_exponents_and_cut_offs_are_those_of_another_package() -> None:
    random = np.random.default_rng(3)
    values = np.concatenate([continuous(1.6, 1500, random), random.uniform(0.5, 2.0, 1000)])
    theirs = powerlaw.Fit(values, verbose=False)
    ours = power_law(values, theirs.xmin)
    assert ours.exponent == pytest.approx(theirs.power_law.alpha, rel=1e-9)
    # They look for the distance at one side of every step only.
    assert ours.distance == pytest.approx(theirs.power_law.D, abs=1.5 / len(ours.above))
    assert power_law(values).minimum == pytest.approx(2.0, rel=0.25)
    assert power_law(values).distance <= ours.distance
    sizes = discrete(2.1, 500, random)
    theirs = powerlaw.Fit(sizes, xmin=2, discrete=True, estimate_discrete=False, verbose=False)
    assert power_law(sizes, 2).exponent == pytest.approx(theirs.power_law.alpha, rel=1e-3)


@pytest.mark.parametrize("draw", [continuous, discrete])
def test_samples_of_a_fit_have_its_exponent(draw) -> None:
    fit = power_law(draw(1.8, 200, np.random.default_rng(2)), 2)
    again = power_law(fit.sample(20000), fit.minimum)
    assert abs(again.exponent - fit.exponent) < 4.0 * again.error
    assert again.distance < 0.02


def test_what_is_no_power_law_has_a_small_p_value() -> None:
    random = np.random.default_rng(5)
    assert power_law(continuous(1.6, 300, random), 2.0).p_value(100) > 0.1
    assert power_law(discrete(2.0, 300, random), 1).p_value(50) > 0.1
    assert power_law(2.0 + random.exponential(size=300), 2.0).p_value(100) < 0.05
    assert power_law(1 + random.poisson(5.0, size=300), 1).p_value(50) < 0.05


def test_values_that_have_no_exponent_are_refused() -> None:
    for values, minimum, said in [
        (np.array([1.0, -2.0]), 1.0, "above 0"),
        (np.full(20, 3), None, "not all the same"),
        (np.array([1.0, 2.0]), 5.0, "too few"),
        (np.array([1.0, 2.0]), 0.0, "cut-off must be above 0"),
    ]:
        with pytest.raises(ValueError, match=said):
            power_law(values, minimum)
    # A cut-off between whole numbers is the next one.
    sizes = np.array([1, 2, 2, 3, 5, 9])
    assert power_law(sizes, 1.5).exponent == power_law(sizes, 2).exponent


def table(magnitudes: np.ndarray) -> pandas.DataFrame:
    strain = np.linspace(0.0, 0.01, len(magnitudes))
    return pandas.DataFrame({"energy_j": 10.0 ** (1.5 * magnitudes), "axial_strain": strain})


def test_b_is_that_of_gutenberg_and_richter() -> None:
    # Two thirds of the emissions have b = 1.5, the others b = 0.7.
    random = np.random.default_rng(11)
    magnitudes = np.concatenate(
        [random.exponential(np.log10(np.e) / b, n) for b, n in [(1.5, 800), (0.7, 400)]]
    )
    b = b_values(table(magnitudes - 3.0), 10.0**-4.5, window=200)
    assert (b["emissions"] == 200).all() and len(b) == 11
    mean = magnitudes[:200].mean()
    assert b["b"][0] == pytest.approx(np.log10(np.e) / mean, rel=1e-12)
    assert (b["low"][:7] < 1.5).all() and (b["high"][:7] > 1.5).sum() >= 6
    assert abs(b["b"].iloc[-1] - 0.7) < 3.0 * b["error"].iloc[-1]
    with pytest.raises(ValueError, match="give a window below 2000"):
        b_values(table(magnitudes), 1.0, window=2000)


class ByHand(clastic.Run):
    """Loaded to 4 MPa, unloaded to 1 MPa, loaded to 6 MPa, with emissions of 1, 2, 4 and 8 J."""

    def __init__(self) -> None:
        self.path = "by hand"

    @property
    def history(self) -> pandas.DataFrame:
        stress = np.array([0, 2, 4, 3, 1, 2, 4, 6, 5])
        # At the end the stress falls although the strain grows.
        strain = np.array([0, 2, 4, 3, 1, 2, 4, 6, 7]) * 1e-3
        columns = {"increment": np.arange(1, 10), "axial_strain": strain, "axial_stress_pa": 1e6 * stress}
        return pandas.DataFrame(columns)

    @property
    def avalanches(self) -> pandas.DataFrame:
        return pandas.DataFrame({
            "increment": [3, 4, 7, 8], "axial_strain": 1e-3 * np.array([4, 3, 4, 6]),
            "axial_stress_before_pa": 1e6 * np.array([4, 3, 2.5, 6]), "released_j": [1.0, 2.0, 4.0, 8.0],
            "broken_tension": [1, 1, 1, 3], "broken_shear": [0, 0, 0, 2], "broken_rolling": 0,
            "x_m": 0.0, "y_m": 0.0,
        })  # fmt: skip


def test_a_loading_is_compared_with_the_largest_stress_before_it() -> None:
    first, second = cycles(ByHand()).to_dict("records")
    assert (first["emissions"], first["emissions_unloading"], first["highest_pa"]) == (1, 1, 4e6)
    assert np.isnan(first["borne_pa"]) and np.isnan(first["felicity"]) and first["emissions_below"] == 0
    assert (second["borne_pa"], second["onset_pa"], second["felicity"]) == (4e6, 2.5e6, 0.625)
    assert (second["emissions"], second["emissions_below"]) == (2, 1)
    assert (second["energy_j"], second["energy_below_j"]) == (12.0, 4.0)
    both = emissions(ByHand(), ByHand())
    assert list(both["run"]) == [0] * 4 + [1] * 4 and list(both["bonds"][:4]) == [1, 1, 1, 5]
    assert both["magnitude"][3] == pytest.approx(2 / 3 * np.log10(8.0))


def test_a_rock_remembers_the_stress_that_it_has_borne(cyclic: clastic.Run) -> None:
    loadings = cycles(cyclic)
    assert len(loadings) == 4
    assert loadings["emissions"].sum() == len(emissions(cyclic))
    assert (loadings["emissions"] > 5).all() and (loadings["emissions_unloading"] == 0).all()
    # The stress of every cycle is that at which its stage ends, within one increment of 3.5 MPa.
    borne = loadings["borne_pa"][1:].to_numpy()
    assert np.all((borne >= [1.0e8, 1.3e8, 1.6e8]) & (borne < [1.04e8, 1.34e8, 1.64e8]))
    assert (loadings["felicity"][1:] > 0.98).all()
    ax = figures.emission_cycles(cyclic, energy=True)
    assert ax.lines[-2].get_ydata()[-1] == pytest.approx(emissions(cyclic)["energy_j"].sum())


def test_runs_without_emissions_say_why(tmp_path: Path) -> None:
    run = clastic.run("tension", out=tmp_path / "tension", progress=False)
    with pytest.raises(ValueError, match="no avalanche"):
        emissions(run)
    # A lateral stress does work, which only the energy ledger has.
    sets = {"stages.load.increments": 24, "rupture": "(rolling: Yields, density: 21.0, brittleness: 0.0)"}
    with pytest.warns(clastic.RunWarning):
        run = clastic.run("biaxial_small", sets, tmp_path / "biaxial", progress=False)
    with pytest.raises(ValueError, match="energy: true"):
        emissions(run)
