#!/usr/bin/env python3
"""clastic and its peers on the same work: time beside error, one core, interleaved, medians.

    python3 benches/peers/run.py uniaxial --small      clastic and YADE, 400 disks
    python3 benches/peers/run.py biaxial --small       clastic and YADE, 400 disks
    python3 benches/peers/run.py collapse --small      clastic and LIGGGHTS, 300 disks
    python3 benches/peers/run.py nsgs --small          clastic and Siconos, one program

Without --small: 7380, 6160, 5000 and 5000 disks. See README.md for what to install. Seconds
are those of the processor, user and system, of the whole process (of the solve, where it is one
program that is solved).
"""

import argparse
import csv
import json
import math
import signal
import statistics
import sys

from biaxial import biaxial
from harness import HERE, ROOT, Bench, at, table_of

# The rock of scenes/uniaxial.ron, elastic, on the stored packings of the rigid scenes.
ROCK = [
    "materials.rock.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "materials.rock.bond=(normal_stiffness: 7.9e10, tangential_stiffness: 7.9e10, friction: 0.8, "
    "cohesion: 195.0e6, tensile_strength: 144.0e6)",
    "walls.bottom.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
    "walls.top.contact=(normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)",
]
STRAINS = [1.0e-3, 2.0e-3]
LAST_STRAIN = 2.5e-3


# Uniaxial compression: YADE.


def uniaxial(bench):
    small = bench.options.small
    scene = "uniaxial_rigid_small" if small else "uniaxial_rigid"
    width, height = (11.64e-3, 29.0245e-3) if small else (50.0e-3, 120.0e-3)
    packing = ROOT / "scenes" / "specimens" / ("uniaxial_400.csv" if small else "uniaxial_7380.csv")

    def ours(factor):
        step = 5e-5 * factor
        sets = ROCK + [
            f"stages.load.increments={math.ceil(LAST_STRAIN / step - 1e-9)}",
            f"stages.load.walls.top[1]={-step * height!r}",
        ]
        seconds = bench.run_clastic(scene, bench.out / "clastic", sets)
        rows = [row for row in table_of(bench.out / "clastic" / "history.csv") if row["stage"] == "load"]
        curve = [(float(r["axial_strain"]), float(r["axial_stress_pa"])) for r in rows]
        cracks = [sum(int(r[f"broken_{m}"]) for m in ("tension", "shear", "rolling")) for r in rows]
        return seconds, curve, cracks, len(rows)

    def theirs(speed):
        parameters = {
            "specimen": str(packing),
            "out": str(bench.out / "yade.json"),
            "width": width,
            "height": height,
            "speed": speed,
            "strain": LAST_STRAIN,
        }
        script = HERE / "uniaxial_yade.py"
        command = ["yade", "-n", "-x", "-j1", script]
        seconds = bench.timed(command, {"PEER": json.dumps(parameters)})
        result = json.loads((bench.out / "yade.json").read_text())
        curve = [(e, s) for e, s, _ in result["curve"]]
        return seconds, curve, [c for *_, c in result["curve"]], result["steps"]

    runs = [(f"clastic, {f} x 0.005 %", lambda f=f: ours(f)) for f in bench.options.factors]
    runs += [(f"YADE, {v} m/s", lambda v=v: theirs(v)) for v in bench.options.speeds]
    _, reference, _, _ = ours(0.25)
    expected = [at(reference, e) for e in STRAINS]
    rows = []
    for name, results in bench.interleaved(runs).items():
        _, curve, cracks, steps = results[-1]
        first = next((s for (_, s), c in zip(curve, cracks) if c > 0), math.nan)
        errors = [100 * (at(curve, e) / x - 1) for e, x in zip(STRAINS, expected)]
        cpu, wall = (statistics.median(r[0][k] for r in results) for k in (0, 1))
        rows.append([name, steps, cpu, wall, *errors, first / 1e6])
    strains = [f"error of stress at {100 * e:g} %, %" for e in STRAINS]
    header = ["run", "increments or steps", "cpu_s", "wall_s", *strains, "first crack, MPa"]
    bench.report("uniaxial", header, rows)


# Collapse of a column: LIGGGHTS.

SMALL_COLUMN = ("column_collapse_small", [])
# 5000 disks, 40 columns of the grid of column_collapse.ron.
COLUMN = (
    "column_collapse",
    [
        "specimen.count=5000",
        "specimen.columns=40",
        "walls.floor.end=(0.502, 0.0)",
        "walls.gate.start=(0.502, 0.0)",
        "walls.gate.end=(0.502, 1.9)",
        "walls.back.start=(0.0, 1.9)",
        "walls.lid.start=(0.502, 1.7)",
        "walls.lid.end=(0.0, 1.7)",
    ],
)


def settled_column(bench):
    """The column behind its gate, made by clastic: a CSV of x, y, r."""
    scene, sets = SMALL_COLUMN if bench.options.small else COLUMN
    path = bench.out / "column.csv"
    print("  the column is compacted and settles", file=sys.stderr)
    # Only places matter: forces to 1e-8 cost hundreds of factorisations a step at rest.
    settles = ["stages.release.increments=1", "acceptance.residual=1e-3"]
    bench.run_clastic(scene, bench.out / "prepare", [*sets, *settles])
    path.write_bytes((bench.out / "prepare" / "specimen.csv").read_bytes())
    with open(path) as f:
        rows = list(csv.reader(f))[1:]
    return scene, sets, path, [[float(v) for v in row[:3]] for row in rows]


def released(sets, packing, increments, law):
    """Settings that turn the scene into the release alone, of the packing given."""
    sets = [*sets_without_packing(sets), f'specimen=File(path: "{packing}")']
    sets += ["walls.gate.present=false", "walls.lid.present=false"]
    sets += [f'stages=[Load(name: "release", increments: {increments})]']
    return [*sets, f"friction_law={law}"]


def sets_without_packing(sets):
    return [s for s in sets if not s.startswith("specimen.")]


def spread(disks):
    """Front (x + r) that 99 % of the disks do not pass, and height that 99 % do not."""
    def high(values):
        values = sorted(values)
        return values[min(len(values) - 1, math.ceil(0.99 * len(values)) - 1)]

    return high(x + r for x, _, r in disks), high(y + r for _, y, r in disks)


def collapse(bench):
    scene, sets, packing, disks = settled_column(bench)
    d0, h0 = spread(disks)
    seconds_of_motion = bench.options.time
    data = bench.out / "column.data"
    with open(data, "w") as f:
        f.write(f"column\n\n{len(disks)} atoms\n1 atom types\n")
        f.write("-1 20 xlo xhi\n-1 5 ylo yhi\n-0.01 0.01 zlo zhi\n\nAtoms\n\n")
        for k, (x, y, r) in enumerate(disks):
            f.write(f"{k + 1} 1 {2 * r!r} 2650 {x!r} {y!r} 0\n")

    def ours(dt, residual):
        directory = bench.out / "clastic"
        increments = round(seconds_of_motion / dt)
        sets_now = [*released(sets, packing, increments, bench.options.law), f"analysis=Dynamic(dt: {dt}, theta: 1.0)"]
        sets_now += [f"acceptance.residual={residual!r}"]
        seconds = bench.run_clastic(scene, directory, sets_now)
        rows = table_of(directory / "final_particles.csv")
        return seconds, [[float(r[k]) for k in ("x_m", "y_m", "radius_m")] for r in rows], increments

    def theirs(dt):
        dump = bench.out / "liggghts.dump"
        command = ["liggghts", "-in", HERE / "collapse.liggghts", "-log", "none"]
        for name, value in (("data", data), ("out", dump), ("time", seconds_of_motion), ("dt", dt)):
            command += ["-var", name, value]
        seconds = bench.timed([*command, "-var", "young", 1e8])
        lines = dump.read_text().splitlines()
        start = next(k for k, line in enumerate(lines) if line.startswith("ITEM: ATOMS"))
        rows = [[float(v) for v in line.split()[1:4]] for line in lines[start + 1 :]]
        if len(rows) != len(disks):
            sys.exit(f"LIGGGHTS lost {len(disks) - len(rows)} disks")
        return seconds, rows, round(seconds_of_motion / dt)

    runs = [
        (f"clastic, dt = {dt:g} s, residual {residual:g}", lambda dt=dt, r=residual: ours(dt, r))
        for residual in bench.options.residuals
        for dt in bench.options.steps
    ]
    runs += [("LIGGGHTS, dt = 4e-5 s", lambda: theirs(4e-5))]
    rows = []
    for name, results in bench.interleaved(runs).items():
        _, final, steps = results[-1]
        front, height = spread(final)
        cpu, wall = (statistics.median(r[0][k] for r in results) for k in (0, 1))
        rows.append([name, steps, cpu, wall, (front - d0) / d0, height / h0])
    header = ["run", "increments or steps", "cpu_s", "wall_s", "run-out (d - d0)/d0", "height h/h0"]
    bench.report("collapse", header, rows)


# One frictional program: Siconos.


def nsgs(bench):
    scene, sets, packing, _ = settled_column(bench)
    increment = bench.options.increment
    residuals = sorted(bench.options.residuals, reverse=True)

    def ours(residual):
        directory = bench.out / f"clastic_{residual:g}"
        now = [*released(sets, packing, increment, "Coulomb()"), f"acceptance.residual={residual!r}"]
        bench.run_clastic(scene, directory, now, dump=increment)
        row = table_of(directory / "timings.csv")[-1]
        history = table_of(directory / "history.csv")[-1]
        return float(row["solve_s"]), history

    def theirs():
        out = bench.out / "nsgs.json"
        # The problem is that of the tightest run, which ran just before.
        dump = bench.out / f"clastic_{residuals[-1]:g}" / f"program_{increment:06}.json"
        command = [bench.options.python, HERE / "nsgs_siconos.py", dump]
        for n in bench.options.iterations:
            command += ["--iterations", n]
        bench.timed([*command, "--out", out])
        return json.loads(out.read_text())

    runs = [(r, lambda r=r: ours(r)) for r in residuals]
    results = bench.interleaved([*runs, ("Siconos", theirs)])
    last = results["Siconos"][-1]
    rows = []
    for residual in residuals:
        history = results[residual][-1][1]
        name = f"clastic, residual {residual:g}: {history['solver_iterations']} iterations ({history['status']})"
        seconds = statistics.median(run[0] for run in results[residual])
        natural = float(history["coulomb_residual"])
        violation = last["own_violation_m"] if residual == residuals[-1] else math.nan
        rows.append([name, int(history["potential_contacts"]), seconds, natural, violation, "", ""])
    for k, row in enumerate(last["rows"]):
        cpu = statistics.median(r["rows"][k]["cpu_s"] for r in results["Siconos"])
        name = f"Siconos NSGS, {row['iterations']} iterations"
        errors = [100 * row["error"], 100 * row["maximum_error"]]
        rows.append([name, last["contacts"], cpu, "", row["violation_m"], *errors])
    header = ["run", "contacts", "cpu_s", "natural map", "violation, m", "error of motion, %", "maximum error, %"]
    bench.report("nsgs", header, rows)


def main():
    # Whoever ends this script ends what it runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("test", choices=["uniaxial", "biaxial", "collapse", "nsgs"])
    parser.add_argument("--small", action="store_true", help="small specimens")
    parser.add_argument("--repeat", type=int, default=3, help="runs of each, interleaved")
    parser.add_argument("--core", type=int, default=0, help="core that all runs are pinned to")
    parser.add_argument("--out", default=str(ROOT / "bench" / "peers"), help="directory of results")
    parser.add_argument("--clastic", default=str(ROOT / "target" / "release" / "clastic"))
    parser.add_argument("--python", default="/usr/bin/python3", help="a Python that has siconos")
    numbers = lambda kind: lambda text: [kind(x) for x in text.split(",")]
    parser.add_argument("--factors", type=numbers(float), default=[1.0, 4.0], help="uniaxial: increments over 0.005 %%")
    parser.add_argument("--speeds", type=numbers(float), default=[2.0, 1.0, 0.5], help="uniaxial: speeds of YADE's platen, m/s")
    parser.add_argument("--seeds", type=numbers(int), default=[1, 2, 3, 4, 5], help="biaxial --small: packings; 1 is the stored one")
    parser.add_argument(
        "--inertial", type=numbers(float), default=[1e-3, 1e-4, 3e-5], help="biaxial: inertial numbers of YADE's runs"
    )
    parser.add_argument("--strain", type=float, default=0.03, help="biaxial: axial strain at the end")
    parser.add_argument("--at", type=numbers(float), default=[0.005, 0.01], help="biaxial: strains at which q is compared")
    parser.add_argument(
        "--peer", action="append", default=[], help="biaxial: NAME=NUMBER of a parameter of biaxial_yade.py"
    )
    parser.add_argument("--set", action="append", default=[], help="biaxial: field of the scenes of clastic, KEY=VALUE")
    parser.add_argument("--time", type=float, default=1.0, help="collapse: seconds of motion")
    parser.add_argument("--steps", type=numbers(float), default=[2e-3, 5e-3], help="collapse: clastic's dt, s")
    parser.add_argument(
        "--residuals", type=numbers(float), default=[1e-8, 1e-3], help="collapse and nsgs: what clastic accepts"
    )
    parser.add_argument("--law", default="Coulomb()", help="collapse: friction law of clastic")
    parser.add_argument("--increment", type=int, default=50, help="nsgs: increment after the release")
    parser.add_argument("--iterations", type=numbers(int), default=[100, 1000, 10000], help="nsgs: iterations of Siconos")
    bench = Bench(parser.parse_args())
    {"uniaxial": uniaxial, "biaxial": biaxial, "collapse": collapse, "nsgs": nsgs}[bench.options.test](bench)


if __name__ == "__main__":
    main()
