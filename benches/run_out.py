#!/usr/bin/env python3
"""Run-out of a column collapse with a time step and with half of it, as a mean over seeds.

    cargo build --release
    python3 benches/run_out.py [--out bench/run_out] [--seeds 1,2,3,4,6]

The scene is scenes/column_collapse_small.ron, 300 rigid disks, released for 0.7 s (the packing of seed 5 jams before its porosity). The run-out is
(d - d0)/d0: d from the back wall to the front of the pile, d0 the width of the column. The front
leaves out stray grains, which are more than half a mean diameter ahead of what lies behind them. The
table has the mean of the seeds, its standard error, the change of the mean with half the time step,
and the mean and standard error of the changes seed by seed.
"""

import argparse
import csv
import json
import math
import statistics
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
WIDTH, DT = 0.12, 2e-3
LAWS = {"A": "Associated", "C": "Coulomb()"}


def run(out, program, law, seed, half):
    if (out / "run.json").exists() and "outcome" in json.loads((out / "run.json").read_text()):
        return
    sets = {
        "friction_law": LAWS[law],
        "analysis.dt": DT / half,
        "specimen.seed": seed,
        "stages.compact.seed": seed,
        "stages.settle.increments": 50 * half,
        "stages.release.increments": 350 * half,
    }
    command = [program, "run", ROOT / "scenes/column_collapse_small.ron", "--out", out, "--force"]
    command += ["--quiet", "--threads", "1"]
    command += [word for name, value in sets.items() for word in ("--set", f"{name}={value}")]
    subprocess.run([str(word) for word in command], check=False)


def run_out(out):
    with open(out / "final_particles.csv") as file:
        rows = list(csv.DictReader(file))
    spans = sorted((float(r["x_m"]) - float(r["radius_m"]), float(r["x_m"]) + float(r["radius_m"])) for r in rows)
    reach = 0.0
    for start, end in spans:
        if start > reach + 5e-3:
            break
        reach = max(reach, end)
    return reach / WIDTH - 1


def capped(out):
    with open(out / "history.csv") as file:
        rows = [row for row in csv.DictReader(file) if row["stage"] != "compact"]
    return sum(row["status"] != "solved" or float(row["fraction"]) < 1 for row in rows), len(rows)


def mean(values):
    error = statistics.stdev(values) / math.sqrt(len(values)) if len(values) > 1 else 0.0
    return statistics.mean(values), error


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/run_out")
    parser.add_argument("--seeds", default="1,2,3,4,6")
    parser.add_argument("--program", default=PROGRAM)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    seeds = options.seeds.split(",")
    for law in LAWS:
        table = {}
        for half in (1, 2):
            bad = [0, 0]
            for seed in seeds:
                out = options.out / f"ro_{law}_{seed}_{half}"
                run(out, options.program, law, seed, half)
                table[seed, half] = run_out(out)
                bad = [a + b for a, b in zip(bad, capped(out))]
            values = [table[seed, half] for seed in seeds]
            print(
                f"{LAWS[law]}, dt {1e3 * DT / half:g} ms: mean {mean(values)[0]:.3f} +- {mean(values)[1]:.3f},",
                "seeds", " ".join(f"{v:.2f}" for v in values), f"; {bad[0]} of {bad[1]} increments not solved",
            )
        one, two = [mean([table[seed, half] for seed in seeds])[0] for half in (1, 2)]
        changes = mean([table[seed, 2] / table[seed, 1] - 1 for seed in seeds])
        print(
            f"{LAWS[law]}: change {100 * (two / one - 1):+.1f} %,",
            f"seed by seed {100 * changes[0]:+.1f} +- {100 * changes[1]:.1f} %",
        )


if __name__ == "__main__":
    main()
