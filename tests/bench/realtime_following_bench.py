#!/usr/bin/env python3
"""How the canonical motion is followed on the wall clock, chain by chain, beside a witness of what the host does.

    realtime_following_bench.py PROGRAM SOURCE_TREE [RUNS]

RUNS (20) times each chain in turn, so that all meet the same host. Prints a row per chain; fails when the default chain aborts
although fewer than 20 commands were lost in a row, or is more than 10 mrad off its plan where the witness saw at most 10 cycles of
1 ms spoilt in a row.
"""

import json
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).parent.parent / "support"))
import witness  # noqa: E402

CHAINS = {
    "default": "",
    "default, 250 us of tolerance": "period_tolerance: 250 us",
    "paper's law": "generator: joint",
    "paper's law, limiter, 250 us": "generator: joint\n  limiter: true\n  period_tolerance: 250 us",
}
MOST_MRAD, MOST_IN_ROW, LOST_IN_ROW = 10, 10, 20


class Row:
    def __init__(self):
        self.runs, self.aborted, self.deviations, self.unserved, self.failures = 0, 0, [], [], []

    def add(self, summary, saw):
        self.runs += 1
        self.unserved.append(100 * summary["cycles_held"] / max(summary["cycles_served"] + summary["cycles_held"], 1))
        if summary["outcome"] != "success":
            self.aborted += 1
            if summary["longest_loss_cycles"] < LOST_IN_ROW:
                self.failures.append(f"aborted with {summary['longest_loss_cycles']} lost in a row")
            return
        mrad = 1e3 * summary["deviation_rad"]
        self.deviations.append(mrad)
        if mrad > MOST_MRAD and saw["in_row"] <= MOST_IN_ROW:
            self.failures.append(f"{mrad:.1f} mrad off, and the host spoilt {saw['in_row']} cycles in a row")

    def text(self):
        middle = lambda values: sorted(values)[len(values) // 2] if values else float("nan")  # noqa: E731
        return f"| {self.aborted} of {self.runs} | {middle(self.deviations):.1f} | {max(self.deviations, default=float('nan')):.1f} | " \
               f"{middle(self.unserved):.2f} | {max(self.unserved):.2f} |"


def main(program, source, runs=20):
    models = pathlib.Path(source) / "models"
    canonical = (models / "scenarios/canonical.yaml").read_text().replace("trajectories/", f"{models}/scenarios/trajectories/")
    rows = {name: Row() for name in CHAINS}
    in_row = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(int(runs)):
            for name, tick in CHAINS.items():
                scenario = pathlib.Path(folder) / "canonical.yaml"
                scenario.write_text(canonical.replace("tick:\n", f"tick:\n  {tick}\n" if tick else "tick:\n"))
                with witness.Witness(program) as host:
                    subprocess.run([program, "run", scenario, "--drive", "realtime", "--data", models, "--no-video", "--out",
                                    f"{folder}/out"], capture_output=True, text=True, timeout=300)
                rows[name].add(json.loads(pathlib.Path(folder, "out/summary.json").read_text()), host.saw)
                in_row.append(host.saw["in_row"])
    print("| chain | aborted | deviation, median [mrad] | largest | unserved, median [%] | largest |\n|---|---|---|---|---|---|")
    for name, row in rows.items():
        print(f"| {name} {row.text()}")
    print(f"the witness saw at most {max(in_row)} cycles spoilt in a row, {sorted(in_row)[len(in_row) // 2]} in the median run")
    failures = rows["default"].failures
    for failure in failures:
        print("default chain:", failure, file=sys.stderr)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
