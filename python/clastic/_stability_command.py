"""The command ``clastic stability``: tables and a picture of :func:`clastic.stability` in a folder."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ._arguments import FILES, INTERRUPTED, SCENE, complain, positive, setting
from ._scene import Settings
from .errors import RunError, SceneError
from .run import check
from .stability import Place, Stability, stability

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DESCRIPTION = """\
Find the factor on gravity, or the reduction of strength, at which slopes of several packings and cuts slide, beside
the upper bound of limit analysis (log-spiral) with the cohesion and the friction angle of blocks of the same ground.
Runs, tables (slides.csv, blocks.csv, summary.csv) and the picture of the slope nearest to the mean (slide.png) go
into one folder; runs that are there are not made again.
"""

EXAMPLES = """\
examples:
  clastic stability slope
  clastic stability slope --on strength --seeds 11 12 13 --out runs/strength
  clastic stability my_slope.ron --cuts 1.3,1.0 2.0,1.0 --set let.cohesion=20e3

What the scenes of slope and block need: docs/python.md, "Is a slope stable?"
"""


def main(arguments: Sequence[str]) -> int:
    """Runs the command and returns its exit code."""
    parser = _parser()
    given = parser.parse_args(arguments)
    try:
        found = stability(
            (given.scene, dict(given.set)),
            (given.block, dict(given.set_block)),
            of=given.on,
            **_shape(given),
            seeds=given.seeds,
            toes=given.cuts,
            places=given.places,
            confining=given.confining,
            most=given.most,
            out=given.out,
            jobs=given.jobs,
        )
        print(_write(found, given.out))
    except ImportError as error:
        return complain(f"{error}; install the package with './python[all]'", FILES)
    except (SceneError, ValueError) as error:
        return complain(str(error), SCENE)
    except (RunError, OSError) as error:
        return complain(str(error), FILES)
    except KeyboardInterrupt:
        return complain("interrupted; the same command goes on with the runs that have ended", INTERRUPTED)
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        "clastic stability",
        description=DESCRIPTION,
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("scene", metavar="SCENE", help="scene of the slope: a file, or a name as `slope`")
    add("--block", metavar="SCENE", default="slope_block", help="scene of the block [default: %(default)s]")
    add("--on", choices=("gravity", "strength"), default="gravity", help="what is scaled [default: %(default)s]")
    add("--seeds", type=int, nargs="+", metavar="N", default=[1, 2, 3], help="packings [default: 1 2 3]")
    cuts = [(1.3, 1.0), (2.0, 1.0), (2.7, 1.0)]
    add("--cuts", type=_place, nargs="+", metavar="X,Y", default=cuts, help="places of the toe, m [default: 1.3,1 2,1 2.7,1]")
    places = [(0.1, 0.15), (2.8, 0.15), (5.5, 0.15)]
    add("--places", type=_place, nargs="+", metavar="X,Y", default=places, help="lower left corners of the blocks, m [default: 0.1,0.15 2.8,0.15 5.5,0.15]")
    confining = [0.0, 0.25, 0.5]
    add("--confining", type=float, nargs="+", metavar="PART", default=confining, help="confining stresses of the blocks over the stress at the slide [default: 0 0.25 0.5]")
    for name, unit in (("height", "m"), ("angle", "degrees"), ("gravity", "m/s^2")):
        add(f"--{name}", type=float, help=f"{name} of the slope, {unit} [default: `{name}` in `let` of SCENE]")
    add("--most", type=float, default=8.0, metavar="FACTOR", help="largest factor [default: %(default)s]")
    add("--set", type=setting, action="append", default=[], metavar="PATH=VALUE", help="set a field of the slope; may be repeated")
    add("--set-block", type=setting, action="append", default=[], metavar="PATH=VALUE", help="set a field of the block; may be repeated")
    add("--out", type=Path, default=Path("runs", "stability"), metavar="DIR", help="folder [default: %(default)s]")
    add("--jobs", type=positive, metavar="N", help="maximum number of simultaneous runs [default: number of cores]")
    return parser


def _place(text: str) -> Place:
    try:
        x, y = map(float, text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no place; write x and y in m, as in 1.3,1.0") from None
    return x, y


def _shape(given: argparse.Namespace) -> dict[str, float]:
    """Height, angle and gravity: those of the command, else those of the scene."""
    return {name: _value(given, name) for name in ("height", "angle", "gravity")}


def _value(given: argparse.Namespace, name: str) -> float:
    value: float | None = getattr(given, name)
    if value is not None:
        return value
    sets: Settings = dict(given.set)
    text = check(given.scene, sets)["text"]
    # The value of a key of `let`: a number; names with an expression have to be given.
    found = re.search(rf'"{name}"\s*:\s*([-+0-9.eE]+)\s*[,}}/\n]', text)
    if not found:
        raise ValueError(f"{given.scene}: `let` has no number `{name}`; give --{name}, or write \"{name}\": NUMBER into `let`")
    return float(found[1])


def _write(found: Stability, out: Path) -> str:
    """Writes tables and picture, and returns the summary."""
    out.mkdir(parents=True, exist_ok=True)
    slides, blocks = found.slides.copy(), found.blocks.copy()
    for table, place in ((slides, "toe"), (blocks, "place")):
        where = table.columns.get_loc(place)
        for k, axis in enumerate("xy"):
            table.insert(where + k, f"{place}_{axis}_m", [at[k] for at in table[place]])
        del table[place]
    # The folder may be moved.
    slides["directory"] = [Path(path).name for path in slides["directory"]]
    slides.to_csv(out / "slides.csv", index=False)
    blocks.to_csv(out / "blocks.csv", index=False)
    numbers: dict[str, Any] = {
        field.name: getattr(found, field.name)
        for field in fields(found)
        if isinstance(getattr(found, field.name), (str, float))
    }
    numbers |= {"slopes": len(slides), "ratio": found.ratio, "stability_number": found.mechanism.number}
    lines = [",".join(map(str, row)) for row in (numbers, numbers.values())]
    (out / "summary.csv").write_text("\n".join(lines) + "\n")
    row = int((slides["factor"] - found.factor).abs().fillna(0.0).argmin())
    _draw(found, row).savefig(out / "slide.png")
    return "\n".join(
        [
            slides.drop(columns="directory").to_string(index=False, float_format="{:.3g}".format),
            f"ground: gamma {found.unit_weight / 1e3:.1f} kN/m3, c {found.cohesion / 1e3:.1f} kPa, "
            f"phi {found.friction_angle:.1f} degrees",
            f"factor on {found.of}: {_mean(found)} (slopes: {len(slides)}); "
            f"bound {found.bound:.2f}, ratio {found.ratio:.2f}",
            f"results in {out}",
        ]
    )


def _mean(found: Stability) -> str:
    """Mean factor and, of several slopes, its scatter."""
    scatter = f" +- {found.deviation:.2f}" if found.deviation == found.deviation else ""
    return f"{found.factor:.2f}{scatter}"


def _draw(found: Stability, row: int) -> Figure:
    """The slope of a row, with its mechanism."""
    from .figures import slide
    from .figures.style import style

    ax = slide(found, row)
    slope = found.slides.iloc[row]
    with style():
        ax.set_title(
            f"seed {slope['seed']}, toe at ({slope['toe'][0]:g}, {slope['toe'][1]:g}) m: "
            f"factor {slope['factor']:.2f}\n"
            f"on {found.of}: mean {_mean(found)}, bound {found.bound:.2f}",
            fontsize="medium",
        )
    return ax.figure
