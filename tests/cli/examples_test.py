#!/usr/bin/env python3
"""Runs every example scenario without video: examples_test.py PROGRAM SOURCE_TREE."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()

# Examples that are meant to abort, and what must end them. All others must reach their goal.
ABORTS = {"outage": "communication_constraints_violation", "collision": "cartesian_reflex",
          "user_stop": "user stop pressed"}

# How near the goal, rad. Torques leave what dry friction holds: the break-away torque over the controller's gain. A wrong
# load leaves a sag; poses leave the joints where the null space took them.
NEAR = 1e-3
NEAR_BY = {"torque": 1e-2, "wrong_load": 5e-3, "plan_and_execute": 1e-2, "cartesian": 0.2, "compliance": 0.3, "cartesian_pose": 0.3}

# Examples whose goal is a pose.
OF_POSES = {"cartesian", "compliance", "cartesian_pose"}

# Examples at whose end the hand holds something.
GRASPS = {"grasp", "vacuum"}

# Examples whose motion is planned: they touch nothing.
PLANNED = {"plan_and_execute"}


class ExamplesTest(unittest.TestCase):
    def run_example(self, path, out):
        """The exit code and the summary of a run."""
        done = subprocess.run([PROGRAM, "run", path, "--out", out, "--no-video", "--quiet",
                               "--data", SOURCE / "models"], capture_output=True, text=True)
        summary = pathlib.Path(out) / "summary.json"
        self.assertTrue(summary.exists(), done.stderr)
        return done.returncode, json.loads(summary.read_text())

    def check_abort(self, name, code, summary):
        self.assertEqual((code, summary["outcome"]), (1, "aborted"), summary["failure"])
        causes = [*summary["violations"], summary["failure"]]
        self.assertTrue(any(ABORTS[name] in cause for cause in causes), causes)

    def check_success(self, name, code, summary):
        self.assertEqual((code, summary["outcome"]), (0, "success"), summary["failure"])
        self.assertLess(summary["final_error_rad"], NEAR_BY.get(name, NEAR))
        if name in OF_POSES:
            self.assertLess(summary["final_error_m"], 2e-3)
            self.assertLess(summary["final_error_rotation_rad"], 1e-2)
        else:
            self.assertIsNone(summary["final_error_m"])
        self.assertEqual(summary["plan"] is not None, name in PLANNED)
        if name in PLANNED:
            self.assertEqual(summary["contacts"], {"cycles": 0, "pairs": []})
        self.assertEqual(bool(summary["hand"] and summary["hand"]["is_grasped"]), name in GRASPS)

    def test_every_example_ends_as_it_should(self):
        examples = {p.stem: p for p in sorted((SOURCE / "models" / "scenarios").glob("*.yaml"))
                    if not p.name.endswith(".hash.yaml")}
        self.assertGreaterEqual(len(examples), 5)
        self.assertLessEqual(ABORTS.keys() | NEAR_BY.keys() | OF_POSES | GRASPS | PLANNED, examples.keys())
        for name, path in examples.items():
            check = self.check_abort if name in ABORTS else self.check_success
            with self.subTest(example=name), tempfile.TemporaryDirectory() as out:
                check(name, *self.run_example(path, out))

    def test_every_example_says_what_it_shows(self):
        for path in (SOURCE / "models" / "scenarios").glob("*.yaml"):
            self.assertTrue(path.read_text().startswith("# "), path.name)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
