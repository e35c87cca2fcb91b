#!/usr/bin/env python3
"""The examples of Cartesian controllers against a served twin: served_controllers_test.py PROGRAM SOURCE_TREE."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "clients"))
from twin_server import TwinServer  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()


class ServedControllersTest(unittest.TestCase):
    def run_scenario(self, scenario, *flags):
        """@returns what its summary says."""
        with tempfile.TemporaryDirectory() as out:
            done = subprocess.run([PROGRAM, "run", scenario, *flags, "--data", SOURCE / "models", "--out", out, "--quiet"],
                                  capture_output=True, text=True, timeout=100)
            self.assertEqual(done.returncode, 0, done.stderr)
            return json.loads(pathlib.Path(out, "summary.json").read_text())

    def test_a_planned_motion_is_the_same_over_the_wire(self):
        scenario = SOURCE / "models" / "scenarios" / "plan_and_execute.yaml"
        here = self.run_scenario(scenario, "--no-video")
        with TwinServer(PROGRAM, SOURCE, "lockstep", scenario) as server:
            there = self.run_scenario(scenario, "--backend", "fci", "--robot", server.address, "--robot-time", "states")
        for summary in (here, there):
            self.assertEqual(summary["outcome"], "success")
            self.assertLess(summary["final_error_rad"], 0.02)
        self.assertEqual(there["plan"], here["plan"])

    def test_examples_end_over_the_wire_as_in_the_twin(self):
        for example in ("compliance", "cartesian_pose"):
            scenario = SOURCE / "models" / "scenarios" / f"{example}.yaml"
            # The push is the served robot's affair.
            with self.subTest(example=example), TwinServer(PROGRAM, SOURCE, "lockstep", scenario) as server:
                summary = self.run_scenario(scenario, "--backend", "fci", "--robot", server.address, "--robot-time", "states")
                self.assertEqual(summary["outcome"], "success")
                self.assertLess(summary["final_error_m"], 1e-3)
                self.assertLess(summary["final_error_rotation_rad"], 5e-3)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
