"""The program ``clastic``: ``clastic ARGUMENTS`` or ``python -m clastic ARGUMENTS``."""

from __future__ import annotations

import sys

from . import _engine
from .program import WORDS


def main() -> None:
    """Runs the program with the arguments of this process. ``envelope`` and ``stability`` are commands of the
    package.
    """
    if sys.argv[1:2] == ["envelope"]:
        from . import _envelope_command

        sys.exit(_envelope_command.main(sys.argv[2:]))
    if sys.argv[1:2] == ["stability"]:
        from . import _stability_command

        sys.exit(_stability_command.main(sys.argv[2:]))
    sys.exit(_engine.call(WORDS, ["clastic", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
