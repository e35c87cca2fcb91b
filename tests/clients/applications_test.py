#!/usr/bin/env python3
"""Carries out the applications that come with the program on a twin that is served.

applications_test.py PROGRAM SOURCE_TREE DRIVE [unittest options]
"""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import twin_server

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""
ATTEMPTS = 4
# Half a minute on the wall clock, together; compliance alone takes two minutes.
SHORT = ("plan_and_execute", "pick_and_place")
BASE = re.compile("^base:", re.MULTILINE)
# What a machine that is busy with other things makes of a motion in real time.
DISTURBED = ("communication_constraints", "discontinuity", "FAILED states", "FAILED communication", "FAILED scheduler",
             "no robot state", "path tolerance", "cartesian_reflex", "joint_reflex")


class ApplicationsTest(unittest.TestCase):
    def test_short_ones_do_on_a_served_robot_what_they_do_in_process(self):
        self.carry_out_all(lambda name: name in SHORT)

    def test_long_ones_do_on_a_served_robot_what_they_do_in_process(self):
        self.carry_out_all(lambda name: name not in SHORT)

    def carry_out_all(self, wanted):
        files = [file for file in sorted((SOURCE / "models/applications").glob("*.yaml")) if wanted(file.stem)
                 and not BASE.search(file.read_text())]  # a robot at the other end of a wire has none
        self.assertTrue(files)
        for file in files:
            with self.subTest(application=file.stem):
                self.carry_out(file)

    def carry_out(self, file):
        attempts = ATTEMPTS if DRIVE == "realtime" else 1
        for left in reversed(range(attempts)):
            with tempfile.TemporaryDirectory() as folder:
                done, summary = self.run_on_a_served_robot(file, pathlib.Path(folder))
            if done.returncode == 0:
                break
            said = done.stdout + done.stderr
            if not any(sign in said for sign in DISTURBED) or attempts == 1:
                self.fail(said)
            if left == 0:
                self.skipTest("this machine disturbed every run")
        self.assertEqual(summary["outcome"], "success")
        self.assertTrue(all(step["succeeded"] for step in summary["steps"][-1:]))
        self.assertEqual([finding for finding in summary["findings"] if finding["met"] is False], [])
        # Nobody here knows what the arm touched, nor which commands were taken.
        self.assertIsNone(summary["contacts"])
        self.assertIsNone(summary["cycles_served"])

    def run_on_a_served_robot(self, file, folder):
        """@returns (the client, its summary or None)."""
        with twin_server.TwinServer(PROGRAM, SOURCE, DRIVE, file) as server:
            done = subprocess.run([PROGRAM, "run", file, "--backend", "fci", "--robot", server.address, "--robot-time",
                                   "states" if DRIVE == "lockstep" else "wall", "--data", SOURCE / "models",
                                   "--out", folder / "out"], capture_output=True, text=True, timeout=200)
        summary = folder / "out/summary.json"
        return done, json.loads(summary.read_text()) if summary.exists() else None


if __name__ == "__main__":
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
