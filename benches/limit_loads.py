#!/usr/bin/env python3
"""Limit loads of sand without cement: active earth pressure beside Rankine and Coulomb, a footing beside Prandtl.

    cargo build --release
    python3 benches/limit_loads.py [--out bench/limit_loads] [--only sand,wall,footing] [--seeds 701,702,703,704,705,706,707,708]
    python3 benches/limit_loads.py --only footing --seeds 1,101,102,103,701,702,703,704

All friction is Coulomb's law. Packings are as dense as they get, apart from that of `footing`. `sand`: biaxial tests on 400
of the same disks in a periodic cell under 10 kPa tell the angle of friction at the peak (mean over half a per cent of strain) and beyond it (from 2 to
4 %). `wall`: the scene `retaining_wall` with 450 disks, 15 over the height, and a wall that moves out by 1.5 mm, smooth and
with a friction of 0.5. K_a is the mean horizontal force over the last 1 mm, over gamma H^2/2 with gamma H = W/b. `footing`: the
scene `footing`. The porosity inside leaves out a border of two mean diameters.
"""

import argparse
import csv
import json
import subprocess
from math import asin, atan, cos, degrees, exp, pi, radians, sin, sqrt, tan
from pathlib import Path
from statistics import mean, stdev

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
D = 10e-3
SAND = """(
    version: 1, title: "Biaxial test of sand",
    friction_law: Coulomb(),
    materials: {{ "sand": (density: 2650.0,
        contact: (normal_stiffness: 4.0e7, tangential_stiffness: 4.0e7, friction: 0.5)) }},
    specimen: Packing(count: 400, columns: 16, spacing: 12.1e-3, sizes: Uniform(radius: (4.0e-3, 6.0e-3)), seed: {seed}),
    cell: (size: (0.1936, 0.3025)),
    stages: [
        Compact(name: "compact", target: Jammed, step: 1.0e-3, agitation: 0.1, seed: {seed}),
        Load(name: "press", increments: 5, cell: (xx: Stress(1.0e4), yy: Stress(1.0e4))),
        Load(name: "shear", increments: 40, cell: (xx: Stress(1.0e4), yy: Strain(0.04))),
    ],
    reference_stage: "shear",
    measures: [
        (name: "axial_strain", of: Strain(Cell(Height))),
        (name: "lateral_strain", of: Strain(Cell(Width))),
        (name: "axial_stress", of: Stress(Average(component: Yy, area: Cell))),
        (name: "lateral_stress", of: Stress(Average(component: Xx, area: Cell))),
    ],
    output: (plots: false),
)
"""
WALL = {
    "friction_law": "Coulomb()", "let.stiffness": 4.0e7, "let.out": 0.1e-3, "specimen.count": 450, "specimen.columns": 20,
    "walls.floor.end": "(0.242, 0.0)", "walls.wall.start": "(0.242, 0.0)", "walls.wall.end": "(0.242, 0.28)",
    "walls.top.start": "(0.242, 0.28)", "walls.top.end": "(0.0, 0.28)", "walls.back.start": "(0.0, 0.28)",
    "stages.compact.target": "Jammed", "stages.active.increments": 15, "stages.passive.increments": 1,
    "measures[4]": '(name: "wall_shear_n", of: WallForce(wall: "wall", along: Tangent))', "output.plots": "false",
}


def run(scene, out, sets=None):
    if not (out / "run.json").exists() or "outcome" not in json.loads((out / "run.json").read_text()):
        command = [PROGRAM, "run", scene, "--out", out, "--force", "--threads", "1", "--quiet"]
        command += [w for name, value in (sets or {}).items() for w in ("--set", f"{name}={value}")]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with open(out / "history.csv") as file:
        return [{k: v if k in ("stage", "status", "caps") else float(v or "nan") for k, v in r.items()} for r in csv.DictReader(file)]


def inside(out):
    """Porosity of the packing within a border of two diameters, on a grid of an eighth of one."""
    with open(out / "specimen.csv") as file:
        disks = [tuple(map(float, r.split(",")[:3])) for r in file if r[0].isdigit() or r[0] == "-"]
    low = [min(p[k] for p in disks) + 2 * D for k in (0, 1)]
    high = [max(p[k] for p in disks) - 2 * D for k in (0, 1)]
    near, count, free = {}, 0, 0
    for x, y, r in disks:
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                near.setdefault((int(x // D) + i, int(y // D) + j), []).append((x, y, r))
    nx, ny = (int((h - l) / (D / 8)) for l, h in zip(low, high))
    for i in range(nx):
        for j in range(ny):
            x, y = low[0] + i * D / 8, low[1] + j * D / 8
            count += 1
            free += not any((x - a) ** 2 + (y - b) ** 2 < r * r for a, b, r in near.get((int(x // D), int(y // D)), ()))
    return free / count


def shown(name, values, unit=""):
    spread = f" +- {stdev(values):.3g} (standard error {stdev(values) / sqrt(len(values)):.2g})" if len(values) > 1 else ""
    print(f"{name}: {mean(values):.3g}{spread}{unit}, {min(values):.3g} to {max(values):.3g}, {len(values)} packings", flush=True)


def sand(out, seeds):
    peaks, rest = [], []
    for seed in seeds:
        place = out / f"sand_{seed}"
        scene = place.with_suffix(".ron")
        scene.write_text(SAND.format(seed=seed))
        test = [(r["axial_strain"], r["axial_stress_pa"] / r["lateral_stress_pa"]) for r in run(scene, place) if r["stage"] == "shear"]
        phi = lambda k: degrees(asin((k - 1) / (k + 1)))
        top = max(mean(k for e, k in test if start <= e < start + 0.005) for start, _ in test if start < 0.035)
        peaks.append(phi(top))
        rest.append(phi(mean(k for e, k in test if e >= 0.02)))
        porosity = json.loads((place / "run.json").read_text())["results"]["porosity"]
        print(f"  seed {seed}: peak {peaks[-1]:.1f}, beyond {rest[-1]:.1f} degrees, porosity {porosity:.3f}", flush=True)
    shown("phi at the peak", peaks, " degrees")
    shown("phi beyond it", rest, " degrees")
    return mean(peaks), mean(rest)


def coulomb(phi, delta):
    """Horizontal part of Coulomb's coefficient of a vertical wall; Rankine's for delta = 0."""
    phi, delta = radians(phi), radians(delta)
    return (cos(phi) / (1 + sqrt(sin(phi + delta) * sin(phi) / cos(delta)))) ** 2


def wall(out, seeds, angles):
    for name, mu in (("smooth", 0.0), ("rough", 0.5)):
        found, deltas = [], []
        for seed in seeds:
            place = out / f"wall_{name}_{seed}"
            law = f"(normal_stiffness: 4.0e7, tangential_stiffness: 4.0e7, friction: {mu})"
            rows = run(ROOT / "scenes/retaining_wall.ron", place, WALL | {"let.seed": seed, "walls.wall.contact": law})
            rows = [r for r in rows if r["stage"] == "active"]
            last = rows[-10:]
            porosity = json.loads((place / "run.json").read_text())["results"]["porosity"]
            # The floor carries the weight less what the wall does.
            weight = mean(r["floor_force_n"] + abs(r["wall_shear_n"]) for r in last)
            unit = weight**2 / (2 * (1 - porosity) * 2650 * 9.81 * 0.242**2)
            found.append(mean(r["wall_force_n"] for r in last) / unit)
            deltas.append(degrees(atan(mean(abs(r["wall_shear_n"]) / r["wall_force_n"] for r in last))))
            capped = sum(r["status"] != "solved" for r in rows)
            print(f"  {name}, seed {seed}: K_a {found[-1]:.3f}, lowest {min(r['wall_force_n'] for r in rows) / unit:.3f}, delta {deltas[-1]:.1f}, "
                  f"porosity {porosity:.3f}, inside {inside(place):.3f}, capped {capped}", flush=True)
        shown(f"K_a of a {name} wall", found)
        laws = ", ".join(f"{coulomb(phi, mean(deltas)):.3f} for {phi:.1f} degrees" for phi in angles)
        print(f"  delta {mean(deltas):.1f} degrees; {'Coulomb' if mu else 'Rankine'}: {laws}", flush=True)


def bearing(phi, gamma):
    """Prandtl and Reissner, with Martin's N_gamma of a rough strip by the fit of Salgado (2008), Pa."""
    phi = radians(phi)
    n_q = exp(pi * tan(phi)) * tan(pi / 4 + phi / 2) ** 2
    return 5.0e3 * n_q + 0.5 * gamma * 0.07 * (n_q - 1) * tan(1.32 * phi)


def footing(out, seeds, angles):
    found = []
    for seed in seeds:
        place = out / f"footing_{seed}"
        rows = [r for r in run(ROOT / "scenes/footing.ron", place, {"let.seed": seed, "output.plots": "false"}) if r["stage"] == "push"]
        force = [r["footing_n"] for r in rows]
        found.append(max(mean(force[i : i + 133]) for i in range(len(force) - 132)) / 0.07 / 1e3)
        print(f"  seed {seed}: {found[-1]:.1f} kPa, porosity inside {inside(place):.3f}", flush=True)
    shown("bearing pressure", found, " kPa")
    print("  law: " + ", ".join(f"{bearing(phi, 20.8e3) / 1e3:.1f} kPa for {phi:.1f} degrees" for phi in angles), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/limit_loads")
    parser.add_argument("--only", default="sand,wall,footing")
    parser.add_argument("--seeds", default=",".join(map(str, range(701, 709))))
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    seeds, only = [int(s) for s in options.seeds.split(",")], options.only.split(",")
    # Without `sand` those of the seeds 701 to 703.
    angles = sand(options.out.resolve(), seeds) if "sand" in only else (27.1, 23.6)
    for name, study in (("wall", wall), ("footing", footing)):
        if name in only:
            study(options.out.resolve(), seeds, angles)


if __name__ == "__main__":
    main()
