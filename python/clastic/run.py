"""Runs scenes into directories, as the program does."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import Any

from . import _engine
from ._progress import Progress
from ._scene import Scene, Settings, settings, source
from .errors import RunWarning
from .program import call
from .results import Run


def check(scene: Scene, set: Settings | None = None) -> dict[str, Any]:
    """Reads a scene and checks it. Returns ``title``, number of ``particles``, names of ``walls`` and
    ``stages``, ``warnings``, the ``text`` with its settings, and the hash of the file that the specimen
    is read from, ``specimen_sha256`` (None: it is read from none).

    Raises
    ------
    SceneError
        If the scene or a setting is wrong: with line, column and remedy.
    OSError
        If there is no such scene, or it cannot be read.
    """
    text, is_text = source(scene)
    return _engine.check(text, is_text, settings(set))


def run(
    scene: Scene,
    set: Settings | None = None,
    out: str | os.PathLike[str] | None = None,
    *,
    force: bool = False,
    checkpoint_every: int = 0,
    threads: int | None = None,
    progress: bool | None = None,
) -> Run:
    """Runs a scene to its end and returns the run.

    The files are those of the program, byte for byte (``timings.csv`` has the time of the clock).
    Ctrl-C finishes the increment, writes all results up to it and a checkpoint, from which
    :func:`resume` goes on, and raises ``KeyboardInterrupt``.

    Parameters
    ----------
    scene
        A file, the name of a scene that ships, or the text of a scene.
    set
        Settings by their paths; see :class:`Simulation`.
    out
        Directory for the results, ``runs/NAME`` without it.
    force
        Whether the results of an earlier run may be overwritten.
    checkpoint_every
        Number of increments between checkpoints; 0 writes one only if the run stops early.
    threads
        Maximum number of threads; results do not depend on it.
    progress
        Whether a bar is shown; by default on a terminal and in a notebook.

    Raises
    ------
    SceneError
        If the scene or a setting is wrong.
    OSError
        If the directory has results and ``force`` is not given, or a file cannot be written.
    """
    text, is_text = source(scene)
    name = "scene" if is_text else Path(text).stem
    folder = Path("runs", name) if out is None else Path(out)
    engine = _engine.Simulation(text, is_text, settings(set), folder, force, checkpoint_every, threads)
    for warning in engine.warnings():
        warnings.warn(warning, RunWarning, stacklevel=2)
    shown = Progress(progress, len(engine.stages()))
    try:
        while (row := engine.step()) is not None:
            shown.see(engine, row)
    except KeyboardInterrupt:
        engine.finish()
        raise KeyboardInterrupt(f"clastic.resume({str(folder)!r}) goes on") from None
    finally:
        shown.end()
    doubts = engine.finish()
    outcome = engine.outcome()
    if outcome and outcome["status"] in ("undecided", "refused"):
        doubts.append(f"{outcome['status']}: {outcome['message']}")
    for doubt in doubts:
        warnings.warn(doubt, RunWarning, stacklevel=2)
    return Run(folder)


def resume(
    path: str | os.PathLike[str],
    set: Settings | None = None,
    scene: str | os.PathLike[str] | None = None,
    *,
    progress: bool | None = None,
) -> Run:
    """Continues a run that was interrupted, killed or undecided, or extends one that has ended, as
    ``clastic resume`` does.

    Raises
    ------
    RunError
        If it cannot go on; the message is the program's.
    """
    arguments = ["resume", os.fspath(path)]
    for setting in settings(set):
        arguments += ["--set", setting]
    if scene is not None:
        arguments += ["--scene", os.fspath(scene)]
    call(arguments, quiet=progress is False)
    return Run(path)
