"""Strength reduction of a slope: by what factor may all strengths fall before it slides?"""

from pathlib import Path

import numpy as np

import clastic

STEP = 1.02  # Each increment divides cohesion, tensile strength and friction by this.
SLIDES = 0.1  # A motion of a grain that is a slide and no elastic deformation, m.

sim = clastic.Simulation(Path(__file__).with_name("slope.ron"))
for row in sim:
    if row["stage"] == "weight":
        rest = sim.frame()
        continue
    moved = np.hypot(*sim.frame().moved(rest).T)
    if row["status"] == "collapsed" or moved.max() > SLIDES:
        break
    # While bonds break at constant load (fraction below 1), the strength waits.
    if row["fraction"] == 1.0:
        sim.strength /= STEP
else:
    raise SystemExit(f"It stands at a factor of {1.0 / sim.strength:.2f}: {sim.status}.")

factor = 1.0 / sim.strength
broken = row["broken_tension"] + row["broken_shear"]
print(f"It slides at a factor of {factor:.2f}, with {broken} of {broken + row['bonds']} bonds broken.")
clastic.figures.displacement(sim.frame(), since=rest, cracks=True).figure.savefig("slope.png")
