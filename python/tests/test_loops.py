"""Loops of cyclic tests, against ellipses of a spring and a dashpot, and an elastic run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas
import pytest

import clastic


class Recorded:
    """A run with this history."""

    path = Path("recorded")

    def __init__(self, strain: np.ndarray, stress: np.ndarray) -> None:
        increments = np.arange(1, len(strain) + 1)
        self.history = pandas.DataFrame(
            {"increment": increments, "axial_strain": strain, "axial_stress_pa": stress}
        )


@pytest.mark.parametrize("damping", [0.02, 0.15])
@pytest.mark.parametrize("cycles", [2.5, 3.0])
def test_an_ellipse_has_the_modulus_and_damping_it_was_made_of(damping: float, cycles: float) -> None:
    # A spring E and a dashpot: the ratio of the loss to the elastic stress is 2 D.
    phase = np.linspace(0.0, 2.0 * np.pi * cycles, int(2000 * cycles) + 1)
    strain = 1e-3 * np.cos(phase)
    stress = 5e3 + 4e7 * (strain - 2.0 * damping * 1e-3 * np.sin(phase))
    table = clastic.loops(Recorded(strain, stress))
    assert len(table) == 2
    assert table["modulus_pa"].to_numpy() == pytest.approx(4e7, rel=1e-6)
    assert table["damping"].to_numpy() == pytest.approx(damping, rel=1e-4)
    assert table["loss_j_m3"].to_numpy() == pytest.approx(2.0 * np.pi * damping * 4e7 * 1e-6, rel=1e-4)


def test_a_friction_block_has_the_damping_of_a_parallelogram() -> None:
    # A spring beside a slider: loss 4 tau a, modulus E + tau/a.
    legs = [np.linspace(0.0, 1.0, 500), np.linspace(1.0, -1.0, 1000), np.linspace(-1.0, 1.0, 1000)]
    strain = 1e-3 * np.concatenate(legs)
    stress = 1e7 * strain + np.concatenate([np.full(500, 2e3), np.full(1000, -2e3), np.full(1000, 2e3)])
    table = clastic.loops(Recorded(strain, stress))
    assert len(table) == 1
    assert table["modulus_pa"][0] == pytest.approx(1e7 + 2e6, rel=1e-3)
    assert table["damping"][0] == pytest.approx(2.0 * 2e3 * 1e-3 / (np.pi * 1.2e7 * 1e-6), rel=5e-3)


def test_a_last_loop_ends_where_it_began_or_is_none() -> None:
    legs = [np.linspace(0.0, 1.0, 500), np.linspace(1.0, -1.0, 1000), np.linspace(-1.0, 1.0, 1000)]
    legs += [np.linspace(1.0, -1.0, 1000)]
    strain = 1e-3 * np.concatenate(legs)
    stress = 1e7 * strain + 2e3 * np.sign(np.gradient(strain))
    whole = clastic.loops(Recorded(strain, stress))
    for more in (np.linspace(-1.0, -0.6, 200), np.linspace(-1.0, 3.0, 2000)):
        way = np.concatenate([strain, 1e-3 * more])
        table = clastic.loops(Recorded(way, 1e7 * way + 2e3 * np.sign(np.gradient(way))))
        assert table["damping"][0] == pytest.approx(whole["damping"][0], rel=1e-9)
        assert table["strain_range"].to_numpy() == pytest.approx(2e-3, rel=1e-2)
        assert len(table) == (1 if more[-1] < 1.0 else 2)


def test_a_signal_without_a_loop_is_refused() -> None:
    strain = np.linspace(0.0, 1.0, 50)
    with pytest.raises(ValueError, match="no loop: axial_strain turns 1 times"):
        clastic.loops(Recorded(strain, strain))


def test_an_elastic_layer_has_its_modulus_and_no_damping(tmp_path: Path) -> None:
    table = clastic.loops(clastic.run("unload_reload", out=tmp_path / "run"))
    assert len(table) == 2
    assert table["modulus_pa"].to_numpy() == pytest.approx(8e6, rel=1e-6)
    assert table["damping"].to_numpy() == pytest.approx(0.0, abs=1e-6)
