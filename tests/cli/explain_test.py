#!/usr/bin/env python3
"""What explain says about runs of the simulated arm: explain_test.py PROGRAM SOURCE_TREE [unittest options]."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

READY = "[0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]"


def motion_to(goal, more):
    return f"""name: there
motion:
  trajectory:
    unit: rad
    duration: 4 s
    waypoints:
      - {{q: {READY}}}
      - {{q: {goal}}}
render: {{enabled: false}}
{more}"""


class ExplainTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_explain_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def call(self, *arguments):
        return subprocess.run([PROGRAM, *map(str, arguments)], cwd=self.folder, capture_output=True, text=True, timeout=120)

    def explain(self, scenario):
        """Of a run that an error ends."""
        (self.folder / "scenario.yaml").write_text(scenario)
        done = self.call("run", "scenario.yaml", "--out", "out", "--data", SOURCE / "models")
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        done = self.call("explain", "out")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        return " ".join(done.stdout.split())

    def test_names_finger_and_floor(self):
        text = self.explain(motion_to("[0, 1.4, 0, -1.0, 0, 1.5708, 0.7854]", "scene: scenes/floor.xml\n"))
        self.assertRegex(text, "aborted at .* by (joint|cartesian)_reflex")
        touching = re.search(r"touching (.*?) commands ", text)[1]
        self.assertRegex(touching, r"panda_(left|right)finger and floor at \(0\.\d+, .*\) m with up to [1-9]\d* N, ")
        # Advice about the command chain does not belong to a collision.
        self.assertNotIn("tick.", text)

    def test_names_the_scenarios_push(self):
        text = self.explain((SOURCE / "models/scenarios/collision.yaml").read_text())
        self.assertIn("The scenario pushes panda_hand with 30 N from 1.000 s to 1.800 s (perturbations)", text)

    def test_tells_by_how_much_commands_were_late(self):
        # A cycle has 0.9 ms for a command, and four of five commands take longer.
        text = self.explain(motion_to("[0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]", """plant: {kind: ideal}
link: {command_delay: {log_normal: {median: 1150 us, sigma: 0.3}}}
"""))
        self.assertIn("communication_constraints_violation", text)
        late = re.search(r"(\d+) because the command came too late, by (up to )?([\d.]+) ms", text)
        self.assertGreaterEqual(int(late[1]), 20)
        self.assertTrue(0 < float(late[3]) < 3, late[0])
        self.assertNotIn("was lost on its way", text)
        self.assertNotIn("the link lost", text)

    def test_motion_without_an_error_is_refused(self):
        self.explain(motion_to("[0, 1.4, 0, -1.0, 0, 1.5708, 0.7854]", "scene: scenes/floor.xml\n"))
        self.assertEqual(self.call("explain", "out", "--motion", "1").returncode, 0)
        for other in ("2", "0"):
            done = self.call("explain", "out", "--motion", other)
            self.assertEqual(done.returncode, 3)
            self.assertIn(f"no error ended motion {other} of there; errors ended motion 1", done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
