#!/usr/bin/env python3
"""`panda-twin serve --guard` and clients that know of no limits: serve_guard_test.py PROGRAM SOURCE_TREE [unittest options]."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "clients"))
from twin_server import TwinServer  # noqa: E402

PROGRAM, SOURCE = "", pathlib.Path()

# Joint 1 turns by 1 rad in 2 s: the end effector, half a metre from its axis, would get to y = 0.4 m.
SCENARIO = """name: turn
plant: {kind: ideal}
render: {enabled: false}
motion:
  trajectory:
    unit: rad
    duration: 2 s
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""
WALL = """limits:
  regions:
    - {name: wall, what: [end_effector], keep: inside, half_space: {normal: [0, 1, 0], offset: 0.2 m}}
"""


class ServeGuardTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_serve_guard_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.free = self.write("free.yaml", SCENARIO)

    def write(self, name, text):
        file = self.folder / name
        file.write_text(text)
        return file

    def run_client(self, server):
        return subprocess.run([PROGRAM, "run", self.free, "--backend", "fci", "--robot", server.address, "--robot-time", "states",
                               "--data", SOURCE / "models", "--no-video", "--out", self.folder / "out"],
                              capture_output=True, text=True, timeout=120)

    def assert_stopped(self, limits, error, line):
        with TwinServer(PROGRAM, SOURCE, "lockstep", self.write("limited.yaml", SCENARIO + limits), "--guard") as server:
            done = self.run_client(server)
            self.assertNotEqual(done.returncode, 0, done.stdout)
            self.assertIn(error, done.stdout + done.stderr)
            self.assertRegex(server.said(), line)

    def test_a_region_ends_the_motion_with_its_name_value_and_bound(self):
        self.assert_stopped(WALL, "cartesian_position_limits_violation",
                            r'Guard: limit "wall": the end effector reaches y = 0\.20\d* m; it must be at most 0\.2000+ m; the stop '
                            r"would pass it by [0-9.]+ mm")

    def test_explain_names_the_limit_as_the_server_does(self):
        log = pathlib.Path(self.folder, "guarded.mcap")
        with TwinServer(PROGRAM, SOURCE, "lockstep", self.write("limited.yaml", SCENARIO + WALL), "--guard", "--log", log) as server:
            self.run_client(server)
            line = re.search(r"([\d.]+) s  arm: motion aborted .* Guard: (.*)", server.said())
        done = subprocess.run([PROGRAM, "explain", log], capture_output=True, text=True, timeout=60)
        said = " ".join(done.stdout.split())
        self.assertIn(f"value {line[2]}.", said, done.stderr)
        # The line has the robot's time, that of the cycle or, as it is told on another thread, shortly after.
        cycle = float(re.search(r"cycle of state \d+, ([\d.]+) s", said)[1])
        self.assertTrue(cycle <= float(line[1]) <= cycle + 1, line[0])

    def test_a_cap_on_speed_ends_the_motion(self):
        self.assert_stopped("limits: {speed: {joints: 0.3 rad/s}}\n", "joint_velocity_violation",
                            r"Guard: limit speed\.joints: joint 1 moves at 0\.3\d* rad/s; the bound is 0\.3 rad/s")

    def test_without_guard_the_robot_has_no_such_limit(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep", self.write("limited.yaml", SCENARIO + WALL)) as server:
            done = self.run_client(server)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_guard_without_limits_is_refused(self):
        done = subprocess.run([PROGRAM, "serve", self.free, "--guard", "--port", "0", "--hand-port", "0", "--for", "0.1", "--drive",
                               "lockstep", "--data", SOURCE / "models"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertIn("--guard: there is nothing to guard", done.stderr)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
