#!/usr/bin/env python3
"""Peak of bonded rock against the increment, from event to event, on packings of any size.

    cargo build --release
    python3 benches/rock_increments.py [--count 400] [--seeds 601,602,603] [--multiples 1,4,16]

The rig of scenes/uniaxial_small.ron in proportion to `--count`, compacted anew with each seed (of
the packing and of the agitation), loaded with `rupture.order=Events` until the stress has fallen to
40 % of its peak. An increment of 1 is 0.0048 % strain. The table has the peak in MPa with the
number of bonds broken before it, the range of the peaks over the smallest of them, the solves to
the peak and processor seconds with the compaction. `--set` gives further fields of the scene.
"""

import argparse
import csv
from pathlib import Path

import ruptures


def peak(out):
    """Peak, bonds broken before it, solves to it."""
    with open(out / "history.csv") as file:
        rows = [row for row in csv.DictReader(file) if row["stage"] == "load"]
    k = max(range(len(rows)), key=lambda k: float(rows[k]["axial_stress_pa"]))
    with open(out / "events.csv") as file:
        broken = [int(row["increment"]) for row in csv.DictReader(file)]
    before = sum(n < int(rows[k]["increment"]) for n in broken)
    solves = sum(int(row["solves"]) for row in rows[: k + 1])
    return float(rows[k]["axial_stress_pa"]), before, solves


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ruptures.ROOT / "bench/rock_increments")
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seeds", default="601,602,603")
    parser.add_argument("--multiples", default="1,4,16")
    parser.add_argument("--program", type=Path, default=ruptures.PROGRAM)
    parser.add_argument("--set", action="append", default=[], dest="sets", metavar="FIELD=VALUE")
    args = parser.parse_args()
    ruptures.PROGRAM = args.program
    args.out.mkdir(parents=True, exist_ok=True)
    multiples = [float(m) for m in args.multiples.split(",")]
    path, closing = ruptures.rock(args.count, args.out)
    heads = [f"{m:g}" for m in multiples]
    print("| seed | " + " | ".join(heads) + " | range, % | solves to the peak | CPU s |")
    print("|---" * (len(heads) + 4) + "|")
    for seed in args.seeds.split(","):
        found = []
        for m in multiples:
            out = args.out / f"{args.count}_{seed}_{m:g}"
            sets = [
                "rupture.order=Events",
                f"specimen.seed={seed}",
                f"stages.compact.seed={seed}",
                f"stages.load.increments={round(400 / m)}",
                f"stages.load.walls.top=Displacement(0.0, {-closing * m:.9e})",
                "stages.load.stop=[StressDrop(0.4)]",
            ]
            cpu = ruptures.run(path, out, sets + args.sets)
            found.append([*peak(out), cpu])
        peaks = [row[0] for row in found]
        cells = [seed, *(f"{1e-6 * row[0]:.2f} ({row[1]})" for row in found)]
        cells.append(f"{100 * (max(peaks) / min(peaks) - 1):.2f}")
        cells.append(", ".join(str(row[2]) for row in found))
        cells.append(", ".join(f"{row[3]:.1f}" for row in found))
        print("| " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
