#!/usr/bin/env python3
"""The files for MoveIt and ros2_control in models/ros2 name what panda-twin serves. MoveIt and ros2_control themselves are in no registry."""

import ast
import pathlib
import unittest
import xml.etree.ElementTree

import yaml

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDER = ROOT / "models/ros2"
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]
BRIDGE = "".join((ROOT / f"plugins/ros2/{name}").read_text() for name in ("bridge.h", "bridge.cc"))


class SnippetsTest(unittest.TestCase):
    def test_hardware(self):
        system = xml.etree.ElementTree.parse(FOLDER / "panda.ros2_control.xml").getroot().find("ros2_control")
        topics = {one.get("name"): one.text for one in system.iter("param")}
        for topic in (topics["joint_commands_topic"], topics["joint_states_topic"]):
            self.assertIn(f'"{topic.removeprefix("/")}"', BRIDGE)
        self.assertEqual([joint.get("name") for joint in system.iter("joint")], JOINTS)
        self.assertEqual({one.get("name") for one in system.iter("command_interface")}, {"position"})

    def test_controllers(self):
        controllers = yaml.safe_load((FOLDER / "ros2_controllers.yaml").read_text())
        self.assertEqual(controllers["joint_trajectory_controller"]["ros__parameters"]["joints"], JOINTS)

    def test_moveit(self):
        simple = yaml.safe_load((FOLDER / "moveit_controllers.yaml").read_text())["moveit_simple_controller_manager"]
        for name in simple["controller_names"]:
            self.assertIn(f'"{name}/{simple[name]["action_ns"]}"', BRIDGE)
        self.assertEqual(simple["panda_arm_controller"]["joints"], JOINTS)
        ast.parse((FOLDER / "moveit.launch.py").read_text())


if __name__ == "__main__":
    unittest.main()
