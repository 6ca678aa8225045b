#!/usr/bin/env python3
"""Tunnels: ground that yields beside the elastic-plastic ground reaction curve, and a lining beside convergence-confinement.

    cargo build --release
    python3 benches/tunnel.py [--out bench/tunnel] [--only yield,lining] [--seeds 11,12,13]

`yield` is the scene `tunnel` with cement of 0.2 MPa (in tension half of it) under 1 MPa. E and nu are those of its stages
`load` and `unload`. Biaxial tests of the same ground, in its own box, under a tenth, a fifth and two fifths of the
pressure tell its peak (the line sigma_1 = q + K sigma_3), its residual strength (from 0.3 to 0.6 % of strain) and its
dilation. Beside the closure stand those of the closed form for perfect plasticity with the peak, and for a brittle drop to
the residual strength (Park and Kim 2006, Int. J. Rock Mech. Min. Sci. 43, 616-622), in a ring with the area of the box. The radius of the ring of
broken bonds is that of a uniform ring with their median distance.

`lining` is the scene `tunnel_lining`: the thrust N in the ring beside p R, with the p that the closure leaves on it, and
beside the point at which the straight reaction curve meets the line of the ring.
"""

import argparse
import csv
import json
import subprocess
from math import asin, degrees, pi, sin, sqrt
from pathlib import Path
from statistics import median

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
K, P, A, BOX, CENTRE = 1.0e9, 1.0e6, 2.0, (15.965, 15.6), (8.0, 7.8)
WEAK = {"let.cohesion": 0.2e6, "let.tension": 0.1e6}
BLOCK = """(
    version: 1, title: "Biaxial test of the ground of a tunnel",
    materials: {{ "ground": (density: 2000.0,
        contact: (normal_stiffness: 1.0e9, tangential_stiffness: 0.5e9, friction: 0.5)) }},
    specimen: State(path: "{state}"),
    stages: [
        Load(name: "confine", increments: 4, walls: {{
            "top": Stress(stress: {confining}, between: ("left", "right")),
            "right": Stress(stress: {confining}, between: ("bottom", "top")) }}),
        Load(name: "shear", increments: 60, walls: {{ "top": Displacement(0.0, -1.56e-3) }}),
    ],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "lateral_strain", of: Strain(Walls("left", "right"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["top"], length: Between("left", "right")))),
        (name: "lateral_stress", of: Stress(Walls(walls: ["right"], length: Between("bottom", "top")))),
    ],
    output: (plots: false),
)
"""


def run(scene, out, sets=None):
    if not (out / "run.json").exists() or "outcome" not in json.loads((out / "run.json").read_text()):
        command = [PROGRAM, "run", scene, "--out", out, "--force", "--threads", "1", "--quiet"]
        command += [w for name, value in (sets or {}).items() for w in ("--set", f"{name}={value}")]
        subprocess.run([str(word) for word in command], check=True, stdout=subprocess.DEVNULL)
    with open(out / "history.csv") as file:
        return [{k: v if k in ("stage", "status", "caps") else float(v or "nan") for k, v in r.items()} for r in csv.DictReader(file)]


def last(rows, stage):
    return [row for row in rows if row["stage"] == stage][-1]


def elastic(rows):
    """E and nu in the plane: strain = (sigma_1 - nu sigma_2)/E."""
    load, stand = last(rows, "load"), last(rows, "stand")
    d = {c: load[c] - stand[c] for c in ("yy_pa", "xx_pa")}
    shear = (d["yy_pa"] - d["xx_pa"]) / (2 * (load["axial_strain"] - load["lateral_strain"]))
    bulk = (d["yy_pa"] + d["xx_pa"]) / (2 * (load["axial_strain"] + load["lateral_strain"]))
    nu = (bulk - shear) / (bulk + shear)
    return 2 * shear * (1 + nu), nu


def line(points):
    """q and K of sigma_1 = q + K sigma_3 by least squares."""
    n, sx, sy = len(points), sum(x for x, _ in points), sum(y for _, y in points)
    slope = (n * sum(x * y for x, y in points) - sx * sy) / (n * sum(x * x for x, _ in points) - sx * sx)
    return (sy - slope * sx) / n, slope


def angle(k):
    return degrees(asin((k - 1) / (k + 1)))


def reaction(p0, e, nu, peak, residual, k_psi, a, b, r):
    """Support, radius of the plastic ring, and closure at r, row by row of growing closure."""
    (q, k), (q_r, k_r) = peak, residual
    strain = lambda along, across: (along - nu * across) / e
    rows = []

    def outside(s, radius):
        """Lame: sigma_r = c - d/r^2, sigma_theta = c + d/r^2, with s at the radius and p0 at b."""
        d = (p0 - s) / (1 / radius**2 - 1 / b**2)
        return p0 + d / b**2, d

    def closure(c, d, x):
        return x * strain(d / x**2 + c - p0, c - d / x**2 - p0)

    def yields(radius):
        g = 2 / (1 - (radius / b) ** 2)
        return (g * p0 - q) / (k - 1 + g)

    for i in range(101):
        s = p0 + (yields(a) - p0) * i / 100
        rows.append((s, a, closure(*outside(s, a), r)))
    shift = q_r / (k_r - 1)
    for i in range(1, 1001):
        radius = a + (0.9 * b - a) * i / 1000
        s = yields(radius)
        c, d = outside(s, radius)
        p = (s + shift) * (a / radius) ** (k_r - 1) - shift
        if p < 0:
            break
        if radius <= r:
            rows.append((p, radius, closure(c, d, r)))
            continue
        # du/dr + K_psi u/r = elastic strains, inwards from the radius.
        steps, u_r = 100, closure(c, d, radius) * radius**k_psi
        width = (radius - r) / steps
        for j in range(steps):
            x = r + (j + 0.5) * width
            s_x = (p + shift) * (x / a) ** (k_r - 1) - shift
            t_x = k_r * s_x + q_r
            u_r -= width * x**k_psi * (strain(s_x - p0, t_x - p0) + k_psi * strain(t_x - p0, s_x - p0))
        rows.append((p, radius, u_r / r**k_psi))
    return rows


def at(rows, p):
    """Radius and closure of a reaction curve at a support."""
    for (p1, r1, u1), (p2, r2, u2) in zip(rows, rows[1:]):
        if p2 <= p <= p1:
            t = (p1 - p) / (p1 - p2)
            return r1 + t * (r2 - r1), u1 + t * (u2 - u1)
    return float("nan"), float("nan")


def ring_of_ruptures(out, increment, a):
    with open(out / "events.csv") as file:
        far = [
            sqrt((float(e["x_m"]) - CENTRE[0]) ** 2 + (float(e["y_m"]) - CENTRE[1]) ** 2)
            for e in csv.DictReader(file) if int(e["increment"]) <= increment
        ]
    # Half of a uniform ring lies within the median of the distances.
    return (sqrt(max(2 * median(far) ** 2 - a**2, a**2)) if far else a), len(far)


def yielding(out, seed):
    sets = WEAK | {"let.seed": seed, "output.plots": "false", "stages.release.increments": 19,
                   "stages.release.particles[0].remains": 0.05}
    rows = run(ROOT / "scenes/tunnel.ron", out / f"tunnel_{seed}", sets)
    e, nu = elastic(rows)
    peaks, rest, grow = [], [], []
    for part in (0.1, 0.2, 0.4):
        place = out / f"block_{seed}_{part}"
        scene = place.with_suffix(".ron")
        scene.write_text(BLOCK.format(state=f"tunnel_{seed}/state_ground.npz", confining=part * P))
        test = [r for r in run(scene, place) if r["stage"] == "shear"]
        top = max(test, key=lambda r: r["axial_stress_pa"])
        peaks.append((part * P, top["axial_stress_pa"]))
        after = [r["axial_stress_pa"] for r in test if r["axial_strain"] > test[0]["axial_strain"] + 0.003]
        rest.append((part * P, sum(after) / len(after)))
        lateral, axial = (test[-1][c] - top[c] for c in ("lateral_strain", "axial_strain"))
        grow.append(-lateral / axial)
    peak, residual, k_psi = line(peaks), line(rest), sum(grow) / len(grow)
    still = last(rows, "still")
    p0 = 0.5 * (last(rows, "stand")["yy_pa"] + last(rows, "stand")["xx_pa"])
    a, b = A * still["support_pa"] / p0, sqrt(BOX[0] * BOX[1] / pi)
    print(f"seed {seed}: E {e / 1e9:.2f} GPa, nu {nu:.2f}; peak q {peak[0] / 1e3:.0f} kPa, K {peak[1]:.2f} (phi {angle(peak[1]):.1f}); "
          f"residual q {residual[0] / 1e3:.0f} kPa, K {residual[1]:.2f} (phi {angle(residual[1]):.1f}); K_psi {k_psi:.2f} (psi {angle(k_psi):.1f}); a {a:.2f} m")
    perfect = reaction(p0, e, nu, peak, peak, k_psi, a, b, 1.1 * A)
    brittle = reaction(p0, e, nu, peak, (max(residual[0], 0.0), residual[1]), k_psi, a, b, 1.1 * A)
    for row in rows:
        p = row["support_pa"] * A / a
        if row["stage"] != "release" or row["fraction"] < 1 or p > 0.55 * P:
            continue
        (r1, u1), (r2, u2) = at(perfect, p), at(brittle, p)
        radius, broken = ring_of_ruptures(out / f"tunnel_{seed}", row["increment"], a)
        print(f"  p {p / 1e6:.3f} MPa: closure {1e3 * row['closure_m']:.2f} mm (perfect {1e3 * u1:.2f}, brittle {1e3 * u2:.2f}), "
              f"ring {radius:.2f} m of {broken} ruptures (perfect {r1:.2f}, brittle {r2:.2f})")


def lining(out, seed):
    stiffness, ring = 3.0e9, 1.54
    r = 0.999 * ring * sin(pi / 24)
    rows = run(ROOT / "scenes/tunnel_lining.ron", out / f"lining_{seed}", {"let.seed": seed, "output.plots": "false"})
    e, nu = elastic(rows)
    still, part, rest = (last(rows, s) for s in ("still", "part", "rest"))
    p0 = 0.5 * (last(rows, "stand")["yy_pa"] + last(rows, "stand")["xx_pa"])
    a = A * still["support_pa"] / p0
    thrusts = [2 * r * rest[f"thrust_{side}_pa"] for side in ("right", "top", "left", "bottom")]
    n = sum(thrusts) / 4
    free = 2 * part["closure_m"]
    carried = p0 * a * (1 - rest["closure_m"] / free)
    line = stiffness * 2 * r / ring
    meet = line * (free - part["closure_m"]) / (1 + line * free / (p0 * a))
    print(f"seed {seed}: E {e / 1e9:.2f} GPa, nu {nu:.2f}, a {a:.2f} m; closure {1e3 * part['closure_m']:.3f} mm, lined {1e3 * rest['closure_m']:.3f} mm; "
          f"thrust {' '.join(f'{t / 1e3:.0f}' for t in thrusts)}, mean {n / 1e3:.0f} kN; p R {carried / 1e3:.0f} kN, curves meet at {meet / 1e3:.0f} kN")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/tunnel")
    parser.add_argument("--only", default="yield,lining")
    parser.add_argument("--seeds", default="11,12,13")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    for name, study in (("yield", yielding), ("lining", lining)):
        for seed in options.seeds.split(",") if name in options.only.split(",") else []:
            study(options.out.resolve(), int(seed))


if __name__ == "__main__":
    main()
