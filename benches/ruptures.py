#!/usr/bin/env python3
"""Peak of cemented sand against rule of rupture and increment, on five packings of 900 disks.

    cargo build --release
    python3 benches/ruptures.py [--out bench/ruptures] [--seeds 11,12,13,14,15] [--set rupture.brittleness=0.0]

The packings are made as by scenes/prepare_biaxial.ron, in proportion and without the last leg; the
packing is that of the last leg that does not jam. Laws are those of scenes/biaxial_10kPa.ron, and
an increment of 1 is its 0.074 % strain (0.3 mm of each platen at full size; 0.2 and 1.0 mm are 0.667
and 3.33). The table has the mean error of q at 0.5 % and 1 % strain and of the peak against
`OneRound` at 1/64 of the increment (`--reference 16`: at 1/16), the errors of the peak of single
packings, solves to the peak, processor seconds, and their sum over that of `OneRound` at 1.
`--set` gives fields of the scene to the runs with `Events`, `--multiples` their increments.

With `--avalanches` the rules of `rupture.avalanche` are compared instead, with bonds that break one by one: on these
packings, and on the rocks of scenes/uniaxial_small.ron with the seeds of `--rocks`, of 400 disks or of `--rock-count`.
A run that takes longer than `--limit` processor seconds is stopped, and its row is left open where it did not come so
far. `--end` is the strain at which a sand ends.
"""

import argparse
import csv
import re
import resource
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
COUNT, STRAIN, END = 900, 0.000741, 0.022
AVALANCHES = ["MostOverloaded", "Dynamic"]


def prepare(seed, out):
    """Runs the compaction in proportion to COUNT."""
    text = (ROOT / "scenes/prepare_biaxial.ron").read_text()
    k = (COUNT / 6160) ** 0.5
    text = text.replace("count: 6160", f"count: {COUNT}").replace("columns: 59", f"columns: {int(59 * k)}")
    text = re.sub(r"(?<![\d.])0\.6(?=[,)])", f"{0.6 * k:.6g}", text)
    text = re.sub(r"(?<![\d.])1\.05(?=[,)])", "0.43", text)
    text = re.sub(r"Height\(([\d.]+)\)", lambda m: f"Height({float(m[1]) * k:.6g})", text)
    text = re.sub(r".*\"leg 9\".*\n", "", text)
    text = text.replace("seed: 1,\n    ),", f"seed: {seed},\n    ),")
    scene = out / f"prepare_{seed}.ron"
    scene.write_text(text)
    run(scene, out / f"prepare_{seed}")
    return out / f"prepare_{seed}/specimen.csv"


def biaxial(seed, specimen, out):
    """The scene with this specimen between its walls, and half of the closing of an increment."""
    with open(specimen) as file:
        disks = [[float(x) for x in row] for row in list(csv.reader(file))[1:]]
    width = max(x + r for x, _, r in disks) + 1e-7
    height = max(y + r for _, y, r in disks) + 1e-7
    text = (ROOT / "scenes/biaxial_small.ron").read_text()
    text = text.replace("specimens/biaxial_400.csv", str(specimen.resolve()))
    text = text.replace("0.2147896", f"{height:.7f}").replace("0.121", f"{width:.7f}")
    text = text.replace("50.0e3", "10.0e3").replace("Above(\"axial_strain\", 0.12)", f"Above(\"axial_strain\", {END})")
    scene = out / f"biaxial_{seed}.ron"
    scene.write_text(text)
    return scene, height * STRAIN / 2


def rock(count, out):
    """The rig of uniaxial_small with `count` disks, width and height in proportion; its increment, m."""
    text = (ROOT / "scenes/uniaxial_small.ron").read_text()
    columns = round(9 * (count / 400) ** 0.5)
    width = (1.2 * columns + 0.84) * 1e-3
    height = 1.2e-3 * -(-count // columns)
    # Of equal porosity, so that the area a disk needs is that of 400 disks.
    compacted = 29.02e-3 * count / 400 * 11.64e-3 / width
    text = text.replace("count: 400", f"count: {count}").replace("columns: 9", f"columns: {columns}")
    text = text.replace("11.64e-3", f"{width:.6g}").replace("54.0e-3", f"{height:.6g}")
    path = out / f"rock_{count}.ron"
    path.write_text(text)
    return path, 1.397e-6 / 29.02e-3 * compacted


def run(scene, out, sets=(), limit=None):
    command = [PROGRAM, "run", scene, "--out", out, "--force", "--threads", "1"]
    command += [word for value in sets for word in ("--set", value)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    bound = (lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit))) if limit else None
    command = [str(word) for word in command]
    subprocess.run(command, capture_output=True, check=False, preexec_fn=bound)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def loading(out):
    """Strain, q and solves so far of every row of the loading stage."""
    with open(out / "history.csv") as file:
        rows = list(csv.DictReader(file))
    curve, solves = [(0.0, 0.0, 0)], 0
    for row in rows:
        solves += int(row["solves"])
        if row["stage"] == "load" and row["axial_stress_pa"]:  # empty where the test collapsed
            q = float(row["axial_stress_pa"]) - float(row["lateral_stress_pa"] or 0.0)
            curve.append((float(row["axial_strain"]), q, solves))
    return curve


def at(curve, strain):
    """q at a strain: linear between rows, of several rows at this strain the last; None beyond the end."""
    k = max(k for k, point in enumerate(curve) if point[0] <= strain)
    if k + 1 == len(curve):
        return curve[k][1] if curve[k][0] == strain else None
    a, b = curve[k], curve[k + 1]
    return a[1] + (strain - a[0]) / (b[0] - a[0]) * (b[1] - a[1])


def measured(out):
    """q at 0.5 % and 1 % strain, its peak, and the solves up to the peak."""
    curve = loading(out)
    peak = max(curve, key=lambda point: point[1])
    return [at(curve, 0.005), at(curve, 0.01), peak[1], peak[2]]


def avalanches(out, times):
    """Peak and its strain, q at multiples of this strain, bonds broken, and those in avalanches.

    Bonds in avalanches are those after the first bond of each event.
    """
    curve = loading(out)
    peak = max(curve, key=lambda point: point[1])
    later = [at(curve, k * peak[0]) for k in times]
    with open(out / "events.csv") as file:
        broken = sum(1 for _ in file) - 1
    with open(out / "avalanches.csv") as file:
        sizes = [
            sum(int(row[f"broken_{mode}"]) for mode in ("tension", "shear", "rolling"))
            for row in csv.DictReader(file)
        ]
    return [peak[1], peak[0], *later, broken, sum(size - 1 for size in sizes), max(sizes, default=0)]


def compare_avalanches(args):
    """Prints the table of the rules of avalanches."""
    scene, closing = ROOT / "scenes/uniaxial_small.ron", 1.397e-6
    if args.rock_count != 400:
        scene, closing = rock(args.rock_count, args.out)
    moved = f"stages.load.walls.top=Displacement(0.0, {-closing:.9e})"
    rocks = [(f"rock {seed}", scene, [f"specimen.seed={seed}", moved], 1e-6, (1.1, 1.5))
             for seed in args.rocks.split(",") if seed]
    sands = []
    for seed in args.seeds.split(","):
        if seed:
            scene, closing = biaxial(seed, prepare(seed, args.out), args.out)
            sets = [
                f"stages.load.increments={int(7500 * END)}",
                f"stages.load.walls.top=Displacement(0.0, {-closing:.9e})",
                f"stages.load.walls.bottom=Displacement(0.0, {closing:.9e})",
                "rupture.density=21.0",
                "rupture.brittleness=0.0",
            ]
            sands.append((f"sand {seed}", scene, sets, 1e-3, (1.1, 1.3)))
    print("| packing | rule | peak | strain, % | later | later | bonds broken | in avalanches | largest | CPU s |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name, scene, sets, unit, times in rocks + sands:
        for rule in args.rules.split(","):
            out = args.out / f"{name.replace(' ', '_')}_{rule}"
            rules = ["rupture.order=Events", f"rupture.avalanche={rule}"]
            cpu = run(scene, out, sets + rules + args.sets, args.limit)
            peak, strain, *later, broken, more, largest = avalanches(out, times)
            numbers = [f"{unit * peak:.1f}", f"{100 * strain:.3f}"]
            numbers += ["" if q is None else f"{unit * q:.1f}" for q in later]
            numbers += [str(broken), str(more), str(largest), f"{cpu:.1f}"]
            print("| " + " | ".join([name, f"`{rule}`", *numbers]) + " |", flush=True)


def main():
    global PROGRAM, COUNT, END
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/ruptures")
    parser.add_argument("--seeds", default="11,12,13,14,15")
    parser.add_argument("--count", type=int, default=COUNT, help="disks of a sand")
    parser.add_argument("--end", type=float, default=END, help="axial strain at the end of a sand")
    parser.add_argument("--rock-count", type=int, default=400, help="disks of a rock")
    parser.add_argument("--rocks", default="1,2,3,4,5", help="with --avalanches")
    parser.add_argument("--rules", default=",".join(AVALANCHES), help="with --avalanches")
    parser.add_argument("--avalanches", action="store_true")
    parser.add_argument("--reference", type=int, default=64, choices=(16, 64))
    parser.add_argument("--multiples", default="1,2,3.3333333333333335", help="increments with Events")
    parser.add_argument("--limit", type=int, default=600, help="processor seconds of a run")
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--set", action="append", default=[], dest="sets", metavar="FIELD=VALUE")
    args = parser.parse_args()
    PROGRAM, COUNT, END = args.program, args.count, args.end
    args.out.mkdir(parents=True, exist_ok=True)
    if args.avalanches:
        return compare_avalanches(args)
    found = {}
    runs = [("OneRound", m) for m in (1 / 64, 1 / 16, 1.0) if m >= 1 / args.reference]
    runs += [("Events", float(m)) for m in args.multiples.split(",")]
    for seed in args.seeds.split(","):
        scene, closing = biaxial(seed, prepare(seed, args.out), args.out)
        for order, m in runs:
            sets = [
                f"rupture.order={order}",
                f"stages.load.increments={int(165 / m)}",
                f"stages.load.walls.top=Displacement(0.0, {-closing * m:.9e})",
                f"stages.load.walls.bottom=Displacement(0.0, {closing * m:.9e})",
            ]
            if order == "Events":
                sets += args.sets
            out = args.out / f"{seed}_{order}_{m:.4f}"
            cpu = run(scene, out, sets)
            found.setdefault((order, m), []).append([*measured(out), cpu])
            print(seed, order, f"{m:.4g}", found[order, m][-1], file=sys.stderr, flush=True)
    print("| rule | increment | q 0.5 % | q 1 % | peak | peaks | solves | CPU s | ratio |")
    print("|---|---|---|---|---|---|---|---|---|")
    reference = found[runs[0]]
    one = sum(row[4] for row in found["OneRound", 1.0])
    for (order, m), rows in found.items():
        errors = [
            [100 * (row[k] / exact[k] - 1) for row, exact in zip(rows, reference)]
            for k in range(3)
        ]
        mean = [f"{sum(e) / len(e):+.1f}" for e in errors]
        single = ", ".join(f"{e:+.1f}" for e in errors[2])
        solves, cpu = (sum(row[k] for row in rows) / len(rows) for k in (3, 4))
        ratio = sum(row[4] for row in rows) / one
        cells = [f"`{order}`", f"{m:.3g}", *mean, single, f"{solves:.0f}", f"{cpu:.2f}", f"{ratio:.2f}"]
        print("| " + " | ".join(cells) + " |")


if __name__ == "__main__":
    main()
