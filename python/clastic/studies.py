"""Studies: many runs and one table, by the code of the program."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ._scene import Settings, _nested, settings, source
from .errors import RunError
from .program import call
from .results import Run
from .strengths import Strengths, hoek_brown, mohr_coulomb

if TYPE_CHECKING:
    import pandas

#: Field that is the confining stress where none is named.
CONFINING = "let.confining"


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
    """The directory of an envelope. ``peaks`` has the peak (Pa) of every run that ended as planned and has one, with
    its seed and its confining stress. As a text it is the fits, and what to know of the runs.
    """

    def __init__(self, path: str | os.PathLike[str]) -> None:
        super().__init__(path)
        ended = self.table["status"].isin(["completed", "collapsed"])
        rows = self.table[ended & self.table["peak_stress_pa"].notna()].reset_index(drop=True)
        self.peaks: pandas.DataFrame = rows[["confining", "peak_stress_pa"]].astype(float)
        self.peaks.columns = ["confining_pa", "peak_pa"]
        self.peaks.insert(0, "seed", rows["seed"] if "seed" in rows else "")
        self._rows = rows

    def mohr_coulomb(self) -> tuple[float, float]:
        """Cohesion (Pa) and friction angle (degrees) of all peaks, by least squares of sigma_1."""
        return mohr_coulomb(_strengths(self.peaks))

    def hoek_brown(self) -> tuple[float, float]:
        """sigma_ci (Pa) and m_i of all peaks, by least squares of (sigma_1 - sigma_3)^2."""
        return hoek_brown(_strengths(self.peaks))

    def _rising(self) -> int:
        """Number of runs whose peak is in the last increment."""
        last = [Run(self.path / str(run)).history["axial_stress_pa"].iloc[-1] for run in self._rows["run"]]
        return sum(stress == peak for stress, peak in zip(last, self.peaks["peak_pa"]))

    def __str__(self) -> str:
        said = []
        if left_out := len(self.table) - len(self.peaks):
            said.append(f"{left_out} runs without a peak are left out of the envelopes (see `marks`)")
        if uncertain := int((self.table["peak_stress_pa"].notna() & self.table["marks"].notna()).sum()):
            said.append(f"the envelopes include {uncertain} runs with marks")
        if rising := self._rising():
            said.append(
                f"WARNING: in {rising} runs the stress is at its maximum in the last increment, and may rise "
                "further; give more increments"
            )
        if self.peaks.empty:
            said.append(
                "no run has a peak, so that there is no envelope; the `outcome` of each run says why. A packing that "
                "jams does so at every confining stress: `prepare` makes it once"
            )
            return "\n".join(said)
        low, high = (1e-6 * stress for stress in (self.peaks["confining_pa"].min(), self.peaks["confining_pa"].max()))
        said.append(
            f"envelopes of {len(self.peaks)} peaks at confining stresses from {low:.9g} to {high:.9g} MPa, least "
            "squares of sigma_1:"
        )
        for fit, quantities in (
            (mohr_coulomb, (("c", "MPa", 1e-6, 4), ("phi", "degrees", 1.0, 2))),
            (hoek_brown, (("sigma_ci", "MPa", 1e-6, 3), ("m_i", "", 1.0, 2))),
        ):
            of_seeds = [found for _, of in self.peaks.groupby("seed") if (found := _fitted(fit, of))]
            for k, (name, unit, factor, digits) in enumerate(quantities):
                try:
                    value = factor * fit(_strengths(self.peaks))[k]
                except ValueError as reason:
                    said.append(f"  {name:9} not defined: {reason}")
                    continue
                line = f"  {name:9} {value:.{digits}f} {unit}"
                if len(of_seeds) > 1:
                    scatter = factor * np.std([found[k] for found in of_seeds], ddof=1)
                    line += f", standard deviation over {len(of_seeds)} seeds {scatter:.{digits}f}"
                said.append(line)
        return "\n".join(said)


def _strengths(peaks: pandas.DataFrame) -> list[tuple[float, float]]:
    return list(peaks[["confining_pa", "peak_pa"]].itertuples(index=False, name=None))


def _fitted(fit: Callable[[Strengths], tuple[float, float]], peaks: pandas.DataFrame) -> tuple[float, float] | None:
    try:
        return fit(_strengths(peaks))
    except ValueError:
        return None


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
    if grid is not None:
        plan = f"Grid({_map(grid)})"
    else:
        plan = "List([" + ", ".join(_map(run) for run in runs or ()) + "])"
    where = Path(scene)
    text = _text(where, "study of " + where.stem, names or {}, set, plan, f"average_over: {_nested(list(average_over))}")
    folder = Path(out) if out else Path("runs", f"{where.stem}_study")
    return _of_text(text, folder, jobs, progress)


def _text(
    scene: Path,
    title: str,
    names: Mapping[str, str | Sequence[str]],
    set: Settings | None,
    plan: str,
    further: str,
) -> str:
    """The text of a study of one scene."""
    return (
        f"(version: 1, title: {_nested(title)}, scene: {_place(scene)}, set: {_nested(settings(set))}, "
        f"settings: {_fields(names)}, {further}, runs: {plan})"
    )


def _place(scene: Path) -> str:
    """The scene as a study names it: a file from anywhere, or a name."""
    return _nested(str(scene.absolute()) if scene.exists() else str(scene))


def _fields(names: Mapping[str, str | Sequence[str]]) -> str:
    return _map({name: [paths] if isinstance(paths, str) else list(paths) for name, paths in names.items()})


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
    """Finds the strength at several confining stresses (Pa), and writes the peaks as ``envelope.csv``.

    Parameters
    ----------
    fields
        Fields of the scene that are the confining stress, ``let.confining`` without any.
    seeds, seed_fields
        Seeds of the specimen, and the fields that are the seed, ``let.seed`` without any.
    prepare
        A scene whose state at the end is the specimen of all runs of a seed; its fields are then the seed.

    Raises
    ------
    ValueError
        If there is one confining stress.
    RunError
        If a scene is wrong, or a run failed; the message is the program's.
    """
    if len({float(stress) for stress in confining}) < 2:
        raise ValueError("an envelope needs two confining stresses or more, as in 0, 5e6, 10e6")
    where = Path(scene)
    grid: dict[str, Sequence[float]] = {"confining": [float(stress) for stress in confining]}
    names: dict[str, Sequence[str]] = {"confining": list(fields) or [CONFINING]}
    of_seed = {"seed": list(seed_fields) or ["let.seed"]} if seeds else {}
    if seeds:
        grid["seed"] = list(seeds)
    further = "average_over: []"
    if prepare is not None:
        further = f"prepare: (scene: {_place(Path(prepare))}, settings: {_fields(of_seed)})"
    else:
        names |= of_seed
    text = _text(where, f"strength of {scene}", names, set, f"Grid({_map(grid)})", further)
    folder = Path(out) if out else Path("runs", f"{where.stem}_envelope")
    try:
        _of_text(text, folder, jobs, progress)
    except RunError as error:
        if fields or CONFINING not in str(error):
            raise
        help = "write the confining stress of the scene once, as a value `confining` of `let`, or name the fields"
        raise RunError(f"{error}\n{help} that are the confining stress (`fields`, --field)") from None
    found = Envelope(folder)
    found.peaks.to_csv(folder / "envelope.csv", index=False)
    return found
