"""Uniaxial compression of bonded rock with YADE's JCFpm model; run by `run.py`, or

    PEER='{"specimen": "p.csv", ...}' yade -n -x -j1 uniaxial_yade.py

The packing is a CSV of x, y, r. Spheres with the masses of disks of unit thickness move in the
plane; pairs with a gap below `bond_length` are bonded, free of stress, with the stiffnesses and
strengths of `scenes/uniaxial.ron` (JCFpm would derive them from elastic constants). The top wall
moves at a constant speed. What remains different: a broken bond keeps the stiffness of the bond.
"""

import csv
import json
import math
import os
import time

P = {
    "specimen": None,
    "out": "yade.json",
    "width": 50.0e-3,
    "height": 120.0e-3,
    "bond_length": 0.06e-3,
    "contact_stiffness": 3.4e10,
    "contact_friction": 0.4,
    "bond_stiffness": 7.9e10,
    "bond_friction": 0.8,
    "cohesion": 195.0e6,
    "tensile_strength": 144.0e6,
    "density": 2650.0,
    "speed": 2.0,
    "strain": 2.5e-3,
    "damping": 0.3,
    "safety": 0.8,
}
P.update(json.loads(os.environ["PEER"]))

with open(P["specimen"]) as f:
    rows = [
        [float(v) for v in row[:3]]
        for row in csv.reader(line for line in f if not line.startswith(("#", "x")))
    ]
least = min(r for _, _, r in rows)
reach = 1.0 + 1.01 * P["bond_length"] / (2 * least)

rock = O.materials.append(
    JCFpmMat(
        young=P["contact_stiffness"] / (sum(r for _, _, r in rows) / len(rows)),
        poisson=1.0,
        frictionAngle=math.atan(P["contact_friction"]),
        density=P["density"],
        tensileStrength=P["tensile_strength"],
        cohesion=P["cohesion"],
        type=1,
    )
)
platen = O.materials.append(
    JCFpmMat(
        young=P["contact_stiffness"] / (sum(r for _, _, r in rows) / len(rows)),
        poisson=1.0,
        frictionAngle=math.atan(P["contact_friction"]),
        density=P["density"],
        type=0,
    )
)
ids = [O.bodies.append(sphere((x, y, 0), r, material=rock)) for x, y, r in rows]
for i, (_, _, r) in zip(ids, rows):
    b = O.bodies[i]
    b.state.blockedDOFs = "zXY"
    b.state.mass = P["density"] * math.pi * r * r
    inertia = 0.5 * b.state.mass * r * r
    b.state.inertia = (inertia, inertia, inertia)
bottom = O.bodies.append(utils.wall((0, 0, 0), axis=1, sense=1, material=platen))
top = O.bodies.append(utils.wall((0, P["height"], 0), axis=1, sense=-1, material=platen))

# One step without motion makes the interactions: bonds where gaps are small, nothing elsewhere.
O.dt = 1e-20
detect = Ig2_Sphere_Sphere_ScGeom(interactionDetectionFactor=reach, label="detect")
bounds = Bo1_Sphere_Aabb(aabbEnlargeFactor=reach, label="bounds")
O.engines = [
    ForceResetter(),
    InsertionSortCollider([bounds, Bo1_Wall_Aabb()], verletDist=0.05 * least),
    InteractionLoop(
        [detect, Ig2_Wall_Sphere_ScGeom()],
        [Ip2_JCFpmMat_JCFpmMat_JCFpmPhys(cohesiveTresholdIteration=1, label="physics")],
        [Law2_ScGeom_JCFpmPhys_JointedCohesiveFrictionalPM(label="law")],
    ),
    NewtonIntegrator(damping=P["damping"], label="newton"),
]
O.step()

bonds = 0
radius = dict(zip(ids, (r for _, _, r in rows)))
centre = dict(zip(ids, ((x, y) for x, y, _ in rows)))
for i in list(O.interactions):
    if i.id1 not in radius or i.id2 not in radius:
        continue
    a, b = centre[i.id1], centre[i.id2]
    ra, rb = radius[i.id1], radius[i.id2]
    gap = math.hypot(a[0] - b[0], a[1] - b[1]) - ra - rb
    if gap >= P["bond_length"]:
        O.interactions.erase(i.id1, i.id2)
        continue
    area = 2 * min(ra, rb)
    i.phys.kn = i.phys.ks = P["bond_stiffness"]
    i.phys.FnMax = P["tensile_strength"] * area
    i.phys.FsMax = P["cohesion"] * area
    i.phys.tanFrictionAngle = P["bond_friction"]
    bonds += 1
# From here on contacts are made where disks touch. Bonds keep their interactions.
detect.interactionDetectionFactor = 1.0
bounds.aabbEnlargeFactor = 1.0


def platen_stiffness():
    """Contacts of the walls have the stiffness of the scene, not one that depends on the radius."""
    for wall in (bottom, top):
        for i in O.bodies[wall].intrs():
            if i.isReal:
                i.phys.kn = i.phys.ks = P["contact_stiffness"]


stiffness = dict.fromkeys(ids, 0.0)
for i in O.interactions:
    for k in (i.id1, i.id2):
        if k in stiffness:
            stiffness[k] += i.phys.kn + i.phys.ks
O.dt = P["safety"] * min(
    math.sqrt(O.bodies[i].state.mass / k) for i, k in stiffness.items() if k > 0
)
O.bodies[top].state.vel = (0, -P["speed"], 0)
# All at the speed of an even strain: a platen that hits a specimen at rest sends waves through it.
for i in ids:
    O.bodies[i].state.vel = (0, -P["speed"] * centre[i][1] / P["height"], 0)
steps = math.ceil(P["strain"] * P["height"] / (P["speed"] * O.dt))
every = max(1, steps // 1000)
curve = []


def record():
    strain = (P["height"] - O.bodies[top].state.pos[1]) / P["height"]
    force = 0.5 * (O.forces.f(top)[1] - O.forces.f(bottom)[1])
    broken = law.nbTensCracks + law.nbShearCracks if hasattr(law, "nbTensCracks") else 0
    curve.append([strain, force / P["width"], int(broken)])


O.engines = O.engines[:3] + [
    PyRunner(command="platen_stiffness()", iterPeriod=1),
    O.engines[3],
    PyRunner(command="record()", iterPeriod=every),
]
clock, cpu = time.perf_counter(), time.process_time()
O.run(steps, True)
result = {
    "disks": len(rows),
    "bonds": bonds,
    "dt_s": O.dt,
    "steps": steps,
    "wall_s": time.perf_counter() - clock,
    "cpu_s": time.process_time() - cpu,
    "curve": curve,
}
with open(P["out"], "w") as f:
    json.dump(result, f)
