"""Directories of runs."""

from __future__ import annotations

import io
import json
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _engine
from .frame import Frame

if TYPE_CHECKING:
    import pandas


class Run:
    """The directory of a run.

    Parameters
    ----------
    path
        A directory with a ``run.json``.

    Raises
    ------
    FileNotFoundError
        If no run is there.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.path = Path(path)
        file = self.path / "run.json"
        if not file.exists():
            raise FileNotFoundError(f"{self.path}: no run is here, since it has no run.json")
        #: Content of ``run.json``.
        self.record: dict[str, Any] = json.loads(file.read_text())

    def __repr__(self) -> str:
        return f"Run({str(self.path)!r}): {self.title}, {self.status}"

    @property
    def title(self) -> str:
        """Title of the scene."""
        return self.record["title"]

    @property
    def status(self) -> str:
        """``completed``, ``collapsed``, ``undecided``, ``refused``, ``interrupted``, or ``running``
        for a run that has not ended or was killed.
        """
        return self.record["outcome"]["status"]

    @property
    def results(self) -> dict[str, Any]:
        """Key results: None for those that the run does not define."""
        return {k: v for k, v in self.record["results"].items() if k != "not_defined"}

    @property
    def reasons(self) -> dict[str, str]:
        """Why key results are not defined, by their names."""
        return self.record["results"].get("not_defined", {})

    @property
    def marks(self) -> list[str]:
        """Reasons to doubt the run; empty for one that can be trusted."""
        return _engine.marks(self.path)

    def key_results(self) -> pandas.DataFrame:
        """Numbers among the key results, with the reasons where they are not defined."""
        import pandas

        numbers = {
            name: value
            for name, value in self.results.items()
            if name in self.reasons or (isinstance(value, (int, float)) and not isinstance(value, bool))
        }
        columns = {
            "value": [numbers[name] for name in numbers],
            "reason": [self.reasons.get(name, "") for name in numbers],
        }
        return pandas.DataFrame(columns, index=list(numbers))

    @property
    def history(self) -> pandas.DataFrame:
        """``history.csv``: one row per increment."""
        return self._table("history.csv")

    @property
    def events(self) -> pandas.DataFrame:
        """``events.csv``: one row per broken bond."""
        return self._table("events.csv")

    @property
    def avalanches(self) -> pandas.DataFrame:
        """``avalanches.csv``: bonds that broke at constant load, one row per avalanche."""
        return self._table("avalanches.csv")

    def _table(self, name: str) -> pandas.DataFrame:
        import pandas

        # Python reads numbers to the bit.
        table = pandas.read_csv(self.path / name, dtype=str, keep_default_na=False)
        return pandas.DataFrame({column: _numbers(table[column].to_numpy()) for column in table})

    def curve(self, column: str) -> np.ndarray:
        """A column of the history against the axial strain, shape (k, 2), from the initial state of
        the test on.
        """
        return _engine.curve(self.path, column)

    def peak_stresses(self) -> tuple[float, float]:
        """Lateral and axial stress (Pa) at the peak. Without a measured lateral stress it is 0.

        Raises
        ------
        ValueError
            If the peak is not defined.
        """
        peak = self.results["peak_stress_pa"]
        if peak is None:
            raise ValueError(f"{self.path}: no peak: {self.reasons.get('peak_stress_pa', 'not defined')}")
        rows = self.history[self.history["axial_stress_pa"] == peak]
        lateral = rows["lateral_stress_pa"].iloc[0] if len(rows) else np.nan
        return 0.0 if np.isnan(lateral) else float(lateral), peak

    def drives(self) -> list[tuple[str, str, np.ndarray]]:
        """Probes on which the outside world works: name, direction, and points (k, 3) of increment,
        displacement (m) or rotation (rad), and force (N) or moment (N m) in the direction.
        """
        return _engine.drives(self.path)

    def frames(self) -> list[Frame]:
        """All frames in the order of increments, one for each."""
        files = sorted((self.path / "frames").glob("*.npz"))
        frames = {frame.increment: frame for frame in map(Frame, files)}
        return [frames[increment] for increment in sorted(frames)]

    def frame(self, moment: int | str | os.PathLike[str] = "end") -> Frame:
        """The frame of a moment: ``start``, ``peak`` or ``end``, the number of an increment that has
        one, or the path of a file. Without a stress the peak is that of the force.

        Raises
        ------
        FileNotFoundError
            If the run has no frame of it; the message lists those that it has.
        """
        if isinstance(moment, (str, os.PathLike)) and str(moment).endswith(".npz"):
            return Frame(moment)
        folder = self.path / "frames"
        if moment in ("start", "peak", "end"):
            file = folder / f"{moment}.npz"
            if file.exists():
                return Frame(file)
            if moment == "peak" and (drives := self.drives()):
                work = lambda p: abs((0.5 * (p[1:, 2] + p[:-1, 2]) * np.diff(p[:, 1])).sum())
                points = max((points for *_, points in drives), key=work)
                peak = points[np.abs(points[:, 2]).argmax(), 0]
                if frames := self.frames():
                    return min(frames, key=lambda frame: abs(frame.increment - peak))
        for file in folder.glob("*.npz"):
            with np.load(file) as arrays:
                if moment == int(arrays["increment"]):
                    return Frame(file)
        there = ", ".join(str(frame.increment) for frame in self.frames())
        raise FileNotFoundError(f"{self.path}: no frame of {moment}; it has those of {there or 'none'}")

    def contacts(self, moment: int | str = "end") -> pandas.DataFrame:
        """Contacts and bonds at a moment (see :meth:`Frame.contacts`)."""
        return self.frame(moment).contacts()

    def state(self, name: str = "final") -> dict[str, np.ndarray]:
        """Arrays of a saved state: ``final``, or that of a ``Save`` stage by its name."""
        file = "final_state.npz" if name == "final" else f"state_{name}.npz"
        with np.load(self.path / file) as arrays:
            return {key: arrays[key] for key in arrays.files}

    @property
    def text(self) -> str:
        """The scene as run."""
        return (self.path / "scene.ron").read_text()

    def _repr_html_(self) -> str:
        """Picture and key results, for a notebook."""
        from base64 import b64encode
        from html import escape

        image = b64encode(self._repr_png_()).decode()
        rows = "".join(
            f"<tr><td>{escape(name)}</td><td>{value:.6g}</td></tr>"
            for name, value in self.results.items()
            if isinstance(value, float)
        )
        head = f"<b>{escape(self.title)}</b>: {escape(self.status)}"
        return f"<div>{head}<table>{rows}</table><img style='max-width:40em' src='data:image/png;base64,{image}'></div>"

    def _repr_png_(self) -> bytes:
        """Picture of the specimen at the end, for a notebook that shows no HTML."""
        from . import figures

        with figures.style():
            axes = figures.specimen(self)
            file = io.BytesIO()
            axes.figure.savefig(file, format="png")
            figures.close(axes)
        return file.getvalue()


def _numbers(fields: np.ndarray) -> np.ndarray:
    """Whole numbers, numbers with NaN for an empty field, or texts."""
    for read in (int, lambda field: float(field) if field else np.nan):
        try:
            return np.array([read(field) for field in fields], float if read is not int else np.int64)
        except ValueError:
            continue
    return fields


def open(path: str | os.PathLike[str]) -> Run:
    """The run in a directory."""
    return Run(path)
