#!/usr/bin/env python3
"""Runs scenarios at other sites: lab_test.py PROGRAM SOURCE_TREE [unittest options]."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()

SHORT = """name: short
plant: {kind: KIND}
motion:
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""


class LabTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_lab_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def run_at(self, lab, kind="ideal"):
        scenario = self.folder / "scenario.yaml"
        scenario.write_text(SHORT.replace("KIND", kind))
        return subprocess.run([PROGRAM, "run", scenario, "--lab", lab, "--no-video", "--out", self.folder / "out",
                               "--data", SOURCE / "models"], capture_output=True, text=True, timeout=120)

    def lab(self, text):
        path = self.folder / "lab.yaml"
        path.write_text(text)
        return path

    def written(self):
        return (self.folder / "out" / "scenario.yaml").read_text()

    def assert_refused(self, done, says):
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn(says, done.stderr)
        self.assertFalse((self.folder / "out").exists())

    def test_a_run_writes_what_came_of_scenario_and_lab(self):
        done = self.run_at(self.lab("link: {state_delay: 150 us}\ncontroller: {cost: 70 us}\n"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("state_delay: 150 us", self.written())
        self.assertIn("cost: 70 us", self.written())

    def test_the_labs_that_come_with_it_are_found_by_name(self):
        for lab, scale in (("a", "1.05"), ("b", "0.95")):
            with self.subTest(lab=lab):
                done = self.run_at(lab, "mujoco")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn(f"mass_scale: {scale}", self.written())

    def test_what_is_no_lab_is_refused(self):
        self.assert_refused(self.run_at("nowhere"), "one of a, b")
        self.assert_refused(self.run_at(self.lab("robot: {hand: none}\n")), "lab.yaml:1: robot: ")

    def test_a_robot_without_a_scenario_is_served_at_a_lab(self):
        done = subprocess.run([PROGRAM, "serve", "--lab", "b", "--drive", "lockstep", "--port", "0", "--hand-port", "0", "--for", "0.1",
                               "--data", SOURCE / "models"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_lab_of_weight_does_not_go_with_the_ideal_plant(self):
        self.assert_refused(self.run_at("a"), "leave mass_scale, base_tilt, links, delay and a law of friction out")


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
