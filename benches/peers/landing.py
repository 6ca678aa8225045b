#!/usr/bin/env python3
"""Where a followed motion lands: a loose packing under its first confining stress, by several routes.

    python3 benches/peers/landing.py                       five seeds, all routes, results in bench/landing
    python3 benches/peers/landing.py --seeds 1 --routes followed,yade

Every route starts from the same packing of a seed (one `Compact` stage) and ends at the same isotropic
stress; a biaxial test follows. The routes:

    followed          static increments of the stress, the first of which the engine follows as a motion;
                      static test
    followed-1        the same with the whole stress in one increment
    followed-100      the same with the stress in 100 increments
    followed-coulomb  as `followed` with `friction_law: Coulomb()`
    slow              the engine's dynamics: the walls close slowly until the mean stress is a tenth of the
                      confining stress, which then rises to its value in --ramp seconds; static test
    slow-slow         the same, and the test is slow dynamics, too
    slow-coulomb      the same with Coulomb's law
    ramped            the engine's dynamics: the wall stresses rise from zero in --ramp-from-zero seconds,
                      and nothing limits the speed of the walls while the packing gives way; static test
    yade              as `slow-coulomb`, with YADE (`landing_yade.py`)

A result that is already in the directory (SEED/ROUTE.json) is not computed again; --force does.
Needs Python 3 and nothing beyond; `yade` for its route, which is left out where there is none.
"""

import argparse
import csv
import json
import math
import os
import shutil
import signal
import statistics
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
ROUTES = ["followed", "followed-1", "followed-100", "followed-coulomb", "slow", "slow-slow", "slow-coulomb", "ramped", "yade"]

NORMAL, TANGENTIAL = 60.0e6, 30.0e6  # stiffnesses of contacts, N/m
DENSITY = 2650.0
RADII = (3.0e-3, 5.0e-3)
STRESS = 100.0e3
FIRST = 10.0e3  # mean stress at which the slow routes change from moving walls to wall stresses
STRAINS = [0.005, 0.01, 0.02]
SHEAR_STEP = 0.25e-3  # axial strain in an increment of the static test


def box(width, height):
    side = f"contact: (normal_stiffness: {NORMAL!r}, tangential_stiffness: {TANGENTIAL!r})"
    return f"""walls: [
    (name: "bottom", start: (0.0, 0.0), end: ({width!r}, 0.0), probe: "bottom", {side}),
    (name: "top", start: ({width!r}, {height!r}), end: (0.0, {height!r}), probe: "top", {side}),
    (name: "left", start: (0.0, {height!r}), end: (0.0, 0.0), probe: "left", {side}),
    (name: "right", start: ({width!r}, 0.0), end: ({width!r}, {height!r}), probe: "right", {side}),
  ]"""


def scene(title, specimen, walls, stages, friction, law="Associated"):
    return f"""(
  version: 1, title: "{title}", friction_law: {law},
  materials: {{ "sand": (density: {DENSITY!r}, contact: (normal_stiffness: {NORMAL!r},
    tangential_stiffness: {TANGENTIAL!r}, friction: {friction!r})) }},
  specimen: {specimen},
  {walls},
  stages: [
{stages}
  ],
  measures: [(name: "axial_strain", of: Strain(Walls("bottom", "top"))),
    (name: "lateral_strain", of: Strain(Walls("left", "right"))),
    (name: "axial_stress", of: Stress(Walls(walls: ["bottom", "top"], length: Between("left", "right")))),
    (name: "lateral_stress", of: Stress(Walls(walls: ["left", "right"], length: Between("bottom", "top"))))],
  output: (plots: false),
)
"""


def stresses(value):
    flat = f'Stress(stress: {value!r}, between: ("left", "right"))'
    upright = f'Stress(stress: {value!r}, between: ("bottom", "top"))'
    return f'walls: {{ "bottom": {flat}, "top": {flat}, "left": {upright}, "right": {upright} }}'


def test_stages(height, analysis="Static", rate=None, dt=None):
    """Static hold under the confining stress, then the biaxial test: static, or at a strain rate."""
    hold = f'    Load(name: "hold", analysis: Static, increments: 3, {stresses(STRESS)}, record: (frames_every: 1)),\n'
    if rate:
        count = math.ceil(1.06 * STRAINS[-1] / (rate * dt))
        move, step = "Velocity", 0.5 * rate * height
    else:
        count = math.ceil(1.06 * STRAINS[-1] / SHEAR_STEP)
        move, step = "Displacement", 0.5 * SHEAR_STEP * height
    return f"""{hold}    Load(name: "shear", analysis: {analysis}, increments: {count}, walls: {{
      "bottom": {move}(0.0, {step!r}), "top": {move}(0.0, {-step!r}) }},
      stop: [Above("axial_strain", {1.02 * STRAINS[-1]!r})]),"""


def read(path):
    with open(path) as f:
        return list(csv.DictReader(f))


def particles(path):
    return [[float(row[k]) for k in ("x_m", "y_m", "radius_m")] for row in read(path)]


class Landing:
    def __init__(self, options):
        self.options = options
        self.out = Path(options.out).resolve()
        self.out.mkdir(parents=True, exist_ok=True)
        self.clastic = Path(options.clastic).resolve()

    # Running.

    def start(self, text, directory):
        directory.mkdir(parents=True, exist_ok=True)
        path = directory / "input.ron"
        path.write_text(text)
        command = [self.clastic, "run", path, "--out", directory / "run", "--force", "--threads", "1", "--quiet"]
        shutil.rmtree(directory / "run", ignore_errors=True)
        with open(directory / "log.txt", "w") as log:
            return subprocess.Popen(list(map(str, command)), stdin=subprocess.DEVNULL, stdout=log, stderr=log)

    def run(self, text, directory):
        """Runs a scene to its end; its history and the seconds of processor time it took."""
        process = self.start(text, directory)
        try:
            _, status, usage = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            raise
        process.returncode = os.waitstatus_to_exitcode(status)
        run = directory / "run"
        if not (run / "history.csv").exists():
            raise RuntimeError(f"{directory}: {(directory / 'log.txt').read_text()}")
        outcome = json.loads((run / "run.json").read_text())["outcome"]
        return read(run / "history.csv"), outcome["status"], usage.ru_utime + usage.ru_stime

    # Preparation.

    def packing(self, seed):
        """Loose packing of a seed: file, particles, width and height of its box."""
        o = self.options
        columns = max(4, round(math.sqrt(o.count / 1.7)))
        spacing = 2.0 * RADII[1]
        width = columns * spacing + 1e-3
        top = -(-o.count // columns) * spacing + 3 * RADII[1]
        directory = self.out / str(seed) / "packing"
        path = directory / "run" / "specimen.csv"
        if not path.exists() or o.force:
            specimen = (
                f"Packing(count: {o.count}, columns: {columns}, spacing: {spacing!r}, origin: (0.5e-3, 0.0), "
                f"sizes: Uniform(radius: {RADII!r}), seed: {seed})"
            )
            stage = (
                f'    Compact(name: "compact", wall: "top", base: "bottom", target: Porosity({o.porosity!r}), '
                f"step: {0.8 * RADII[1]!r}, agitation: 0.1, seed: {seed}),"
            )
            self.run(scene(f"packing {seed}", specimen, box(width, top), stage, o.friction), directory)
        disks = particles(path)
        height = sum(math.pi * r * r for *_, r in disks) / (width * (1.0 - o.porosity))
        if max(y + r for _, y, r in disks) > height * (1 + 1e-6):
            raise RuntimeError(f"seed {seed}: the packing has not reached its porosity")
        return path, disks, width, height

    # Routes of the engine.

    def engine(self, seed, route):
        path, disks, width, height = self.packing(seed)
        o = self.options
        law = {"followed-coulomb": "Coulomb()", "slow-coulomb": "Coulomb()"}.get(
            route, "Associated"
        )
        directory = self.out / str(seed) / route
        specimen = f'File(path: "{os.path.relpath(path, directory)}")'

        def text(stages):
            return scene(f"{route} {seed}", specimen, box(width, height), stages, o.friction, law)

        analysis = f"Dynamic(dt: {o.dt!r}, theta: {o.theta!r})"
        extra = 0.0
        if route.startswith("followed"):
            count = {"followed-1": 1, "followed-100": 100}.get(route, o.increments)
            load = f'    Load(name: "confine", increments: {count}, {stresses(STRESS)}),\n'
        elif route == "ramped":
            count = round(o.ramp_from_zero / o.dt)
            load = f'    Load(name: "confine", analysis: {analysis}, increments: {count}, {stresses(STRESS)}),\n'
            load += f'    Load(name: "calm", analysis: {analysis}, increments: {round(0.05 / o.dt)}),\n'
        else:
            vx, vy = 0.5 * o.rate * width, 0.5 * o.rate * height
            walls = (
                f'walls: {{ "bottom": Velocity(0.0, {vy!r}), "top": Velocity(0.0, {-vy!r}), '
                f'"left": Velocity({vx!r}, 0.0), "right": Velocity({-vx!r}, 0.0) }}'
            )
            approach = f'    Load(name: "approach", analysis: {analysis}, increments: %d, {walls}),\n'
            # First run: how many increments until the mean stress is FIRST.
            count, extra = self.approach(text(approach % round(0.06 / o.rate / o.dt)), directory)
            load = approach % count
            load += f'    Load(name: "ramp", analysis: {analysis}, increments: {round(o.ramp / o.dt)}, {stresses(STRESS)}),\n'
            load += f'    Load(name: "calm", analysis: {analysis}, increments: {round(0.05 / o.dt)}),\n'
        dynamic = route in ("slow-slow", "slow-coulomb")
        test = test_stages(height, analysis, o.rate, o.dt) if dynamic else test_stages(height)
        history, status, seconds = self.run(text(load + test), directory)
        held = [row for row in history if row["stage"] == "hold"]
        if not held:
            raise RuntimeError(f"seed {seed}, {route}: {status} in stage {history[-1]['stage']}")

        def size(row):
            move = lambda name, axis: float(row[f"{name}.{axis}_m"])
            return width + move("right", "x") - move("left", "x"), height + move("top", "y") - move("bottom", "y")

        def stress(row):
            return 0.5 * (float(row["axial_stress_pa"] or 0) + float(row["lateral_stress_pa"] or 0))

        row = held[-1]
        move = lambda name, axis: float(row[f"{name}.{axis}_m"])
        walls = {
            "bottom": move("bottom", "y"),
            "top": height + move("top", "y"),
            "left": move("left", "x"),
            "right": width + move("right", "x"),
        }
        placed = particles(directory / "run" / "frames" / f"frame_{int(row['increment']):06}.csv")
        shear = [row for row in history if row["stage"] == "shear" and row["axial_strain"]]
        curve = [
            (float(r["axial_strain"]), float(r["axial_stress_pa"]) - float(r["lateral_stress_pa"]), float(r["lateral_strain"]))
            for r in shear
        ]
        before = [r for r in history if r["stage"] not in ("hold", "shear")]
        moving = [[float(r["time_s"]), *size(r), stress(r)] for r in before if r["stage"] != "confine" or route == "ramped"]
        motion = lambda rows: sum(int(r.get("motion_steps") or 0) for r in rows)
        return {
            **self.landed(placed, walls),
            **self.strength(curve),
            "inertial": 0.0 if route.startswith("followed") else self.inertial(moving),
            "contacts_of_engine": int(row["contacts"]),
            "motion_confine": motion(before),
            "motion_hold": motion(held),
            "motion_shear": motion(shear),
            "motions_shear": sum(1 for r in shear if float(r.get("motion_steps") or 0) > 0),
            "capped": sum(1 for r in history if r["status"] == "capped"),
            "increments": len(history),
            "status": status,
            "cpu_s": seconds + extra,
        }

    def approach(self, text, directory):
        """Increments of the stage `approach` until the mean stress is FIRST, and processor seconds."""
        process = self.start(text, directory)
        history = directory / "run" / "history.csv"
        clock = os.times()

        def reached():
            if not history.exists():
                return None
            for k, row in enumerate(read(history)):
                try:
                    mean = 0.5 * (float(row["axial_stress_pa"]) + float(row["lateral_stress_pa"]))
                except (TypeError, ValueError):
                    continue
                if mean >= FIRST:
                    return int(row["increment"])
            return None

        try:
            while process.poll() is None and reached() is None:
                time.sleep(0.5)
        finally:
            if process.poll() is None:
                process.send_signal(signal.SIGTERM)
            process.wait()
        count = reached()
        if count is None:
            raise RuntimeError(f"{directory}: the mean stress did not reach {FIRST:g} Pa")
        now = os.times()
        return count, now.children_user + now.children_system - clock.children_user - clock.children_system

    # YADE.

    def yade(self, seed):
        path, _, width, height = self.packing(seed)
        directory = self.out / str(seed) / "yade"
        directory.mkdir(parents=True, exist_ok=True)
        o = self.options
        parameters = {
            "specimen": str(path),
            "out": str(directory / "yade.json"),
            "width": width,
            "height": height,
            "normal_stiffness": NORMAL,
            "tangential_stiffness": TANGENTIAL,
            "friction": o.friction,
            "density": DENSITY,
            "stress": STRESS,
            "first_stress": FIRST,
            "rate": o.rate,
            "ramp": o.ramp,
            "strain": STRAINS[-1],
            "damping": o.damping,
        }
        (directory / "yade.json").unlink(missing_ok=True)
        env = {**os.environ, "PEER": json.dumps(parameters), "OMP_NUM_THREADS": "1"}
        with open(directory / "log.txt", "w") as log:
            command = ["yade", "-n", "-x", "-j1", str(HERE / "landing_yade.py")]
            subprocess.run(command, env=env, cwd=directory, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        if not (directory / "yade.json").exists():
            raise RuntimeError(f"YADE: {(directory / 'log.txt').read_text()}")
        result = json.loads((directory / "yade.json").read_text())
        hold = result["hold"]
        return {
            **self.landed(hold["particles"], hold["walls"]),
            **self.strength([(e, q, lateral) for e, q, _, lateral in result["curve"]]),
            "inertial": self.inertial(result["path"]),
            "unbalanced": hold["unbalanced"],
            "lateral_stress_error": max(abs(s / STRESS - 1) for _, _, s, _ in result["curve"]),
            "steps": result["steps"],
            "dt_s": result["dt_s"],
            "status": "completed",
            "cpu_s": result["cpu_s"],
        }

    # Measures.

    def inertial(self, path):
        """Maximum inertial number once there is a stress: rate d sqrt(density/stress), over windows of 10 ms."""
        worst, first = 0.0, 0
        for k in range(1, len(path)):
            while path[k][0] - path[first + 1][0] >= 0.01:
                first += 1
            (t0, w0, h0, _), (t1, w1, h1, p) = path[first], path[k]
            if t1 - t0 < 0.009 or p < 0.1 * FIRST:
                continue
            rate = max(abs(w1 / w0 - 1), abs(h1 / h0 - 1)) / (t1 - t0)
            worst = max(worst, rate * sum(RADII) * math.sqrt(DENSITY / p))
        return worst

    def landed(self, disks, walls):
        """Porosity within the walls, coordination with and without rattlers (contacts that carry force)."""
        width, height = walls["right"] - walls["left"], walls["top"] - walls["bottom"]
        porosity = 1.0 - sum(math.pi * r * r for *_, r in disks) / (width * height)
        pairs = []  # a, b or -1 for a wall, overlap
        for a, (x, y, r) in enumerate(disks):
            for b in range(a + 1, len(disks)):
                u, v, s = disks[b]
                if abs(u - x) < r + s and abs(v - y) < r + s:
                    pairs.append((a, b, r + s - math.hypot(u - x, v - y)))
            pairs.append((a, -1, walls["bottom"] - (y - r)))
            pairs.append((a, -1, y + r - walls["top"]))
            pairs.append((a, -1, walls["left"] - (x - r)))
            pairs.append((a, -1, x + r - walls["right"]))
        pairs = [p for p in pairs if p[2] > 0.0]
        mean = sum(o for *_, o in pairs) / max(1, len(pairs))
        pairs = [p for p in pairs if p[2] > 1e-6 * mean]

        def number(kept):
            """Contacts of a grain on average: one between grains counts at both."""
            inside = [p for p in pairs if p[0] in kept and (p[1] < 0 or p[1] in kept)]
            return inside, sum(1 if p[1] < 0 else 2 for p in inside) / len(kept)

        kept = set(range(len(disks)))
        every, z = number(kept)
        while True:
            count = dict.fromkeys(kept, 0)
            for a, b, _ in number(kept)[0]:
                count[a] += 1
                if b >= 0:
                    count[b] += 1
            loose = {k for k, n in count.items() if n < 2}
            if not loose:
                break
            kept -= loose
        return {
            "porosity": porosity,
            "contacts": len(every),
            "z": z,
            "z_without_rattlers": number(kept)[1],
            "rattlers": 1.0 - len(kept) / len(disks),
        }

    def strength(self, curve):
        """q at STRAINS, its mean up to the last of them, volumetric strain there."""
        points = [(0.0, 0.0, 0.0), *curve]

        def at(strain, column):
            for (e0, *v0), (e1, *v1) in zip(points, points[1:]):
                if e0 <= strain <= e1 and e1 > e0:
                    part = (strain - e0) / (e1 - e0)
                    return v0[column] + part * (v1[column] - v0[column])
            return math.nan

        result = {f"q_{100 * e:g}": at(e, 0) for e in STRAINS}
        last = STRAINS[-1]
        grid = [last * (k + 0.5) / 200 for k in range(200)]
        result["q_mean"] = sum(at(e, 0) for e in grid) / len(grid)
        result["volumetric"] = 1.0 - (1.0 - last) * (1.0 - at(last, 1))
        return result

    # Report.

    def result(self, seed, route):
        path = self.out / str(seed) / f"{route}.json"
        if path.exists() and not self.options.force:
            return json.loads(path.read_text())
        try:
            result = self.yade(seed) if route == "yade" else self.engine(seed, route)
        except RuntimeError as error:
            print(f"  {error}", file=sys.stderr)
            return None
        path.write_text(json.dumps(result, indent=1))
        print(
            f"  seed {seed}, {route}: porosity {result['porosity']:.4f}, z {result['z']:.2f}, "
            f"q {result['q_2'] / 1e3:.1f} kPa at 2 %, {result['cpu_s']:.0f} s",
            file=sys.stderr,
        )
        return result

    def report(self, table):
        columns = [
            ("porosity", "porosity", 1, 4),
            ("contacts a grain", "z", 1, 2),
            ("without rattlers", "z_without_rattlers", 1, 2),
            ("rattlers, %", "rattlers", 100, 1),
            *[(f"q at {100 * e:g} %, kPa", f"q_{100 * e:g}", 1e-3, 1) for e in STRAINS],
            ("mean q, kPa", "q_mean", 1e-3, 1),
            ("volumetric strain at 2 %, %", "volumetric", 100, 2),
            ("seconds", "cpu_s", 1, 0),
        ]

        def cell(values, scale, digits):
            values = [scale * v for v in values if not math.isnan(v)]
            if not values:
                return ""
            scatter = f" ± {statistics.stdev(values):.{digits}f}" if len(values) > 1 else ""
            return f"{statistics.mean(values):.{digits}f}{scatter}"

        print("\n| route | seeds | " + " | ".join(c[0] for c in columns) + " | maximum I | capped, % |")
        print("|---" * (len(columns) + 4) + "|")
        for route, results in table.items():
            if not results:
                continue
            cells = [cell([r[k] for r in results.values()], scale, digits) for _, k, scale, digits in columns]
            inertial = max(r["inertial"] for r in results.values())
            cells.append("" if inertial == 0.0 else f"{inertial:.1g}")
            capped = [100 * r["capped"] / r["increments"] for r in results.values() if "capped" in r]
            cells.append(f"{statistics.mean(capped):.0f}" if capped else "")
            print(f"| {route} | {len(results)} | " + " | ".join(cells) + " |")
        base = table.get("followed") or {}
        print("\nDifference from `followed`, seed by seed: mean ± standard error\n")
        print("| route | " + " | ".join(c[0] for c in columns[:-1]) + " |")
        print("|---" * len(columns) + "|")
        for route, results in table.items():
            common = [s for s in results if s in base]
            if route == "followed" or len(common) < 2:
                continue
            cells = []
            for _, k, scale, digits in columns[:-1]:
                d = [scale * (results[s][k] - base[s][k]) for s in common]
                d = [v for v in d if not math.isnan(v)]
                error = statistics.stdev(d) / math.sqrt(len(d)) if len(d) > 1 else math.nan
                cells.append(f"{statistics.mean(d):+.{digits}f} ± {error:.{digits}f}" if d else "")
            print(f"| {route} | " + " | ".join(cells) + " |")


def main():
    # Whoever ends this script ends what it runs.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(1))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--clastic", default=str(ROOT / "target" / "release" / "clastic"))
    parser.add_argument("--out", default=str(ROOT / "bench" / "landing"), help="directory of results")
    parser.add_argument("--seeds", default="1,2,3,4,5")
    parser.add_argument("--routes", default=",".join(ROUTES))
    parser.add_argument("--force", action="store_true", help="compute results again that are there")
    parser.add_argument("--count", type=int, default=300, help="disks")
    parser.add_argument("--porosity", type=float, default=0.23, help="of the loose packing")
    parser.add_argument("--friction", type=float, default=0.5)
    parser.add_argument("--increments", type=int, default=20, help="of the stress, static")
    parser.add_argument("--rate", type=float, default=0.02, help="strain rate of slow routes in each direction, 1/s")
    parser.add_argument("--ramp", type=float, default=0.2, help="seconds in which the slow routes raise the stress")
    parser.add_argument("--ramp-from-zero", type=float, default=1.0, help="the same of the route `ramped`")
    parser.add_argument("--dt", type=float, default=1e-3, help="time step of the engine's dynamics, s")
    parser.add_argument("--theta", type=float, default=1.0, help="of the engine's dynamics")
    parser.add_argument("--damping", type=float, default=0.1, help="YADE's local damping")
    options = parser.parse_args()
    routes = options.routes.split(",")
    unknown = [r for r in routes if r not in ROUTES]
    if unknown:
        parser.error(f"unknown route {unknown[0]}; there are {', '.join(ROUTES)}")
    if "yade" in routes and not shutil.which("yade"):
        print("  there is no yade: its route is left out", file=sys.stderr)
        routes.remove("yade")
    landing = Landing(options)
    table = {route: {} for route in routes}
    for seed in map(int, options.seeds.split(",")):
        for route in routes:
            result = landing.result(seed, route)
            if result:
                table[route][seed] = result
    landing.report(table)


if __name__ == "__main__":
    main()
