"""Strength over confining stress: Mohr-Coulomb and Hoek-Brown, by least squares of sigma_1."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

#: Confining stress and peak, Pa, compression positive.
Strengths = Sequence[tuple[float, float]]


def _line(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """Value at 0 and slope of the least-squares line."""
    apart = x - x.mean()
    if not apart.any():
        raise ValueError("peaks at two confining stresses are needed")
    slope = apart @ (y - y.mean()) / (apart @ apart)
    return float(y.mean() - slope * x.mean()), float(slope)


def mohr_coulomb(strengths: Strengths) -> tuple[float, float]:
    """Cohesion c (Pa) and friction angle (degrees) of ``sigma_1 = 2 c sqrt(N) + N sigma_3`` with
    ``N = (1 + sin phi)/(1 - sin phi)``.

    Raises
    ------
    ValueError
        If there is one confining stress, or N < 1, which belongs to no friction angle.
    """
    start, slope = _line(*np.transpose(strengths))
    if slope < 1.0:
        raise ValueError("sigma_1 rises less than sigma_3")
    angle = float(np.degrees(np.arcsin((slope - 1.0) / (slope + 1.0))))
    return 0.5 * start / slope**0.5, angle


def hoek_brown(strengths: Strengths) -> tuple[float, float]:
    """sigma_ci (Pa) and m_i of ``(sigma_1 - sigma_3)^2 = sigma_ci^2 + m_i sigma_ci sigma_3``, as Hoek and Brown
    (1980, with s = 1 and a = 1/2) fit triaxial tests.

    Raises
    ------
    ValueError
        If there is one confining stress, or the line has no positive value at sigma_3 = 0, as that of most soils.
    """
    confining, peak = np.transpose(strengths)
    square, slope = _line(confining, (peak - confining) ** 2)
    if square <= 0.0:
        raise ValueError("no sigma_ci: the fitted line has no strength at sigma_3 = 0")
    return square**0.5, slope / square**0.5
