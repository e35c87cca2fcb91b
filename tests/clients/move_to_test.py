#!/usr/bin/env python3
"""`panda-twin move-to`, in the twin and on a served one: move_to_test.py PROGRAM SOURCE_TREE [unittest options].
"""

import json
import math
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile
import unittest

import own_client_test
from twin_server import TwinServer

PROGRAM, SOURCE = "", pathlib.Path()


class MoveToTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)

    def program(self, *words, code=0):
        done = subprocess.run([PROGRAM, *words, "--data", SOURCE / "models", "--out", self.tmp / "out"], capture_output=True, text=True,
                              timeout=120, stdin=subprocess.DEVNULL, env=dict(os.environ, XDG_STATE_HOME=str(self.tmp / "state")))
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def summary(self):
        return json.loads((self.tmp / "out/summary.json").read_text())

    @staticmethod
    def there(server, *flags):
        return ["--backend", "fci", "--robot", server.address, "--robot-time", "states", *flags]

    def scenario(self, start):
        path = self.tmp / "scenario.yaml"
        path.write_text(own_client_test.MOTION.replace("INTERFACE", "joint_position").replace("CONTROLLER", "").replace("START", start))
        return path

    def test_a_pose_is_reached_slowly(self):
        goal = [10, -45, 0, -135, 0, 90, 45]
        times = []
        for share in ("0.2", "0.4"):
            self.program("move-to", ",".join(map(str, goal)) + "deg", "--no-video", "--max-speed", share)
            summary = self.summary()
            for reached, wanted in zip(summary["q_final_rad"], goal):
                self.assertAlmostEqual(reached, math.radians(wanted), delta=1e-3)
            times.append(summary["plan"]["duration_s"])
        self.assertAlmostEqual(times[0], 2 * times[1], places=6)

    def test_a_start_that_is_far_names_the_command_that_brings_the_arm_there(self):
        scenario = self.scenario("0.5")  # the served arm's last joint is at pi/4
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            refused = self.program("run", scenario, *self.there(server), code=1)
            self.assertRegex(refused.stdout, r"(?m)^FAILED start ")
            command = shlex.split(re.search(r"panda-twin (move-to .*)$", refused.stderr, re.MULTILINE).group(1))
            data = ["--data", str(SOURCE / "models")]  # as program() says it
            self.assertEqual(command, ["move-to", "start-of", str(scenario), *data, *self.there(server)])
            moved = self.program(*command[:3], *command[5:])
            self.assertRegex(moved.stdout, r"(?m)^ok +path +planned around")
            self.program("run", scenario, *self.there(server))
            self.assertEqual(self.summary()["outcome"], "success")
            # The motion ends at pi/4 again; an arm that is there already does not move.
            self.assertIn("stands there already", self.program("move-to", "ready", *self.there(server)).stdout)

    def test_a_real_arm_is_asked_for_and_never_blindly(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            goal = ["move-to", "0,-0.7,0,-2.3,0,1.5,0.7", *self.there(server, "--allow-hardware")]
            self.assertIn("say --yes", self.program(*goal, code=3).stderr)
            self.assertFalse((self.tmp / "out").exists())
            self.program(*goal, "--yes")
        record = self.summary()["hardware"]
        self.assertEqual((record["max_speed"], record["confirmed"]), (0.1, False))
        self.assertIn("plans from where the arm stands", record["no_rehearsal"])

    def test_goes_around_what_a_scenario_says_stands_there(self):
        table = SOURCE / "models/scenarios/grasp.yaml"
        into = "0,0.1,0,-2.3,0,2.4,-0.785"  # the fingertips are 0.20 m high, the table 0.30 m
        self.assertIn("table", self.program("move-to", into, "--in", table, "--no-video", code=3).stderr)
        self.program("move-to", into, "--lab", "b", "--no-video", "--max-speed", "1")  # without the table, at a site

    def test_says_what_is_wrong_with_a_goal(self):
        for goal, why in ((["0,1,2"], "is not a pose"), (["0,0,0,-1,0,1,0,0"], "is not a pose"), (["a,0,0,-1,0,1,0"], "is not a pose"),
                          (["ready", "x.yaml"], "one pose"), (["start-of"], "needs a scenario"),
                          (["0,0,0,1,0,1,0"], "joint 4")):
            with self.subTest(goal=goal):
                self.assertIn(why, self.program("move-to", *goal, "--no-video", code=3).stderr)
        self.assertFalse((self.tmp / "out").exists())


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
