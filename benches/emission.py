#!/usr/bin/env python3
"""Acoustic emission of rock on several seeds: exponent of the energies, b towards failure, Kaiser effect.

    env/bin/python benches/emission.py [--out bench/emission] [--seeds 20]

with the package of python/ in env. The seed of scenes/acoustic_emission.ron is that of packing,
compaction and strengths of the bonds. The cut-off of exponents and of b is 0.1 J, that
of the smallest Kolmogorov-Smirnov distance of all energies.
"""

import argparse
from pathlib import Path

import clastic
import numpy as np
import pandas
from clastic.emission import cycles, emissions, power_law

CUT_OFF = 0.1
SEEDS = ("let.seed",)
#: Parts of the strength.
PARTS = (0.0, 0.6, 0.8, 0.9, 1.0)


def told(energy, what, factor=1.0, less=0.0):
    fit = power_law(energy, CUT_OFF)
    value, low, high = (factor * (a - less) for a in (fit.exponent, *fit.interval))
    print(
        f"{what}: {value:.2f} ({low:.2f} to {high:.2f}), {len(fit.above)} of {len(energy)} emissions"
    )


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--out", type=Path, default=Path("bench/emission"))
    parser.add_argument("--seeds", type=int, default=20)
    arguments = parser.parse_args()
    runs = []
    for seed in range(1, arguments.seeds + 1):
        sets = {path: seed for path in SEEDS}
        out = arguments.out / f"{seed}"
        is_there = (out / "run.json").exists() and clastic.open(
            out
        ).status == "completed"
        runs.append(
            clastic.open(out)
            if is_there
            else clastic.run("acoustic_emission", sets, out, force=True)
        )
    strength = np.array([run.results["peak_stress_pa"] for run in runs])
    print(f"strength {strength.min() / 1e6:.0f} to {strength.max() / 1e6:.0f} MPa")
    table = emissions(*runs)
    energy, of, stress = (
        table[c].to_numpy() for c in ("energy_j", "run", "axial_stress_before_pa")
    )
    each = np.array(
        [power_law(energy[of == k], CUT_OFF).exponent for k in range(len(runs))]
    )
    told(energy, "exponent of energies")
    print(
        f"of single runs: {each.mean():.2f} ± {each.std(ddof=1):.2f}, {each.min():.2f} to {each.max():.2f}"
    )
    sought = power_law(energy)
    print(f"cut-off sought: {sought.minimum:.3g} J, p = {sought.p_value(500):.3f}")
    for minimum in (0.1, 0.3, 1.0, 3.0):
        law = power_law(energy, minimum)
        print(
            f"  cut-off {minimum} J: {law.exponent:.2f} ± {law.error:.2f}, D = {law.distance:.3f}, p = {law.p_value(500):.3f}"
        )
    for minimum in (1, 2, 5, 10):
        law = power_law(table["bonds"].to_numpy(), minimum)
        print(
            f"  sizes from {minimum} on: {law.exponent:.2f} ± {law.error:.2f}, p = {law.p_value(100):.2f}"
        )

    part = stress / strength[of]
    summit = np.array(
        [
            table["increment"][stress_of.idxmax()]
            for _, stress_of in table.groupby("run")["axial_stress_before_pa"]
        ]
    )
    before = table["increment"].to_numpy() < summit[of]
    for low, high in zip(PARTS[:-1], PARTS[1:]):
        told(
            energy[before & (part > low) & (part <= high)],
            f"b from {low} to {high} of the strength",
            1.5,
            1.0,
        )
    told(
        energy[table["increment"].to_numpy() > summit[of]], "b after the peak", 1.5, 1.0
    )

    loadings = pandas.concat(
        [cycles(run).assign(loading=range(1, 5)) for run in runs], ignore_index=True
    )
    loadings["part"] = loadings["borne_pa"] / np.repeat(strength, 4)
    for k, rows in loadings[loadings["loading"] > 1].groupby("loading"):
        f, below = rows["felicity"], rows["emissions_below"].sum()
        print(
            f"after {rows['part'].mean():.2f} of the strength: felicity {f.median():.3f}, {f.min():.2f} to {f.max():.2f}, "
            f"{(f < 1).sum()} below 1; {below} of {rows['emissions'].sum()} emissions before, "
            f"{rows['emissions_unloading'].sum()} after it in unloading"
        )


if __name__ == "__main__":
    main()
