"""Twenty frictional problems of at most 30 contacts: clastic beside Lemke's method of Siconos.

    cargo build --release
    /usr/bin/python3 benches/peers/lemke_siconos.py [--out bench/lemke]

Twelve rigid disks (friction 0.5) fall out of a box of which two sides are taken away, in steps of
5 ms under Coulomb's law. Of four packings every second increment is dumped, and the first five in
which a contact slides are solved again by Siconos as dense problems in two dimensions
(SICONOS_FRICTION_2D_LEMKE). Seeds whose compaction jams are left out. Siconos reports success for
some answers that violate the limit of friction. So it solves each problem in SI units and in units
of the maximum load and gap, and the answer with the smaller violation counts. Where both programs
fulfil the law and the motions differ, the problem has several solutions. Columns: seed, dump,
contacts, violation of the law by Siconos and by clastic over the maximum gap or force, and the
difference of the motions over the maximum motion.
"""

import argparse
import json
import subprocess
from pathlib import Path

import numpy as np
import siconos.numerics as sn
from nsgs_siconos import Problem

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "target/release/clastic"
SCENE = """(
    version: 1,
    title: "twelve disks",
    analysis: Dynamic(dt: 5.0e-3),
    friction_law: Coulomb(),
    gravity: (0.0, -9.81),
    materials: {{ "stone": (density: 2650.0, contact: (friction: 0.5)) }},
    specimen: Packing(count: 12, columns: 4, spacing: 10.0e-3, origin: (0.5e-3, 0.0),
        sizes: Uniform(radius: (3.0e-3, 5.0e-3)), seed: {seed}),
    walls: [
        (name: "bottom", start: (0.0, 0.0), end: (0.041, 0.0), contact: (friction: 0.5)),
        (name: "top", start: (0.041, 0.0305), end: (0.0, 0.0305), contact: (friction: 0.5)),
        (name: "left", start: (0.0, 0.0305), end: (0.0, 0.0), contact: (friction: 0.5)),
        (name: "right", start: (0.041, 0.0), end: (0.041, 0.0305), contact: (friction: 0.5)),
    ],
    stages: [
        Compact(name: "compact", wall: "top", base: "bottom", target: Porosity(0.34), step: 1.0e-3,
            agitation: 0.1, seed: {seed}),
        Load(name: "fall", increments: 30, remove_walls: ["top", "right"]),
    ],
    output: (plots: false),
)
"""


def dumps(seed, out, program):
    scene = out / f"twelve_{seed}.ron"
    scene.write_text(SCENE.format(seed=seed))
    command = [program, "run", scene, "--out", out / f"twelve_{seed}", "--force", "--quiet"]
    command += [word for n in range(1, 30, 2) for word in ("--dump-program", f"fall:{n}")]
    subprocess.run([str(word) for word in command], check=False, capture_output=True)
    return sorted((out / f"twelve_{seed}").glob("program_*.json"))


def slides(problem):
    """Whether a contact that carries force slips by more than a millionth of the motion."""
    r = problem.reference
    v = problem.w @ r + problem.b
    carries = r[0::2] > 1e-6 * r[0::2].max()
    return (carries & (abs(v[1::2]) > 1e-6 * abs(problem.motion).max())).any()


def lemke(problem, force, length):
    """Forces of Siconos in these units, N."""
    r, v = np.zeros(2 * problem.contacts), np.zeros(2 * problem.contacts)
    matrix, b = problem.w.toarray() * force / length, problem.b / length
    dense = sn.FrictionContactProblem(2, problem.contacts, matrix, b, problem.friction)
    sn.fc2d_driver(dense, r, v, sn.SolverOptions(sn.SICONOS_FRICTION_2D_LEMKE))
    return r * force


def violation(problem, r):
    """Maximum violation of the law over the maximum gap, and of the cone over the maximum force."""
    cone = (abs(r[1::2]) - problem.friction * r[0::2]).max() / max(r[0::2].max(), 1e-300)
    return max(problem.violation(r) / abs(problem.b).max(), cone, 0.0)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=ROOT / "bench/lemke")
    parser.add_argument("--program", default=PROGRAM)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    rows, wrong = [], 0
    for seed in range(1, 9):
        # A packing that jams in the compaction has no dumps.
        found = 0
        if len(rows) == 20:
            break
        for path in dumps(seed, options.out, options.program):
            problem = Problem(json.loads(path.read_text()))
            if problem.contacts > 30 or not slides(problem):
                continue
            units = [(1.0, 1.0), (abs(problem.load).max(), abs(problem.b).max())]
            answers = [lemke(problem, *unit) for unit in units]
            violations = [violation(problem, r) for r in answers]
            wrong += sum(v > 1e-6 for v in violations)
            best = int(np.argmin(violations))
            u = problem.displacement(answers[best])
            apart = abs(u - problem.motion).max() / abs(problem.motion).max()
            own = violation(problem, problem.reference)
            rows.append((seed, path.stem, problem.contacts, violations[best], own, apart))
            print("{} {} {} {:.0e} {:.0e} {:.0e}".format(*rows[-1]), flush=True)
            found += 1
            if found == 5 or len(rows) == 20:
                break
    print(f"{len(rows)} problems, {min(r[2] for r in rows)} to {max(r[2] for r in rows)} contacts,")
    print(f"maximum violation {max(r[3] for r in rows):.0e} (Siconos), {max(r[4] for r in rows):.0e} (clastic),")
    same = [r[5] for r in rows if r[5] < 1e-6]
    print(f"{len(same)} motions differ by at most {max(same):.0e}, the others by", end=" ")
    print(" ".join(f"{r[5]:.0e}" for r in rows if r[5] >= 1e-6) + ";")
    print(f"{wrong} of {2 * len(rows)} answers of Siconos violate the law by more than 1e-6")


if __name__ == "__main__":
    main()
