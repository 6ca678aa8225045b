"""The ramp that brings a slope to its slide, and what happens in a collapse."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ._scene import _nested
from .results import Run
from .run import check, resume

#: Ratio of the factors of two increments.
STEP = 1.03
#: Least part of an increment by which the load of a collapse is above that of the last equilibrium: twice the shortest.
BEYOND = 1.0 / 32.0
#: Longest time that a collapse is followed, over sqrt(H/g) with the gravity that acts: 26 slides of `slope` took at most 1.1.
FOLLOWED = 3.0
#: Time step over sqrt(H/g): half of it and its double find the same factors of three slopes.
TIME_STEP = 0.004
#: Speed of rest over sqrt(g H): half of it and its double find the same factors of three slopes; ten times takes the first
#: steps of a slide for rest.
REST = 1e-3


@dataclass
class Ramp:
    """A ramp of the factor from 1 to ``most``; parts of it are 0 to 1."""

    of: str
    most: float
    height: float
    gravity: float

    def value(self, part: np.ndarray | float) -> np.ndarray | float:
        """Multiplier of gravity or strength."""
        return self.most ** (part if self.of == "gravity" else -part)

    def ends(self, start: float) -> np.ndarray:
        """Ends of the increments of a stage that begins at a part."""
        increments = (1.0 - start) * np.log(self.most) / np.log(STEP)
        return np.linspace(start, 1.0, int(np.ceil(increments)) + 1)

    def table(self, start: float) -> str:
        """Field `scale` of such a stage."""
        ends = self.ends(start)
        points = zip(np.linspace(0.0, 1.0, len(ends)), self.value(ends))
        return f"({self.of}: {_nested([(float(s), float(f)) for s, f in points])})"

    def follow(self, run: Run) -> tuple[float, Run]:
        """Factor of the slide, infinite without one, and the run with the stages that this took."""
        name, part, passes = "ramp", 0.0, 0
        while True:
            rows, ends = run.history, self.ends(part)
            rows, increment = rows[rows["stage"] == name], ends[1] - ends[0]
            collapsed = rows["status"] == "collapsed"
            part += float(rows["fraction"][~collapsed].sum()) * increment
            ended = _ended_by(run, name)
            if ended == "collapse":
                passes += 1
                # The load that was tried has no equilibrium.
                part += max(float(rows["fraction"][collapsed].max()), BEYOND) * increment
            part = min(part, 1.0)
            value = float(np.interp(part, ends, self.value(ends)))
            if ended == "collapse":
                run = self.extend(run, f"slide_{passes}", self.slide(value))
                ended = _ended_by(run, f"slide_{passes}")
                if ended not in ("Above", "Rest"):
                    raise ValueError(
                        f"{run.path}: slide_{passes} ended by {ended} after {FOLLOWED:g} sqrt(H/g), and grains still move: "
                        "add walls that stop loose grains"
                    )
            if ended == "Above":
                return (value if self.of == "gravity" else 1.0 / value), run
            if part > 1.0 - 1e-9:
                return np.inf, run
            name, increments = f"ramp_{passes}", len(self.ends(part)) - 1
            run = self.extend(run, name, f"increments: {increments}, {_loads(self.table(part))}")

    def slide(self, value: float) -> str:
        """Fields of the stage that follows a collapse at a multiplier."""
        time = float(np.sqrt(self.height / (self.gravity * (value if self.of == "gravity" else 1.0))))
        loads = _loads(
            f"({self.of}: [(0.0, {value!r}), (1.0, {value!r})])", f"Rest({REST * self.height / time!r})"
        )
        increments = round(FOLLOWED / TIME_STEP)
        return f"increments: {increments}, analysis: Dynamic(dt: {TIME_STEP * time!r}), {loads}"

    @staticmethod
    def extend(run: Run, name: str, fields: str) -> Run:
        """The run with another stage, unless it has that already."""
        stages = [s["stage"] for s in run.record["stages"]]
        if name not in stages:
            stage = {f"stages[{len(stages)}]": f'Load(name: "{name}", {fields})'}
            longer = run.path / "longer.ron"
            longer.write_text(check(run.path / "scene.ron", stage)["text"])
            run = resume(run.path, scene=longer, progress=False)
            longer.unlink()
        ended_well(run)
        return run


def _loads(scale: str, *stops: str) -> str:
    """Loads of a slope, and when a stage ends, in the names of its scene."""
    stop = ", ".join(['Above("sliding", share)', *stops])
    return f"gravity: (0.0, -gravity), scale: {scale}, stop: [{stop}]"


def ended_well(run: Run) -> None:
    """Raises ValueError if a run cannot be read."""
    if run.status not in ("completed", "collapsed"):
        raise ValueError(f"{run.path}: {run.status}: {run.record['outcome']['message']}")


def _ended_by(run: Run, stage: str) -> str:
    """How a stage ended; of a stop the name of the condition."""
    record = next(s for s in run.record["stages"] if s["stage"] == stage)
    return record["ended_by"] if record["ended_by"] != "stop" else next(iter(record["stop"]))
