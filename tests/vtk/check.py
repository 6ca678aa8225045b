"""Checks exported VTK files with VTK itself against the engine's state and history.

    check.py RUN      RUN is the directory of a run of biaxial_small, exported by
                      clastic export RUN
"""

import csv
import random
import sys
import xml.etree.ElementTree as xml
from pathlib import Path

import numpy as np
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOXML import vtkXMLPolyDataReader

# Frames hold float32: 24 bits, relative to the value. Offsets of centres are relative to the middle.
DIGITS = 6e-8


def read(path):
    reader = vtkXMLPolyDataReader()
    reader.SetFileName(str(path))
    reader.Update()
    return reader.GetOutput()


def fields(attributes):
    return {
        attributes.GetArrayName(k): vtk_to_numpy(attributes.GetArray(k))
        for k in range(attributes.GetNumberOfArrays())
    }


def close(found, expected, scale, what):
    error = np.max(np.abs(np.asarray(found) - np.asarray(expected)), initial=0.0)
    assert error <= DIGITS * scale, f"{what}: error {error:.3g}, allowed {DIGITS * scale:.3g}"
    print(f"{what}: error {error:.3g} of {scale:.3g}")


run = Path(sys.argv[1])
state = np.load(run / "final_state.npz")
history = list(csv.DictReader(open(run / "history.csv")))
last = history[-1]
increment = int(state["increment"])


def final(kind):
    return read(run / "vtk" / f"{kind}_{increment:06}.vtp")


# Series: every file is there, and times increase.
for kind in ["bodies", "contacts", "bonds", "walls", "cracks"]:
    sets = xml.parse(run / "vtk" / f"{kind}.pvd").getroot().findall("./Collection/DataSet")
    times = [float(entry.get("timestep")) for entry in sets]
    assert times == sorted(set(times)) and times[-1] == increment, times
    for entry, time in zip(sets, times):
        data = read(run / "vtk" / entry.get("file"))
        assert data.GetFieldData().GetArray("TimeValue").GetValue(0) == time
    print(f"{kind}: {len(times)} frames up to {times[-1]}")

# Bodies: 20 at random.
bodies = final("bodies")
of_bodies = fields(bodies.GetPointData())
points = vtk_to_numpy(bodies.GetPoints().GetData())
ids = state["particles.id"]
assert bodies.GetNumberOfPoints() == len(ids) and (of_bodies["id"] == ids).all()
rows = random.Random(1).sample(range(len(ids)), 20)
x = state["particles.position_m"]
size = np.ptp(x, axis=0).max()
close(points[rows, :2], x[rows], size, "centres")
assert (points[:, 2] == 0).all()
u = x - state["particles.origin_m"]
close(of_bodies["displacement_m"][rows, :2], u[rows], np.abs(u).max(), "displacements")
for name in ["radius_m", "rotation_rad"]:
    expected = state[f"particles.{name}"]
    close(of_bodies[name][rows], expected[rows], np.abs(expected).max(), name)

# Bonds: 20 at random, and how many hold.
bonds = final("bonds")
of_bonds = fields(bonds.GetCellData())
order = np.argsort(state["bonds.id"])
for name in ["id", "a", "b", "state"]:
    assert (of_bonds[name] == state[f"bonds.{name}"][order]).all(), name
intact = int((of_bonds["state"] == 0).sum())
broken = [int((of_bonds["state"] == mode).sum()) for mode in (1, 2, 3)]
named = ["broken_tension", "broken_shear", "broken_rolling"]
assert [intact, *broken] == [int(last[name]) for name in ["bonds", *named]]
print(f"bonds: {intact} intact, {broken} broken, as in the history")
assert final("cracks").GetNumberOfLines() == sum(broken)
contacts = final("contacts")
of_contacts = fields(contacts.GetCellData())
p = {(a, b): p for a, b, p in zip(state["contacts.a"], state["contacts.b"], state["contacts.p_n"])}
pairs = list(zip(of_contacts["a"], of_contacts["b"]))
largest = max(abs(force) for force in p.values())
for row in random.Random(2).sample(range(len(pairs)), 20):
    close(of_contacts["p_n"][row], p[pairs[row]], largest, f"force of pair {pairs[row]}")

# Forces on walls: the sum over their contacts, and what the outside world exerts.
of_walls = fields(final("walls").GetCellData())
walls = dict(zip(state["walls.name"], state["walls.id"]))
for name, wall in walls.items():
    on = of_contacts["b"] == wall
    total = np.array([of_contacts[f"force_{axis}_n"][on].sum() for axis in "xy"])
    row = list(of_walls["id"]).index(wall)
    outside = np.array([of_walls[f"force_{axis}_n"][row] for axis in "xy"])
    scale = np.abs(of_contacts["p_n"][on]).sum()
    # The balance of a wall holds within the residual of the increment, 1e-8.
    error = np.abs(total + outside).max()
    assert error <= (DIGITS + 1e-7) * scale, f"{name}: {total} against {outside}"
    row_of_history = np.array([float(last[f"{name}.force_{axis}_n"]) for axis in "xy"])
    assert np.abs(total + row_of_history).max() <= (DIGITS + 1e-7) * scale, row_of_history
    print(f"wall {name}: contacts {total} N, history {row_of_history} N, error {error:.3g} N")
print("all agree")
