#!/usr/bin/env python3
"""Writes a rock specimen of 7380 n m disks and its uniaxial test, to be run with `clastic run`.

    python3 benches/large.py --columns 5 --rows 3 --out bench/large
    cargo run --release -- run bench/large/uniaxial.ron

The specimen is the stored packing of 50 x 120 mm, every other tile mirrored, so that the disks at the
edge of a tile touch their mirror images. Rock and increments are those of scenes/uniaxial.ron; the
test ends when the stress has fallen to 90 % of its peak.
"""

import argparse
import csv
from pathlib import Path

PACKING = Path(__file__).parent.parent / "scenes/specimens/uniaxial_7380.csv"
WIDTH, HEIGHT = 0.05, 0.12

SCENE = """(
    version: 1,
    title: "Uniaxial compression of rock, {columns} x {rows} tiles",
    materials: {{
        "rock": (
            contact: (normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4),
            bond: (
                normal_stiffness: 7.9e10,
                tangential_stiffness: 7.9e10,
                friction: 0.8,
                cohesion: 195.0e6,
                tensile_strength: 144.0e6,
            ),
        ),
    }},
    specimen: File(path: "specimen.csv"),
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: ({width}, 0.0), probe: "bottom",
            contact: (normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)),
        (name: "top", start: ({width}, {height}), end: (0.0, {height}), probe: "top",
            contact: (normal_stiffness: 3.4e10, tangential_stiffness: 3.4e10, friction: 0.4)),
    ],
    stages: [
        Cement(name: "cement", length: 0.06e-3),
        Load(
            name: "load",
            increments: 120,
            // 0.005 % of the height.
            walls: {{ "top": Displacement(0.0, {step}) }},
            stop: [StressDrop(0.9)],
            record: (frames: [20, 40, 60, 66]),
        ),
    ],
    measures: [
        (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
        (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Fixed({width})))),
    ],
)
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--columns", type=int, default=5, help="tiles side by side")
    parser.add_argument("--rows", type=int, default=3, help="tiles upon each other")
    parser.add_argument("--out", type=Path, default=Path("bench/large"), help="directory to write")
    args = parser.parse_args()
    if args.columns < 1 or args.rows < 1:
        parser.error("--columns and --rows: at least 1")

    with PACKING.open(newline="") as file:
        disks = [[float(value) for value in row] for row in list(csv.reader(file))[1:]]
    width, height = args.columns * WIDTH, args.rows * HEIGHT
    args.out.mkdir(parents=True, exist_ok=True)
    with (args.out / "specimen.csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["x_m", "y_m", "radius_m"])
        for row in range(args.rows):
            for column in range(args.columns):
                for x, y, radius in disks:
                    x = WIDTH - x if column % 2 else x
                    y = HEIGHT - y if row % 2 else y
                    rows.writerow([column * WIDTH + x, row * HEIGHT + y, radius])
    count = len(disks) * args.columns * args.rows
    text = SCENE.format(columns=args.columns, rows=args.rows, width=width, height=height, step=-5e-5 * height)
    (args.out / "uniaxial.ron").write_text(text)
    print(f"{count} disks, {width:g} x {height:g} m: {args.out / 'uniaxial.ron'}")


if __name__ == "__main__":
    main()
