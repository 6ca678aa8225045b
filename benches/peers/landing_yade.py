"""Slow confinement and biaxial test of a loose packing with YADE; run by `landing.py`, or

    PEER='{"specimen": "p.csv", "width": 0.131, "height": 0.17, ...}' yade -n -x -j1 landing_yade.py

The packing is a CSV of x, y, r. Spheres with the masses and inertias of disks of unit thickness move
in the plane; contacts have linear stiffnesses and Coulomb's friction, walls none. Three phases:

1. all four walls move inwards at `rate` (strain in each direction, 1/s) until the mean stress is
   `first_stress`;
2. every wall is under a stress, which rises to `stress` within `ramp` seconds and is then held until the
   specimen is at rest; no wall is faster than four times the speed of phase 1;
3. the bottom and the top move inwards at `rate`, the sides keep their stress.
"""

import csv
import json
import math
import os
import time

P = {
    "specimen": None,
    "out": "yade.json",
    "width": None,
    "height": None,
    "normal_stiffness": 60.0e6,
    "tangential_stiffness": 30.0e6,
    "friction": 0.5,
    "density": 2650.0,
    "stress": 100.0e3,
    "first_stress": 10.0e3,
    "rate": 0.02,
    "ramp": 0.2,
    "hold": 0.05,
    "strain": 0.02,
    "damping": 0.1,
    "step": 0.2,
    "servo_every": 5,
}
P.update(json.loads(os.environ["PEER"]))

with open(P["specimen"]) as f:
    rows = [
        [float(v) for v in row[:3]]
        for row in csv.reader(line for line in f if not line.startswith(("#", "x")))
    ]
least = min(r for _, _, r in rows)

grain = O.materials.append(FrictMat(young=1e7, poisson=0.5, frictionAngle=math.atan(P["friction"]), density=P["density"]))
plate = O.materials.append(FrictMat(young=1e7, poisson=0.5, frictionAngle=0.0, density=P["density"]))
ids = [O.bodies.append(sphere((x, y, 0), r, material=grain)) for x, y, r in rows]
for i, (_, _, r) in zip(ids, rows):
    b = O.bodies[i]
    b.state.blockedDOFs = "zXY"
    b.state.mass = P["density"] * math.pi * r * r
    inertia = 0.5 * b.state.mass * r * r
    b.state.inertia = (inertia, inertia, inertia)
W, H = P["width"], P["height"]
# name: (body, axis, sign of the inward direction)
WALLS = {
    "bottom": (O.bodies.append(utils.wall((0, 0, 0), axis=1, sense=1, material=plate)), 1, 1),
    "top": (O.bodies.append(utils.wall((0, H, 0), axis=1, sense=-1, material=plate)), 1, -1),
    "left": (O.bodies.append(utils.wall((0, 0, 0), axis=0, sense=1, material=plate)), 0, 1),
    "right": (O.bodies.append(utils.wall((W, 0, 0), axis=0, sense=-1, material=plate)), 0, -1),
}

mass = P["density"] * math.pi * least * least
O.dt = P["step"] * math.sqrt(mass / P["normal_stiffness"])
RATE = P["rate"]
state = {"phase": "approach", "since": 0.0}
curve = []
path = []
result = {"disks": len(rows), "dt_s": O.dt, "rate": RATE}


def place(name):
    body, axis, _ = WALLS[name]
    return O.bodies[body].state.pos[axis]


def force(name):
    """Force of the specimen on the wall, positive outwards."""
    body, axis, sign = WALLS[name]
    return -sign * O.forces.f(body)[axis]


def lengths():
    return place("right") - place("left"), place("top") - place("bottom")


def stresses():
    width, height = lengths()
    return 0.5 * (force("bottom") + force("top")) / width, 0.5 * (force("left") + force("right")) / height


def move(name, speed):
    body, axis, sign = WALLS[name]
    v = [0.0, 0.0, 0.0]
    v[axis] = sign * speed
    O.bodies[body].state.vel = v


def servo(name, target, limit):
    """Speed in proportion to what the force lacks, beside the stiffness of the wall's contacts."""
    width, height = lengths()
    loaded = width if WALLS[name][1] == 1 else height
    lack = target * loaded - force(name)
    touching = max(10, sum(1 for i in O.bodies[WALLS[name][0]].intrs() if i.isReal))
    speed = 0.5 * lack / (touching * P["normal_stiffness"] * P["servo_every"] * O.dt)
    move(name, max(-limit, min(limit, speed)))


def control():
    phase = state["phase"]
    axial, lateral = stresses()
    if phase != "shear" and O.iter % 200 < P["servo_every"]:
        path.append([O.time, *lengths(), 0.5 * (axial + lateral)])
    if phase == "approach":
        for name, (_, axis, _) in WALLS.items():
            move(name, 0.5 * RATE * (H if axis == 1 else W))
        if 0.5 * (axial + lateral) >= P["first_stress"]:
            state.update(phase="ramp", since=O.time)
            result["approach_s"] = O.time
        return
    limit = 2.0 * RATE * max(W, H)
    if phase == "ramp":
        part = min(1.0, (O.time - state["since"]) / P["ramp"])
        target = P["first_stress"] + part * (P["stress"] - P["first_stress"])
        for name in WALLS:
            servo(name, target, limit)
        if O.time - state["since"] < P["ramp"] + P["hold"]:
            return
        width, height = lengths()
        unbalanced = utils.unbalancedForce()
        if unbalanced > 1e-3 and O.time - state["since"] < P["ramp"] + 20 * P["hold"]:
            return
        result["hold"] = {
            "time_s": O.time,
            "unbalanced": unbalanced,
            "axial_stress": axial,
            "lateral_stress": lateral,
            "walls": {name: place(name) for name in WALLS},
            "particles": [[O.bodies[i].state.pos[0], O.bodies[i].state.pos[1], r] for i, (_, _, r) in zip(ids, rows)],
        }
        state.update(phase="shear", since=O.time, height0=height, width0=width)
    for name in ("bottom", "top"):
        move(name, 0.5 * RATE * state["height0"])
    for name in ("left", "right"):
        servo(name, P["stress"], limit)
    width, height = lengths()
    strain = 1.0 - height / state["height0"]
    if O.iter % 20 < P["servo_every"]:
        curve.append([strain, axial - lateral, lateral, 1.0 - width / state["width0"]])
    if strain >= 1.02 * P["strain"]:
        O.pause()


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=0.1 * least),
    InteractionLoop(
        [Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
        [
            Ip2_FrictMat_FrictMat_FrictPhys(
                kn=MatchMaker(algo="val", val=P["normal_stiffness"]),
                ks=MatchMaker(algo="val", val=P["tangential_stiffness"]),
            )
        ],
        [Law2_ScGeom_FrictPhys_CundallStrack()],
    ),
    PyRunner(command="control()", iterPeriod=P["servo_every"]),
    NewtonIntegrator(damping=P["damping"]),
]
clock, cpu = time.perf_counter(), time.process_time()
O.run(3_000_000, True)
result.update(
    steps=O.iter,
    wall_s=time.perf_counter() - clock,
    cpu_s=time.process_time() - cpu,
    curve=curve,
    path=path,
    phase=state["phase"],
)
with open(P["out"], "w") as f:
    json.dump(result, f)
