"""Red Bohus granite: the strengths of the study beside those that were measured.

    python granite.py [DIRECTORY of a finished `clastic sweep studies/granite.ron`]

Without a directory it makes the study, 35 runs, in some four minutes of one core. It prints a table and draws the
strengths against the confining stress into `granite.png`.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import clastic

#: Dumoulin et al. 2024, Geomech. Energy Environ. 40, 100592 (doi 10.1016/j.gete.2024.100592), specimens of 50 x 100 mm,
#: in compression at confining stresses 40 x 100 mm: MPa, GPa.
UNCONFINED = np.array([112.1, 158.2, 117.9, 114.8])
BRAZILIAN = np.array([10.2, 10.6, 11.4, 9.0])
MODULUS = np.array([64.25, 60.0, 50.46, 54.46])
POISSON = np.array([0.11, 0.15, 0.20, 0.22])
#: Confining stress, and mean of three peaks of the axial stress.
CONFINED = {20.0: 424.9, 50.0: 649.0, 75.0: 779.1, 100.0: 899.3}
#: Saadati et al. 2016, Shock Vib. 6279571, another granite of Bohus.
TENSION = 8.0


def m_i_through_unconfined(confining, axial):
    """m_i of (sigma_1 - sigma_3)^2 = sigma_ci^2 + m_i sigma_ci sigma_3, by least squares. The first pair is unconfined."""
    confining, axial = np.asarray(confining, float), np.asarray(axial, float)
    squares = (axial - confining) ** 2 - axial[0] ** 2
    return confining @ squares / (axial[0] * confining @ confining)


root = Path(__file__).parents[2]
if len(sys.argv) > 1:
    table = clastic.Study(sys.argv[1]).table
else:
    table = clastic.sweep(root / "studies" / "granite.ron", out="runs/granite").table
strength = table.assign(strength=table.peak_stress_pa.abs() / 1e6)
of = {name: rows for name, rows in strength.groupby("scene")}
compression = of["compression"].assign(confining=lambda rows: rows.confining / 1e6)
by_confining = {s: rows.strength.to_numpy() for s, rows in compression.groupby("confining")}
unconfined = compression[compression.confining == 0.0]
by_packing = compression.sort_values("confining").groupby("seed")
m_i = [m_i_through_unconfined(rows.confining, rows.strength) for _, rows in by_packing]
measured_m_i = m_i_through_unconfined([0.0, *CONFINED], [UNCONFINED.mean(), *CONFINED.values()])


def line(name, measured, found, fitted=False):
    measured, found = np.atleast_1d(measured), np.asarray(found, float)
    spread = f" ± {measured.std(ddof=1):.3g}" if measured.size > 1 else ""
    error = found.mean() / measured.mean() - 1.0
    print(
        f"{name:28} {measured.mean():7.4g}{spread:8} {found.mean():8.4g} ± {found.std(ddof=1):<6.3g}"
        f" {100.0 * error:+6.1f} %  {'fitted' if fitted else ''}"
    )


print(f"{'':28} {'measured':>15} {'found':>17}")
line("E, GPa", MODULUS, unconfined.youngs_modulus_pa / 1e9, True)
line("nu", POISSON, of["tension"].poissons_ratio, True)
line("unconfined, MPa", UNCONFINED, by_confining[0.0], True)
line("Brazilian, MPa", BRAZILIAN, of["brazilian"].strength, True)
line("direct tension, MPa", TENSION, of["tension"].strength)
for confining, axial in CONFINED.items():
    line(f"at {confining:g} MPa, MPa", axial, by_confining[confining], confining == 50.0)
line("m_i", measured_m_i, m_i)

with clastic.figures.style():
    figure, axes = plt.subplots(figsize=(3.3, 2.8))
    axes.plot(0.0, UNCONFINED.mean(), "ks", mfc="none", label="measured")
    axes.errorbar(0.0, UNCONFINED.mean(), UNCONFINED.std(ddof=1), color="k", capsize=2)
    axes.plot(list(CONFINED), list(CONFINED.values()), "ks", mfc="none")
    axes.errorbar(
        list(by_confining),
        [s.mean() for s in by_confining.values()],
        [s.std(ddof=1) for s in by_confining.values()],
        fmt="o-",
        capsize=2,
        label="found, five packings",
    )
    axes.set_xlabel("confining stress, MPa")
    axes.set_ylabel("axial stress at the peak, MPa")
    axes.legend(frameon=False)
    axes.set_xlim(-3.0, 105.0)
    axes.set_ylim(bottom=0.0)
    figure.tight_layout()
    figure.savefig("granite.png", dpi=200)
