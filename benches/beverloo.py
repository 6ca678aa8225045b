#!/usr/bin/env python3
"""Discharge of a flat-bottomed hopper in two dimensions over four openings, beside Beverloo's law.

    cargo build --release
    python3 benches/beverloo.py [--out bench/beverloo] [--seeds 1,2] [--law "Coulomb()"]

800 rigid disks of 8 to 12 mm (mean diameter d = 10 mm, friction 0.4 on disks and walls) settle in a
container of 300 mm and flow through an opening of width D in its bottom. The rate is the slope of
the number of disks below the opening, from 0.1 s after the opening until the filling is two openings
high. Runs in which an arch stops the flow are left out. With phi the solid fraction before the flow and a the mean area of a disk, Beverloo's law in
two dimensions is

    n = C phi/a sqrt(g) (D - k d)^(3/2)

so that n^(2/3) is linear in D. The script prints the rates, k and C of the straight line, and the
exponent of (D - k d) with that k, writes them to table.json, and draws beverloo.svg. It needs numpy.
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
COUNT, WIDTH, DT, SETTLE, EVERY = 800, 0.3, 1e-3, 250, 10
# Mean diameter and mean area of disks with radii between 4 and 6 mm.
DIAMETER, AREA = 10e-3, np.pi * 76e-6 / 3
# Openings, m, and increments of the flow.
OPENINGS = {0.045: 900, 0.060: 700, 0.075: 500, 0.090: 400}
G = 9.81
# Disks that the window of a run must have; with fewer an arch stands over the opening.
MIN_DISKS = 50


def scene(opening, increments, seed, law):
    half, side = opening / 2, WIDTH / 2
    mu = "contact: (friction: 0.4)"
    return f"""(
    version: 1,
    title: "Discharge through {1e3 * opening:.0f} mm",
    analysis: Dynamic(dt: {DT}),
    gravity: (0.0, -{G}),
    friction_law: {law},
    materials: {{ "seed": (density: 1000.0, {mu}) }},
    specimen: Packing(count: {COUNT}, columns: 23, spacing: 12.5e-3, origin: (-143.0e-3, 0.0),
        sizes: Uniform(radius: (4.0e-3, 6.0e-3)), seed: {seed}),
    walls: [
        (name: "left", shape: Polyline([({-side}, 0.0)]), start: ({-side}, 0.6), end: ({-half}, 0.0), {mu}),
        (name: "right", shape: Polyline([({side}, 0.0)]), start: ({half}, 0.0), end: ({side}, 0.6), {mu}),
        (name: "plate", shape: Segment, start: ({-half}, 0.0), end: ({half}, 0.0), {mu}),
    ],
    stages: [
        Load(name: "settle", increments: {SETTLE}),
        Load(name: "flow", increments: {increments}, remove_walls: ["plate"]),
    ],
    output: (frames_every: {EVERY}, plots: false),
)
"""


def run(path, out, program):
    if not (out / "run.json").exists() or "outcome" not in json.loads((out / "run.json").read_text()):
        command = [program, "run", path, "--out", out, "--force", "--threads", "1", "--quiet"]
        subprocess.run([str(word) for word in command], check=False)
    times, below, fraction = [], [], None
    for frame in sorted((out / "frames").glob("frame_*.npz")):
        increment = int(frame.stem.split("_")[1])
        if increment < SETTLE:
            continue
        data = np.load(frame)
        position, radius = data["origin_m"] + data["bodies.offset_m"], data["bodies.radius_m"]
        if fraction is None:
            # Between one and eight diameters above the bottom, without the grains at its edges.
            inside = (position[:, 1] > DIAMETER) & (position[:, 1] < 9 * DIAMETER)
            fraction = np.pi * (radius[inside] ** 2).sum() / (8 * DIAMETER * WIDTH)
        times.append((increment - SETTLE) * DT)
        below.append(int((position[:, 1] < 0.0).sum()))
    return np.array(times), np.array(below), fraction


def rate(times, below, fraction, opening):
    """Slope of the number of disks below the opening, 1/s, and how many the window has."""
    left = COUNT - below
    window = (times >= 0.1) & (left * AREA / fraction >= 2 * opening * WIDTH)
    return np.polyfit(times[window], below[window], 1)[0], int(np.ptp(below[window]))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/beverloo")
    parser.add_argument("--seeds", default="1,2")
    parser.add_argument("--law", default="Coulomb()")
    parser.add_argument("--program", default=PROGRAM)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows = []
    for opening, increments in OPENINGS.items():
        rates, counted, fractions = [], [], []
        for seed in options.seeds.split(","):
            name = options.out / f"d{1e3 * opening:.0f}_{seed}"
            path = name.with_suffix(".ron")
            path.write_text(scene(opening, increments, seed, options.law))
            times, below, fraction = run(path, name, options.program)
            value, disks = rate(times, below, fraction, opening)
            fractions.append(fraction)
            if disks < MIN_DISKS:
                print(f"{1e3 * opening:.0f} mm, seed {seed}: an arch stops the flow; left out")
                continue
            rates.append(value)
            counted.append(disks)
        rows.append({"opening": opening, "rates": rates, "disks": counted, "fractions": fractions})
        print(rows[-1], flush=True)
    d = np.array([row["opening"] for row in rows])
    n = np.array([np.mean(row["rates"]) for row in rows])
    phi = np.mean([f for row in rows for f in row["fractions"]])
    slope, start = np.polyfit(d, n ** (2 / 3), 1)
    free = -start / slope
    c = slope**1.5 * AREA / (phi * G**0.5)
    off = n / (c * phi / AREA * G**0.5 * (d - free) ** 1.5) - 1
    exponent = np.polyfit(np.log(d - 1.4 * DIAMETER), np.log(n), 1)[0]
    table = {
        "rows": rows, "phi": phi, "k": free / DIAMETER, "C": c, "off": off.tolist(),
        "exponent_at_k_1.4": exponent,
    }
    (options.out / "table.json").write_text(json.dumps(table, indent=1))
    print(json.dumps(table, indent=1))
    (options.out / "beverloo.svg").write_text(picture(d, rows, free, slope))


def picture(d, rows, free, slope):
    """n^(2/3) against D, with the straight line."""
    x = lambda v: 60 + 4000 * v
    top = max(max(row["rates"]) for row in rows) ** (2 / 3) * 1.1
    y = lambda v: 260 - 240 * v / top
    parts = [
        '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 480 310" font-family="sans-serif" font-size="12">',
        '<rect width="480" height="310" fill="white"/>',
        f'<path d="M60 20V260H460" fill="none" stroke="black"/>',
        f'<line x1="{x(free):.1f}" y1="{y(0):.1f}" x2="{x(d[-1] + 0.005):.1f}" '
        f'y2="{y(slope * (d[-1] + 0.005 - free)):.1f}" stroke="#888"/>',
        '<text x="260" y="300" text-anchor="middle">opening D, mm</text>',
        '<text x="18" y="140" text-anchor="middle" transform="rotate(-90 18 140)">'
        "(disks in a second)^(2/3)</text>",
    ]
    for v in range(0, 101, 20):
        parts.append(f'<text x="{x(v / 1e3):.1f}" y="276" text-anchor="middle">{v}</text>')
    for v in range(0, int(top) + 1, 20):
        parts.append(f'<text x="54" y="{y(v) + 4:.1f}" text-anchor="end">{v}</text>')
    for opening, row in zip(d, rows):
        for value in row["rates"]:
            parts.append(
                f'<circle cx="{x(opening):.1f}" cy="{y(value ** (2 / 3)):.1f}" r="4" fill="#1f5a99"/>'
            )
    return "\n".join(parts) + "\n</svg>\n"


if __name__ == "__main__":
    main()
