"""Modulus and damping of cyclic tests, loop by loop.

A loop lies between one turning point of the strain and the next one but one. With the range of its
strain and that of the stress between these turning points, its secant modulus and damping ratio are

    E = stress range / strain range,   D = dW / (4 pi W),   W = stress range * strain range / 8

where dW is the area of the loop and W the elastic energy of a spring of that modulus at the amplitude
(ASTM D3999). Both are per unit volume of the specimen.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .results import Run

if TYPE_CHECKING:
    import pandas

#: Part of the range of the strain by which it must go back to turn.
TURNED = 0.02


def loops(run: Run, strain: str = "axial_strain", stress: str = "axial_stress_pa") -> pandas.DataFrame:
    """Loops of a run, in order: ``begin`` and ``end`` (increments), ``modulus_pa``, ``damping``,
    ``strain_range``, ``stress_range_pa`` and ``loss_j_m3`` (dW). The way to the first turning point is in
    none, and a last loop that does not come back within 2 % of its range either. Other columns of the
    history, such as those of a shear, serve as ``strain`` and ``stress``.

    Raises
    ------
    ValueError
        If the strain turns less than three times, its end counted.
    """
    import pandas

    rows = run.history.dropna(subset=[strain, stress])
    x, y = rows[strain].to_numpy(), rows[stress].to_numpy()
    turns = _closed(x, y, _turns(x))
    if len(turns) < 3:
        raise ValueError(f"{run.path}: no loop: {strain} turns {len(turns)} times, its end counted")
    table = []
    for begin, middle, end in zip(turns[:-2:2], turns[1:-1:2], turns[2::2], strict=True):
        # A chord closes the loop, so that its area does not depend on the origin.
        a, b = x[begin : end + 1] - x[begin], y[begin : end + 1] - y[begin]
        loss = abs(np.dot(a, np.roll(b, -1)) - np.dot(b, np.roll(a, -1))) / 2.0
        strains = abs((x[begin] + x[end]) / 2.0 - x[middle])
        stresses = abs((y[begin] + y[end]) / 2.0 - y[middle])
        increments = rows["increment"].iloc[[begin, end]]
        damping = loss / (np.pi / 2.0 * strains * stresses)
        table.append([*increments, stresses / strains, damping, strains, stresses, loss])
    names = ["begin", "end", "modulus_pa", "damping", "strain_range", "stress_range_pa", "loss_j_m3"]
    return pandas.DataFrame(table, columns=names)


def _closed(x: np.ndarray, y: np.ndarray, turns: list[int]) -> list[int]:
    """The turning points, the last loop ending where strain or stress comes back to that at its begin."""
    if len(turns) < 3 or len(turns) % 2 == 0:
        return turns
    begin, middle, last = turns[-3:]
    for of in (x, y):
        away = np.abs(of[middle : last + 1] - of[begin])
        if away.min() <= TURNED * away[0]:
            return [*turns[:-1], middle + int(away.argmin())]
    return turns[:-1]


def _turns(x: np.ndarray) -> list[int]:
    """Rows at which a signal turns by more than TURNED of its range, and the extreme it ends with."""
    turns: list[int] = []
    way, last = 0.0, 0
    for k in range(len(x)):
        if way == 0.0 or (x[k] - x[last]) * way > 0.0:
            way = way or float(np.sign(x[k] - x[last]))
            last = k
        elif abs(x[k] - x[last]) > TURNED * np.ptp(x):
            turns.append(last)
            way, last = -way, k
    return [*turns, last]
