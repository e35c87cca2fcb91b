#!/usr/bin/env python3
"""`panda-twin run --backend fci` from outside: own_client_test.py PROGRAM SOURCE_TREE DRIVE [unittest options].

DRIVE is that of the server: lockstep or realtime. A run that this machine spoilt, as a witness saw, is repeated.
"""

import csv
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from twin_server import TwinServer

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""

MOTION = """\
name: there_and_back
CONTROLLER
motion:
  interface: INTERFACE
  trajectory:
    unit: rad
    duration: 1 s
    waypoints:
      - {q: [0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, START]}
      - {q: [0.05, -0.7853981633974483, 0.03, -2.356194490192345, 0, 1.5707963267948966, 0.8], stop: false}
      - {q: [0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483]}
"""


def rows(folder, table):
    with open(folder / "csv" / table, newline="") as file:
        return list(csv.DictReader(file))


class OwnClientTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)

    def scenario(self, interface="joint_position", start="0.7853981633974483", controller=""):
        path = self.tmp / "scenario.yaml"
        text = MOTION.replace("INTERFACE", interface).replace("START", start).replace("CONTROLLER", controller)
        path.write_text(text)
        return path

    def run_there(self, server, scenario, out, *flags):
        return subprocess.run([PROGRAM, "run", scenario, "--backend", "fci", "--robot", server.address, "--data", SOURCE / "models", "--out", out, *flags], capture_output=True, text=True, timeout=120)

    def succeed(self, scenario, out, *flags, serve=()):
        """Runs it on a robot of its own."""
        def attempt():
            with TwinServer(PROGRAM, SOURCE, DRIVE, *serve) as server:
                done = self.run_there(server, scenario, out, *flags)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            return done
        if DRIVE == "lockstep":
            return attempt()
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.A_CLIENT)

    def test_every_interface_reaches_the_goal(self):
        for interface in ("joint_position", "joint_velocity", "cartesian_pose", "torque"):
            with self.subTest(interface=interface):
                out = self.tmp / interface
                self.succeed(self.scenario(interface), out)
                summary = json.loads((out / "summary.json").read_text())
                self.assertEqual(summary["outcome"], "success")
                self.assertEqual(summary["drive"], "remote")
                self.assertIsNone(summary["cycles_served"])
                self.assertLess(summary["final_error_rad"], 2e-2)

    def test_prints_its_checks_and_logs_states_and_ticks(self):
        out = self.tmp / "out"
        done = self.succeed(self.scenario(), out)
        for subject in ("reach", "states", "mode", "errors", "joint limits", "settings", "payload", "torques", "start",
                        "communication", "scheduler"):
            self.assertRegex(done.stdout, rf"(?m)^ok +{subject} ")
        self.assertIn("no video is made", done.stderr)
        self.assertFalse((out / "video.mp4").exists())
        subprocess.run([PROGRAM, "export", out / "run.mcap", "--out", out / "csv"], check=True, capture_output=True)
        cycles, ticks = rows(out, "cycles.csv"), rows(out, "ticks.csv")
        self.assertEqual([row["message_id"] for row in cycles], [row["message_id"] for row in ticks])
        # In wall-clock time a client does not get each state; the robot's own count tells how long the motion took.
        self.assertGreater(int(cycles[-1]["message_id"]) - int(cycles[0]["message_id"]), 1000)
        self.assertGreater(len(cycles), 1000 if DRIVE == "lockstep" else 500)
        explained = subprocess.run([PROGRAM, "explain", out, "--out", out], capture_output=True, text=True)
        self.assertEqual(explained.returncode, 0, explained.stderr)

    def test_a_slower_motion_takes_longer(self):
        out = self.tmp / "slow"
        self.succeed(self.scenario(), out, "--max-speed", "0.25")
        self.assertGreater(json.loads((out / "summary.json").read_text())["simulated_s"], 4)

    def test_an_arm_that_is_elsewhere_is_not_moved(self):
        log = self.tmp / "served.mcap"
        with TwinServer(PROGRAM, SOURCE, DRIVE, "--log", log) as server:
            done = self.run_there(server, self.scenario(start="0.9"), self.tmp / "out")
        self.assertEqual(done.returncode, 1)
        subprocess.run([PROGRAM, "export", log, "--out", self.tmp / "csv"], check=True, capture_output=True)
        self.assertEqual({row["robot_mode"] for row in rows(self.tmp, "cycles.csv")}, {"Idle"})
        self.assertRegex(done.stdout, r"(?m)^FAILED start +joint 7 is 0.1146 rad")
        self.assertIn("the arm was not moved", done.stderr)
        self.assertFalse((self.tmp / "out" / "run.mcap").exists())

    def test_a_robot_that_is_not_there_is_named(self):
        scenario = self.scenario()
        done = subprocess.run([PROGRAM, "run", scenario, "--backend", "fci", "--robot", "127.0.0.1:9", "--data", SOURCE / "models",
                               "--out", self.tmp / "out"], capture_output=True, text=True, timeout=60)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stdout, r"(?m)^FAILED reach ")
        self.assertIn("127.0.0.1:9", done.stderr)

    def test_the_same_run_gives_the_same_commands(self):
        motions = []
        for number in range(2):
            out = self.tmp / str(number)
            # Else the wall clock decides how many states come before a motion's first command.
            self.succeed(self.scenario(controller="controller: {rate: 100 Hz}"), out, serve=("--idle", "freeze"))
            subprocess.run([PROGRAM, "export", out / "run.mcap", "--out", out / "csv"], check=True, capture_output=True)
            motions.append([[row[f"q_c[{j}]"] for j in range(7)] for row in rows(out, "ticks.csv")
                            if row["action"] in ("written", "finished")])
        self.assertGreater(len(motions[0]), 1000)
        self.assertEqual(motions[0], motions[1])


if __name__ == "__main__":
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    if DRIVE != "lockstep":
        del OwnClientTest.test_the_same_run_gives_the_same_commands  # the wall clock never repeats
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
