"""Biaxial compression of cemented sand: clastic and YADE on the same packings; a test of `run.py`."""

import csv
import json
import math
import shutil
import statistics
import sys

from harness import HERE, ROOT, at, table_of

STRAINS = [0.005, 0.01]
# Strains between which q is averaged, after the peak.
AFTER = (0.02, 0.03)
# Strain over which forces of YADE are averaged.
BIN = 2e-4
TANGENTIAL = 30.0e6
# The clastic runs: order of ruptures, increment over that of the scene, with the laws of YADE.
CLASTIC = [("OneRound", 1.0, False), ("OneRound", 0.25, False), ("Events", 1.0, False), ("Events", 0.25, False)]
SMALL = [("Events", 0.25, True), ("Events", 0.125, False)]


def particles(path):
    with open(path) as f:
        return [[float(v) for v in row[:3]] for row in list(csv.reader(f))[1:]]


def packing(bench, seed):
    """A specimen file, its width and its height."""
    if not bench.options.small:
        return ROOT / "scenes" / "specimens" / "biaxial_6160.csv", 0.475, 0.81
    width = 0.121
    if seed == 1:
        return ROOT / "scenes" / "specimens" / "biaxial_400.csv", width, 0.2147896
    path = bench.out / f"packing_{seed}.csv"
    if not path.exists():
        sets = [f"specimen.seed={seed}", f"stages.compact.seed={seed}"]
        bench.run_clastic("prepare_biaxial_small", bench.out / "prepare", sets)
        shutil.copyfile(bench.out / "prepare" / "specimen.csv", path)
    disks = particles(path)
    height = sum(math.pi * r * r for *_, r in disks) / (width * (1.0 - 0.2))
    if max(y + r for _, y, r in disks) > height * (1 + 1e-6):
        sys.exit(f"packing {seed} has not reached its porosity")
    return path, width, height


def clastic(bench, place, order, factor, laws):
    path, width, height = place
    scene, step = ("biaxial_small", 0.08e-3) if bench.options.small else ("biaxial_50kPa", 0.3e-3)
    last = bench.options.strain
    sets = [
        f'specimen=File(path: "{path}")',
        f"walls.bottom.end=({width!r}, 0.0)",
        f"walls.top.start=({width!r}, {height!r})",
        f"walls.top.end=(0.0, {height!r})",
        f"walls.left.start=(0.0, {height!r})",
        f"walls.right.start=({width!r}, 0.0)",
        f"walls.right.end=({width!r}, {height!r})",
        f"rupture.order={order}",
        f"stages.load.increments={math.ceil(1.1 * last * height / (2 * step * factor))}",
        f"stages.load.walls.bottom[1]={step * factor!r}",
        f"stages.load.walls.top[1]={-step * factor!r}",
        f"stages.load.stop=[AxialStrain({last!r})]",
    ]
    if laws:
        radii = [r for *_, r in particles(path)]
        stiffness = TANGENTIAL * statistics.mean(radii) ** 2
        sets += ["friction_law=Coulomb()"]
        sets += [f"materials.sand.{law}.rolling_stiffness={stiffness!r}" for law in ("contact", "bond")]
    cpu, wall = bench.run_clastic(scene, bench.out / "clastic", sets)
    history = table_of(bench.out / "clastic" / "history.csv")
    unsolved = {row["status"] for row in history} - {"solved"}
    if unsolved:
        print(f"  increments that are {', '.join(sorted(unsolved))}", file=sys.stderr)
    rows = [row for row in history if row["stage"] == "load"]
    curve = [
        (float(r["axial_strain"]), float(r["axial_stress_pa"]) - float(r["lateral_stress_pa"])) for r in rows
    ]
    broken = sum(int(rows[-1][f"broken_{m}"]) for m in ("tension", "shear", "rolling"))
    return measured(curve, broken) | {"steps": len(rows), "cpu_s": cpu, "wall_s": wall}


def yade(bench, place, inertial):
    path, width, height = place
    out = bench.out / "yade.json"
    out.unlink(missing_ok=True)
    parameters = {
        "specimen": str(path),
        "out": str(out),
        "width": width,
        "height": height,
        "inertial": inertial,
        "strain": bench.options.strain,
    }
    for setting in bench.options.peer:
        name, value = setting.split("=")
        parameters[name] = json.loads(value)
    command = ["yade", "-n", "-x", "-j1", HERE / "biaxial_yade.py"]
    cpu, wall = bench.timed(command, {"PEER": json.dumps(parameters)})
    result = json.loads(out.read_text())
    bins = {}
    for strain, axial, lateral, *_ in result["curve"]:
        bins.setdefault(int(strain / BIN), []).append((strain, axial - lateral, lateral))
    means = [[statistics.fmean(column) for column in zip(*bins[k])] for k in sorted(bins)]
    lateral = max(abs(s / 200e3 - 1) for *_, s in means)
    return measured([(e, q) for e, q, _ in means], result["curve"][-1][4]) | {
        "steps": result["steps"],
        "cpu_s": cpu,
        "wall_s": wall,
        "script_s": result["script_s"],
        "lateral stress, % off": 100 * lateral,
    }


def measured(curve, broken):
    peak = max(curve, key=lambda point: point[1])
    grid = [AFTER[0] + (AFTER[1] - AFTER[0]) * (k + 0.5) / 100 for k in range(100)]
    after = [q for q in (at(curve, e) for e in grid if e < curve[-1][0])]
    return {
        **{f"q at {100 * e:g} %, kPa": at(curve, e) * 1e-3 for e in STRAINS},
        "peak, kPa": peak[1] * 1e-3,
        "at, %": peak[0] * 100,
        "mean q, 2 to 3 %, kPa": statistics.fmean(after) * 1e-3 if len(after) > 90 else math.nan,
        "bonds broken": broken,
    }


def name_of(run):
    if isinstance(run, float):
        return f"YADE, I = {run:g}"
    order, factor, laws = run
    parts = ["clastic", order]
    parts += [f"1/{1 / factor:g} increment"] if factor < 1 else []
    return ", ".join(parts + (["laws of YADE"] if laws else []))


def with_error(values):
    """Mean and standard error of values in per cent."""
    mean = statistics.fmean(values)
    if len(values) == 1:
        return f"{mean:+.2f}"
    return f"{mean:+.2f} ± {statistics.stdev(values) / math.sqrt(len(values)):.2f}"


def biaxial(bench):
    seeds = bench.options.seeds if bench.options.small else [1]
    rates = sorted(bench.options.inertial, reverse=True)
    ours = CLASTIC + (SMALL if bench.options.small else [])
    found = {name_of(run): [] for run in [*ours, *rates]}
    for seed in seeds:
        place = packing(bench, seed)
        runs = [(name_of(run), lambda run=run: clastic(bench, place, *run)) for run in ours]
        runs += [(name_of(run), lambda run=run: yade(bench, place, run)) for run in rates]
        for name, results in bench.interleaved(runs).items():
            times = {k: statistics.median(r[k] for r in results) for k in ("cpu_s", "wall_s")}
            found[name].append(results[-1] | times)

    limits = {"YADE": name_of(rates[-1]), "clastic": name_of(ours[-1])}
    strains = [f"q at {100 * e:g} %, kPa" for e in STRAINS]
    rows = []
    for name, results in found.items():
        mean = lambda key: statistics.fmean(r[key] for r in results)
        row = [name, round(mean("steps")), mean("cpu_s")]
        for key in [*strains, "peak, kPa"]:
            for limit in limits.values():
                pairs = zip(results, found[limit])
                row.append("" if name == limit else with_error([100 * (a[key] / b[key] - 1) for a, b in pairs]))
        row += [mean("peak, kPa"), mean("at, %"), mean("mean q, 2 to 3 %, kPa"), round(mean("bonds broken"))]
        rows.append(row)
    header = ["run", "increments or steps", "cpu_s"]
    for measure in ["q at 0.5 %", "q at 1 %", "peak"]:
        header += [f"{measure}, % off YADE's limit", "% off clastic's limit"]
    header += ["peak, kPa", "at, %", "mean q, 2 to 3 %, kPa", "bonds broken"]

    columns = ["steps", "cpu_s", "wall_s", "script_s", *strains, *header[-4:], "lateral stress, % off"]
    single = [
        [seed, name, *(results[k].get(c, "") for c in columns)]
        for k, seed in enumerate(seeds)
        for name, results in found.items()
    ]
    bench.report("biaxial_packings", ["packing", "run", *columns], single)
    bench.report("biaxial", header, rows)
