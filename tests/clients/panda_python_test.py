#!/usr/bin/env python3
"""Unmodified panda-python 1.1.1, which is libfranka 0.9.2 inside, against `panda-twin serve`:

    panda_python_test.py PROGRAM SOURCE_TREE lockstep|realtime [unittest options]

In real time a motion that lost its messages to this machine, or jumps where they came late, is run again when a witness saw that.
"""

import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

from twin_server import HAND_PORT, VACUUM_PORT, TwinServer

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import witness  # noqa: E402: found by the path above

PROGRAM, SOURCE, DRIVE = "", pathlib.Path(), ""
SKIPPED = 77  # ctest's word for it
HERE = pathlib.Path(__file__).parent
PROGRAMS = HERE / "panda_programs.py"
TABLE = "--scene", "scenes/table_box.xml"
REFLEX = "libfranka: Move command aborted: motion aborted by reflex! "
LAPSE, JUMP = "communication_constraints_violation", "discontinuity"
JOINT_GOAL, POSITION_GOAL = 5e-3, 1e-3  # rad, m
TOUCH = 0.3088  # m, height of the end effector where its fingertips, 8.8 mm below, touch the table


def run_client(server, name, timeout=120):
    """What the program saw, and all it said. libfranka blocks forever where a server is wrong: hence a process and a time
    limit."""
    with tempfile.TemporaryDirectory() as folder:  # libfranka keeps the served model there for a moment
        try:
            done = subprocess.run([sys.executable, "-B", PROGRAMS, name, server.address], capture_output=True, text=True,
                                  timeout=timeout, env={"TMPDIR": folder, "PATH": "/usr/bin:/bin"})
        except subprocess.TimeoutExpired as hung:
            raise AssertionError(f"{name} hangs; server: {server.said()}") from hung
    if done.returncode != 0:
        raise AssertionError(f"{name} ended with {done.returncode}:\n{done.stdout}{done.stderr}\nserver: {server.said()}")
    return json.loads(done.stdout.splitlines()[-1]), done.stdout + done.stderr


class PandaPythonTest(unittest.TestCase):
    def run_program(self, name, *options, meant=(), hand_port=HAND_PORT):
        """What the program saw, of a server of its own. meant: what ends its motion on purpose, of LAPSE and JUMP."""
        spoilt_by = {sign: cycles for sign, cycles in (witness.ENDS_A_MOTION | witness.JUMPS).items() if sign not in meant}

        def attempt():
            with TwinServer(PROGRAM, SOURCE, DRIVE, *options, hand_port=hand_port) as server:
                facts, said = run_client(server, name)
            for sign in spoilt_by:
                self.assertNotIn(sign, said)
            return facts
        if DRIVE == "lockstep":
            return attempt()
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, spoilt_by, attempts=3)

    def assert_reflex(self, text, errors, rate=1):
        """The whole text, letter by letter; in real time the machine decides on the share of commands that arrived."""
        names = ", ".join(f'"{name}"' for name in errors)
        rate = re.escape(str(rate))
        if DRIVE == "realtime":
            rate = r"(0\.\d+|1)( packets lost in a row in the last sample: \d+)?"
        self.assertRegex(text, "^" + re.escape(f"{REFLEX}[{names}]\ncontrol_command_success_rate: ") + rate + "$")

    def assert_aftermath(self, facts):
        """A reflex keeps motions out until it is recovered from; then the robot moves again."""
        self.assertEqual(facts["mode"], "kReflex")
        self.assertEqual(facts["refused"], "libfranka: Move command rejected: command not possible in the current mode"
                                           ' ("Reflex")!')
        self.assertEqual(facts["mode_recovered"], "kIdle")
        self.assertFalse(facts["errors_recovered"])
        self.assertEqual(facts["afterwards"], "")

    def test_connects_and_loads_the_served_model(self):
        facts = self.run_program("connect_and_load_model")
        self.assertEqual(facts["version"], 5)
        self.assertEqual(facts["mode"], "kIdle")
        self.assertLess(facts["model_pose_error"], 1e-9)
        # panda-python's own kinematics have the hand 0.4 mm shorter than the robot says it is.
        self.assertAlmostEqual(facts["own_kinematics_error"], 4e-4, delta=1e-6)
        self.assertLess(facts["mass_asymmetry"], 1e-12)
        self.assertGreater(facts["least_mass_eigenvalue"], 0)
        self.assertLess(facts["gravity_error"], 1.0)  # Nm; friction holds a little of it
        self.assertAlmostEqual(facts["m_total"], 0.73)

    def test_reaches_joint_positions(self):
        facts = self.run_program("joint_moves")
        self.assertEqual(facts["returned"], [True] * 4)
        self.assertLess(max(facts["errors"]), JOINT_GOAL)
        print(f"{DRIVE}: {facts['robot_seconds']:.1f} s of the robot in {facts['wall_seconds']:.2f} s: "
              f"{facts['robot_seconds'] / facts['wall_seconds']:.1f} times real time")

    def test_reaches_poses(self):
        facts = self.run_program("pose_moves")
        self.assertEqual(facts["returned"], [True] * 3)
        self.assertLess(max(facts["errors"]), POSITION_GOAL)
        self.assertLess(max(facts["turned"]), JOINT_GOAL)

    def test_controller_integrates_velocities(self):
        facts = self.run_program("integrated_velocity")
        self.assertLess(facts["error"], JOINT_GOAL)
        for way, velocity in zip(facts["way"], (0.1, 0, 0, 0.1, 0, 0, 0.2)):
            self.assertAlmostEqual(way, 2 * velocity, delta=0.1 * abs(velocity) + JOINT_GOAL)  # told by polling

    def test_controller_follows_joint_positions(self):
        self.assertLess(self.run_program("joint_position")["error"], JOINT_GOAL)

    def test_controller_holds_a_pose_by_impedance(self):
        self.assertLess(self.run_program("cartesian_impedance")["error"], POSITION_GOAL)

    def test_controller_presses_with_a_force(self):
        facts = self.run_program("force_on_table", *TABLE)
        self.assertAlmostEqual(facts["force"][2], -5, delta=0.5)  # positive is what the robot pushes
        self.assertAlmostEqual(facts["height"], TOUCH, delta=2e-3)

    def test_hand_grasps_and_lifts_the_box(self):
        facts = self.run_program("grasp_box", *TABLE)
        self.assertEqual(facts["version"], 3)
        self.assertIs(facts["homing"], True)
        self.assertAlmostEqual(facts["max_width"], 0.08, delta=1e-3)
        self.assertAlmostEqual(facts["open_width"], 0.08, delta=1e-3)
        self.assertIs(facts["grasped_before"], False)
        self.assertIs(facts["empty_grasp"], False)
        self.assertIs(facts["moved"], True)
        self.assertIs(facts["grasp"], True)
        for when in ("", "_lifted"):
            self.assertIs(facts["grasped" + when], True)
            self.assertAlmostEqual(facts["width" + when], 0.05, delta=1e-3)
        self.assertIs(facts["stop"], True)
        self.assertIs(facts["released"], True)
        self.assertIs(facts["grasped_after"], False)

    def test_vacuum_gripper_fetches_the_box_and_drops_it(self):
        facts = self.run_program("vacuum_box", HERE / "vacuum.yaml", hand_port=VACUUM_PORT)
        self.assertEqual(facts["version"], 1)
        nothing = {"present": False, "detached": False, "in_range": False, "status": "kGreen", "power": 0, "vacuum": 0}
        self.assertEqual(facts["before"], nothing)
        self.assertIs(facts["in_the_air"], False)
        self.assertEqual(facts["after_air"], nothing | {"status": "kYellow"})
        self.assertIs(facts["held"], True)
        lifted = facts["lifted"]
        self.assertEqual((lifted["present"], lifted["in_range"], lifted["detached"]), (True, True, False))
        self.assertAlmostEqual(lifted["vacuum"], 600, delta=10)
        self.assertAlmostEqual(facts["weight"], 0.5 * 9.81, delta=0.3)
        self.assertIs(facts["dropped"], True)
        self.assertEqual(facts["after_drop"], nothing | {"detached": True})
        self.assertIs(facts["again_in_the_air"], False)
        self.assertIs(facts["found"], True)
        self.assertIs(facts["stopped"], True)
        self.assertEqual(facts["at_the_end"], nothing | {"detached": True})

    def test_says_which_limit_a_jump_in_acceleration_broke(self):
        facts = self.run_program("jerk_too_large", meant=[JUMP])
        self.assert_reflex(facts["text"], ["joint_motion_generator_acceleration_discontinuity"])
        self.assert_aftermath(facts)

    def test_says_which_limits_a_jump_in_velocity_broke(self):
        facts = self.run_program("acceleration_too_large", meant=[JUMP])
        self.assert_reflex(facts["text"], ["joint_motion_generator_velocity_discontinuity",
                                           "joint_motion_generator_acceleration_discontinuity"])
        self.assert_aftermath(facts)

    def test_says_that_a_torque_jumped(self):
        facts = self.run_program("torque_step", meant=[JUMP])
        self.assert_reflex(facts["text"], ["controller_torque_discontinuity"])
        self.assert_aftermath(facts)

    def test_a_client_that_sleeps_loses_its_motion_in_real_time_only(self):
        facts = self.run_program("sleeper", meant=[LAPSE])
        if DRIVE == "lockstep":
            self.assertEqual(facts["text"], "")  # a slow client is waited for
            return
        self.assertRegex(facts["text"], "^" + re.escape(f'{REFLEX}["{LAPSE}"]\ncontrol_command_success_rate: ') + r"-?\d")  # libfranka's, below 0 when it saw few states
        self.assert_aftermath(facts)

    def test_says_that_it_was_pushed(self):
        facts = self.run_program("held", HERE / "push.yaml")
        self.assert_reflex(facts["text"], ["cartesian_reflex"])
        self.assert_aftermath(facts)

    def test_says_that_20_commands_in_a_row_were_lost(self):
        facts = self.run_program("held", HERE / "outage.yaml", meant=[LAPSE])
        self.assert_reflex(facts["text"], [LAPSE], rate=0.81)
        self.assert_aftermath(facts)

    def test_a_collision_with_the_table_is_a_reflex_and_the_arm_moves_again(self):
        facts = self.run_program("collision", *TABLE)
        # Which thresholds the impact passes in one cycle is a matter of the physics.
        self.assertRegex(facts["text"], "^" + re.escape(REFLEX) +
                         r'\["(joint_reflex", ")?cartesian_reflex"(, "tau_J_range_violation")?\]\ncontrol_command_success_rate: ')
        self.assertAlmostEqual(facts["height"], TOUCH, delta=0.01)
        self.assertTrue(any(facts["collision"]))
        self.assert_aftermath(facts)
        self.assertTrue(facts["returned"])

    def test_stop_from_another_thread_preempts_the_motion(self):
        facts = self.run_program("preempted")
        self.assertEqual(facts, {"text": "libfranka: Move command preempted!", "mode": "kIdle"})

    def test_nothing_is_set_during_a_motion(self):
        facts = self.run_program("setter_during_motion")
        self.assertEqual(facts["text"], "libfranka: Set Load command rejected: command not possible in the current mode"
                                        ' ("Move")!')

    def test_what_is_set_shows_in_the_state(self):
        facts = self.run_program("setters")
        self.assertEqual(facts["EE_T_K"], facts["frame"])
        self.assertEqual(facts["m_load"], 0.5)
        self.assertAlmostEqual(facts["m_total"], 0.5, delta=1e-12)
        self.assertAlmostEqual(facts["z_of_EE_in_flange"], 0.1034 + 0.03, delta=1e-9)
        self.assertEqual(facts["bad"], "libfranka: Set Joint Impedance command rejected: invalid argument!")

    def test_every_raw_interface_moves_the_arm(self):
        ways = self.run_program("raw_interfaces")["ways"]
        self.assertEqual(len(ways), 10)
        for name in ("joint_position", "joint_velocity"):
            self.assertAlmostEqual(ways[name][0], 0.02, delta=JOINT_GOAL)
        for name in ("cartesian_pose", "cartesian_velocity", "cartesian_pose_impedance"):
            self.assertAlmostEqual(ways[name][1], 0.02, delta=2e-3)
        for name in ("torque_joint_position", "torque_joint_velocity", "torque_cartesian_pose", "torque_cartesian_velocity"):
            self.assertLess(ways[name][0], 0.05)  # torques of zero decide, not the motion


if __name__ == "__main__":
    if importlib.util.find_spec("panda_py") is None:
        print("missing: panda-python is not installed: scripts/setup")
        sys.exit(SKIPPED)
    PROGRAM, SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    unittest.main(argv=[sys.argv[0], *sys.argv[4:]])
