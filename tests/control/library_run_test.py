#!/usr/bin/env python3
"""A controller of a user's library, from the command line: library_run_test.py PROGRAM SOURCE_TREE LIBRARIES."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

for folder in ("clients", "support"):
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / folder))
import witness  # noqa: E402
from twin_server import TwinServer  # noqa: E402

PROGRAM, SOURCE, LIBRARIES = "", pathlib.Path(), pathlib.Path()

SCENARIO = """\
name: mine
plant: {kind: ideal}
controller: {library: LIBRARY, type: TYPE, parameters: {PARAMETERS}}
motion:
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {q: [0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483]}
      - {q: [0.05, -0.7853981633974483, 0.03, -2.356194490192345, 0, 1.5707963267948966, 0.8]}
"""


class LibraryRunTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)

    def run_with(self, library, *flags, kind="follower", parameters=""):
        """The finished process, and its summary or None."""
        scenario = self.tmp / "mine.yaml"
        scenario.write_text(SCENARIO.replace("LIBRARY", str(library)).replace("TYPE", kind)
                            .replace("PARAMETERS", parameters))
        done = subprocess.run([PROGRAM, "run", scenario, "--data", SOURCE / "models", "--out", self.tmp / "out", "--no-video",
                               "--quiet", *flags], capture_output=True, text=True, timeout=100)
        summary = self.tmp / "out" / "summary.json"
        return done, json.loads(summary.read_text()) if summary.exists() else None

    def validate_with(self, library, *flags, parameters=""):
        scenario = self.tmp / "mine.yaml"
        scenario.write_text(SCENARIO.replace("LIBRARY", str(library)).replace("TYPE", "follower").replace("PARAMETERS", parameters))
        return subprocess.run([PROGRAM, "validate", scenario, "--data", SOURCE / "models", *flags], capture_output=True, text=True,
                              timeout=100)

    def library(self, name):
        return LIBRARIES / f"test_controllers_{name}.so"

    def test_runs_in_the_twin_and_its_scenario_stands_alone(self):
        (self.tmp / "lib.so").write_bytes(self.library("good").read_bytes())
        done, summary = self.run_with("lib.so")  # beside the scenario
        self.assertEqual((done.returncode, summary["outcome"]), (0, "success"), done.stderr)
        again = subprocess.run([PROGRAM, "run", self.tmp / "out" / "scenario.yaml", "--data", SOURCE / "models", "--out",
                                self.tmp / "again", "--no-video", "--quiet"], capture_output=True, text=True, timeout=100)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(json.loads((self.tmp / "again" / "summary.json").read_text())["states_hash"], summary["states_hash"])

    def test_runs_on_a_robot_on_the_network(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            done, summary = self.run_with(self.library("good"), "--backend", "fci", "--robot", server.address,
                                          "--robot-time", "states")
            self.assertEqual((done.returncode, summary["outcome"]), (0, "success"), done.stderr)
            done, _ = self.run_with(self.library("no_entry"), "--backend", "fci", "--robot", server.address,
                                    "--robot-time", "states")
            self.assertEqual(done.returncode, 3)
            self.assertIn("panda_twin_controllers", done.stderr)

    def test_says_file_line_and_fault_of_what_cannot_be_used(self):
        faults = {"other_version": "version 999", "other_headers": "other headers", "null_entry": "returns null",
                  "throwing_entry": "the entry is closed", "unresolved": "this_function_is_nowhere", "missing": "no such file"}
        for name, fault in faults.items():
            with self.subTest(library=name):
                done, _ = self.run_with(self.library(name))
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn("mine.yaml:3: controller library ", done.stderr)
                self.assertIn(fault, done.stderr)
                self.assertEqual(len(done.stderr.strip().splitlines()), 1, done.stderr)

    def test_says_file_line_and_key_of_a_wrong_parameter(self):
        for parameters, words in (("patience: 10 m", "controller.parameters.patience: unit"),
                                  ("patiense: 10 s", 'did you mean "patience"'),
                                  ("patience: [1 s, 2 s]", "is a list")):
            with self.subTest(parameters=parameters):
                done, _ = self.run_with(self.library("good"), parameters=parameters)
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertIn("mine.yaml:3: ", done.stderr)
                self.assertIn(words, done.stderr)

    def test_validate_runs_none_of_its_code_unless_asked(self):
        done = self.validate_with(self.library("runs_when_loaded"))
        self.assertEqual((done.returncode, done.stderr), (0, ""), "its code ran" if done.returncode == 77 else done.stderr)
        self.assertIn("not loaded; validate --load", done.stdout)
        self.assertEqual(self.validate_with(self.library("runs_when_loaded"), "--load").returncode, 77)

    def test_validate_checks_what_it_can_without_the_code(self):
        done = self.validate_with(self.library("missing"))
        self.assertEqual(done.returncode, 3)
        self.assertIn("mine.yaml:3: controller library ", done.stderr)
        self.assertIn("no such file", done.stderr)
        # Its parameters it alone understands.
        self.assertEqual(self.validate_with(self.library("good"), parameters="patiense: 10 s").returncode, 0)
        done = self.validate_with(self.library("good"), "--load", parameters="patiense: 10 s")
        self.assertEqual(done.returncode, 3)
        self.assertIn('did you mean "patience"', done.stderr)
        done = self.validate_with(self.library("good"), "--load")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertNotIn("not loaded", done.stdout)

    def test_stops_the_robot_when_the_controller_gives_up(self):
        def attempt(*flags):
            done, summary = self.run_with(self.library("good"), *flags, parameters="patience: 300 ms")
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertIn("the follower lost its patience; the motion was stopped", summary["failure"])
            self.assertLess(summary["simulated_s"], 5)
        attempt()
        witness.undisturbed(lambda: witness.Witness(PROGRAM), lambda: attempt("--drive", "realtime"),
                            witness.ENDS_A_MOTION | witness.JUMPS)


if __name__ == "__main__":
    PROGRAM, SOURCE, LIBRARIES = sys.argv[1], pathlib.Path(sys.argv[2]), pathlib.Path(sys.argv[3])
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
