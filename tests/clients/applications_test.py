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

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""
ATTEMPTS = 4
# Half a minute on the wall clock, together; compliance alone takes two minutes.
SHORT = ("plan_and_execute", "pick_and_place")
BASE = re.compile("^base:", re.MULTILINE)


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
        if DRIVE == "lockstep":
            summary = self.run_on_a_served_robot(file)
        else:
            summary = witness.undisturbed(lambda: witness.Witness(PROGRAM), lambda: self.run_on_a_served_robot(file), witness.A_CLIENT,
                                          ATTEMPTS)
        self.assertEqual(summary["outcome"], "success")
        self.assertTrue(all(step["succeeded"] for step in summary["steps"][-1:]))
        self.assertEqual([finding for finding in summary["findings"] if finding["met"] is False], [])
        # Nobody here knows what the arm touched, nor which commands were taken.
        self.assertIsNone(summary["contacts"])
        self.assertIsNone(summary["cycles_served"])

    def run_on_a_served_robot(self, file):
        """Its summary, when it succeeds."""
        with tempfile.TemporaryDirectory() as folder, twin_server.TwinServer(PROGRAM, SOURCE, DRIVE, file) as server:
            done = subprocess.run([PROGRAM, "run", file, "--backend", "fci", "--robot", server.address, "--robot-time",
                                   "states" if DRIVE == "lockstep" else "wall", "--data", SOURCE / "models",
                                   "--out", folder], capture_output=True, text=True, timeout=200)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return json.loads(pathlib.Path(folder, "summary.json").read_text())


if __name__ == "__main__":
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
