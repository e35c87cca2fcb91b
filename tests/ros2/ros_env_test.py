#!/usr/bin/env python3
"""The ROS 2 environments of ros_env.py: topics and actions between nodes of one process and of two, and the hashes of types as ROS tells them."""

import json
import os
import subprocess
import unittest

import ros2_partner
import ros_env

SECONDS = 60
SEND_GOAL = "control_msgs/action/FollowJointTrajectory_SendGoal"
SUBSCRIBER = """
import rclpy, sensor_msgs.msg
rclpy.init()
node = rclpy.create_node("subscriber")
got = []
subscription = node.create_subscription(sensor_msgs.msg.JointState, "/states", got.append, 10)
print("ready", flush=True)
while not got:
    rclpy.spin_once(node, timeout_sec=0.1)
print(list(got[0].position), flush=True)
"""
PUBLISHER = """
import rclpy, sensor_msgs.msg, sys
rclpy.init()
node = rclpy.create_node("publisher")
publisher = node.create_publisher(sensor_msgs.msg.JointState, "/states", 10)
node.create_timer(0.05, lambda: publisher.publish(sensor_msgs.msg.JointState(name=["a", "b"], position=[1.0, 2.0])))
rclpy.spin(node)
"""
ACTION = """
import json, rclpy, rclpy.action, time
from control_msgs.action import FollowJointTrajectory
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from test_msgs.msg import BasicTypes
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint
rclpy.init()
node = rclpy.create_node("both")

def execute(handle):
    names = handle.request.trajectory.joint_names
    handle.publish_feedback(FollowJointTrajectory.Feedback(joint_names=names))
    handle.succeed()
    return FollowJointTrajectory.Result(error_string=" ".join(names))

server = rclpy.action.ActionServer(node, FollowJointTrajectory, "/follow", execute)
client = rclpy.action.ActionClient(node, FollowJointTrajectory, "/follow")
feedback = []

def wait(future):
    rclpy.spin_until_future_complete(node, future, timeout_sec=20)
    return future.result()

assert client.wait_for_server(timeout_sec=20)
goal = FollowJointTrajectory.Goal(trajectory=JointTrajectory(joint_names=["a", "b"], points=[JointTrajectoryPoint(positions=[1.0, 2.0])]))
handle = wait(client.send_goal_async(goal, feedback_callback=lambda message: feedback.append(list(message.feedback.joint_names))))
result = wait(handle.get_result_async())

publishers = [node.create_publisher(kind, "/" + kind.__name__, 1) for kind in (JointState, JointTrajectory, WrenchStamped, BasicTypes)]
topics = {"/" + kind: False for kind in ("JointState", "JointTrajectory", "WrenchStamped", "BasicTypes")}
topics |= {"rq/follow/_action/send_goalRequest": True, "/follow/_action/feedback": False}
hashes = {}
until = time.monotonic() + 20
while len(hashes) < len(topics) and time.monotonic() < until:
    rclpy.spin_once(node, timeout_sec=0.1)
    for topic, raw in topics.items():
        for info in node.get_publishers_info_by_topic(topic, no_mangle=raw):
            hashes[info.topic_type] = str(info.topic_type_hash)
print(json.dumps({"accepted": handle.accepted, "status": result.status, "said": result.result.error_string, "feedback": feedback, "hashes": hashes}))
"""


class RosEnvTest:
    @classmethod
    def setUpClass(cls):
        ros_env.folder_of(cls.distro)
        cls.domain = ros2_partner.free_domain()

    def start(self, program):
        environment = {**os.environ, **ros_env.environment_of(self.distro, self.domain)}
        process = subprocess.Popen([ros_env.python_of(self.distro), "-c", program], env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True)  # fmt: skip
        self.addCleanup(process.communicate, timeout=SECONDS)
        self.addCleanup(process.terminate)  # killed, it would leave its memory in /dev/shm
        return process

    def end(self, process):
        printed, said = process.communicate(timeout=SECONDS)
        self.assertEqual(process.returncode, 0, printed + said)
        return printed

    def test_two_processes_exchange_a_message(self):
        subscriber = self.start(SUBSCRIBER)
        self.start(PUBLISHER)
        self.assertEqual(self.end(subscriber), "ready\n[1.0, 2.0]\n")

    def test_an_action_of_an_interface_made_here(self):
        told = json.loads(self.end(self.start(ACTION)))
        hashes = told.pop("hashes")
        self.assertEqual(told, {"accepted": True, "status": 4, "said": "a b", "feedback": [["a", "b"]]})
        made = json.loads((ros_env.folder_of(self.distro) / "share/control_msgs/action/FollowJointTrajectory.json").read_text())
        made = {entry["type_name"]: entry["hash_string"] for entry in made["type_hashes"]}
        for name, digest in {**hashes, SEND_GOAL: made[SEND_GOAL]}.items():
            print(f"{self.distro} {name} {digest}", flush=True)
        self.assertEqual(len(hashes), 6)
        # A service's endpoints tell the hash of their message, not of the service.
        self.assertEqual(hashes["control_msgs::action::dds_::FollowJointTrajectory_SendGoal_Request_"], made[f"{SEND_GOAL}_Request"])
        feedback = "control_msgs/action/FollowJointTrajectory_FeedbackMessage"
        self.assertEqual(hashes[feedback], made[feedback])


class JazzyTest(RosEnvTest, unittest.TestCase):
    distro = "jazzy"


class KiltedTest(RosEnvTest, unittest.TestCase):
    distro = "kilted"


if __name__ == "__main__":
    unittest.main()
