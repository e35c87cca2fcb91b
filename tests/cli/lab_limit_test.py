#!/usr/bin/env python3
"""A run that meets a limit of its lab: lab_limit_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

# A push of 30 N at the hand while joint 1 turns.
SCENARIO = """name: pushed
render: {enabled: false}
onboard: {collision_behavior: off}
motion:
  trajectory:
    unit: rad
    duration: 3 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.3, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
perturbations:
  - push: {body: panda_hand, begin: 1 s, duration: 800 ms, rise: 200 ms, force: [0 N, 30 N, 0 N], point: [0 m, 0 m, 0.1 m]}
"""


class LabLimitTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_lab_limit_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def run_with(self, limits):
        scenario = self.folder / "s.yaml"
        scenario.write_text(SCENARIO + limits)
        return subprocess.run([PROGRAM, "run", scenario, "--no-video", "--out", self.folder / "out", "--data", SOURCE / "models"],
                              capture_output=True, text=True, timeout=300)

    def test_a_force_above_its_cap_stops_the_arm_and_ends_the_run(self):
        done = self.run_with("limits: {force: 15 N}\n")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout + done.stderr,
                         r"lab_limit: limit force: the end effector is pushed with 15\.\d* N; the bound is 15 N")
        summary = json.loads((self.folder / "out" / "summary.json").read_text())
        self.assertNotEqual(summary["outcome"], "success")

    def test_a_force_below_its_cap_does_not(self):
        done = self.run_with("limits: {force: 60 N}\n")
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
