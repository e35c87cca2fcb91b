#!/usr/bin/env python3
"""Unmodified pylibfranka 0.21.3, franky-control 2.0.0 (libfranka 0.21) and franka-rs 0.4.0 (its own client), protocol 10, against `panda-twin serve --model fr3`:

    fr3_test.py PROGRAM SOURCE_TREE lockstep|realtime [unittest options]

In real time a motion that lost its messages to this machine is run again when a witness saw that.
"""

import importlib.util
import json
import math
import pathlib
import subprocess
import sys
import tempfile
import unittest

from twin_server import TwinServer

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""
SKIPPED = 77  # ctest's word for it
PROGRAMS = pathlib.Path(__file__).parent / "fr3_programs.py"
SCENARIO = """\
name: turn
robot: {model: fr3}
render: {enabled: false}
motion:
  trajectory:
    unit: rad
    velocity_scale: 0.3
    acceleration_scale: 0.3
    waypoints:
      - {q: [0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483]}
      - {q: [0.5, -0.6, 0.3, -2, 0.2, 1.8, 0.9]}
"""
JOINT_GOAL, POSITION_GOAL = 5e-3, 1e-3  # rad, m


def run_client(server, name, timeout=120):
    """What the program saw. libfranka blocks forever where a server is wrong: hence a process and a time limit."""
    try:
        done = subprocess.run([sys.executable, "-B", PROGRAMS, name, server.address], capture_output=True, text=True,
                              timeout=timeout)
    except subprocess.TimeoutExpired as hung:
        raise AssertionError(f"{name} hangs; server: {server.said()}") from hung
    if done.returncode != 0:
        raise AssertionError(f"{name} ended with {done.returncode}:\n{done.stdout}{done.stderr}\nserver: {server.said()}")
    return json.loads(done.stdout.splitlines()[-1])


class Fr3Test(unittest.TestCase):
    def run_program(self, name, *options):
        """What the program saw, of a server of its own."""
        def attempt():
            with TwinServer(PROGRAM, SOURCE, DRIVE, "--model", "fr3", *options) as server:
                return run_client(server, name)
        if DRIVE == "lockstep":
            return attempt()
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.ENDS_A_MOTION | witness.JUMPS, attempts=3)

    def test_reads_the_state_and_reckons_with_the_served_model(self):
        facts = self.run_program("pylibfranka_reads")
        self.assertEqual(facts["mode"], "Idle")
        self.assertAlmostEqual(facts["q"][3], -3 * math.pi / 4, delta=2e-3)
        self.assertAlmostEqual(facts["O_T_EE"][12], 0.307, delta=2e-3)
        self.assertLess(facts["asymmetry"], 1e-9)
        # At rest the sensors show gravity, by the client's own model of arm and hand: friction holds the rest.
        for joint, (tau, gravity) in enumerate(zip(facts["tau_J"], facts["gravity"])):
            self.assertAlmostEqual(tau, gravity, delta=0.5, msg=f"joint {joint + 1}")
        self.assertEqual(facts["m_load"], 0.5)
        self.assertGreater(abs(facts["gravity_with_load"][1] - facts["gravity"][1]), 0.5)
        self.assertAlmostEqual(facts["raised"], 0.02, delta=1e-3)

    def test_joint_positions(self):
        facts = self.run_program("pylibfranka_joint_positions")
        self.assertLess(facts["miss"], JOINT_GOAL)
        self.assertEqual(facts["mode"], "Idle")

    def test_joint_velocities(self):
        self.assertAlmostEqual(self.run_program("pylibfranka_joint_velocities")["turned"], 0.8 / math.pi, delta=0.02)

    def test_cartesian_poses(self):
        for moved, wanted in zip(self.run_program("pylibfranka_cartesian_pose")["moved"], (0.1, 0, -0.05)):
            self.assertAlmostEqual(moved, wanted, delta=3 * POSITION_GOAL)

    def test_cartesian_velocities(self):
        self.assertAlmostEqual(self.run_program("pylibfranka_cartesian_velocities")["moved"], 0.4 / math.pi, delta=0.01)

    def test_torques_without_a_motion_generator(self):
        facts = self.run_program("pylibfranka_torques")
        self.assertLess(facts["miss"], 0.05)
        self.assertGreater(facts["dq"], 0.1)
        self.assertEqual(facts["reference_moved"], 0)
        self.assertEqual(facts["mode"], "Idle")

    def test_asynchronous_goals(self):
        facts = self.run_program("pylibfranka_asynchronous")
        self.assertEqual(facts["reached"], "kTargetReached")
        self.assertGreater(facts["executing"], 300)
        self.assertLess(facts["miss"], JOINT_GOAL)
        self.assertEqual(facts["mode"], "Idle")

    def test_an_error_and_the_recovery_from_it(self):
        facts = self.run_program("pylibfranka_error")
        self.assertIn("joint_motion_generator_velocity_discontinuity", facts["said"])
        self.assertEqual((facts["reflex"], facts["mode"]), ("Reflex", "Idle"))

    def test_the_velocity_limit_shrinks_towards_the_end_of_the_range(self):
        facts = self.run_program("pylibfranka_too_fast_near_the_end")
        self.assertIn("joint_motion_generator_velocity_limits_violation", facts["said"])
        # 2 = sqrt(12 (2.7501 - q)) - 0.3
        self.assertAlmostEqual(facts["q"], 2.7501 - 2.3 ** 2 / 12, delta=5e-3)

    def test_the_hand(self):
        facts = self.run_program("pylibfranka_gripper")
        self.assertEqual((facts["version"], facts["moved"]), (3, True))
        self.assertAlmostEqual(facts["width"], 0.03, delta=1e-3)

    def test_franky_moves(self):
        facts = self.run_program("franky_moves")
        for moved, wanted in zip(facts["moved"], (0.05, 0, 0.05)):  # as seen from EE, whose z points down
            self.assertAlmostEqual(moved, wanted, delta=3 * POSITION_GOAL)
        self.assertAlmostEqual(facts["width"], 0.08, delta=2e-3)
        self.assertFalse(facts["errors"])

    def test_all_of_franka_rs(self):
        facts = self.run_program("franka_rs_all")
        self.assertEqual((facts["version"], facts["moved"], facts["mode"]), (10, True, "idle"))
        self.assertLess(facts["pose"], 1e-6)
        for joint, (tau, gravity) in enumerate(zip(facts["tau_J"], facts["gravity"])):
            self.assertAlmostEqual(tau, gravity, delta=0.5, msg=f"joint {joint + 1}")
        for backend in ("robot", "impedance"):
            for way in ("there", "back"):
                self.assertLess(facts[f"joint_{backend}_{way}"], JOINT_GOAL)
                self.assertLess(facts[f"cartesian_{backend}_{way}"], 4 * POSITION_GOAL)
        self.assertIn("preempted", facts["said"])
        self.assertAlmostEqual(facts["width"], 0.03, delta=1e-3)

    def test_our_own_client_drives_it_and_its_capture_is_read(self):
        with tempfile.TemporaryDirectory() as folder:
            scenario, capture = pathlib.Path(folder, "turn.yaml"), pathlib.Path(folder, "a.pcapng")
            scenario.write_text(SCENARIO)

            def attempt():
                with TwinServer(PROGRAM, SOURCE, DRIVE, "--model", "fr3", "--capture", capture) as server:
                    done = subprocess.run([PROGRAM, "run", scenario, "--data", pathlib.Path(SOURCE, "models"), "--out",
                                           pathlib.Path(folder, "out"), "--backend", "fci", "--robot", server.address],
                                          capture_output=True, text=True, timeout=120)
                    self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            attempt() if DRIVE == "lockstep" else witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.A_CLIENT)
            said = subprocess.run([PROGRAM, "decode", capture], capture_output=True, text=True, timeout=120).stdout
        for words in ("request 1: Get Robot Model", "Move, joint_position, joint_impedance", "accelerometer_top = ",
                      "asynchronous = 0", "status = 0 (success)"):
            self.assertIn(words, said)
        self.assertNotIn("damaged", said)

    def test_a_panda_is_refused(self):
        with TwinServer(PROGRAM, SOURCE, DRIVE) as server:
            said = run_client(server, "pylibfranka_refused")["said"]
        self.assertIn("Incompatible library version", said)
        self.assertIn("server version: 5", said.lower())


class LockstepTest(unittest.TestCase):
    """Of what the wall clock changes nothing."""

    def test_a_session_tells_of_torques_and_of_motions_right_after_each_other(self):
        with tempfile.TemporaryDirectory() as folder:
            out = pathlib.Path(folder, "session")
            with TwinServer(PROGRAM, SOURCE, DRIVE, "--model", "fr3", "--idle", "freeze", "--out", out, "--no-video") as server:
                run_client(server, "pylibfranka_torques")
                run_client(server, "franky_moves")
            motions = json.loads((out / "summary.json").read_text())["motions"]
            self.assertEqual((motions[0]["motion_generator"], motions[0]["controller"]), ("none", "external"))
            self.assertGreater(len(motions), 3)
            self.assertEqual({motion["end"] for motion in motions}, {"finished"})
            for number in range(1, len(motions) + 1):
                done = subprocess.run([PROGRAM, "explain", out / "motions" / str(number)], capture_output=True, text=True, timeout=60)
                self.assertIn(": no error;", done.stdout, f"motion {number}: {done.stdout}{done.stderr}")


if __name__ == "__main__":
    for module in ("pylibfranka", "franky", "franka"):
        if importlib.util.find_spec(module) is None:
            print(f"{module} is not there; scripts/setup installs it")
            sys.exit(SKIPPED)
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    unittest.main(defaultTest=None if DRIVE == "lockstep" else "Fr3Test", argv=[sys.argv[0], *sys.argv[4:]])
