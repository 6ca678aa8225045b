"""Biaxial compression of cemented sand: clastic and YADE on the same packings (`run.py`)."""

import csv
import json
import math
import shutil
import statistics
import sys
from typing import NamedTuple

from harness import HERE, ROOT, at, table_of

# Strains between which q is averaged, after the peak.
AFTER = (0.02, 0.03)
# Strain over which forces of YADE are averaged.
BIN = 2e-4
TANGENTIAL = 30.0e6


class Ours(NamedTuple):
    """A run of clastic."""

    order: str
    # Increment over that of the scene
    factor: float = 1.0
    # Bonds break one by one, however many reach their limits soon after each other.
    single: bool = False
    # Coulomb's law, and the rolling stiffness of YADE
    laws: bool = False


CLASTIC = [Ours("OneRound"), Ours("OneRound", 0.25), Ours("Events"), Ours("Events", 0.25)]
SMALL = [Ours("Events", 0.25, laws=True), Ours("Events", single=True)]


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


def clastic(bench, place, run):
    path, width, height = place
    scene, step = ("biaxial_small", 0.08e-3) if bench.options.small else ("biaxial_50kPa", 0.3e-3)
    step *= run.factor
    last = bench.options.strain
    sets = [
        f'specimen=File(path: "{path}")',
        f"walls.bottom.end=({width!r}, 0.0)",
        f"walls.top.start=({width!r}, {height!r})",
        f"walls.top.end=(0.0, {height!r})",
        f"walls.left.start=(0.0, {height!r})",
        f"walls.right.start=({width!r}, 0.0)",
        f"walls.right.end=({width!r}, {height!r})",
        f"rupture.order={run.order}",
        f"stages.load.increments={math.ceil(1.1 * last * height / (2 * step))}",
        f"stages.load.walls.bottom[1]={step!r}",
        f"stages.load.walls.top[1]={-step!r}",
        f"stages.load.stop=[Above(\"axial_strain\", {last!r})]",
        *bench.options.set,
    ]
    if run.single:
        # Above any density of ruptures
        sets += ["rupture.density=21.0", "rupture.brittleness=0.0"]
    if run.laws:
        radii = [r for *_, r in particles(path)]
        stiffness = TANGENTIAL * statistics.mean(radii) ** 2
        sets += ["friction_law=Coulomb()"]
        for law in ("contact", "bond"):
            sets.append(f"materials.sand.{law}.rolling_stiffness={stiffness!r}")
    cpu, wall = bench.run_clastic(scene, bench.out / "clastic", sets)
    history = table_of(bench.out / "clastic" / "history.csv")
    unsolved = {row["status"] for row in history} - {"solved"}
    if unsolved:
        print(f"  increments that are {', '.join(sorted(unsolved))}", file=sys.stderr)
    rows = [row for row in history if row["stage"] == "load"]
    value = lambda row, name: float(row[name])
    curve = [
        (value(r, "axial_strain"), value(r, "axial_stress_pa") - value(r, "lateral_stress_pa"))
        for r in rows
    ]
    broken = sum(int(rows[-1][f"broken_{m}"]) for m in ("tension", "shear", "rolling"))
    result = measured(curve, broken, bench.options.at)
    return result | {"steps": len(rows), "cpu_s": cpu, "wall_s": wall}


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
    curve = [(e, q) for e, q, _ in means]
    return measured(curve, result["curve"][-1][4], bench.options.at) | {
        "steps": result["steps"],
        "cpu_s": cpu,
        "wall_s": wall,
        "script_s": result["script_s"],
        "lateral stress, % off": 100 * lateral,
    }


def q_at(strain):
    return f"q at {100 * strain:g} %, kPa"


def measured(curve, broken, strains):
    peak = max(curve, key=lambda point: point[1])
    grid = [AFTER[0] + (AFTER[1] - AFTER[0]) * (k + 0.5) / 100 for k in range(100)]
    after = [q for q in (at(curve, e) for e in grid if e < curve[-1][0])]
    return {
        **{q_at(e): at(curve, e) * 1e-3 for e in strains},
        "peak, kPa": peak[1] * 1e-3,
        "at, %": peak[0] * 100,
        "mean q, 2 to 3 %, kPa": statistics.fmean(after) * 1e-3 if len(after) > 90 else math.nan,
        "bonds broken": broken,
    }


def name_of(run):
    if isinstance(run, float):
        return f"YADE, I = {run:g}"
    parts = ["clastic", run.order]
    parts += [f"1/{1 / run.factor:g} increment"] if run.factor < 1 else []
    parts += ["one by one"] if run.single else []
    parts += ["laws of YADE"] if run.laws else []
    return ", ".join(parts)


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
        runs = [(name_of(run), lambda run=run: clastic(bench, place, run)) for run in ours]
        runs += [(name_of(run), lambda run=run: yade(bench, place, run)) for run in rates]
        for name, results in bench.interleaved(runs).items():
            times = {k: statistics.median(r[k] for r in results) for k in ("cpu_s", "wall_s")}
            found[name].append(results[-1] | times)

    report(bench, seeds, found, {"YADE": name_of(rates[-1]), "clastic": name_of(ours[-1])})


def report(bench, seeds, found, limits):
    """Two tables: every run of every packing, and means over the packings beside the limits."""
    strains = [q_at(e) for e in bench.options.at]
    rows = []
    for name, results in found.items():
        mean = lambda key: statistics.fmean(r[key] for r in results)
        row = [name, round(mean("steps")), mean("cpu_s")]
        for key in [*strains, "peak, kPa"]:
            for limit in limits.values():
                errors = [100 * (a[key] / b[key] - 1) for a, b in zip(results, found[limit])]
                row.append("" if name == limit else with_error(errors))
        row += [mean("peak, kPa"), mean("at, %"), mean("mean q, 2 to 3 %, kPa")]
        rows.append([*row, round(mean("bonds broken"))])
    header = ["run", "increments or steps", "cpu_s"]
    for key in [*strains, "peak, kPa"]:
        header += [f"{key.removesuffix(', kPa')}, % off YADE's limit", "% off clastic's limit"]
    header += ["peak, kPa", "at, %", "mean q, 2 to 3 %, kPa", "bonds broken"]

    columns = ["steps", "cpu_s", "wall_s", "script_s", *strains, *header[-4:]]
    columns += ["lateral stress, % off"]
    single = [
        [seed, name, *(results[k].get(c, "") for c in columns)]
        for k, seed in enumerate(seeds)
        for name, results in found.items()
    ]
    bench.report("biaxial_packings", ["packing", "run", *columns], single)
    bench.report("biaxial", header, rows)
