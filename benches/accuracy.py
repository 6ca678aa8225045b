#!/usr/bin/env python3
"""Error of q in uncemented biaxial tests against the increment and against `accuracy`.

    cargo build --release
    python3 benches/accuracy.py [--out bench/accuracy] [--count 400] [--seeds 1,2,3,4,5] [--end 0.02]

Disks of `biaxial_small` without bonds, compacted without friction to a porosity of 0.2 and brought
to 200 kPa on all sides. From the state saved there top and bottom close by 0.075 % of the height an
increment (1), by 2 and by 4 times that. The reference has increments of 1/16. The error is that of
q, axial minus lateral stress, at 40 strains up to the end: the root of its mean square over the
maximum of q, and the mean of its magnitude over the maximum of q as the second number. Factorisations,
solves and processor seconds are of the shear alone. The lines are means over the seeds; the errors
of single seeds follow.

A second table has the error that `accuracy` aims at, that of the stress over its norm, both of axial
and lateral stress. A row counts with the strain since the row before.
"""

import argparse
import csv
import json
import resource
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PROGRAM = ROOT / "target/release/clastic"
STRAIN = 0.00075
MULTIPLES = [1, 2, 4]
ACCURACIES = [None, 0.1, 0.03, 0.01, 0.003]
SIDE = "contact: (normal_stiffness: 60.0e6, tangential_stiffness: 30.0e6)"
MATERIALS = """materials: { "sand": (contact: (normal_stiffness: 60.0e6,
    tangential_stiffness: 30.0e6, friction: 0.3, rolling_friction: 0.05)) },"""
MEASURES = """measures: [
    (name: "axial_strain", of: Strain(Walls("bottom", "top"))),
    (name: "axial_stress",
        of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right")))),
    (name: "lateral_stress",
        of: Stress(Walls(walls: ["left", "right"], length: Between("bottom", "top")))),
  ],
  output: (plots: false),"""


def run(text, out, sets=()):
    out.mkdir(parents=True, exist_ok=True)
    scene = out.with_suffix(".ron")
    scene.write_text(text)
    command = [PROGRAM, "run", scene, "--out", out, "--force"]
    command += ["--threads", "1"]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = subprocess.run(
        [str(word) for word in command], capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 2):
        raise SystemExit(f"{scene}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before


def confined(count, seed, out):
    """The state under 200 kPa on all sides, and its height, m."""
    k = (count / 400) ** 0.5
    width, columns = 0.121 * k, int(12 * k)
    height = 0.01 * (count / columns + 2)
    flat, upright = (
        f'Stress(stress: 200.0e3, between: ("{a}", "{b}"))'
        for a, b in (("left", "right"), ("bottom", "top"))
    )
    text = f"""(
  version: 1, title: "Uncemented disks under 200 kPa",
  {MATERIALS}
  specimen: Packing(count: {count}, columns: {columns}, spacing: 10.0e-3, origin: (0.5e-3, 0.0),
    sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: {seed}),
  walls: [
    (name: "bottom", start: (0.0, 0.0), end: ({width}, 0.0), probe: "bottom", {SIDE}),
    (name: "top", start: ({width}, {height}), end: (0.0, {height}), probe: "top", {SIDE}),
    (name: "left", start: (0.0, {height}), end: (0.0, 0.0), {SIDE}),
    (name: "right", start: ({width}, 0.0), end: ({width}, {height}), {SIDE}),
  ],
  stages: [
    Compact(name: "compact", wall: "top", base: "bottom", target: Porosity(0.2), step: 4.0e-3,
      agitation: 0.1, seed: {seed}),
    Load(name: "confine", increments: 5, walls: {{ "bottom": {flat}, "top": {flat},
      "left": {upright}, "right": {upright} }}),
    Save(name: "confined"),
  ],
  {MEASURES}
)
"""
    run(text, out / f"{seed}_confine")
    with open(out / f"{seed}_confine/history.csv") as file:
        last = list(csv.DictReader(file))[-1]
    travel = float(last["bottom.y_m"]) - float(last["top.y_m"])
    return out / f"{seed}_confine/state_confined.npz", height - travel


def sheared(state, height, multiple, accuracy, end, out):
    """Strain, q, kPa, and the work of the test: solves, iterations of the solver, seconds."""
    closing = 0.5 * STRAIN * height * multiple
    choice = "" if accuracy is None else f"accuracy: {accuracy}, "
    text = f"""(
  version: 1, title: "Uncemented biaxial test",
  {MATERIALS}
  specimen: State(path: "{state.resolve()}"),
  stages: [
    Load(name: "shear", increments: {round(2 * end / STRAIN / multiple)}, {choice}walls: {{
      "bottom": Displacement(0.0, {closing!r}), "top": Displacement(0.0, {-closing!r}) }},
      stop: [Above("axial_strain", {end})]),
  ],
  {MEASURES}
)
"""
    seconds = run(text, out)
    with open(out / "history.csv") as file:
        rows = [row for row in csv.DictReader(file) if row["stage"] == "shear"]
    curve = [(0.0, None)]
    for row in rows:
        axial, lateral = (float(row[f"{side}_stress_pa"]) / 1e3 for side in ("axial", "lateral"))
        curve.append((float(row["axial_strain"]), axial - lateral, lateral))
    curve[0] = (0.0, 0.0, curve[1][2])
    work = [sum(int(row[k]) for row in rows) for k in ("solves", "solver_iterations")]
    return curve, [len(rows), *work, seconds]


def at(curve, strain, column=1):
    a, b = next(pair for pair in zip(curve, curve[1:]) if pair[1][0] >= strain - 1e-12)
    return a[column] + (strain - a[0]) / (b[0] - a[0]) * (b[column] - a[column])


def of_the_norm(curve, exact, end):
    """Strain since the row before, and error of the stress over its norm, in every row."""
    errors, before = [], 0.0
    for strain, q, lateral in curve:
        if 0.0 < strain <= end:
            side = at(exact, strain, 2)
            axial = at(exact, strain) + side
            error = ((q + lateral - axial) ** 2 + (lateral - side) ** 2) ** 0.5
            errors.append((strain - before, error / (axial**2 + side**2) ** 0.5))
            before = strain
    return errors


def print_of_the_norm(norms):
    print("| accuracy | increment | mean error, % | of single seeds | maximum | 90 % of the strain below "
          "| share of the strain above the accuracy, % | above twice the accuracy |")
    print("|" + "---|" * 8)
    for (multiple, accuracy), of_seeds in norms.items():
        rows = [row for rows in of_seeds for row in rows]
        total = sum(strain for strain, _ in rows)
        means = [sum(s * e for s, e in rows) / sum(s for s, _ in rows) for rows in of_seeds]
        below, quantile = 0.0, 0.0
        for strain, quantile in sorted(rows, key=lambda row: row[1]):
            below += strain
            if below >= 0.9 * total:
                break
        cells = [f"{accuracy or 'off'}", f"{multiple:g}"]
        cells.append(f"{100 * sum(means) / len(means):.2f}")
        cells.append(", ".join(f"{100 * mean:.2f}" for mean in means))
        cells += [f"{100 * e:.2f}" for e in (max(e for _, e in rows), quantile)]
        for k in (1, 2):
            above = sum(s for s, e in rows if accuracy and e > k * accuracy)
            cells.append(f"{100 * above / total:.0f}" if accuracy else "")
        print("| " + " | ".join(cells) + " |")


def main():
    global PROGRAM
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/accuracy")
    parser.add_argument("--count", type=int, default=400)
    parser.add_argument("--seeds", default="1,2,3,4,5")
    parser.add_argument("--end", type=float, default=0.02)
    parser.add_argument("--program", type=Path, default=PROGRAM)
    parser.add_argument("--multiples", default="1,2,4")
    parser.add_argument("--accuracies", default="0.1,0.03,0.01,0.003")
    args = parser.parse_args()
    PROGRAM = args.program
    cases = [(1 / 16, None), (1 / 8, None)]
    for accuracy in [None, *map(float, filter(None, args.accuracies.split(",")))]:
        cases += [(float(m), accuracy) for m in args.multiples.split(",")]
    found, norms = {}, {}
    for seed in args.seeds.split(","):
        state, height = confined(args.count, seed, args.out)
        exact = None
        for case in cases:
            out = args.out / f"{seed}_{case[0]:g}_{case[1] or 'off'}"
            curve, work = sheared(state, height, *case, args.end, out)
            exact = exact or curve
            # Chords of coarse increments cross the curve: only their ends are compared.
            ends = [(strain, q) for strain, q, _ in curve if 0.0 < strain <= args.end]
            peak = max(q for _, q, _ in exact)
            errors = [(q - at(exact, strain)) / peak for strain, q in ends]
            gaps = [b[0] - a[0] for a, b in zip([(0.0, 0.0), *ends], ends)]
            weighted = [sum(g * f(e) for g, e in zip(gaps, errors)) / sum(gaps)
                        for f in (lambda e: e, abs, lambda e: e * e)]
            top = max(q for _, q, _ in curve) / peak - 1
            row = [weighted[0], weighted[1], weighted[2] ** 0.5, top, *work]
            found.setdefault(case, []).append(row)
            norms.setdefault(case, []).append(of_the_norm(curve, exact, args.end))
            print(json.dumps([seed, *case, *row]), flush=True)
    print("| accuracy | increment | mean error of q, % | mean magnitude | r.m.s. | of the peak | rows "
          "| solves | iterations | CPU s | mean magnitude of single seeds |")
    print("|" + "---|" * 11)
    for (multiple, accuracy), rows in found.items():
        mean = [sum(row[k] for row in rows) / len(rows) for k in range(8)]
        cells = [str(accuracy or "off"), f"{multiple:g}", *(f"{100 * e:.1f}" for e in mean[:4])]
        cells += [f"{n:.0f}" for n in mean[4:7]] + [f"{mean[7]:.1f}"]
        cells.append(", ".join(f"{100 * row[1]:.1f}" for row in rows))
        print("| " + " | ".join(cells) + " |")
    print_of_the_norm(norms)


if __name__ == "__main__":
    main()
