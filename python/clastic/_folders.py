"""Runs in folders that are named by the hashes of their scenes."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections import defaultdict
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Lock
from typing import Any

from . import _engine
from ._scene import Scene, Settings
from .errors import RunWarning
from .results import Run
from .run import check, run


class Folders:
    """Runs below a directory, several at once. One whose scene has the same text is there already and is not made
    again.
    """

    def __init__(self, out: str | os.PathLike[str], jobs: int | None) -> None:
        self.out = Path(out).absolute()
        self.jobs = jobs or os.cpu_count()
        #: Rows of the table of runs, by folder, and the runs, None for failed ones.
        self.rows: dict[Path, dict[str, Any]] = {}
        self.found: dict[Path, Run | None] = {}
        #: One for each folder, so that tests of one text make one run.
        self.locks: defaultdict[Path, Lock] = defaultdict(Lock)

    @property
    def made(self) -> int:
        """Number of runs that were made."""
        return sum(not row["cached"] for row in self.rows.values())

    def map(self, function: Callable[[Any], Any], work: Iterable[Any]) -> list[Any]:
        """The function of all work, several at once. Doubts of runs are in the column `marks`."""
        with warnings.catch_warnings(), ThreadPoolExecutor(self.jobs) as pool:
            warnings.simplefilter("ignore", RunWarning)
            return list(pool.map(function, work))

    def run(
        self, row: dict[str, Any], scene: Scene, settings: Settings, results: Iterable[str] = ()
    ) -> Run | None:
        """A run, unless one of the same text is there. None if it failed. Its row gets the named key results."""
        # The directory may be moved, and its runs stay what they are.
        text = check(scene, settings)["text"].replace(str(self.out), "")
        folder = self.out / hashlib.sha256(f"{_engine.__version__}\n{text}".encode()).hexdigest()[:16]
        with self.locks[folder]:
            if folder not in self.rows:
                self._make(row, folder, scene, settings, results)
            return self.found[folder]

    def _make(
        self, row: dict[str, Any], folder: Path, scene: Scene, settings: Settings, results: Iterable[str]
    ) -> None:
        ended = ("completed", "collapsed", "undecided", "refused")
        there = (folder / "run.json").exists() and Run(folder).status in ended
        done = Run(folder) if there else run(scene, settings, folder, force=True, threads=1, progress=False)
        row |= {"directory": str(folder), "cached": there, "status": done.status}
        row |= {"marks": "; ".join(done.marks)}
        row |= {name: done.results[name] for name in results if name in done.results}
        self.rows[folder] = row
        self.found[folder] = done if done.status in ("completed", "collapsed") else None
