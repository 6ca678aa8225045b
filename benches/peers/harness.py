"""What the tests of the peers share: timed runs on one core, tables, curves."""

import csv
import math
import os
import subprocess
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent


class Bench:
    def __init__(self, options):
        self.options = options
        self.out = Path(options.out).resolve()
        self.out.mkdir(parents=True, exist_ok=True)
        self.clastic = Path(options.clastic).resolve()

    def timed(self, command, env=None):
        """Runs a command on the core; processor and wall seconds."""
        command = ["taskset", "-c", str(self.options.core), *map(str, command)]
        env = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", **(env or {})}
        log = self.out / "last.log"
        clock = time.perf_counter()
        with open(log, "w") as f:
            process = subprocess.Popen(
                command, env=env, cwd=self.out, stdin=subprocess.DEVNULL, stdout=f, stderr=f
            )
            try:
                _, status, usage = os.wait4(process.pid, 0)
            except BaseException:
                process.kill()
                raise
            process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            sys.exit(f"{' '.join(command)}\nended with {process.returncode}:\n{log.read_text()}")
        return usage.ru_utime + usage.ru_stime, time.perf_counter() - clock

    def run_clastic(self, scene, directory, sets, dump=None):
        command = [self.clastic, "run", ROOT / "scenes" / f"{scene}.ron", "--quiet", "--force"]
        command += ["--threads", "1", "--out", directory, "--set", "output.plots=false"]
        for s in sets:
            command += ["--set", s]
        if dump:
            command += ["--dump-program", str(dump)]
        return self.timed(command)

    def interleaved(self, runs):
        """Runs every (name, function) in turn, `repeat` times; the results by name."""
        results = {name: [] for name, _ in runs}
        for turn in range(self.options.repeat):
            for name, run in runs:
                results[name].append(run())
                print(f"  {turn + 1}/{self.options.repeat} {name}", file=sys.stderr)
        return results

    @staticmethod
    def arguments():
        """Arguments of this run that change what is measured."""
        given = list(sys.argv[1:])
        for option in ("--out", "--clastic", "--core"):
            while option in given:
                del given[(at := given.index(option)) : at + 2]
        return " ".join(given)

    def report(self, name, header, rows):
        path = self.out / f"{name}.csv"
        with open(path, "w", newline="") as f:
            writer = csv.writer(f, lineterminator="\n")
            writer.writerow(header)
            writer.writerows(rows)
        texts = [header] + [[short(cell) for cell in row] for row in rows]
        widths = [max(len(str(row[k])) for row in texts) for k in range(len(header))]
        lines = ["| " + " | ".join(str(c).ljust(w) for c, w in zip(row, widths)) + " |" for row in texts]
        lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
        table = "\n".join(lines)
        load = " ".join(f"{x:.2f}" for x in os.getloadavg())
        text = (
            f"**{name}**: `python3 benches/peers/run.py {self.arguments()}`, "
            f"{time.strftime('%Y-%m-%d', time.gmtime())}, load averages at the end {load}\n\n{table}\n"
        )
        (self.out / f"{name}.md").write_text(text)
        print(text)
        print(f"written: {path}")


def short(cell):
    if isinstance(cell, float):
        return "" if math.isnan(cell) else f"{cell:.3g}"
    return str(cell)


def table_of(path):
    with open(path) as f:
        return list(csv.DictReader(f))


def at(points, strain):
    """Linear interpolation of a curve that begins at (0, 0)."""
    before = (0.0, 0.0)
    for point in points:
        if point[0] >= strain:
            part = (strain - before[0]) / (point[0] - before[0])
            return before[1] + part * (point[1] - before[1])
        before = point
    return math.nan
