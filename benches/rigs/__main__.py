#!/usr/bin/env python3
"""The rigs of a laboratory on other seeds and another geometry, each against its closed form.

    cargo build --release
    python3 benches/rigs [--program target/release/clastic] [--out bench/rigs] [--only hopper,oedometer] [--again]

Every rig runs on three seeds and on one changed geometry. One of these runs is interrupted in the
middle of a stage and resumed; its files must be the same bytes. The table goes to OUT/table.md:
how the run ended, increments, increments that are capped, seconds, and the figures of the rig with
what is expected of them. A run that is there already is not repeated; `--again` repeats it. The
exit code is 1 if a run has not completed, a figure is not as expected, or bytes differ.
"""

import argparse
import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import expected
import interrupted
import rigs
import runs


def line(name, variant, out, again):
    """Runs a variant and judges it. Returns a row of the table."""
    run = out / variant.name
    begun = time.monotonic()
    if again or not (run / "figures.json").exists():
        runs.run(variant.scene(out), run, variant.sets(out))
        (run / "figures.json").write_text(json.dumps({"seconds": time.monotonic() - begun}))
    seconds = json.loads((run / "figures.json").read_text())["seconds"]
    record = json.loads((run / "run.json").read_text())
    outcome = record["outcome"]
    row = {
        "rig": name, "variant": variant.name, "outcome": outcome["status"],
        "increments": record["increments"], "capped": record["capped_increments"],
        "seconds": seconds, "figures": [], "finding": "", "bytes": "",
    }
    last = runs.rows(run)[-1]
    if outcome["status"] != variant.ends:
        worst = max(runs.number(last, f"residual_{k}") for k in runs.RESIDUALS)
        row["finding"] = (
            f"{outcome['status']} in increment {last['increment']} of stage {last['stage']} "
            f"({last['status']}), residual {worst:.1e}: {outcome['message']}"
        )
        return row
    row["figures"] = expected.FIGURES[name](run, variant)
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--program", type=Path, default=runs.PROGRAM)
    parser.add_argument("--out", type=Path, default=Path("bench/rigs"))
    parser.add_argument("--only", default="")
    parser.add_argument("--again", action="store_true")
    options = parser.parse_args()
    runs.PROGRAM = options.program.resolve()
    wanted = [name for name in options.only.split(",") if name]
    table = []
    for name, variants in rigs.RIGS.items():
        if wanted and name not in wanted:
            continue
        out = options.out.resolve() / name
        out.mkdir(parents=True, exist_ok=True)
        for variant in variants:
            row = line(name, variant, out, options.again)
            if variant.interrupt and not row["finding"]:
                row["bytes"] = interrupted.check(variant, out)
            table.append(row)
            print(runs.text_of(row), flush=True)
    text = runs.table_of(table)
    options.out.mkdir(parents=True, exist_ok=True)
    (options.out / "table.md").write_text(text)
    return int(any(runs.is_wrong(row) for row in table))


if __name__ == "__main__":
    sys.exit(main())
