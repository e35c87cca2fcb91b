#!/usr/bin/env python3
"""Streams of joint positions from nodes of real ROS 2, as ros2_control's topic-based hardware sends them: arguments as ros2_rclpy_test's."""

import math
import os
import pathlib
import subprocess
import sys
import tempfile
import time
import unittest

import ros2_partner
from ros2_partner import ARM, JOINTS, Partner, Twin, goal_of, seconds_of

PROGRAM = sys.argv[1]
ros2_partner.enter(sys.argv[2])
from control_msgs.action import FollowJointTrajectory  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from ros2_served import ABORTED, SUCCEEDED, Served  # noqa: E402

RAW = """name: raw_stream
robot: {q_start: {unit: rad, values: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
tick: {generator: none}
"""


class StreamTest(Served):
    def setUp(self):
        super().setUp()
        self.publisher = self.writer_of(self.partner)

    def tearDown(self):
        self.partner.arm(False)
        self.partner.rest()
        self.partner.node.destroy_publisher(self.publisher)

    @staticmethod
    def writer_of(partner):
        publisher = partner.node.create_publisher(JointState, "/robot_joint_commands", QoSProfile(depth=1))
        partner.until(lambda: publisher.get_subscription_count() > 0)
        return publisher

    def tells(self, text):
        self.partner.until(lambda: text in self.told(), f"the twin did not say: {text}")

    def put(self, publisher, position, names=JOINTS, age=0):
        message = JointState(name=list(names), position=list(position))
        message.header.stamp = self.partner.node.get_clock().now().to_msg()
        message.header.stamp.sec -= age
        publisher.publish(message)
        return seconds_of(message.header.stamp), message.position[0] if message.position else 0.0

    def stream(self, seconds, by=lambda t: 0.0, rate=100, start=None):
        """Joint positions with jitter from where the arm is. @returns what was sent."""
        start = start or self.partner.state()[:7]
        begin = time.monotonic()
        sent = []
        for i in range(int(seconds * rate)):
            due = begin + i / rate + ros2_partner.random.uniform(0, 0.3 / rate)
            while time.monotonic() < due:
                self.partner.spin(max(min(0.002, due - time.monotonic()), 0))
            sent.append(self.put(self.publisher, [q + by(i / rate) for q in start]))
        return sent

    def lead(self):
        """The arm follows a stream that stands."""
        self.assertTrue(self.partner.arm().success)
        _, start = self.partner.rest()
        end = time.monotonic() + ros2_partner.PATIENCE
        while "the arm follows" not in self.told():
            self.assertLess(time.monotonic(), end, "the arm does not follow")
            self.stream(0.1, start=start[:7])
        return start[:7]

    def test_unarmed_commands_are_ignored(self):
        start = self.partner.state()
        self.stream(0.5, lambda t: 0.05)
        self.tells("is not armed for it")
        self.stays(start)

    def test_follows(self):
        self.assertTrue(self.partner.arm().success)
        ages = []
        self.partner.node.create_subscription(JointState, "/joint_states", lambda m: ages.append(time.time() - seconds_of(m.header.stamp)), 10)
        for amplitude in (0.2, -0.2, 0.2, -0.2):
            start = self.partner.state()
            ages.clear()
            sent = self.stream(3.5, lambda t: amplitude * ros2_partner.swing(min(max((t - 0.5) / 2, 0), 1))[0])
            states = self.partner.states[:]
            late = max(ages) - min(ages) + sum(by for _, by in ros2_partner.leaps_of(states))
            gap = max(b - a for (a, _), (b, _) in zip(sent, sent[1:]))
            self.tells("the commands have ended; the arm rests")
            self.since = len(self.twin.told())
            _, end = self.partner.rest()
            self.assertLess(abs(end[0] - start[0] - amplitude), 0.005)
            error, delay = ros2_partner.stream_error(states, sent)
            print(f"  stream of 100 Hz with jitter: {1e3 * error:.2f} mrad, {1e3 * delay:.0f} ms later; "
                  f"this host was up to {1e3 * late:.0f} ms late, between commands {1e3 * gap:.0f} ms")
            if error < 0.005:
                break
        fastest = 0.2 * math.pi / 4  # rad/s
        self.assertLess(error, 0.005 + fastest * (max(gap - 0.02, 0) + max(late - 0.02, 0)))
        self.stream(1.0)  # it may begin anew
        self.tells("the arm follows")

    def test_another_commander_is_ignored(self):
        start = self.lead()
        other = Partner("other")
        try:
            second = self.writer_of(other)
            while "commands the arm too" not in self.told():
                self.stream(0.05, start=start)
                self.put(second, [q + 0.05 for q in start])
            self.stays(start)
        finally:
            other.end()

    def test_a_goal_does_not_fight_with_the_stream(self):
        start = self.lead()
        goal = self.partner.send(FollowJointTrajectory, ARM, goal_of(start))
        self.stream(0.3, start=start)
        response = self.partner.wait(goal.get_result_async())
        self.assertEqual((response.status, response.result.error_code), (ABORTED, -1))
        self.assertIn("the arm follows /robot_joint_commands", response.result.error_string)
        self.tells("the commands have ended")
        self.assertNotIn("motion was ended", self.told())
        self.stays(start)
        goal = self.partner.send(FollowJointTrajectory, ARM, goal_of(start, seconds=2.0))
        self.stream(1.0, start=start)
        self.tells("the arm is busy")
        response = self.partner.wait(goal.get_result_async())
        self.assertEqual((response.status, response.result.error_string), (SUCCEEDED, ""))

    def test_what_is_no_command(self):
        self.partner.arm()
        _, start = self.partner.rest()
        q = start[:7]
        for names, position, age, text in (([*JOINTS[:6], "panda_joint8"], q, 0, "lacks panda_joint7"), (JOINTS, [math.nan] * 7, 0, "is commanded to nan"),
                                           (JOINTS, [9.0] * 7, 0, "is commanded to 9"), (JOINTS, [], 0, "has no positions"),
                                           (JOINTS, q, 100, "s ago; 1 s are permitted")):  # as of a bag that is played
            end = time.monotonic() + ros2_partner.PATIENCE
            while text not in self.told():
                self.assertLess(time.monotonic(), end, f"the twin did not say: {text}")
                self.put(self.publisher, position, names, age)
                self.partner.spin_for(0.1)
            self.since = len(self.twin.told())
        self.stays(start)
        self.stream(0.5, start=[x + 0.2 for x in q])
        self.tells("begin to command from where the arm is; arm it again")
        self.stays(start)

    def test_what_is_no_command_changes_nothing_on_the_way(self):
        start = self.lead()
        for position in ([math.nan] * 7, [9.0] * 7, start[:6]):
            self.put(self.publisher, position)
            self.stream(0.1, start=start)
        self.stays(start)
        self.partner.arm(False)
        self.tells("the motion was ended")
        self.stays(start)
        self.is_well()

    def test_unarmed_is_told_after_other_complaints(self):
        self.partner.arm()
        end = time.monotonic() + ros2_partner.PATIENCE
        while "is commanded to nan" not in self.told():
            self.assertLess(time.monotonic(), end)
            self.put(self.publisher, [math.nan] * 7)
            self.partner.spin_for(0.02)
        self.partner.arm(False)
        start = self.partner.state()
        end = time.monotonic() + 3
        while "is not armed for it" not in self.told():
            self.assertLess(time.monotonic(), end, "commands are ignored without a word")
            self.put(self.publisher, start[:7])
            self.partner.spin_for(0.05)


class ReflexTest(Served):
    """A robot whose stream nothing smooths."""

    @classmethod
    def setUpClass(cls):
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as scenario:
            scenario.write(RAW)
            scenario.flush()
            cls.words = [scenario.name, *Served.words, "--ros-arm"]
            super().setUpClass()

    def test_goals_are_refused_until_recovery(self):
        publisher = StreamTest.writer_of(self.partner)
        _, start = self.partner.rest()
        end = time.monotonic() + ros2_partner.PATIENCE
        begin = time.monotonic()
        while "arm it again" not in self.told():
            self.assertLess(time.monotonic(), end, "the raw stream did not abort")
            t = time.monotonic() - begin
            publisher.publish(JointState(name=JOINTS, position=[q + 0.05 * math.sin(t)**2 for q in start[:7]]))
            self.partner.spin_for(0.01)
        print("  raw stream:", self.told().split("arm it again")[0].splitlines()[-1].strip())
        _, start = self.partner.rest()
        self.assertEqual(self.twin.ctl("status")["mode"], "Reflex")
        status, result = self.follow(goal_of(start))
        self.assertEqual((status, result.error_code), (ABORTED, -1))
        self.assertIn("after a reflex call the service ~/recover", result.error_string)
        self.stays(start)
        answer = self.partner.call(Trigger, "/panda_twin/recover")
        self.assertTrue(answer.success, answer.message)
        self.is_well()


class LockstepTest(unittest.TestCase):
    """Time stands until the partner has answered."""

    def run_once(self, log, end=4.0):
        twin = Twin(PROGRAM, "--drive", "lockstep", "--idle", "freeze", "--ros-lockstep", "100", "--ros-arm", "--log", log)
        partner = Partner()
        publisher = partner.node.create_publisher(JointState, "/robot_joint_commands", QoSProfile(depth=1))
        start = {}

        def answer(state):
            at = seconds_of(state.header.stamp)
            if not start:
                start.update(at=at, q=list(state.position))
            if publisher.get_subscription_count() == 0:
                return
            if at >= end:  # time stands here
                start["over"] = True
                return
            by = 0.2 * ros2_partner.swing(min(max((at - start["at"] - 0.5) / 2, 0), 1))[0]
            command = JointState(name=JOINTS, position=[q + by for q in start["q"]])
            command.header.stamp = state.header.stamp
            publisher.publish(command)

        partner.node.create_subscription(JointState, "/robot_joint_states", answer, QoSProfile(depth=1))
        try:
            partner.until(lambda: start.get("over"), "robot time did not come to 4 s")
            partner.arm(False)
            partner.until(lambda: "the arm rests" in twin.told(), "the motion did not end")
            return list(partner.states[-1].position)  # time stands again
        finally:
            partner.end()
            twin.end()

    def test_ends_at_rest_in_full_motion(self):
        with tempfile.TemporaryDirectory() as folder:
            at_rest = self.run_once(f"{folder}/run.mcap", end=1.505)  # half of the way, at the highest speed
        self.assertLess(abs(at_rest[0] - 0.1), 0.02)

    def test_the_same_bytes_twice(self):
        tables = []
        with tempfile.TemporaryDirectory() as folder:
            for name in ("one", "two"):
                log = pathlib.Path(folder) / f"{name}.mcap"
                self.run_once(str(log))
                subprocess.run([PROGRAM, "export", str(log), "--out", f"{folder}/{name}"], check=True, capture_output=True, env={**os.environ, "LD_LIBRARY_PATH": ""})
                tables.append((pathlib.Path(folder) / name / "cycles.csv").read_bytes())
        print(f"  lockstep: {tables[0].count(bytes([10]))} cycles")
        self.assertEqual(*tables)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
