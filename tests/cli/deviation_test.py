#!/usr/bin/env python3
"""What a run says whose arm was far off its path: deviation_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "clients"))
from twin_server import TwinServer  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()

MOTION = """name: short
plant: {kind: ideal}
tick: {generator: none}
motion:
  interface: joint_position
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.2, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
render: {enabled: false}
"""
# A low-pass of 2 Hz is late by 1 / (2 pi 2 Hz) = 80 ms; the quintic's peak speed is 1.875 of the mean, 0.375 rad/s.
LATE = MOTION + "onboard: {filters: {joint_position: 2 Hz}}\n"
POSES = MOTION.replace("joint_position", "cartesian_pose").replace("tick: {generator: none}\n", "")


class DeviationTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_deviation_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.folder / "out"

    def run_text(self, text, *more):
        path = self.folder / "scenario.yaml"
        path.write_text(text)
        return subprocess.run([PROGRAM, "run", path, "--out", self.out, "--data", SOURCE / "models", *more],
                              cwd=self.folder, capture_output=True, text=True, timeout=300)

    def summary(self):
        return json.loads((self.out / "summary.json").read_text())

    def assert_within(self, text, *more):
        done = self.run_text(text, *more)
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        self.assertIs(self.summary()["deviation_exceeded"], False)

    def assert_exceeds(self, says, text, *more):
        """A success with a warning, which is the last line; with --strict an error."""
        done = self.run_text(text, *more)
        self.assertEqual(done.returncode, 0, done.stderr)
        last = done.stderr.splitlines()[-1]
        self.assertTrue(last.startswith("panda-twin: warning: "), done.stderr)
        self.assertIn(says, last)
        self.assertEqual(self.summary()["outcome"], "success")
        self.assertIs(self.summary()["deviation_exceeded"], True)
        strict = self.run_text(text, "--strict", "--quiet", *more)
        self.assertEqual(strict.returncode, 1, strict.stderr)
        last = strict.stderr.splitlines()[-1]
        self.assertTrue(last.startswith("panda-twin: error: "), strict.stderr)
        self.assertIn(says, last)
        self.assertIs(self.summary()["deviation_exceeded"], True)

    def test_an_arm_on_its_path_is_a_success_without_a_word(self):
        self.assert_within(MOTION, "--strict")
        self.assertEqual(self.summary()["max_deviation_rad"], 0.02)

    def test_an_arm_behind_its_path_is_told_of(self):
        self.assert_exceeds("joint 1", LATE)
        # The lag of a first-order low-pass on a ramp is v / w; here the speed changes, so that is the most.
        deviation = self.summary()["deviation_rad"]
        self.assertLess(deviation, 0.375 / (2 * math.pi * 2) + 0.375 * 0.003)
        self.assertGreater(deviation, 0.02)

    def test_without_a_log_too(self):
        self.assert_exceeds("joint 1", LATE + "record: false\n")

    def test_the_scenario_says_how_far_is_too_far(self):
        self.assert_within(LATE + "max_deviation: {joints: 40 mrad}\n", "--strict")
        self.assertEqual(self.summary()["max_deviation_rad"], 0.04)
        self.assert_within(LATE + "max_deviation: off\n", "--strict")
        self.assertIsNone(self.summary()["max_deviation_rad"])
        self.assert_exceeds("limit of 0.01 mrad", LATE + "max_deviation: {joints: 0.01 mrad}\n")

    def test_poses_are_judged_by_position_and_angle(self):
        self.assert_within(POSES, "--strict")
        summary = self.summary()
        self.assertEqual((summary["max_deviation_m"], summary["max_deviation_rotation_rad"]), (0.02, 0.02))
        self.assertGreater(summary["deviation_m"], 0)
        self.assertGreater(summary["deviation_rotation_rad"], 0)
        self.assertIsNone(summary["deviation_rad"])
        self.assert_exceeds("mm", POSES + "max_deviation: {position: 0.001 mm}\n")
        self.assert_exceeds("mrad", POSES + "max_deviation: {angle: 0.0001 mrad}\n")

    def test_torques_and_pushes_have_no_default(self):
        torque = MOTION.replace("joint_position", "torque").replace("tick: {generator: none}\n", "")
        torque = torque.replace("kind: ideal", "kind: mujoco")
        self.assert_within(torque, "--strict")
        self.assertIsNone(self.summary()["max_deviation_rad"])
        self.assert_exceeds("joint", torque + "max_deviation: {joints: 0.001 mrad}\n")
        pushed = LATE.replace("kind: ideal", "kind: mujoco") + (
            "perturbations:\n  - push: {body: panda_hand, begin: 0.2 s, duration: 0.2 s, rise: 0.1 s, force: [0 N, 1 N, 0 N]}\n")
        self.assert_within(pushed, "--strict")
        self.assert_exceeds("joint 1", pushed + "max_deviation: {joints: 20 mrad}\n")

    def test_an_aborted_run_is_judged_by_its_abort(self):
        done = self.run_text(MOTION.replace("duration: 1 s", "duration: 0.3 s\n    velocity_scale: 1")
                             + "link: {command_loss: {scripted: [{at: 0.1 s, count: 25}]}}\nmax_deviation: {joints: 0.001 mrad}\n")
        self.assertIn(done.returncode, (1, 3), done.stderr)
        self.assertNotIn("warning", done.stderr)

    def test_a_limit_has_its_unit_and_goes_with_something(self):
        for text, says in [("max_deviation: {joints: 20 mm}", "mm"), ("max_deviation: {joints: 20}", "unit"),
                           ("max_deviation: {joints: 0 mrad}", "out of range"), ("max_deviation: {torque: 1 Nm}", "unknown key"),
                           ("max_deviation: none", "off"), ("max_deviation: {position: 20 mm}", "interface")]:
            done = self.run_text(MOTION + text + "\n")
            self.assertEqual(done.returncode, 3, text)
            self.assertIn("max_deviation", done.stderr)
            self.assertIn(says, done.stderr)

    def test_strict_judges_one_run(self):
        done = subprocess.run([PROGRAM, "run", SOURCE / "models/applications/plan_and_execute.yaml", "--seeds", "2", "--strict",
                               "--out", self.out, "--data", SOURCE / "models"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("--strict", done.stderr)

    def test_a_robot_over_the_wire_is_judged_too(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            there = ["--backend", "fci", "--robot", server.address, "--robot-time", "states"]
            back = "      - {q: [0.2, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}\n"
            start = "      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}\n"
            followed = MOTION.replace("tick: {generator: none}\n", "").replace(back, back + start)
            for rounded, exact in (("0.7854", "0.785398163397"), ("2.3562", "2.356194490192"), ("1.5708", "1.570796326795")):
                followed = followed.replace(rounded, exact)  # the arm rests within 1e-3 rad of where it begins
            self.assert_exceeds("joint", followed + "max_deviation: {joints: 0.001 mrad}\n", *there)

    def test_each_motion_of_an_application_is_judged(self):
        text = (SOURCE / "models/applications/pick_and_place.yaml").read_text()
        done = self.run_text(text, "--no-video", "--strict")
        self.assertEqual((done.returncode, done.stderr), (0, ""), done.stdout)
        summary = self.summary()
        self.assertIs(summary["deviation_exceeded"], False)
        self.assertEqual(len(summary["deviations"]), summary["motions"])
        self.assertTrue(all(m["deviation_rad"] <= m["max_deviation_rad"] == 0.02 for m in summary["deviations"]), summary)
        done = self.run_text(text + "max_deviation: {joints: 0.01 mrad}\n", "--no-video", "--quiet")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr.splitlines()[-1], r"^panda-twin: warning: .* motions, first in \w+")
        self.assertIs(self.summary()["deviation_exceeded"], True)


if __name__ == "__main__":
    PROGRAM, SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
