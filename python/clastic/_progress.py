"""Progress of a run: a bar of tqdm where it is installed, a plain line otherwise."""

from __future__ import annotations

import sys
import time
from typing import Any

#: Time between two updates, s.
PAUSE = 0.2


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    kernel = shell.get_ipython() if shell else None
    return kernel is not None and hasattr(kernel, "kernel")


def _state(row: dict[str, Any]) -> str:
    parts = []
    if row.get("axial_strain") is not None:
        parts.append(f"strain {100 * row['axial_strain']:.3f} %")
    if row.get("axial_stress_pa") is not None:
        parts.append(f"stress {1e-6 * row['axial_stress_pa']:.4g} MPa")
    broken = sum(row[name] for name in ("broken_tension", "broken_shear", "broken_rolling"))
    if broken:
        parts.append(f"{broken} bonds broken")
    return ", ".join(parts)


class Progress:
    """Shows rows as they come."""

    def __init__(self, show: bool | None, stages: int) -> None:
        self.show = show if show is not None else sys.stderr.isatty() or _in_notebook()
        self.stages = stages
        self.stage = ""
        self.number = 0
        self.due = 0.0
        self.bar: Any = None
        self.width = 0

    def see(self, engine: Any, row: dict[str, Any]) -> None:
        """Shows the row of an increment, if the last one is some time ago."""
        if not self.show or (row["stage"] == self.stage and time.monotonic() < self.due):
            return
        self.due = time.monotonic() + PAUSE
        _, done, total = engine.progress()
        if row["stage"] != self.stage:
            self.stage, self.number = row["stage"], self.number + 1
            self._begin(total)
        if self.bar is not None:
            self.bar.n = min(done, total)
            self.bar.set_postfix_str(_state(row), refresh=False)
            self.bar.refresh()
            return
        line = f"{self.stage} {done:.0f}/{total:.0f}, {_state(row)}"
        print("\r" + line.ljust(self.width), end="", file=sys.stderr, flush=True)
        self.width = len(line)

    def _begin(self, total: float) -> None:
        self.end()
        try:
            from tqdm.auto import tqdm
        except ImportError:
            return
        layout = "{desc} {n:.0f}/{total:.0f} |{bar}| {elapsed}{postfix}"
        self.bar = tqdm(total=total, desc=self.stage, bar_format=layout, leave=True)

    def end(self) -> None:
        """Ends the bar or the line."""
        if self.bar is not None:
            self.bar.close()
            self.bar = None
        elif self.width:
            print(file=sys.stderr)
            self.width = 0
