"""The program in a process of its own."""

from __future__ import annotations

import subprocess
import sys
import threading

from .errors import RunError

#: Words that begin the program in another process.
WORDS = [sys.executable, "-m", "clastic"]
#: Exit code where an increment could not be solved, which is a result of a run.
UNDECIDED = 4


def call(arguments: list[str], quiet: bool = False) -> str:
    """Calls the program and returns what it says.

    Raises
    ------
    RunError
        If it fails; the message is the program's.
    """
    words = [*WORDS, *arguments, *(["--quiet"] if quiet else [])]
    said: list[str] = []
    with subprocess.Popen(
        words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8"
    ) as process:

        def show() -> None:
            # Progress is shown as it comes, and kept for the message of an exception.
            for line in process.stderr or ():
                said.append(line)
                if not quiet:
                    print(line, end="", file=sys.stderr, flush=True)

        reader = threading.Thread(target=show, daemon=True)
        reader.start()
        # Ctrl-C reaches the process too: leaving the block waits for its checkpoint.
        out = process.stdout.read() if process.stdout else ""
        reader.join()
    if process.returncode not in (0, UNDECIDED):
        raise RunError("".join(said).strip() or f"the program ended with {process.returncode}")
    return out
