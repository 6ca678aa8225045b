"""Upper bound of limit analysis for a slope: a rigid mass turns on a logarithmic spiral through the toe.

The ground has a cohesion c and a friction angle phi, and its normality rule lets it move only on r = r_0
exp((theta - theta_0) tan phi). The work of the weight over the dissipation on the spiral gives the stability number
N_s = gamma H / c, which no slope exceeds (Chen, Limit Analysis and Soil Plasticity, 1975, chapter 9). A level crest
is at a height H above the toe.
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
    #: Angles (rad) from the horizontal line through the pole down to the crest and to the toe.
    start: float
    end: float
    #: Friction angle, rad.
    friction: float

    def points(self, height: float, toe: tuple[float, float]) -> Floats:
        """Points from the crest to the toe, m, shape (100, 2). The ground rises along +x."""
        theta = np.linspace(self.start, self.end, 100)
        radius = np.exp((theta - self.start) * np.tan(self.friction))
        x = np.stack([radius * np.cos(theta), -radius * np.sin(theta)], axis=1)
        return np.asarray(toe) + height * (x - x[-1]) / (x[0, 1] - x[-1, 1])


def log_spiral(angle: float, friction_angle: float) -> LogSpiral:
    """The spiral with the smallest stability number for a slope and a friction angle, both in degrees.

    A slope without friction that is flatter than 53 degrees slides below its toe, at N_s = 5.53: the spiral through
    the toe is then no least bound.

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

    def number(angles: np.ndarray) -> np.ndarray:
        start, end = angles
        growth = np.exp((end - start) * tan)
        height = growth * np.sin(end) - np.sin(start)
        crest = np.cos(start) - growth * np.cos(end) - height / np.tan(slope)
        at = lambda theta: 3.0 * tan * np.cos(theta) + np.sin(theta)
        sector = (growth**3 * at(end) - at(start)) / (3.0 * (1.0 + 9.0 * tan**2))
        above = crest * (2.0 * np.cos(start) - crest) * np.sin(start) / 6.0
        before = growth * (np.sin(end - start) - crest * np.sin(end)) / 6.0
        before = before * (np.cos(start) - crest + growth * np.cos(end))
        weight = sector - above - before
        found = (
            height
            * np.expm1(2.0 * (end - start) * tan)
            / (2.0 * tan * np.where(weight > 0.0, weight, np.nan))
        )
        return np.where((height > 0.0) & (crest > 0.0) & (end > start) & (found > 0.0), found, 1e30)

    grid = np.radians(np.meshgrid(np.arange(1.0, 90.0), np.arange(2.0, 180.0))).reshape(2, -1)
    best = grid[:, np.argmin(number(grid))]
    least = minimize(number, best, method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-9})
    return LogSpiral(float(least.fun), *map(float, least.x), float(friction))


def critical_factor(
    of: str, angle: float, friction_angle: float, cohesion: float, weight: float
) -> tuple[float, LogSpiral]:
    """Upper bound of the factor on gravity, or on strength, at which a slope slides, and its spiral.

    On gravity it is N_s(phi) c / (gamma H). On strength it is the F by which cohesion and tan phi are divided, so that
    N_s(phi_F) c / F = gamma H. ``weight`` is gamma H, Pa; angles are in degrees.
    """
    from scipy.optimize import brentq

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
