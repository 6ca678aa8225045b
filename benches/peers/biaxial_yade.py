"""Biaxial compression of cemented sand with YADE's CohFrictMat; run by `run.py`, or

    PEER='{"specimen": "p.csv", "inertial": 1e-4, ...}' yade -n -x -j1 biaxial_yade.py

The packing is a CSV of x, y, r, and the defaults are the laws of `scenes/biaxial_small.ron`.
Spheres with the masses and inertias of disks of unit thickness move in the plane. Pairs with a gap
below `bond_length` are bonded, free of stress; walls have no friction. Two phases:

1. every wall is under a stress, which rises to `stress` and is then held until the specimen is at
   rest;
2. the bottom and the top move inwards at constant speed, the sides keep their stress.

Both have the strain rate of the inertial number `inertial`, I = rate d sqrt(density/stress), with d
the mean diameter.
"""

import csv
import json
import math
import os
import time

P = {
    "specimen": None,
    "out": "yade.json",
    "width": 0.121,
    "height": 0.2147896,
    "bond_length": 2.0e-3,
    "normal_stiffness": 60.0e6,
    "tangential_stiffness": 30.0e6,
    "friction": 0.3,
    "rolling_friction": 0.05,
    "bond_friction": 0.5,
    "bond_rolling_friction": 0.05,
    "cohesion": 50.0e3,
    "tensile_strength": 50.0e3,
    "density": 2650.0,
    "stress": 200.0e3,
    "inertial": 1e-4,
    "strain": 0.03,
    # Rolling stiffness k_R = rolling k_T r_a r_b, N m/rad. YADE has no rigid one.
    "rolling": 1.0,
    # Bonds have the rolling limit mu_r r (p + f_t) of the scene; else that of YADE, mu_r r |p|.
    "rolling_strength": True,
    "damping": 0.2,
    # Time step over sqrt(m/k_N) of the smallest disk.
    "step": 0.2,
    "servo_every": 5,
    # Strain between two passes over the bonds, at most `refresh_every` steps.
    "refresh_strain": 1e-4,
    "refresh_every": 100,
}
P.update(json.loads(os.environ["PEER"]))

with open(P["specimen"]) as f:
    rows = [
        [float(v) for v in row[:3]]
        for row in csv.reader(line for line in f if not line.startswith(("#", "x")))
    ]
least = min(r for _, _, r in rows)
reach = 1.0 + 1.01 * P["bond_length"] / (2 * least)
W, H = P["width"], P["height"]
diameter = 2 * sum(r for _, _, r in rows) / len(rows)
RATE = P["inertial"] / (diameter * math.sqrt(P["density"] / P["stress"]))

# YADE multiplies Young's modulus by the radius: a material of its own for each disk gives every
# pair the stiffness of the scene.
ids = []
for x, y, r in rows:
    sand = O.materials.append(
        CohFrictMat(
            young=P["normal_stiffness"] / r,
            poisson=P["tangential_stiffness"] / P["normal_stiffness"],
            frictionAngle=math.atan(P["friction"]),
            density=P["density"],
            isCohesive=True,
            normalCohesion=1e30,
            shearCohesion=1e30,
            momentRotationLaw=True,
            alphaKr=P["rolling"],
            alphaKtw=0.0,
            etaRoll=P["rolling_friction"],
            etaTwist=0.0,
        )
    )
    ids.append(O.bodies.append(sphere((x, y, 0), r, material=sand)))
for i, (_, _, r) in zip(ids, rows):
    b = O.bodies[i]
    b.state.blockedDOFs = "zXY"
    b.state.mass = P["density"] * math.pi * r * r
    inertia = 0.5 * b.state.mass * r * r
    b.state.inertia = (inertia, inertia, inertia)
plate = O.materials.append(
    FrictMat(young=1e7, poisson=0.5, frictionAngle=0.0, density=P["density"])
)
# name: (body, axis, sign of the inward direction)
WALLS = {
    "bottom": (O.bodies.append(utils.wall((0, 0, 0), axis=1, sense=1, material=plate)), 1, 1),
    "top": (O.bodies.append(utils.wall((0, H, 0), axis=1, sense=-1, material=plate)), 1, -1),
    "left": (O.bodies.append(utils.wall((0, 0, 0), axis=0, sense=1, material=plate)), 0, 1),
    "right": (O.bodies.append(utils.wall((W, 0, 0), axis=0, sense=-1, material=plate)), 0, -1),
}

# One step without motion makes the interactions, which hold across gaps by an unlimited cohesion:
# bonds where gaps are small, nothing elsewhere. Without `avoidGranularRatcheting` the arms of the
# shear force are those of the contact point, as in clastic.
detect = Ig2_Sphere_Sphere_ScGeom6D(interactionDetectionFactor=reach, avoidGranularRatcheting=False)
bounds = Bo1_Sphere_Aabb(aabbEnlargeFactor=reach)
grains = Ip2_CohFrictMat_CohFrictMat_CohFrictPhys(setCohesionNow=True)
walls = Ip2_FrictMat_FrictMat_FrictPhys(
    kn=MatchMaker(algo="val", val=P["normal_stiffness"]),
    ks=MatchMaker(algo="val", val=P["tangential_stiffness"]),
)
law = Law2_ScGeom6D_CohFrictPhys_CohesionMoment(always_use_moment_law=True, useIncrementalForm=True)
O.dt = 1e-20
O.engines = [
    ForceResetter(),
    InsertionSortCollider([bounds, Bo1_Wall_Aabb()], verletDist=0.1 * least),
    InteractionLoop(
        [detect, Ig2_Wall_Sphere_ScGeom()],
        [grains, walls],
        [law, Law2_ScGeom_FrictPhys_CundallStrack()],
    ),
    NewtonIntegrator(damping=P["damping"]),
]
O.step()
grains.setCohesionNow = False

radius = dict(zip(ids, (r for _, _, r in rows)))
# Interaction, tensile strength f_t, and mu_r r
bonds = []
for i in list(O.interactions):
    if i.id1 not in radius or i.id2 not in radius:
        continue
    gap = -i.geom.penetrationDepth
    if gap >= P["bond_length"]:
        O.interactions.erase(i.id1, i.id2)
        continue
    r = min(radius[i.id1], radius[i.id2])
    strength = 2 * r * P["tensile_strength"]
    i.phys.unp = -gap
    i.phys.normalAdhesion = strength
    i.phys.shearAdhesion = 2 * r * P["cohesion"]
    i.phys.tangensOfFrictionAngle = P["bond_friction"]
    i.phys.maxRollPl = P["bond_rolling_friction"] * r
    bonds.append((i, strength, P["bond_rolling_friction"] * r))
# From here on contacts are made where disks touch. Bonds keep their interactions.
detect.interactionDetectionFactor = 1.0
bounds.aabbEnlargeFactor = 1.0
made = len(bonds)

O.dt = P["step"] * math.sqrt(P["density"] * math.pi * least**2 / P["normal_stiffness"])
refresh_every = P["refresh_strain"] / (RATE * O.dt)
refresh_every = int(max(P["servo_every"], min(P["refresh_every"], refresh_every)))
state = {"phase": "confine", "script_s": 0.0, "height": H, "width": W}
drift = dict.fromkeys(WALLS, 0.0)
curve = []
# Strain by which the walls bring the stress, roughly: that of a square lattice of disks.
RAMP = P["stress"] / P["normal_stiffness"] / RATE


def refresh():
    """What YADE's law leaves out: broken bonds become contacts, f_t adds to the rolling limit."""
    global bonds
    clock = time.process_time()
    intact = []
    for bond in bonds:
        i, strength, arm = bond
        if not i.isReal:
            continue
        phys = i.phys
        if phys.cohesionBroken:
            phys.unp = 0.0
            phys.tangensOfFrictionAngle = P["friction"]
            phys.maxRollPl = P["rolling_friction"] * min(radius[i.id1], radius[i.id2])
            continue
        intact.append(bond)
        if P["rolling_strength"]:
            # YADE multiplies maxRollPl by the magnitude of the force.
            force = phys.kn * (i.geom.penetrationDepth - phys.unp)
            phys.maxRollPl = arm * (force + strength) / max(abs(force), 1e-3 * strength)
    bonds = intact
    state["script_s"] += time.process_time() - clock


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
    axial = 0.5 * (force("bottom") + force("top")) / width
    return axial, 0.5 * (force("left") + force("right")) / height


def move(name, speed):
    body, axis, sign = WALLS[name]
    v = [0.0, 0.0, 0.0]
    v[axis] = sign * speed
    O.bodies[body].state.vel = v


def servo(name, target):
    """Mean speed of late, and what the force lacks over the stiffness of the wall's contacts.

    Without the mean speed a wall that goes on moving would keep a lack in proportion to its speed.
    """
    width, height = lengths()
    loaded = width if WALLS[name][1] == 1 else height
    lack = target * loaded - force(name)
    touching = max(10, sum(1 for i in O.bodies[WALLS[name][0]].intrs() if i.isReal))
    speed = 0.5 * lack / (touching * P["normal_stiffness"] * P["servo_every"] * O.dt)
    limit = 10.0 * RATE * max(W, H)
    speed = max(-limit, min(limit, drift[name] + speed))
    drift[name] += 0.02 * (speed - drift[name])
    move(name, speed)


def control():
    clock = time.process_time()
    axial, lateral = stresses()
    if state["phase"] == "confine":
        target = P["stress"] * min(1.0, O.time / RAMP)
        for name in WALLS:
            servo(name, target)
        if O.time >= 1.2 * RAMP and (utils.unbalancedForce() < 1e-3 or O.time > 10 * RAMP):
            begin_loading(axial, lateral)
    else:
        for name in ("left", "right"):
            servo(name, P["stress"])
        width, height = lengths()
        strain = 1.0 - height / state["height"]
        curve.append([strain, axial, lateral, 1.0 - width / state["width"], made - len(bonds)])
        if strain >= P["strain"]:
            O.pause()
    state["script_s"] += time.process_time() - clock


def begin_loading(axial, lateral):
    width, height = lengths()
    state.update(phase="load", height=height, width=width)
    state["confined"] = {
        "time_s": O.time,
        "steps": O.iter,
        "unbalanced": utils.unbalancedForce(),
        "axial_stress": axial,
        "lateral_stress": lateral,
        "height": height,
        "width": width,
        "bonds": len(bonds),
    }
    for name in ("bottom", "top"):
        move(name, 0.5 * RATE * height)
    # All at the speed of an even axial strain: platens that hit a specimen at rest send waves.
    middle = 0.5 * (place("bottom") + place("top"))
    for i in ids:
        s = O.bodies[i].state
        v = s.vel
        s.vel = (v[0], v[1] - RATE * (s.pos[1] - middle), 0)


O.engines = O.engines[:3] + [
    PyRunner(command="control()", iterPeriod=P["servo_every"]),
    PyRunner(command="refresh()", iterPeriod=refresh_every),
    O.engines[3],
]
clock, cpu = time.perf_counter(), time.process_time()
O.run(100_000_000, True)
result = {
    "disks": len(rows),
    "bonds": made,
    "diameter": diameter,
    "rate": RATE,
    "dt_s": O.dt,
    "steps": O.iter,
    "refresh_every": refresh_every,
    "wall_s": time.perf_counter() - clock,
    "cpu_s": time.process_time() - cpu,
    "script_s": state["script_s"],
    "confined": state["confined"],
    # strain, axial and lateral stress, lateral strain, bonds broken
    "curve": curve,
}
with open(P["out"], "w") as f:
    json.dump(result, f)
