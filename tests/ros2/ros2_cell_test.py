#!/usr/bin/env python3
"""Two arms of one scene, served by `serve --ros` and moved at once by a node of real ROS 2: arguments are the program and a distribution."""

import sys
import unittest

import ros2_partner
from ros2_partner import ARM, Partner, Twin, goal_of

PROGRAM = sys.argv[1]
ros2_partner.enter(sys.argv[2])
from control_msgs.action import FollowJointTrajectory  # noqa: E402
from sensor_msgs.msg import JointState  # noqa: E402
from simulation_interfaces.srv import GetEntities, SetSimulationState  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

from ros2_served import SUCCEEDED  # noqa: E402

ROBOTS = ("left", "right")


class CellTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.twin = Twin(PROGRAM, "tests/clients/two_arms.yaml", "--drive", "lockstep", "--pace", "1")
        ros2_partner.until(lambda: cls.twin.told().count("ROS 2 domain") == len(ROBOTS), "not both robots are there")
        cls.partner = Partner()
        cls.states = {name: cls.partner.collect(JointState, f"/{name}/joint_states") for name in ROBOTS}

    @classmethod
    def tearDownClass(cls):
        cls.partner.end()
        cls.twin.end()

    def positions(self, name):
        self.states[name].clear()
        self.partner.until(lambda: self.states[name], f"{name}: no joint state")
        return list(self.states[name][-1].position[:7])

    def test_both_move_at_once(self):
        begin = {name: self.positions(name) for name in ROBOTS}
        by = {"left": 0.1, "right": -0.1}
        handles = {name: self.partner.send(FollowJointTrajectory, f"/{name}{ARM}", goal_of(begin[name], by=by[name])) for name in ROBOTS}
        for name, handle in handles.items():
            response = self.partner.wait(handle.get_result_async())
            self.assertEqual((response.status, response.result.error_string), (SUCCEEDED, ""), name)
        for name in ROBOTS:
            for q, q_begin in zip(self.positions(name), begin[name]):
                self.assertAlmostEqual(q - q_begin, by[name], delta=0.01, msg=name)

    def test_names_and_what_they_share(self):
        node = self.partner.node
        self.partner.until(lambda: {("panda_twin", f"/{name}") for name in ROBOTS} <= set(node.get_node_names_and_namespaces()), "not both nodes")
        self.assertEqual([info.node_namespace for info in node.get_publishers_info_by_topic("/clock")], ["/left"])
        self.assertTrue(self.partner.call(Trigger, "/right/panda_twin/recover").success)
        self.assertEqual(list(self.partner.call(GetEntities, "/right/get_entities").entities), [])

    def test_no_request_stops_their_time(self):
        request = SetSimulationState.Request()
        request.state.state = request.state.STATE_PAUSED
        answer = self.partner.call(SetSimulationState, "/left/set_simulation_state", request)
        self.assertIn("several robots have one time", answer.result.error_message)


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
