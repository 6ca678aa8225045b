"""Grains and bonds of a rock: E, Poisson's ratio, compressive and tensile strength within 5 %.

    python calibrate.py [granite | basalt | marble]

Tests are short where short ones suffice: modulus and Poisson's ratio need four increments.
"""

import sys
import time
from pathlib import Path

import clastic
from clastic import Parameter, Target

#: E (Pa), Poisson's ratio, compressive and tensile strength (Pa): about those of Forsmark granite and Carrara
#: marble, and of the basalt of Schultz, J. Geophys. Res. 98 (1993) 10883.
ROCKS = {
    "granite": (76e9, 0.23, 226e6, 13e6),
    "basalt": (73e9, 0.25, 262e6, 14e6),
    "marble": (49e9, 0.19, 84.6e6, 6.9e6),
}
SCENES = Path(__file__).parent
QUICK = {"output.plots": False}
STRENGTHS = ("compression", "tension")

name = sys.argv[1] if len(sys.argv) > 1 else "marble"
modulus, poisson, compressive, tensile = ROCKS[name]
start = time.perf_counter()
found = clastic.calibrate(
    {
        "elastic": (SCENES / "rock.ron", {"let.increments": 4, **QUICK}),
        "compression": (SCENES / "rock.ron", QUICK),
        "tension": (SCENES / "rock.ron", {"let.direction": -1, "let.strain": 0.02, **QUICK}),
    },
    [
        Target("elastic", "youngs_modulus_pa", modulus, "stiffness"),
        Target("elastic", "poissons_ratio", poisson),
        Target("compression", "strength_pa", compressive, "strength"),
        Target("tension", "strength_pa", -tensile, "strength"),
    ],
    [
        Parameter("stiffness", ["let.stiffness"], 5e10, "stiffness"),
        # Strengths have no influence on the elastic test, which is then not repeated for them.
        Parameter("tensile", {test: ["let.tensile"] for test in STRENGTHS}, 2e7, "strength"),
        Parameter("shear", ["let.shear"], 0.4, low=0.1, high=1.0),
        Parameter("cohesion", {test: ["let.cohesion"] for test in STRENGTHS}, 5.0, low=1.0, high=10.0),
    ],
    seeds=(1, 2),
    prepare=(SCENES / "rock_packing.ron", QUICK),
    tolerance=0.05,
    out=Path("runs", name),
)
print(found.targets.to_string(float_format="{:.4g}".format))
print(", ".join(f"{key} {value:.4g}" for key, value in found.parameters.items()))
print(f"{found.message}: {found.made} runs in {time.perf_counter() - start:.0f} s")
