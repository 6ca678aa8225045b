"""Runs a scene, reads its results, and writes the table."""

import csv
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent.parent
PROGRAM = ROOT / "target/release/clastic"
RESIDUALS = ("balance", "kinematics", "cone", "complementarity")


def command(scene, out, sets):
    words = [PROGRAM, "run", scene, "--out", out, "--force", "--threads", "1", "-q"]
    words += [word for value in sets for word in ("--set", value)]
    return [str(word) for word in words]


def run(scene, out, sets):
    """Runs a scene. A scene that is refused is an error of this script."""
    done = subprocess.run(command(scene, out, sets), capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        raise SystemExit(f"{' '.join(done.args)}\n{done.stderr}")


def rows(out, stage=None):
    """Rows of the history, of one stage or of all."""
    with open(out / "history.csv") as file:
        return [row for row in csv.DictReader(file) if stage in (None, row["stage"])]


def number(row, column):
    return float(row[column]) if row[column] else float("nan")


def column(some, name):
    return [number(row, name) for row in some]


def particles(path):
    """Particles of a frame or of the end: x, y, radius."""
    with open(path) as file:
        return [(float(r["x_m"]), float(r["y_m"]), float(r["radius_m"])) for r in csv.DictReader(file)]


def figure(name, value, low, high):
    """A figure and the range in which it is expected."""
    return {"name": name, "value": value, "low": low, "high": high, "good": low <= value <= high}


def is_wrong(row):
    wrong = any(not each["good"] for each in row["figures"])
    return bool(row["finding"]) or wrong or row["bytes"] not in ("", "same")


def shown(each):
    def short(x):
        return f"{x:.3g}" if x == 0 or 1e-2 <= abs(x) < 1e4 else f"{x:.1e}"

    mark = "" if each["good"] else " **outside**"
    ends = f"{short(each['low'])} to {short(each['high'])}"
    if each["low"] == 0 and each["high"] < 1e-2:
        ends = f"at most {short(each['high'])}"
    return f"{each['name']} {short(each['value'])} ({ends}){mark}"


def text_of(row):
    figures = "; ".join(shown(each) for each in row["figures"]) or row["finding"]
    return (
        f"| {row['variant']} | {row['outcome']} | {row['increments']} | {row['capped']} "
        f"| {row['seconds']:.0f} | {figures} | {row['bytes']} |"
    )


def table_of(table):
    text = ""
    for name in dict.fromkeys(row["rig"] for row in table):
        text += f"\n`{name}`\n\n| run | outcome | increments | capped | s | figures (expected) | resumed |\n"
        text += "|---|---|---|---|---|---|---|\n"
        text += "".join(text_of(row) + "\n" for row in table if row["rig"] == name)
    return text
