"""Scenes and settings as the engine wants them."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from typing import Any, Union

Scene = Union[str, "os.PathLike[str]"]
Settings = Mapping[str, Any]


def ron(value: Any) -> str:
    """The value in RON, the language of scenes.

    Numbers, truth values, lists, tuples and dictionaries are written as such. A text is taken as RON
    itself, ``"Stress(stress: 1e5)"``; within lists and dictionaries it is a text.
    """
    return value if isinstance(value, str) else _nested(value)


def _nested(value: Any) -> str:
    if hasattr(value, "item") and getattr(value, "ndim", 0) == 0:
        value = value.item()
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ValueError(f"{value} is no number of a scene")
        return repr(value)
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, tuple):
        return "(" + ", ".join(map(_nested, value)) + ")"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_nested, value)) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_nested(k)}: {_nested(v)}" for k, v in value.items()) + "}"
    raise TypeError(f"{value!r} is no value of a scene; give a number, a text in RON, a list or a tuple")


def settings(set: Settings | None) -> list[str]:
    """Settings as after ``--set`` of the program."""
    return [f"{path}={ron(value)}" for path, value in (set or {}).items()]


def source(scene: Scene) -> tuple[str, bool]:
    """Text or path of a scene, and whether it is a text. A text has a ``(`` of its own."""
    is_text = isinstance(scene, str) and "(" in scene and not os.path.exists(scene)
    return os.fspath(scene), is_text
