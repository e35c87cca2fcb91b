#!/usr/bin/env python3
"""Much of what ros2_rclpy_test tries once: 1000 goals in a row; ros2_control's part played at 100, 500 and 1000 Hz, through the position interface and raw.

Arguments: the program, then [GOALS] [RUNS] [SECONDS]. As the paper has it, a raw stream of positions aborts and the interface does not.
"""

import os
import pathlib
import sys
import tempfile
import time
import unittest

import ros2_partner
from ros2_partner import ARM, JOINTS, Partner, Twin, goal_of

PROGRAM = sys.argv[1]
GOALS, RUNS, SECONDS = [int(word) for word in [*sys.argv[2:], *("1000", "100", "20")[len(sys.argv) - 2:]]]
ros2_partner.enter("jazzy")
from control_msgs.action import FollowJointTrajectory  # noqa: E402
from rclpy.qos import QoSProfile  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402

WORDS = ["--drive", "lockstep", "--pace", "1"]
RAW = """name: raw_stream
robot: {q_start: {unit: rad, values: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}}
tick: {generator: none}
"""


class GoalsTest(unittest.TestCase):
    def test_goals_in_a_row(self):
        twin, partner = Twin(PROGRAM, *WORDS), Partner()
        try:
            by, memory = 0.01, {}
            for i in range(GOALS):
                status, result = partner.do(FollowJointTrajectory, ARM, goal_of(partner.state(), by=by, seconds=0.2, step=0.05))
                self.assertEqual(status, 4, f"goal {i}: {result.error_string}")
                by = -by
                memory[i + 1] = twin.memory_kb()
            half = memory[max(GOALS // 2, 1)]
            print(f"  {GOALS} goals; memory {half} kB after half, {memory[GOALS]} kB at the end")
            self.assertLess(memory[GOALS] - half, 4000)
        finally:
            partner.end()
            twin.end()


class StreamTest(unittest.TestCase):
    """The partner is topic-based hardware of ros2_control: it answers old states, at its own rate, with jitter."""

    def aborts(self, rate, runs, *words):
        twin, partner = Twin(PROGRAM, *words, *WORDS, "--ros-arm"), Partner()
        publisher = partner.node.create_publisher(JointState, "/robot_joint_commands", QoSProfile(depth=1))
        try:
            partner.until(lambda: publisher.get_subscription_count() > 0)
            for run in range(runs):
                self.stream(partner, publisher, rate)
                partner.until(lambda: twin.told().count("the arm rests") + twin.told().count("arm it again") > run, "the stream did not end")
                if "arm it again" in twin.told():
                    return run, twin.told().split("arm it again")[0].splitlines()[-1]
            return runs, ""
        finally:
            partner.end()
            twin.end()

    @staticmethod
    def stream(partner, publisher, rate):
        start = partner.state()[:7]
        begin = time.monotonic()
        swings = 2 * ((SECONDS - 2) // 3)  # there and back; it ends where it began
        for i in range(SECONDS * rate):
            due = begin + i / rate + ros2_partner.random.uniform(0, 0.4 / rate)
            while time.monotonic() < due:
                partner.spin(max(min(0.001, due - time.monotonic()), 0))
            x = 0.15 * ros2_partner.swing(min(max((i / rate - 1) / 1.5, 0), swings))[0]
            message = JointState(name=JOINTS, position=[q + x for q in start])
            message.header.stamp = partner.node.get_clock().now().to_msg()
            publisher.publish(message)

    def test_the_interface_never_aborts(self):
        for rate, runs in ((100, RUNS - 2 * (RUNS // 3)), (500, RUNS // 3), (1000, RUNS // 3)):
            with self.subTest(rate=rate):
                done, why = self.aborts(rate, runs)
                print(f"  {rate} Hz: {done} of {runs} runs of {SECONDS} s without an abort")
                self.assertEqual((done, why), (runs, ""))

    def test_a_raw_stream_aborts(self):
        with tempfile.TemporaryDirectory() as folder:
            scenario = pathlib.Path(folder) / "raw.yaml"
            scenario.write_text(RAW)
            done, why = self.aborts(100, 3, str(scenario))
        print(f"  raw, 100 Hz: {why}")
        self.assertEqual(done, 0)
        self.assertIn("aborted", why)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *os.environ.get("TWIN_CASES", "").split()], verbosity=1)
