"""Runs in folders that are named by the hashes of their scenes."""

from __future__ import annotations

import hashlib
import os
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from itertools import count
from pathlib import Path
from threading import Lock, local
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
        #: Rows of the table of runs in the order of the work, by folder.
        self.rows: dict[Path, dict[str, Any]] = {}
        #: Runs by folder, and whether they were there already.
        self.found: dict[Path, tuple[Run, bool]] = {}
        #: One for each folder, so that tests of one text make one run. The first guards the others.
        self.lock, self.locks = Lock(), dict[Path, Lock]()
        #: Place of the work of this thread, and rows by the place of theirs.
        self.thread, self.asked = local(), list[tuple[int, Path, dict[str, Any]]]()

    @property
    def made(self) -> int:
        """Number of runs that were made."""
        return sum(not row["cached"] for row in self.rows.values())

    def map(self, function: Callable[[Any], Any], work: Iterable[Any]) -> list[Any]:
        """The function of all work, several at once. Doubts of runs are in the column `marks`."""

        def at(place: int, item: Any) -> Any:
            self.thread.place = place
            return function(item)

        with warnings.catch_warnings(), ThreadPoolExecutor(self.jobs) as pool:
            warnings.simplefilter("ignore", RunWarning)
            done = list(pool.map(at, count(), work))
        # Threads end in any order; the table has that of the work.
        for _, folder, row in sorted(self.asked, key=lambda asked: asked[0]):
            self.rows.setdefault(folder, row)
        self.asked.clear()
        return done

    def run(
        self, row: dict[str, Any], scene: Scene, settings: Settings, results: Iterable[str] = ()
    ) -> Run | None:
        """A run, unless one of the same text is there; for the function of `map` only. None if it failed. Its row gets
        the named key results.
        """
        # The directory may be moved, and its runs stay what they are.
        found = check(scene, settings)
        text = found["text"].replace(str(self.out), "")
        # A specimen may be stored anew under the same name.
        what = f"{_engine.__version__}\n{found['specimen_sha256']}\n{text}"
        folder = self.out / hashlib.sha256(what.encode()).hexdigest()[:16]
        with self.lock:
            lock = self.locks.setdefault(folder, Lock())
        with lock:
            if folder not in self.found:
                self.found[folder] = self._make(folder, scene, settings)
        done, there = self.found[folder]
        row |= {"directory": str(folder), "cached": there, "status": done.status}
        row |= {"marks": "; ".join(done.marks)}
        row |= {name: done.results[name] for name in results if name in done.results}
        self.asked.append((self.thread.place, folder, row))
        return done if done.status in ("completed", "collapsed") else None

    @staticmethod
    def _make(folder: Path, scene: Scene, settings: Settings) -> tuple[Run, bool]:
        ended = ("completed", "collapsed", "undecided", "refused")
        there = (folder / "run.json").exists() and Run(folder).status in ended
        done = Run(folder) if there else run(scene, settings, folder, force=True, threads=1, progress=False)
        return done, there
