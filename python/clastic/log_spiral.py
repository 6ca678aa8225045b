"""Upper bound of limit analysis for a slope: a rigid mass turns on a logarithmic spiral through the toe or below it.

The ground has a cohesion c and a friction angle phi, and its normality rule lets it move only on r = r_0
exp((theta - theta_0) tan phi). The work of the weight over the dissipation on the spiral gives the stability number
N_s = gamma H / c, which no slope exceeds (Chen, Limit Analysis and Soil Plasticity, 1975, chapter 9). A level crest
is at a height H above the toe, and level ground in front of the toe.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .frame import Floats


@dataclass(frozen=True)
class LogSpiral:
    """Spiral with the smallest stability number."""

    #: N_s = gamma H / c, with gamma the unit weight (N/m^3).
    number: float
    #: Angles (rad) from the horizontal line through the pole down to the crest and to the lower end.
    start: float
    end: float
    #: Distance of the lower end in front of the toe, over H.
    front: float
    #: Friction angle, rad.
    friction: float

    def points(self, height: float, toe: tuple[float, float]) -> Floats:
        """Points from the crest to the lower end, m, shape (100, 2). The ground rises along +x."""
        theta = np.linspace(self.start, self.end, 100)
        radius = np.exp((theta - self.start) * np.tan(self.friction))
        x = np.stack([radius * np.cos(theta), -radius * np.sin(theta)], axis=1)
        return np.asarray(toe) - (height * self.front, 0.0) + height * (x - x[-1]) / (x[0, 1] - x[-1, 1])


def log_spiral(angle: float, friction_angle: float) -> LogSpiral:
    """The spiral with the smallest stability number for a slope and a friction angle, both in degrees.

    A flat slope with little friction slides below its toe. Without friction and below 53 degrees the spiral grows
    without end, towards N_s = 5.52. A floor that the spiral would cut forbids it, and the slope then bears more.

    Raises
    ------
    ValueError
        If the slope is not between the friction angle and 90 degrees: one that is flatter stands at any height.
    """
    from scipy.optimize import minimize

    if not 0.0 <= friction_angle < angle <= 90.0:
        raise ValueError(
            f"a slope of {angle:g} degrees with a friction angle of {friction_angle:g}: give a slope up to 90 degrees "
            "that is steeper than the friction angle, which is at least 0"
        )
    slope, friction = np.radians([angle, friction_angle])
    tan = max(np.tan(friction), 1e-9)

    def number(unknowns: np.ndarray) -> np.ndarray:
        start, end, root = unknowns
        front = root**2
        growth = np.exp((end - start) * tan)
        height = growth * np.sin(end) - np.sin(start)
        face = 1.0 / np.tan(slope)
        crest = np.cos(start) - growth * np.cos(end) - height * (face + front)
        at = lambda theta: 3.0 * tan * np.cos(theta) + np.sin(theta)
        sector = (growth**3 * at(end) - at(start)) / (3.0 * (1.0 + 9.0 * tan**2))
        above = crest * (2.0 * np.cos(start) - crest) * np.sin(start) / 6.0
        before = growth * (np.sin(end - start) - crest * np.sin(end)) / 6.0
        before = before * (np.cos(start) - crest + growth * np.cos(end))
        # Between the face and the line from the lower end to the crest there is no ground.
        empty = np.cos(start) - crest - height * (2.0 * face + front) / 3.0
        weight = sector - above - before - front * height**2 * empty / 2.0
        found = (
            height
            * np.expm1(2.0 * (end - start) * tan)
            / (2.0 * tan * np.where(weight > 0.0, weight, np.nan))
        )
        # A spiral that is not below the toe cuts the face.
        toe = growth * np.cos(end) + height * front, growth * np.sin(end)
        below = np.exp((np.arctan2(*toe[::-1]) - start) * tan) > (1.0 - 1e-6) * np.hypot(*toe)
        # The weight of a spiral that turns less is lost in rounding.
        turns = (start < 0.5 * np.pi) & (end > start + 1e-3) & (end < np.pi)
        return np.where((height > 0.0) & (crest > 0.0) & below & turns & (found > 0.0), found, 1e30)

    angles = np.radians(np.arange(1.0, 90.0, 2.0)), np.radians(np.arange(2.0, 180.0, 2.0))
    grid = np.reshape(np.meshgrid(*angles, np.arange(0.0, 3.0, 0.5)), (3, -1))
    best = grid[:, np.argmin(number(grid))]
    least = minimize(number, best, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-9})
    start, end, root = map(float, least.x)
    return LogSpiral(float(least.fun), start, end, root**2, float(friction))


def critical_factor(
    of: str, angle: float, friction_angle: float, cohesion: float, weight: float
) -> tuple[float, LogSpiral]:
    """Upper bound of the factor on gravity, or on strength, at which a slope slides, and its spiral.

    On gravity it is N_s(phi) c / (gamma H). On strength it is the F by which cohesion and tan phi are divided, so that
    N_s(phi_F) c / F = gamma H. ``weight`` is gamma H, Pa; angles are in degrees.

    Raises
    ------
    ValueError
        As :func:`log_spiral`, or if the cohesion or the weight is not positive.
    """
    from scipy.optimize import brentq

    if not (cohesion > 0.0 and weight > 0.0):
        raise ValueError(
            f"a cohesion of {cohesion:g} Pa and gamma H of {weight:g} Pa: the bound takes positive ones. A line of blocks "
            "without cohesion needs more blocks, or smaller confining stresses"
        )
    if of == "gravity":
        spiral = log_spiral(angle, friction_angle)
        return spiral.number * cohesion / weight, spiral
    tan = np.tan(np.radians(friction_angle))
    reduced = lambda log: log_spiral(angle, np.degrees(np.arctan(tan / np.exp(log))))
    error = lambda log: np.log(reduced(log).number * cohesion / weight) - log
    # Below, the slope would be as flat as the friction angle.
    low = np.log(max(1.0001 * tan / np.tan(np.radians(angle)), 1e-6))
    log = float(brentq(error, low, np.log(1e6), xtol=1e-9))
    return float(np.exp(log)), reduced(log)
