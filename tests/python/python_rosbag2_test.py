"""Logs as bags of ROS 2, read back by rosbags, and joint states out of a bag."""

import contextlib
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

import panda_twin as pt
from panda_twin import _host, rosbag2

STORE = get_typestore(Stores.ROS2_JAZZY)
STATE = "/franka_robot_state_broadcaster"


class Rosbag2Test(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.result = pt.run("scenarios/smoke.yaml", out=cls.folder / "run", video=False, plots=False)
        cls.log = pt.Log(cls.result)
        environment = {**os.environ, "PANDA_TWIN_PYTHON": sys.executable}
        words = [_host.executable, "export", cls.folder / "run/run.mcap", "--format", "rosbag2", "--out", cls.folder / "bag"]
        cls.done = subprocess.run(words, env=environment, capture_output=True, text=True)

    def messages(self, topic):
        with AnyReader([self.folder / "bag"], default_typestore=STORE) as reader:
            wanted = [one for one in reader.connections if one.topic == topic]
            return [(at, reader.deserialize(data, one.msgtype)) for one, at, data in reader.messages(wanted)]

    def test_joint_states_are_those_of_the_log(self):
        self.assertEqual((self.done.returncode, self.done.stderr), (0, ""))
        cycles = self.log.cycles
        states = self.messages("/joint_states")
        self.assertEqual(len(states), len(cycles))
        np.testing.assert_array_equal([at for at, _ in states], cycles["at_ns"])
        np.testing.assert_array_equal([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for _, m in states], cycles["at_ns"])
        self.assertEqual(states[0][1].name, [f"panda_joint{i}" for i in range(1, 8)])
        for field, column in (("position", "q"), ("velocity", "dq"), ("effort", "tau_J")):
            np.testing.assert_array_equal([getattr(m, field) for _, m in states], cycles[column])
        np.testing.assert_array_equal([m.position for _, m in self.messages(f"{STATE}/desired_joint_states")], cycles["q_d"])
        wrenches = [[m.wrench.force.x, m.wrench.force.y, m.wrench.force.z, m.wrench.torque.x, m.wrench.torque.y, m.wrench.torque.z]
                    for _, m in self.messages(f"{STATE}/external_wrench_in_base_frame")]  # fmt: skip
        np.testing.assert_array_equal(wrenches, cycles["O_F_ext_hat_K"])

    def test_poses_are_those_of_the_log(self):
        for (_, message), pose in zip(self.messages(f"{STATE}/current_pose"), self.log.cycles.poses("O_T_EE")):
            self.assertEqual(message.header.frame_id, "panda_link0")
            p, q = message.pose.position, message.pose.orientation
            np.testing.assert_array_equal([p.x, p.y, p.z], pose[:3, 3])
            u, w = np.array([q.x, q.y, q.z]), q.w
            cross = np.array([[0, -q.z, q.y], [q.z, 0, -q.x], [-q.y, q.x, 0]])
            np.testing.assert_allclose((w * w - u @ u) * np.eye(3) + 2 * np.outer(u, u) + 2 * w * cross, pose[:3, :3], atol=1e-7)

    def test_messages_are_in_order_of_time_with_the_hashes_of_ros(self):
        with AnyReader([self.folder / "bag"], default_typestore=STORE) as reader:
            at = [time for _, time, _ in reader.messages()]
            self.assertEqual({one.topic: one.digest for one in reader.connections}["/joint_states"], STORE.hash_rihs01("sensor_msgs/msg/JointState"))
        self.assertEqual(at, sorted(at))
        events = [message.msg for _, message in self.messages("/rosout")]
        self.assertEqual(events, list(self.log.events["text"]))

    def test_joint_states_come_back(self):
        log = pt.Log.from_rosbag2(self.folder / "bag")
        for column in ("q", "dq", "tau_J"):
            np.testing.assert_array_equal(log.cycles[column], self.log.cycles[column])

    def test_a_bag_of_a_robot_with_other_names_and_order(self):
        types = STORE.types
        names = [f"fr3_joint{i}" for i in (7, 6, 5, 4, 3, 2, 1)] + ["fr3_finger_joint1"]
        with Writer(self.folder / "other", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
            connection = writer.add_connection("/left/joint_states", "sensor_msgs/msg/JointState", typestore=STORE)
            for k in range(3):
                stamp = types["builtin_interfaces/msg/Time"](sec=1700000000, nanosec=k * 10**7)
                header = types["std_msgs/msg/Header"](stamp=stamp, frame_id="")
                state = types["sensor_msgs/msg/JointState"](header, names, np.array([7.0, 6, 5, 4, 3, 2, 1, k]), np.empty(0), np.empty(0))
                writer.write(connection, k, STORE.serialize_cdr(state, "sensor_msgs/msg/JointState"))
        log = pt.Log.from_rosbag2(self.folder / "other", topic="/left/joint_states")
        np.testing.assert_array_equal(log.cycles["q"], [[1, 2, 3, 4, 5, 6, 7]] * 3)
        self.assertTrue(np.isnan(log.cycles["dq"]).all())
        np.testing.assert_array_equal(log.cycles["at_ns"], [0, 10**7, 2 * 10**7])
        with self.assertRaisesRegex(ValueError, r"no joint states of an arm on /joint_states; its topics are /left/joint_states \(sensor"):
            pt.Log.from_rosbag2(self.folder / "other")

    def test_damaged_bags_are_refused(self):
        whole = (self.folder / "bag/bag.mcap").read_bytes()
        damaged = self.folder / "damaged"
        damaged.mkdir()
        (damaged / "metadata.yaml").write_bytes((self.folder / "bag/metadata.yaml").read_bytes())
        for k in range(40):
            content = bytearray(whole)
            for i in range(k * 1000, len(whole), len(whole) // 7):
                content[i] ^= 1 + k
            (damaged / "bag.mcap").write_bytes(content[: len(whole) - k * 500])
            with contextlib.suppress(ValueError):  # what is damaged may be what is not read
                pt.Log.from_rosbag2(damaged)

    def test_what_is_refused(self):
        with self.assertRaisesRegex(FileExistsError, "bag exists; name a new folder"):
            rosbag2.write(self.log, self.folder / "bag")
        with self.assertRaisesRegex(ValueError, "is no bag of ROS 2"):
            pt.Log.from_rosbag2(self.folder / "run/run.mcap")
        with self.assertRaisesRegex(FileNotFoundError, "missing"):
            pt.Log.from_rosbag2(self.folder / "none")
        words = [_host.executable, "export", self.folder / "run/run.mcap", "--format", "rosbag2", "--columns", "q"]
        done = subprocess.run(words, capture_output=True, text=True)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--columns is for tables", done.stderr)
        self.assertFalse([one for one in self.folder.iterdir() if one.name.startswith(".")])


if __name__ == "__main__":
    unittest.main()
