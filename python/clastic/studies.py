"""Studies: many runs and one table, by the code of the program."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import _engine
from ._scene import Settings, _nested, settings, source
from .program import call
from .results import Run

if TYPE_CHECKING:
    import pandas


class Study:
    """The directory of a study.

    ``table`` has a row for every run: its values, status, marks, increments and key results.
    ``means`` has the means over ``average_over``, or is None.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        import pandas

        self.path = Path(path)
        self.table: pandas.DataFrame = pandas.read_csv(self.path / "study.csv")
        means = self.path / "study_means.csv"
        self.means: pandas.DataFrame | None = pandas.read_csv(means) if means.exists() else None

    def __repr__(self) -> str:
        return f"Study({str(self.path)!r}) of {len(self.table)} runs"

    def runs(self) -> list[Run]:
        """The runs that were made, in the order of the table."""
        folders = [self.path / str(name) for name in self.table["run"]]
        return [Run(folder) for folder in folders if (folder / "run.json").exists()]

    def _repr_html_(self) -> str:
        return self.table._repr_html_()


class Envelope(Study):
    """The directory of an envelope. ``peaks`` has the peak (Pa) of every confining stress and seed."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        import pandas

        super().__init__(path)
        self.peaks: pandas.DataFrame = pandas.read_csv(self.path / "envelope.csv")

    def mohr_coulomb(self) -> tuple[float, float]:
        """Cohesion (Pa) and friction angle (degrees) of all peaks, by least squares of sigma_1."""
        pairs = self.peaks[["confining_pa", "peak_pa"]].itertuples(index=False)
        return _engine.mohr_coulomb([tuple(map(float, pair)) for pair in pairs])


def sweep(
    study: str | os.PathLike[str] | None = None,
    *,
    scene: str | os.PathLike[str] | None = None,
    grid: Mapping[str, Sequence[Any]] | None = None,
    runs: Iterable[Mapping[str, Any]] | None = None,
    names: Mapping[str, str | Sequence[str]] | None = None,
    set: Settings | None = None,
    average_over: Sequence[str] = (),
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool = True,
) -> Study:
    """Makes the runs of a study, several at once, and returns their table. Runs that are there
    already are not made again. Ctrl-C leaves checkpoints, from which the next call continues.

    Parameters
    ----------
    study
        A study file, or its text; or give ``scene`` with ``grid`` or ``runs``.
    scene
        A scene file, or the name of a scene.
    grid
        Values by name: every combination is a run.
    runs
        In its place a list of runs, each a value by name.
    names
        Paths of the scene that a name stands for; a name without one is a path itself.
    set
        Settings of all runs.
    average_over
        Names over which ``means`` averages, such as ``["seed"]``.
    out
        Directory, by default ``runs/NAME``.
    jobs
        Maximum number of simultaneous runs, by default the number of cores.

    Raises
    ------
    RunError
        If the study or one of its scenes is wrong; the message is the program's.
    """
    if study is not None:
        text, is_text = source(study)
        folder = Path(out) if out else Path("runs", "study" if is_text else Path(text).stem)
        if not is_text:
            return _swept(text, folder, jobs, progress)
        return _of_text(text, folder, jobs, progress)
    if scene is None or (grid is None) == (runs is None):
        raise ValueError("give a study file, or a scene with grid or with runs")
    paths = {k: [v] if isinstance(v, str) else list(v) for k, v in (names or {}).items()}
    if grid is not None:
        plan = f"Grid({_map(grid)})"
    else:
        plan = "List([" + ", ".join(_map(run) for run in runs or ()) + "])"
    where = Path(scene)
    text = (
        f"(version: 1, title: {_nested('study of ' + where.stem)}, "
        f"scene: {_nested(str(where.absolute()) if where.exists() else str(scene))}, "
        f"set: {_nested(settings(set))}, settings: {_nested(paths)}, "
        f"average_over: {_nested(list(average_over))}, runs: {plan})"
    )
    folder = Path(out) if out else Path("runs", f"{where.stem}_study")
    return _of_text(text, folder, jobs, progress)


def _map(values: Mapping[str, Any]) -> str:
    return "{" + ", ".join(f"{_nested(k)}: {_nested(v)}" for k, v in values.items()) + "}"


def _of_text(text: str, folder: Path, jobs: int | None, progress: bool) -> Study:
    with tempfile.TemporaryDirectory() as place:
        file = Path(place, "study.ron")
        file.write_text(text)
        return _swept(str(file), folder, jobs, progress)


def _swept(file: str, folder: Path, jobs: int | None, progress: bool) -> Study:
    arguments = ["sweep", file, "--out", str(folder)]
    arguments += ["--jobs", str(jobs)] if jobs else []
    call(arguments, quiet=not progress)
    return Study(folder)


def envelope(
    scene: str | os.PathLike[str],
    confining: Sequence[float],
    *,
    seeds: Sequence[int] = (),
    fields: Sequence[str] = (),
    seed_fields: Sequence[str] = (),
    prepare: str | os.PathLike[str] | None = None,
    set: Settings | None = None,
    out: str | os.PathLike[str] | None = None,
    jobs: int | None = None,
    progress: bool = True,
) -> Envelope:
    """Finds the strength at several confining stresses (Pa), as ``clastic envelope`` does.

    Parameters
    ----------
    fields
        Fields of the scene that are the confining stress, ``let.confining`` without any.
    seeds, seed_fields
        Seeds of the specimen, and the fields that are the seed, ``let.seed`` without any.
    prepare
        A scene whose state at the end is the specimen of all runs of a seed.
    """
    folder = Path(out) if out else Path("runs", f"{Path(scene).stem}_envelope")
    arguments = ["envelope", os.fspath(scene), "--out", str(folder)]
    arguments += ["--confining", ",".join(repr(float(stress)) for stress in confining)]
    arguments += ["--seeds", ",".join(map(str, seeds))] if seeds else []
    for field in fields:
        arguments += ["--field", field]
    for field in seed_fields:
        arguments += ["--seed-field", field]
    for setting in settings(set):
        arguments += ["--set", setting]
    arguments += ["--prepare", os.fspath(prepare)] if prepare else []
    arguments += ["--jobs", str(jobs)] if jobs else []
    call(arguments, quiet=not progress)
    return Envelope(folder)
