"""A run that is interrupted in the middle of a stage, and resumed."""

import json
import shutil
import signal
import subprocess
import time

import runs

# Files that tell the wall clock or what was resumed.
OTHERS = {"timings.csv", "figures.json", "final_checkpoint.bin"}


# A run of a tenth of a second may pass a stage before the signal reaches it.
TRIES = 20


def check(variant, out):
    """Interrupts the run by Ctrl-C in the middle of a stage, resumes it, and compares all files with
    those of the run in one piece. Returns `same` or what differs."""
    whole, parts = out / variant.name, out / f"{variant.name}_resumed"
    stages = [row["stage"] for row in runs.rows(whole)]
    longest = max(dict.fromkeys(stages), key=stages.count)
    aim = stages.index(longest) + stages.count(longest) // 3
    for _ in range(TRIES):
        shutil.rmtree(parts, ignore_errors=True)
        code = interrupt(variant, out, parts, aim)
        done = len(runs.rows(parts))
        if code == 130 and stages[done - 1] == stages[done]:
            break
    else:
        return f"was not interrupted in a stage in {TRIES} runs"
    resumed = subprocess.run(
        [str(runs.PROGRAM), "resume", str(parts), "--threads", "1", "-q"],
        capture_output=True, text=True, check=False,
    )
    if resumed.returncode != 0:
        return f"not resumed: {resumed.stderr.strip()}"
    return compare(whole, parts)


def interrupt(variant, out, parts, aim):
    """Ctrl-C once the history has `aim` rows. Returns the exit code."""
    process = subprocess.Popen(
        runs.command(variant.scene(out), parts, variant.sets(out)),
        stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )
    file = parts / "history.csv"
    while process.poll() is None:
        if file.exists() and file.read_bytes().count(b"\n") - 1 >= aim:
            process.send_signal(signal.SIGINT)
            break
        time.sleep(0.002)
    return process.wait()


def compare(whole, parts):
    def files(at):
        found = {str(p.relative_to(at)): p for p in at.rglob("*") if p.is_file()}
        return {name: path for name, path in found.items() if name not in OTHERS}

    expected, found = files(whole), files(parts)
    if expected.keys() != found.keys():
        return f"other files: {sorted(expected.keys() ^ found.keys())}"
    for name, path in expected.items():
        a, b = path.read_bytes(), found[name].read_bytes()
        if name == "run.json":
            a, b = (json.loads(text) for text in (a, b))
            for record in (a, b):
                record.pop("resumed", None)
        if name == "report.html":
            continue
        if a != b:
            return f"{name} differs"
    return "same"
