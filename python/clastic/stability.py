"""Is a slope stable? The factor at which it slides, beside the bound of limit analysis for its own ground.

Both sides of the comparison come from one packing, since strengths of blocks scatter by a fifth. A slope of a packing
(seed) and a cut (place of the toe) is loaded by a static ramp of events up to a collapse. Its certificate says that no
equilibrium is there, not how much moves: it may be a grain that rolls off. What happens then is followed with inertia,
at the same load. It is a slide if the share of the mass moves by the distance that the scene states; if the rest
stands, the ramp goes on.
"""

from __future__ import annotations

import os
import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from ._folders import Folders
from ._ramp import STEP, Ramp, ended_well
from ._scene import Scene, Settings, _nested
from .log_spiral import LogSpiral, critical_factor
from .results import Run
from .targets import cohesion, friction_angle

if TYPE_CHECKING:
    import pandas

Place = tuple[float, float]


@dataclass
class Stability:
    """Result of :func:`stability`."""

    #: What was scaled: ``gravity`` or ``strength``.
    of: str
    #: Height (m) and angle (degrees) of the slope.
    height: float
    angle: float
    #: A row for each slope: seed, toe (m), factor (infinite where it stands at the last one), share of the mass that
    #: moves, directory.
    slides: pandas.DataFrame
    #: A row for each place of a block: seed, place, strength (Pa) by confining stress, cohesion (Pa), friction angle
    #: (degrees).
    blocks: pandas.DataFrame
    #: Mean factor of the slopes and its standard deviation (n - 1).
    factor: float
    deviation: float
    #: Unit weight, N/m^3; cohesion (Pa) and friction angle (degrees) of all blocks by one line.
    unit_weight: float
    cohesion: float
    friction_angle: float
    #: Upper bound of the factor, and its mechanism.
    bound: float
    mechanism: LogSpiral
    #: All runs.
    runs: pandas.DataFrame

    @property
    def ratio(self) -> float:
        """Factor over its bound."""
        return self.factor / self.bound


def stability(
    slope: Scene | tuple[Scene, Settings] = "slope",
    block: Scene | tuple[Scene, Settings] = "slope_block",
    *,
    of: str = "gravity",
    height: float = 4.0,
    angle: float = 60.0,
    gravity: float = 9.81,
    seeds: Sequence[int] = (1, 2, 3),
    toes: Sequence[Place] = ((1.3, 1.0), (2.0, 1.0), (2.7, 1.0)),
    places: Sequence[Place] = ((0.1, 0.15), (2.8, 0.15), (5.5, 0.15)),
    confining: Sequence[float] = (0.0, 0.25, 0.5),
    most: float = 8.0,
    out: str | os.PathLike[str] = "runs/stability",
    jobs: int | None = None,
) -> Stability:
    """Finds the factor on gravity, or the reduction of strength, at which slopes slide, and the upper bound of the
    log-spiral mechanism with the cohesion and the friction angle of blocks of the same ground.

    The factor of one packing and one cut may be off by 40 %. With 20 disks over the height the mean of nine slopes has a
    standard error of 7 %.

    Parameters
    ----------
    slope
        Scene of the slope, or a pair with settings. It has the values ``height``, ``angle``, ``gravity``, ``toe_x``,
        ``toe_y``, ``seed`` and ``share`` in ``let``, a stage ``Save`` named ``ground`` behind its cement, a measure
        ``sliding``, a ``reference_stage``, and a last stage ``ramp``. The ground rises along +x.
    block
        Scene of a compression test of a block from a state, with ``x``, ``y`` and ``confining`` in ``let``.
    of
        ``gravity`` or ``strength``, which divides cohesion, tensile strength and all friction.
    height, angle, gravity
        Of the slope: m, degrees, m/s^2.
    seeds, toes
        Packings, and the cuts of each by the place of the toe, m.
    places
        Lower left corners of the blocks of each packing, m.
    confining
        Confining stresses of the blocks over gamma H times the mean factor, which is the stress at the slide.
    most
        Largest factor.
    out, jobs
        Directory of the runs, which are not repeated, and their maximum number at a time.

    Raises
    ------
    ValueError
        If a run failed or a slope slides under its own weight; if grains fall without end; if a block does not yield,
        or the blocks give no line with a cohesion.
    """
    import pandas

    if of not in ("gravity", "strength"):
        raise ValueError(f"of is {of!r}; give 'gravity' or 'strength'")
    if not (most > STEP and height > 0.0 and gravity > 0.0):
        raise ValueError(
            f"most is {most!r}, height {height!r}, gravity {gravity!r}: give a factor above {STEP}, and "
            "positive values"
        )
    folders, ramp = Folders(out, jobs), Ramp(of, most, height, gravity)
    pairs = (scene if isinstance(scene, tuple) else (scene, {}) for scene in (slope, block))
    (slope, slope_sets), (block, block_sets) = pairs
    shape = {"let.height": height, "let.angle": angle, "let.gravity": gravity, "output.plots": False}
    shape |= {"stages.ramp.increments": len(ramp.ends(0.0)) - 1, "stages.ramp.scale": ramp.table(0.0)}
    # The ramp adds up the fractions of all increments.
    shape |= {"stages.ramp.record.every": 1}

    def run(row: dict[str, Any], scene: Scene, sets: Settings) -> Run:
        return folders.run(row, scene, sets, ["peak_stress_pa"]) or Run(row["directory"])

    def slid(work: tuple[int, Place]) -> dict[str, Any]:
        seed, (x, y) = work
        row = {"seed": seed, "toe": (x, y)}
        sets = {**slope_sets, **shape, "let.toe_x": x, "let.toe_y": y, "let.seed": seed}
        found = run({"test": "slope", **row}, slope, sets)
        ended_well(found)
        first = next((s["stage"] for s in found.record["stages"] if s["ended_by"] == "collapse"), "ramp")
        # A slide that came to rest has not collapsed.
        first = _slid_before_ramp(found.history, _let(found, "share")) or first
        if first != "ramp":
            raise ValueError(
                f"{found.path}: it slides in stage {first}, before the ramp: give it more cohesion"
            )
        factor, found = ramp.follow(found)
        share = float(found.history["sliding"].iloc[-1])
        return {**row, "factor": factor, "share": share, "directory": str(found.path)}

    slides = folders.map(slid, product(seeds, toes))
    factors = np.array([row["factor"] for row in slides])
    factor = float(factors.mean())
    unit_weight = float(np.mean([_unit_weight(Run(row["directory"]), gravity) for row in slides]))
    # Of slopes that stand: the stress at the end of the ramp.
    stress = unit_weight * height * min(factor, most)
    grounds = {row["seed"]: f"{row['directory']}/state_ground.npz" for row in slides}

    def compressed(work: tuple[int, Place, float]) -> Run:
        seed, (x, y), part = work
        sets = {**block_sets, "let.x": x, "let.y": y, "let.confining": part * stress, "output.plots": False}
        sets["specimen.path"] = _nested(grounds[seed])
        found = run({"test": "block", "seed": seed, "place": (x, y)}, block, sets)
        if found.results["strength_pa"] is None:
            raise ValueError(
                f"{found.path}: {found.status}, and the block has not yielded: give it more increments"
            )
        return found

    tests = folders.map(compressed, product(seeds, places, confining))
    blocks = []
    for k, (seed, place) in enumerate(product(seeds, places)):
        group = tests[k * len(confining) : (k + 1) * len(confining)]
        strengths = {
            f"strength_{part:g}_pa": t.results["peak_stress_pa"] for part, t in zip(confining, group)
        }
        line = {"cohesion_pa": cohesion(*group), "friction_angle": friction_angle(*group)}
        blocks.append({"seed": seed, "place": place, **strengths, **line})
    c, phi = cohesion(*tests), friction_angle(*tests)
    bound, mechanism = critical_factor(of, angle, phi, c, unit_weight * height)
    return Stability(
        of=of,
        height=height,
        angle=angle,
        slides=pandas.DataFrame(slides),
        blocks=pandas.DataFrame(blocks),
        factor=factor,
        deviation=float(factors.std(ddof=1)) if len(factors) > 1 and np.isfinite(factor) else np.nan,
        unit_weight=unit_weight,
        cohesion=c,
        friction_angle=phi,
        bound=bound,
        mechanism=mechanism,
        runs=pandas.DataFrame(folders.rows.values()),
    )


def _slid_before_ramp(history: pandas.DataFrame, share: float) -> str | None:
    """First stage before the ramp in which so much has slid. Slides that the ramp began are stages after it."""
    before = history[(history["stage"] == "ramp").cumsum() == 0]
    far = before[before["sliding"] >= share]
    return str(far["stage"].iloc[0]) if len(far) else None


def _let(run: Run, name: str) -> float:
    """A number of ``let`` of the scene of a run."""
    found = re.search(rf'"{name}":\s*([^,\s)}}]+)', (run.path / "scene.ron").read_text())
    try:
        return float(found[1] if found else "")
    except ValueError:
        raise ValueError(f"{run.path}: its scene has no number `{name}` in `let`") from None


def _unit_weight(run: Run, gravity: float) -> float:
    """Unit weight (N/m^3) of the ground, by the mass of its disks and its porosity."""
    state = run.state("ground")
    area = np.pi * (state["particles.radius_m"] ** 2).sum() * float(state["thickness_m"])
    return float(state["particles.mass_kg"].sum()) / area * (1.0 - run.results["porosity"]) * gravity
