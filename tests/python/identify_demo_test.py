"""From a robot that nobody knows to its twin: over the wire, with the commands of docs/how-to/compare.md.

The robot is a twin with a hidden friction, load and delay, served in lockstep; whoever drives it knows its address only.
"""

import json
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np

import identify_robots as robots

import panda_twin as pt
from panda_twin import _host

PROGRAM = str(_host._executable())
SEED = 7
GAIN = 5  # by which the closed-loop prediction must improve


class Demo(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def command(self, *words, codes=(0,)):
        done = subprocess.run([PROGRAM, *map(str, words)], cwd=self.folder, capture_output=True, text=True, timeout=600)
        self.assertIn(done.returncode, codes, done.stdout + done.stderr)
        return done.stdout

    def serve(self):
        hidden = robots.scenario(robots.drawn(SEED), SEED)
        del hidden["motion"]
        # What a robot carries must be known to 1.5 Nm before `run` moves it.
        hidden["robot"] = {"q_start": robots.joints(pt.model.Q_READY, "rad"), "load": {"mass": "150 g", "position": ["20 mm", "0 mm", "60 mm"]}}
        (self.folder / "hidden.yaml").write_text(json.dumps(hidden))
        server = subprocess.Popen([PROGRAM, "serve", "hidden.yaml", "--drive", "lockstep", "--port", "0", "--hand-port", "0"],
                                  cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)  # fmt: skip
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.terminate)
        for line in server.stdout:
            if found := re.search(r"127\.0\.0\.1:(\d+)", line):
                return f"127.0.0.1:{found[1]}"
        self.fail("the server gave no address")

    def test_an_unknown_robot(self):
        address = self.serve()
        self.command("excite", "--for", "load", "--seconds", "30", "--out", "motion", "--run", "--backend", "fci", "--robot", address)
        fit = next(self.folder.glob("motion/**/run.mcap"))
        self.command("compare", fit, "--against", "motion/scenario.yaml", "--identify", "friction,load,delay", "--write", "mine.yaml", "--out", "first", codes=(0, 1))
        # Another motion judges.
        self.command("excite", "--for", "friction", "--seconds", "20", "--seed", "2", "--out", "other", "--run", "--backend", "fci", "--robot", address)
        judge = next(self.folder.glob("other/**/run.mcap"))
        prior = {"name": "prior", "motion": {"trajectory": {"unit": "rad", "waypoints": robots.swing(12, 0)}}}
        (self.folder / "prior.yaml").write_text(json.dumps(prior))
        (self.folder / "mine.twin.yaml").write_text(json.dumps(prior | {"name": "mine", "robot": {"profile": "mine.yaml"}}))
        difference = {}
        for name in ("prior.yaml", "mine.twin.yaml"):
            self.command("compare", judge, "--against", name, "--out", name + ".out", codes=(0, 1))
            found = json.loads((self.folder / (name + ".out") / "summary.json").read_text())
            difference[name] = found["closed"]["before"]["position_rms"]
        print(difference)
        before, after = (np.array(values) for values in difference.values())
        # What is left, 0.015 mrad, is the noise of both position sensors.
        self.assertGreater(np.linalg.norm(before), GAIN * np.linalg.norm(after))
        self.assertTrue(np.all(before > 3 * after), before / after)


if __name__ == "__main__":
    unittest.main()
