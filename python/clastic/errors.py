"""Errors and warnings."""

from __future__ import annotations

from typing import Any


class SceneError(ValueError):
    """A scene, or a setting of it, is wrong.

    ``diagnostics`` has every mistake as a dictionary: ``file``, ``line`` and ``column`` (from 1),
    ``path`` of the field, ``message``, ``help`` (the remedy, or None) and ``set`` (the setting that
    brought it in, or None). ``line``, ``column``, ``path`` and ``help`` are those of the first.
    """

    def __init__(self, message: str, diagnostics: list[dict[str, Any]] | None = None) -> None:
        super().__init__(message)
        self.diagnostics = diagnostics or []
        first = self.diagnostics[0] if self.diagnostics else {}
        self.line: int | None = first.get("line")
        self.column: int | None = first.get("column")
        self.path: str | None = first.get("path")
        self.help: str | None = first.get("help")

    def __reduce__(self) -> tuple[type, tuple[str, list[dict[str, Any]]]]:
        return type(self), (str(self), self.diagnostics)


class RunError(RuntimeError):
    """A command of the program failed; the message is the program's."""


class RunWarning(UserWarning):
    """A result is doubtful, or a run did not end as its scene plans."""
