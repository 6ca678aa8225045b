#!/usr/bin/env python3
"""Scatter of the rigs whose figures depend on the packing: over seeds, and for finer grains.

    cargo build --release
    python3 benches/rigs/scatter.py [--program target/release/clastic] [--out bench/scatter] [--only oedometer]

Every specimen keeps its size; its grains are as in the scene, or half as large (four times as many).
The table goes to OUT/scatter.md: number of runs, mean, standard deviation, minimum and maximum of
each figure.
"""

import argparse
import sys
from pathlib import Path
from statistics import mean, median, stdev

sys.path.insert(0, str(Path(__file__).parent))

import runs
from runs import column, number, rows

COARSE = range(501, 513)


def fine_packing(columns, count, spacing, radii, step):
    return [
        f"specimen.columns={columns}", f"specimen.count={count}", f"specimen.spacing={spacing!r}",
        f"specimen.sizes.radius=({radii[0]!r}, {radii[1]!r})", f"stages.compact.step={step!r}",
    ]


def seeds_of(names, seed):
    return [f"{name}={seed}" for name in names]


def run(scene, sets, out):
    if not (out / "run.json").exists():
        runs.run(runs.ROOT / f"scenes/{scene}.ron", out, sets)
    return out


def oedometer(out, seed, fine):
    sets = seeds_of(["let.seed"], seed)
    if fine:
        sets += fine_packing(40, 800, 5.05e-3, (1.5e-3, 2.5e-3), 0.5e-3)
    done = run("oedometer", sets, out)
    end = {stage: rows(done, stage)[-1] for stage in ("400 kPa", "unload")}
    ratio = {s: number(r, "lateral_stress_pa") / number(r, "axial_stress_pa") for s, r in end.items()}
    return {"K_0 at 400 kPa": ratio["400 kPa"], "K_0 unloaded": ratio["unload"]}


def retaining_wall(out, seed, fine):
    sets = seeds_of(["let.seed"], seed)
    if fine:
        sets += fine_packing(50, 1200, 6.05e-3, (2.0e-3, 3.0e-3), 0.5e-3)
    done = run("retaining_wall", sets, out)
    weight = number(rows(done)[-1], "floor_force_n")
    unit = weight**2 / (2.0 * 0.795 * 2650.0 * 9.81 * 0.3025**2)
    active = median(column(rows(done, "active")[5:], "wall_force_n")) / unit
    passive = median(column(rows(done, "passive")[50:], "wall_force_n")) / unit
    return {"K_a": active, "K_p": passive, "K_a K_p": active * passive}


def prepare_and_branch(out, seed, fine):
    sets = seeds_of(["specimen.seed", "stages.compact.seed"], seed)
    if fine:
        sets += fine_packing(20, 800, 5.0e-3, (1.5e-3, 2.5e-3), 2.0e-3)
    packing = run("prepare_and_branch", sets, out)
    done = run(
        "prepare_and_branch_100kPa", [f'specimen.path="{packing}/state_packing.npz"'],
        out.with_name(f"{out.name} 100 kPa"),
    )
    sheared = rows(done, "shear")
    return {"stress ratio at the peak": max(column(sheared, "axial_stress_pa")) / 100e3}


def brazilian(out, seed, _):
    done = run("brazilian", seeds_of(["let.seed"], seed), out)
    return {"splitting stress, MPa": max(column(rows(done, "press"), "axial_stress_pa")) / 1e6}


def direct_tension(out, seed, _):
    done = run("direct_tension", seeds_of(["let.seed"], seed), out)
    return {"peak in tension, MPa": -min(column(rows(done, "pull"), "axial_stress_pa")) / 1e6}


# With the seeds of the finer grains. Rock of finer grains needs another glue and plaster.
RIGS = {
    "oedometer": (oedometer, range(601, 605)),
    "retaining_wall": (retaining_wall, range(601, 607)),
    "prepare_and_branch": (prepare_and_branch, range(601, 605)),
    "direct_tension": (direct_tension, ()),
    "brazilian": (brazilian, ()),
}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", type=Path, default=runs.PROGRAM)
    parser.add_argument("--out", type=Path, default=Path("bench/scatter"))
    parser.add_argument("--only", default="")
    options = parser.parse_args()
    runs.PROGRAM = options.program.resolve()
    wanted = [name for name in options.only.split(",") if name]
    text = "| rig: figure | grains | runs | mean | deviation | minimum | maximum |\n|---|---|---|---|---|---|---|\n"
    for name, (figures, fine_seeds) in RIGS.items():
        if wanted and name not in wanted:
            continue
        for fine, seeds in ((False, COARSE), (True, fine_seeds)):
            grains = "half as large" if fine else "of the scene"
            found = {}
            for seed in seeds:
                out = options.out.resolve() / name / f"{'fine' if fine else 'coarse'} {seed}"
                out.parent.mkdir(parents=True, exist_ok=True)
                for figure, value in figures(out, seed, fine).items():
                    found.setdefault(figure, []).append(value)
                    print(f"{name} {out.name}: {figure} {value:.3f}", flush=True)
            for figure, values in found.items():
                text += (
                    f"| `{name}`: {figure} | {grains} | {len(values)} | {mean(values):.2f} "
                    f"| {stdev(values):.2f} | {min(values):.2f} | {max(values):.2f} |\n"
                )
    (options.out / "scatter.md").write_text(text)
    print(text)


if __name__ == "__main__":
    main()
