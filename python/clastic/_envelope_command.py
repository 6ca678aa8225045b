"""The command ``clastic envelope``: :func:`clastic.envelope` in a folder."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from pathlib import Path

from ._arguments import FILES, INTERRUPTED, SCENE, complain, positive, setting
from .errors import RunError
from .program import UNDECIDED
from .studies import envelope


def main(arguments: Sequence[str]) -> int:
    """Runs the command and returns its exit code."""
    given = _parser().parse_args(arguments)
    try:
        found = envelope(
            given.scene,
            given.confining,
            seeds=given.seeds,
            fields=given.fields,
            seed_fields=given.seed_fields,
            prepare=given.prepare,
            set=dict(given.set),
            out=given.out,
            jobs=given.jobs,
            progress=not given.quiet,
        )
        print(found)
        print(f"written: {found.path / 'envelope.csv'}")
    except ImportError as error:
        return complain(f"{error}; install the package with './python[all]'", FILES)
    except ValueError as error:
        return complain(f"--confining: {error}", SCENE)
    except (RunError, OSError) as error:
        return complain(str(error), FILES)
    except KeyboardInterrupt:
        return complain("interrupted; the same command goes on with the runs that have ended", INTERRUPTED)
    return UNDECIDED if found.table["status"].isin(["undecided", "refused"]).any() else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "clastic envelope",
        description="Find the strength at several confining stresses: c and phi, sigma_ci and m_i.",
    )
    add = parser.add_argument
    add("scene", metavar="SCENE", help="a scene file, or the name of a scene")
    add("--confining", type=_list_of(float, "write numbers in Pa with commas between them, as in 0,5e6,10e6"), metavar="PA,...", required=True, help="confining stresses, Pa, compression positive, two or more: 0,5e6,10e6")
    add("--field", dest="fields", action="append", default=[], metavar="PATH[=VALUE]", help="field of the scene that is the confining stress: a path, or PATH=VALUE with {} in the place of the stress; may be repeated [default: let.confining]")
    add("--seeds", type=_list_of(int, "write whole numbers with commas between them, as in 1,2,3"), metavar="N,...", default=[], help="seeds of the specimen")
    add("--seed-field", dest="seed_fields", action="append", default=[], metavar="PATH", help="field of the scene that is the seed; may be repeated [default: let.seed]")
    add("--prepare", metavar="SCENE", help="a scene whose state at the end is the specimen of all runs of a seed; --seed-field is then a field of this scene")
    add("--set", type=setting, action="append", default=[], metavar="PATH=VALUE", help="set a field of the scene for all runs; may be repeated")
    add("--out", type=Path, metavar="DIR", help="directory for the runs and the envelope [default: runs/<name of the scene>_envelope]")
    add("--jobs", type=positive, metavar="N", help="maximum number of simultaneous runs [default: number of cores]")
    add("-q", "--quiet", action="store_true", help="show no progress, only the result")
    return parser


def _list_of(number: type[float], words: str) -> Callable[[str], list[float]]:
    """A reader of numbers with commas between them, which are asked for in these words."""

    def read(text: str) -> list[float]:
        try:
            return [number(part) for part in text.split(",")]
        except ValueError:
            raise argparse.ArgumentTypeError(words) from None

    return read
