"""Strength reduction of a slope: by what factor may all strengths fall before it slides?"""

from pathlib import Path

import numpy as np

import clastic

STEP = 1.02  # Each increment divides cohesion, tensile strength and friction by this.
SLIDES = 0.1  # A motion of a grain that is a slide and no elastic deformation, m.

sim = clastic.Simulation(Path(__file__).with_name("slope.ron"))
while (row := sim.step())["stage"] == "weight":
    rest = sim.positions
while np.abs(sim.positions - rest).max() < SLIDES and row["status"] != "collapsed":
    # While bonds break at constant load (fraction 0), the strength waits.
    sim.strength /= STEP if row["fraction"] == 1.0 else 1.0
    row = sim.step()

factor = 1.0 / sim.strength
broken = row["broken_tension"] + row["broken_shear"]
print(f"It slides at a factor of {factor:.2f}, with {broken} of {broken + row['bonds']} bonds broken.")
