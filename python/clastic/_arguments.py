"""What the commands of the package have in common."""

from __future__ import annotations

import argparse
import sys

#: Exit codes of the program: input or output failed, a scene is wrong, interrupted.
FILES, SCENE, INTERRUPTED = 1, 3, 130


def setting(text: str) -> tuple[str, str]:
    path, equals, value = text.partition("=")
    if not (path and equals):
        raise argparse.ArgumentTypeError(f"{text!r} is no setting; write PATH=VALUE, as in let.cohesion=20e3")
    return path, value


def positive(text: str) -> int:
    if not (text.isdecimal() and int(text) > 0):
        raise argparse.ArgumentTypeError(f"{text!r}: write a whole number from 1")
    return int(text)


def complain(message: str, code: int) -> int:
    """Says what is wrong, and returns the exit code."""
    print(f"error: {message}", file=sys.stderr)
    return code
