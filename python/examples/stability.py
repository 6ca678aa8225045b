"""Is this slope stable? The factor on its weight, or on its strength, at which it slides, beside limit analysis.

    python stability.py [gravity | strength]

Three packings with three cuts each slide, and three blocks of each packing tell the cohesion and the friction angle
of the ground: a few minutes.
"""

import sys
from pathlib import Path

import clastic

of = sys.argv[1] if len(sys.argv) > 1 else "gravity"
found = clastic.stability(of=of, out=Path("runs", f"stability_{of}"))
print(found.slides[["seed", "toe", "factor", "share"]].to_string(float_format="{:.3g}".format))
print(found.blocks.to_string(float_format="{:.4g}".format))
print(
    f"gamma {found.unit_weight / 1e3:.1f} kN/m3, c {found.cohesion / 1e3:.1f} kPa, phi {found.friction_angle:.1f} degrees"
)
print(f"slide {found.factor:.2f} +- {found.deviation:.2f}, bound {found.bound:.2f}, ratio {found.ratio:.2f}")
clastic.figures.slide(found).figure.savefig("slide.png")
