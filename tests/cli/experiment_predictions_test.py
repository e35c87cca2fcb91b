#!/usr/bin/env python3
"""`panda-twin experiment all` and what it must find: experiment_predictions_test.py PROGRAM SOURCE_TREE [unittest options].

In lockstep with the seeds of the report, so it gives the same figures on every machine. The bands stand here a second
time: a demand that the program loosens or drops fails.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()

# Inputs: what the loops' delays were fitted to, and what of it is said of them.
CALIBRATED = {f"{loop}, d_EXT, {figure}" for loop in ("LF", "RS", "RA") for figure in ("median", "p99")}
CALIBRATED.add("LF, unserved cycles")

# Experiment, quantity: what it may be.
PREDICTED = {
    "timings": {
        "LF, d_EXT, max": (0.087 / 1.5, 0.087 * 1.5),
        "RA, d_EXT, max": (0.141 / 1.5, 0.141 * 1.5),
        "RS, unserved cycles": (0.8 * 5.91, 1.2 * 5.91),
        "RA, unserved cycles": (0.8 * 0.41, 1.2 * 0.41),
        "unserved cycles, RS to RA": (10, 20),
        "RS, peak B: intervals within 0.25 ms of 2 ms": (5, 7.5),
        "RS, between A and B: intervals of 1.25 to 1.75 ms": (0, 0.5),
        "LF, one bump: intervals within 0.25 ms of 1 ms": (99, 100),
        "RA, one bump: intervals within 0.25 ms of 1 ms": (99, 100),
    },
}

NOT_REPRODUCED = {
    "timings": {"RS, d_EXT, max"},
}


class PredictionsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory(prefix="panda_twin_predictions_") as folder:
            cls.done = subprocess.run([PROGRAM, "experiment", "all", "--quiet", "--out", folder, "--data", SOURCE / "models"],
                                      capture_output=True, text=True, timeout=850)
            found = json.loads((pathlib.Path(folder) / "findings.json").read_text())
        cls.rows = {one["id"]: {row["quantity"]: row for row in one["comparisons"]} for one in found["experiments"]}
        cls.failures = {one["id"]: one["failure"] for one in found["experiments"] if one["failure"]}

    def named(self, verdict):
        return {id: {name for name, row in rows.items() if row["verdict"] == verdict} for id, rows in self.rows.items()}

    def test_all_is_done_and_nothing_misses_without_a_reason(self):
        self.assertEqual(self.failures, {})
        self.assertEqual(self.done.stderr, "")
        self.assertEqual(self.done.returncode, 0)

    def test_what_was_fitted_is_called_calibrated(self):
        calibrated = {id: names for id, names in self.named("calibrated").items() if names}
        self.assertEqual(calibrated, {"timings": CALIBRATED})

    def test_predictions_are_within_their_bands(self):
        for id, bands in PREDICTED.items():
            for name, (low, high) in bands.items():
                with self.subTest(experiment=id, quantity=name):
                    row = self.rows[id][name]
                    self.assertEqual(row["verdict"], "predicted")
                    self.assertTrue(low <= row["ours"] <= high, row)

    def test_what_is_not_reproduced_is_known_and_says_why(self):
        for id, names in self.named("not reproduced").items():
            self.assertEqual(names, NOT_REPRODUCED.get(id, set()), id)
            for name in names:
                self.assertTrue(self.rows[id][name]["reason"], name)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
