"""What is run: the settings of every rig for three seeds and a changed geometry."""

import math
import random
import re

import runs

SEEDS = (101, 202, 303)


class Variant:
    """A run of a scene that ships, under settings."""

    def __init__(self, scene, name, sets, interrupt=False, ends="completed", **values):
        self.of, self.name, self.settings = scene, name, sets
        self.interrupt, self.ends, self.values = interrupt, ends, values

    def scene(self, _out):
        return runs.ROOT / f"scenes/{self.of}.ron"

    def sets(self, out):
        return [text.replace("OUT", str(out)) for text in self.settings]


class Drum(Variant):
    """The small drum with other grains: drawn like those of the scene, on a loose grid."""

    def scene(self, out):
        text = super().scene(out).read_text()
        ring = [l for l in text.splitlines() if 'group: "drum"' in l]
        of_grains = r"(?m)^        \(position: \([^)]*\), radius: [^,]*\),\n"
        places = re.findall(r"position: \(([-\d.]+), ([-\d.]+)\), radius: ([\d.]+)\)", text)
        draw = random.Random(self.values["seed"])
        size = self.values.get("size", 1.0)
        grains = []
        for x, y, _ in places:
            r = size * draw.uniform(3.0e-3, 4.5e-3)
            shake = [draw.uniform(-0.4e-3, 0.4e-3) for _ in range(2)]
            grains.append(f"        (position: ({float(x) + shake[0]:.6f}, {float(y) + shake[1]:.6f}), radius: {r:.6f}),")
        head, tail = re.sub(of_grains, "", text).split(ring[-1])
        path = out / f"{self.name}.ron"
        path.write_text(head + ring[-1] + "\n" + "\n".join(grains) + tail)
        return path


def three(scene, sets, geometry, make=Variant, **values):
    """Three seeds, and a fourth one with another geometry, which is interrupted."""
    seeds = [make(scene, f"seed {s}", [t.replace("SEED", str(s)) for t in sets], seed=s, **values) for s in SEEDS]
    more, of_geometry = geometry
    sets = [t.replace("SEED", "404") for t in sets] + more
    changed = {**values, **of_geometry}
    return [*seeds, make(scene, "geometry", sets, interrupt=True, seed=404, **changed)]


def wall(name, start=None, end=None):
    ends = (("start", start), ("end", end))
    return [f"walls.{name}.{which}=({at[0]!r}, {at[1]!r})" for which, at in ends if at]


def box(width, height, names=("bottom", "top", "left", "right")):
    bottom, top, left, right = names
    return [
        *wall(bottom, end=(width, 0.0)), *wall(top, (width, height), (0.0, height)),
        *wall(left, start=(0.0, height)), *wall(right, (width, 0.0), (width, height)),
    ]


PACKED = ["specimen.seed=SEED", "stages.compact.seed=SEED"]
LET = ["let.seed=SEED"]
CELL = [*PACKED]
BEAM = 81
BEAM_SETS = [
    f"specimen.columns={BEAM}",
    f'probes={{"left": {4 * BEAM - 2 + 4}, "middle": {4 * BEAM - 2 + BEAM // 2}, "right": {4 * BEAM - 2 + BEAM - 5}}}',
    *wall("right_support", (2e-3 * (BEAM - 5) - 0.5e-3, -1e-3), (2e-3 * (BEAM - 5) + 0.5e-3, -1e-3)),
    *wall("press", (2e-3 * (BEAM // 2) + 0.5e-3, 14.85640646055102e-3), (2e-3 * (BEAM // 2) - 0.5e-3, 14.85640646055102e-3)),
]
LAYER = [
    "specimen=Particles([%s])" % ", ".join(
        f"(position: ({0.005 + 0.01 * x:.3f}, {0.005 + 0.01 * y:.3f}), radius: 0.005)" for y in range(6) for x in range(3)
    ),
    *box(0.03, 0.06, ("bottom", "lid", "left", "right")),
    "measures.axial_stress.of.length=Fixed(0.03)",
    "reference_stage=\"load.1\"",
]

RIGS = {
    "unload_reload": [
        Variant("unload_reload", "3 MN/m", ["let.stiffness=3.0e6"], stiffness=3e6, columns=4, rows=4),
        Variant("unload_reload", "40 MN/m", ["let.stiffness=4.0e7", "let.step=0.25e-5"], stiffness=4e7, columns=4, rows=4),
        Variant("unload_reload", "to 7 kPa", ["let.top=7.0e3"], stiffness=1e7, columns=4, rows=4),
        Variant("unload_reload", "geometry", LAYER, True, stiffness=1e7, columns=3, rows=6),
    ],
    "isotropic_compression": three(
        "isotropic_compression", PACKED,
        (["specimen.columns=14", "specimen.count=98", *box(0.1444, 0.0737)], {}),
    ),
    "oedometer": three(
        "oedometer", LET,
        (["specimen.columns=25", "specimen.count=250", *box(0.2545, 0.102, ("bottom", "lid", "left", "right")),
          "measures.axial_stress.of.length=Fixed(0.2545)"], {}),
    ),
    "three_point_bending": three(
        "three_point_bending", ["materials.rock.bond.scatter=(seed: SEED, tensile_strength: Weibull(modulus: 10.0))"],
        (BEAM_SETS, {"columns": BEAM}), columns=61,
    ),
    "direct_tension": three(
        "direct_tension", LET,
        (["stages.cut.select=Except(All, Box(min: (0.8e-3, 0.8e-3), max: (10.4e-3, 28.0e-3)))",
          *wall("bottom", end=(10.4e-3, 0.8e-3)), *wall("top", start=(10.4e-3, 28.0e-3)),
          "measures.axial_stress.of.length=Fixed(9.6e-3)"], {}),
    ),
    "brazilian": three(
        "brazilian", [*LET, 'walls.low_jaw.probe="low"', 'walls.high_jaw.probe="high"'],
        # A radius of 9 mm.
        (["stages.cut.select=Except(All, Intersection([Circle(centre: (11.0e-3, 11.0e-3), radius: 9.0e-3), "
          "Layer(normal: (0.0, 1.0), from: 2.1367e-3, to: 19.8633e-3)]))",
          *wall("low_jaw", (9.4372e-3, 1.0e-3), (12.5628e-3, 1.0e-3)),
          *wall("high_jaw", (12.5628e-3, 21.0e-3), (9.4372e-3, 21.0e-3)),
          "measures.axial_stress.of.length=Fixed(29.32e-3)"], {}),
    ),
    "shear_box": three(
        "shear_box", PACKED,
        (["specimen.count=300", *wall("lid", (0.204, 0.153), (0.0, 0.153)), *wall("high_left", start=(0.0, 0.17)),
          *wall("high_right", end=(0.204, 0.17))], {}),
    ),
    "simple_shear_periodic": three(
        "simple_shear_periodic", CELL,
        (["specimen.columns=20", "specimen.count=200", "cell.size=(0.202, 0.101)"], {}),
    ),
    "simple_shear_periodic_undrained": three(
        "simple_shear_periodic_undrained", CELL,
        (["specimen.columns=20", "specimen.count=200", "cell.size=(0.202, 0.101)"], {}),
    ),
    "prepare_and_branch": [
        v for s, more in [(101, []), (202, []), (303, []), (404, [
            "specimen.columns=14", "specimen.count=210", *box(0.141, 0.152)])]
        for name in ["geometry" if more else f"seed {s}"]
        for v in [
            Variant("prepare_and_branch", name, [f"specimen.seed={s}", f"stages.compact.seed={s}", *more], bool(more)),
            *[Variant(f"prepare_and_branch_{p}kPa", f"{name}, {p} kPa",
                      [f'specimen.path="OUT/{name}/state_packing.npz"'], bool(more) and p == 100, pressure=1e3 * p)
              for p in (50, 100, 200)],
        ]
    ],
    "retaining_wall": three(
        "retaining_wall", LET,
        (["specimen.columns=30", *wall("floor", end=(0.363, 0.0)), *wall("top", start=(0.363, 0.146)),
          *wall("wall", (0.363, 0.0), (0.363, 0.146))], {"width": 0.363}), width=0.3025,
    ),
    "rotating_drum": three(
        "rotating_drum_small", ["output.frames_every=20"],
        (['stages.turn.rigid.drum.rotation=Velocity(0.6)'], {"size": 0.9, "rate": 0.6}), make=Drum, rate=1.0,
    ),
    "angle_of_repose": three(
        "angle_of_repose", ["specimen.seed=SEED"],
        (["specimen.columns=10", "specimen.origin=(-62.5e-3, 0.0)", *wall("left", (-0.0675, 0.5), (-0.0675, 0.0)),
          *wall("right", (0.0675, 0.0), (0.0675, 0.5))], {}),
    ),
    "hopper": three(
        "hopper", ["specimen.seed=SEED", "output.frames_every=20"],
        ([*wall("left", end=(-0.045, 0.0)), *wall("right", start=(0.045, 0.0))], {"outlet": 0.09}), outlet=0.07,
    ),
}
