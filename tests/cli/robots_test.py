#!/usr/bin/env python3
"""The robots that the program knows, and another one added as a folder: robots_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

SCENARIO = """name: turn
robot: {model: %s}
render: {enabled: false}
motion:
  trajectory:
    unit: rad
    velocity_scale: 1
    acceleration_scale: 0.5
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [1.5, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""


class RobotsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_robots_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.models = self.folder / "models"
        shutil.copytree(SOURCE / "models", self.models)

    def twin(self, *arguments):
        return subprocess.run([PROGRAM, *arguments, "--data", self.models], capture_output=True, text=True, timeout=300)

    def add_robot(self, name):
        """A folder beside the Panda's, of an arm that turns at half its speed at most."""
        robot = self.models / "robots" / name
        shutil.copytree(self.models / "robots/panda", robot)
        (robot / "panda.urdf").rename(robot / f"{name}.urdf")
        for file in robot.glob("*.yaml"):
            text = file.read_text().replace("robot: panda", f"robot: {name}")
            file.write_text(text.replace("2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61", "1, 1, 1, 1, 1.3, 1.3, 1.3"))
        return robot

    def test_lists_what_is_known(self):
        done = self.twin("robots")
        self.assertEqual(done.returncode, 0, done.stderr)
        for line in ("panda       Franka Emika Panda (FER) (arm, FCI protocol 5)", "fr3         Franka Research 3 (arm, FCI protocol 10)", "hand        Franka hand (hand)",
                     "husky       Clearpath Husky A200 (base)", "cobot_pump  Cobot pump (vacuum gripper) (hand)"):
            self.assertIn(line, done.stdout)

    def test_shows_the_figures_of_an_arm_and_where_they_come_from(self):
        done = self.twin("robots", "panda")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"dq_max +2\.175 +2\.175 +2\.175 +2\.175 +2\.61 +2\.61 +2\.61 rad/s\n")
        self.assertRegex(done.stdout, r"translation +1\.7 m/s, 13 m/s\^2, 6500 m/s\^3\n")
        self.assertIn("- inertias about the centre of mass, links 1 to 7\n    Gaz, Cognetti", done.stdout)

    def test_names_those_there_are_when_one_is_unknown(self):
        done = self.twin("robots", "fr4")
        self.assertEqual(done.returncode, 3)
        self.assertIn('robot "fr4" is unknown', done.stderr)
        self.assertIn("cobot_pump, fr3, hand, husky, panda", done.stderr)

    def test_another_arm_is_a_folder(self):
        self.add_robot("slow")
        self.assertIn("slow        Franka Emika Panda (FER) (arm, FCI protocol 5)", self.twin("robots").stdout)
        seconds = {}
        for robot in ("panda", "slow"):
            scenario = self.folder / f"{robot}.yaml"
            scenario.write_text(SCENARIO % robot)
            out = self.folder / robot
            done = self.twin("run", scenario, "--out", out)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            seconds[robot] = json.loads((out / "summary.json").read_text())["simulated_s"]
        self.assertGreater(seconds["slow"], 1.2 * seconds["panda"])

    def test_a_wrong_description_is_refused(self):
        robot = self.add_robot("other") / "robot.yaml"
        scenario = self.folder / "s.yaml"
        scenario.write_text(SCENARIO % "other")
        text = robot.read_text()
        for old, new, message in (("protocol: 5", "protocol: 10", "no model library"), ("protocol: 5", "protocol: 7", "5 and 10"),
                                  ("model: library", "model: books", "model"), ("kind: arm", "kind: leg", "kind"),
                                  ("robot: other", "robot: panda", "must agree"), ("title:", "titel:", "titel")):
            robot.write_text(text.replace(old, new))
            for done in (self.twin("robots", "other"), self.twin("validate", scenario)):
                self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
                self.assertIn("robot.yaml", done.stderr)
                self.assertIn(message, done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
