#!/usr/bin/env python3
"""A twin served by `serve --ros` and commanded by nodes of real ROS 2: arguments are the program and a distribution (jazzy, kilted)."""

import math
import os
import signal
import sys
import time
import unittest
import xml.etree.ElementTree

import ros2_partner
from ros2_partner import ARM, HAND, JOINTS, Partner, Twin, goal_of, seconds_of

PROGRAM = sys.argv[1]
DISTRO = sys.argv[2]
ros2_partner.enter(DISTRO, 20 + os.getpid() % 80)
from control_msgs.action import FollowJointTrajectory, GripperCommand  # noqa: E402
from franka_msgs.action import ErrorRecovery, Grasp, Homing, Move  # noqa: E402
from franka_msgs.msg import FrankaRobotState  # noqa: E402
from franka_msgs.srv import SetFullCollisionBehavior, SetJointStiffness, SetLoad  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, JointState  # noqa: E402
from simulation_interfaces.action import SimulateSteps  # noqa: E402
from simulation_interfaces.srv import GetEntities, GetEntityState, GetSimulationState, SetEntityState, SetSimulationState, StepSimulation  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


class Served(unittest.TestCase):
    """One twin and one partner for all cases of a class."""

    words = ["--drive", "lockstep", "--pace", "1"]

    @classmethod
    def setUpClass(cls):
        cls.twin = Twin(PROGRAM, *cls.words)
        cls.partner = Partner()

    @classmethod
    def tearDownClass(cls):
        cls.partner.end()
        cls.twin.end()

    def follow(self, goal, feedback=None):
        return self.partner.do(FollowJointTrajectory, ARM, goal, feedback)

    def rests(self):
        before = self.partner.state()[:7]
        self.partner.spin_for(0.2)
        self.assertLess(max(abs(a - b) for a, b in zip(before, self.partner.state())), 1e-3)


class GraphTest(Served):
    def test_names_types_hashes(self):
        node = self.partner.node
        self.partner.until(lambda: ("panda_twin", "/") in node.get_node_names_and_namespaces(), "no node panda_twin")
        topics = {"/joint_states": JointState, "/robot_joint_states": JointState, "/clock": Clock, "/robot_description": String,
                  "/franka_robot_state_broadcaster/robot_state": FrankaRobotState, "/franka_robot_state_broadcaster/current_pose": PoseStamped}
        for topic, kind in topics.items():
            own = node.create_publisher(kind, topic + "_own", 10)
            ours = self.partner.node.get_publishers_info_by_topic(topic)
            self.assertEqual([one.node_name for one in ours], ["panda_twin"], topic)
            self.assertEqual(ours[0].topic_type, f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}")
            self.partner.until(lambda: node.get_publishers_info_by_topic(topic + "_own"))
            self.assertEqual(str(ours[0].topic_type_hash), str(node.get_publishers_info_by_topic(topic + "_own")[0].topic_type_hash), topic)
            node.destroy_publisher(own)
        services = dict(node.get_service_names_and_types_by_node("panda_twin", "/"))
        self.assertEqual(services["/service_server/set_load"], ["franka_msgs/srv/SetLoad"])
        self.assertEqual(services["/panda_twin/arm"], ["std_srvs/srv/SetBool"])
        from rclpy.action import get_action_server_names_and_types_by_node
        actions = dict(get_action_server_names_and_types_by_node(node, "panda_twin", "/"))
        self.assertEqual(actions[ARM], ["control_msgs/action/FollowJointTrajectory"])
        self.assertEqual(actions["/panda_gripper/grasp"], ["franka_msgs/action/Grasp"])

    def test_qualities(self):
        info = self.partner.node.get_publishers_info_by_topic("/robot_description")[0].qos_profile
        self.assertEqual((info.reliability, info.durability), (ReliabilityPolicy.RELIABLE, DurabilityPolicy.TRANSIENT_LOCAL))
        info = self.partner.node.get_subscriptions_info_by_topic("/robot_joint_commands")[0].qos_profile
        self.assertEqual(info.reliability, ReliabilityPolicy.RELIABLE)

    def test_late_joiner_gets_the_description(self):
        got = self.partner.collect(String, "/robot_description", LATCHED)
        self.partner.until(lambda: got)
        joints = {joint.get("name") for joint in xml.etree.ElementTree.fromstring(got[0].data).iter("joint")}
        self.assertLessEqual({*JOINTS, "panda_finger_joint1", "panda_finger_joint2"}, joints)

    def test_states_and_clock(self):
        fast = self.partner.collect(JointState, "/robot_joint_states", qos_profile_sensor_data)
        clock = self.partner.collect(Clock, "/clock", qos_profile_sensor_data)
        self.partner.until(lambda: len(fast) > 1500 and len(clock) > 100)
        stamps = [seconds_of(m.header.stamp) for m in self.partner.states[-100:]]
        steps = [b - a for a, b in zip(stamps, stamps[1:])]
        self.assertAlmostEqual(sorted(steps)[len(steps) // 2], 0.01, places=6)
        stamps = [seconds_of(m.header.stamp) for m in fast]
        self.assertAlmostEqual(sorted(b - a for a, b in zip(stamps, stamps[1:]))[len(stamps) // 2], 0.001, places=6)
        self.assertLess(abs(time.time() - stamps[-1]), 5)
        self.assertEqual(sorted(clock, key=lambda m: seconds_of(m.clock)), clock)

    def test_use_sim_time(self):
        other = Partner("sim_time", [Parameter("use_sim_time", value=True)])
        try:
            other.until(lambda: other.node.get_clock().now().nanoseconds > 0, "the node got no time")
        finally:
            other.end()


class TrajectoryTest(Served):
    def check_following(self, **how):
        start = self.partner.state()
        feedback = []
        begun = seconds_of(self.partner.states[-1].header.stamp)
        status, result = self.follow(goal_of(start, **how), feedback)
        self.assertEqual((status, result.error_code, result.error_string), (SUCCEEDED, 0, ""))
        error, begin = ros2_partner.following_error(self.partner.states, start, begun, by=how.get("by", 0.2))
        print(f"  {how}: {1e3 * error:.2f} mrad, begun {begin - begun:.3f} s after the last state before the goal")
        self.assertLess(error, 0.005)
        self.assertTrue(feedback)
        self.assertEqual(list(feedback[-1].joint_names), JOINTS)
        self.assertLess(max(abs(x) for one in feedback for x in one.error.positions), 0.02)

    def test_follows_positions_as_moveit_sends_them(self):
        self.check_following(step=0.1, derivatives=2)

    def test_follows_positions_alone(self):
        self.check_following(step=0.01, by=-0.2)

    def test_follows_velocities_at_few_points(self):
        self.check_following(step=0.5, derivatives=1)

    def test_joints_in_another_order(self):
        self.check_following(names=JOINTS[::-1], step=0.05, by=-0.2)

    def refused(self, goal, code, text):
        before = self.partner.state()[:7]
        status, result = self.follow(goal)
        self.assertEqual((status, result.error_code), (ABORTED, code), result.error_string)
        self.assertIn(text, result.error_string)
        self.assertLess(max(abs(a - b) for a, b in zip(before, self.partner.state())), 1e-3)

    def test_refusals_say_why(self):
        start = self.partner.state()
        self.refused(goal_of(start, names=[*JOINTS[:6], "panda_joint8"]), -2, "joint_names are")
        self.refused(goal_of(start, names=JOINTS[:6]), -2, "joint_names are")
        goal = goal_of(start, names=["x" * 100000, *JOINTS[1:]])
        self.refused(goal, -2, "joint_names are")
        self.assertLess(max(map(len, self.twin.told().splitlines())), 1000)
        goal = goal_of(start)
        goal.trajectory.points[3].positions[2] = math.nan
        self.refused(goal, -1, "points[3].positions has a value that is not finite")
        goal = goal_of(start)
        goal.trajectory.points[5].time_from_start = goal.trajectory.points[4].time_from_start
        self.refused(goal, -1, "points[5].time_from_start")
        goal = goal_of(start)
        goal.trajectory.header.stamp.sec = int(time.time()) - 10
        self.refused(goal, -3, "in the past")
        self.refused(goal_of([q + 0.1 for q in start]), -1, "Plan from where the arm is")
        self.refused(goal_of(start, by=2.5, seconds=30.0, step=1.0), -1, "not inside its limits")
        self.refused(goal_of(start, by=0.5, seconds=0.2, step=0.02), -1, "limit")
        goal = goal_of(start)
        goal.trajectory.points.clear()
        self.refused(goal, -1, "no points")
        goal = goal_of(start, derivatives=1)
        goal.trajectory.points[-1].velocities = [0.1] * 7
        self.refused(goal, -1, "must rest there")

    def test_cancel(self):
        start = self.partner.state()
        handle = self.partner.send(FollowJointTrajectory, ARM, goal_of(start, seconds=20.0))
        self.partner.until(lambda: abs(self.partner.state()[0] - start[0]) > 0.002, "the arm did not begin")
        answer = self.partner.wait(handle.cancel_goal_async())
        self.assertEqual(len(answer.goals_canceling), 1)
        response = self.partner.wait(handle.get_result_async())
        self.assertEqual(response.status, CANCELED)
        self.rests()
        again = self.partner.wait(handle.cancel_goal_async())
        self.assertEqual((again.return_code, len(again.goals_canceling)), (3, 0))  # it has ended
        self.check_following(by=-0.1)

    def test_a_newer_goal_takes_over(self):
        first = self.partner.send(FollowJointTrajectory, ARM, goal_of(self.partner.state(), seconds=20.0))
        self.partner.spin_for(0.5)
        status, result = self.follow(goal_of(self.partner.state(), by=0.1, begin=1.0))
        self.assertEqual(status, SUCCEEDED, result.error_string)
        response = self.partner.wait(first.get_result_async())
        self.assertEqual(response.status, ABORTED)
        self.assertIn("preempted", response.result.error_string)

    def test_path_tolerance(self):
        from control_msgs.msg import JointTolerance
        goal = goal_of(self.partner.state(), by=-0.1, begin=0.5)
        goal.path_tolerance = [JointTolerance(name=JOINTS[0], position=1e-7)]
        status, result = self.follow(goal)
        self.assertEqual((status, result.error_code), (ABORTED, -4))
        self.assertIn("path_tolerance permits", result.error_string)
        self.rests()

    def test_client_dies_in_its_goal(self):
        child = os.fork()
        if child == 0:
            other = Partner("dies")
            other.send(FollowJointTrajectory, ARM, goal_of(other.state(), seconds=3.0))
            os.kill(os.getpid(), signal.SIGKILL)
        os.waitpid(child, 0)
        self.partner.until(lambda: self.twin.told().count("motion started") > self.twin.told().count("motion finished"), "no motion of the dead client")
        self.partner.until(lambda: self.twin.told().count("motion started") == self.twin.told().count("motion finished") + self.twin.told().count("motion stopped"),
                           "the dead client's goal did not end")
        self.check_following(by=-0.1)

    def test_user_stop_and_recovery(self):
        handle = self.partner.send(FollowJointTrajectory, ARM, goal_of(self.partner.state(), seconds=20.0, by=-0.2))
        self.partner.spin_for(0.3)
        self.twin.ctl("user-stop", "press")
        response = self.partner.wait(handle.get_result_async())
        self.assertEqual(response.status, ABORTED)
        self.assertIn("user stop", response.result.error_string)
        self.refused(goal_of(self.partner.state()), -1, "not Idle")
        self.twin.ctl("user-stop", "release")
        self.assertTrue(self.partner.call(Trigger, "/panda_twin/recover").success)
        self.check_following(by=0.1)


class FrankaTest(Served):
    words = ["models/scenarios/grasp.yaml", *Served.words]

    def test_gripper_command(self):
        def command(position, effort=0.0):
            goal = GripperCommand.Goal()
            goal.command.position = position
            goal.command.max_effort = effort
            return self.partner.do(GripperCommand, HAND, goal)

        status, result = command(0.01)
        self.assertEqual((status, result.reached_goal), (SUCCEEDED, True))
        self.assertAlmostEqual(self.partner.state()[7], 0.01, delta=0.001)
        status, result = command(0.04)
        self.assertEqual((status, result.reached_goal), (SUCCEEDED, True))
        self.assertEqual(command(0.2)[0], ABORTED)
        self.assertIn("position is that of one finger", self.twin.told())

    def test_franka_actions(self):
        status, result = self.partner.do(Homing, "/panda_gripper/homing", Homing.Goal())
        self.assertEqual((status, result.success), (SUCCEEDED, True), result.error)
        status, result = self.partner.do(Move, "/panda_gripper/move", Move.Goal(width=0.03, speed=0.1))
        self.assertTrue(result.success, result.error)
        status, result = self.partner.do(Grasp, "/panda_gripper/grasp", Grasp.Goal(width=0.01, speed=0.1, force=10.0))
        self.assertEqual((status, result.success, result.error), (ABORTED, False, "unsuccessful"))  # there is nothing
        self.assertEqual(self.partner.do(ErrorRecovery, "/action_server/error_recovery", ErrorRecovery.Goal())[0], SUCCEEDED)

    def test_setters_and_state(self):
        states = self.partner.collect(FrankaRobotState, "/franka_robot_state_broadcaster/robot_state")
        answer = self.partner.call(SetLoad, "/service_server/set_load",
                                   SetLoad.Request(mass=0.5, center_of_mass=[0.0, 0.0, 0.05], load_inertia=[1e-3, 0.0, 0.0, 0.0, 1e-3, 0.0, 0.0, 0.0, 1e-3]))
        self.assertTrue(answer.success, answer.error)
        self.partner.until(lambda: states and states[-1].inertia_load.inertia.m == 0.5, "the load does not show")
        self.assertEqual(states[-1].robot_mode, FrankaRobotState.ROBOT_MODE_IDLE)
        self.assertEqual(list(states[-1].measured_joint_state.name), JOINTS)
        answer = self.partner.call(SetJointStiffness, "/service_server/set_joint_stiffness", SetJointStiffness.Request(joint_stiffness=[-1.0] * 7))
        self.assertFalse(answer.success)
        self.assertIn("must be in", answer.error)
        answer = self.partner.call(SetFullCollisionBehavior, "/service_server/set_full_collision_behavior")  # all zero
        self.assertFalse(answer.success)
        self.assertIn("threshold is 0", answer.error)

    def test_cameras(self):
        pictures = self.partner.collect(Image, "/camera/overview/image_raw", qos_profile_sensor_data)
        compressed = self.partner.collect(CompressedImage, "/camera/hand/image_raw/compressed", qos_profile_sensor_data)
        infos = self.partner.collect(CameraInfo, "/camera/hand/camera_info", qos_profile_sensor_data)
        depths = self.partner.collect(Image, "/camera/hand/depth/image_raw", qos_profile_sensor_data)
        self.partner.until(lambda: pictures and compressed and infos and depths, "no picture")
        self.assertEqual((pictures[0].width, pictures[0].height, pictures[0].encoding, len(pictures[0].data)), (640, 480, "rgb8", 640 * 480 * 3))
        self.assertGreater(len(set(bytes(pictures[0].data[:90000]))), 20)
        self.assertEqual(bytes(compressed[0].data[:2]), b"\xff\xd8")
        self.assertEqual(infos[0].header.frame_id, "camera_hand_optical_frame")
        self.assertEqual(depths[0].encoding, "32FC1")

    def test_simulation(self):
        entities = self.partner.call(GetEntities, "/get_entities").entities
        self.assertEqual(list(entities), ["box"])
        answer = self.partner.call(StepSimulation, "/step_simulation", StepSimulation.Request(steps=5))
        self.assertEqual(answer.result.result, 3)  # not paused
        state = SetSimulationState.Request()
        state.state.state = 2
        self.assertEqual(self.partner.call(SetSimulationState, "/set_simulation_state", state).result.result, 1)
        self.partner.spin_for(0.2)
        before = seconds_of(self.partner.states[-1].header.stamp)
        self.assertEqual(self.partner.call(StepSimulation, "/step_simulation", StepSimulation.Request(steps=500)).result.result, 1)
        self.partner.spin_for(0.2)
        self.assertAlmostEqual(seconds_of(self.partner.states[-1].header.stamp) - before, 0.5, places=6)
        self.assertEqual(self.partner.call(GetSimulationState, "/get_simulation_state").state.state, 2)
        steps = self.partner.send(SimulateSteps, "/simulate_steps", SimulateSteps.Goal(steps=100000), feedback := [])
        self.partner.until(lambda: feedback, "no feedback")
        self.partner.wait(steps.cancel_goal_async())
        self.assertEqual(self.partner.wait(steps.get_result_async()).status, CANCELED)
        self.partner.spin_for(0.3)
        stands = seconds_of(self.partner.states[-1].header.stamp)
        self.partner.spin_for(0.3)
        self.assertEqual(seconds_of(self.partner.states[-1].header.stamp), stands)
        for x in (math.nan, 1e30):
            bad = SetEntityState.Request(entity="box", set_pose=True)
            bad.state.pose.position.x = x
            bad.state.pose.orientation.w = 1.0
            self.assertEqual(self.partner.call(SetEntityState, "/set_entity_state", bad).result.result, 101)
        where = self.partner.call(GetEntityState, "/get_entity_state", GetEntityState.Request(entity="box")).state
        where.pose.position.y += 0.05
        where.pose.position.z += 0.02
        self.assertEqual(self.partner.call(SetEntityState, "/set_entity_state", SetEntityState.Request(entity="box", state=where, set_pose=True)).result.result, 1)
        state.state.state = 1
        self.assertEqual(self.partner.call(SetSimulationState, "/set_simulation_state", state).result.result, 1)
        self.partner.spin_for(0.5)
        moved = self.partner.call(GetEntityState, "/get_entity_state", GetEntityState.Request(entity="box")).state
        self.assertAlmostEqual(moved.pose.position.y, where.pose.position.y, delta=0.002)


class StreamTest(Served):
    def setUp(self):
        self.publisher = self.partner.node.create_publisher(JointState, "/robot_joint_commands", QoSProfile(depth=1))
        self.partner.until(lambda: self.publisher.get_subscription_count() > 0)

    def tearDown(self):
        self.partner.arm(False)
        self.partner.node.destroy_publisher(self.publisher)

    def stream(self, seconds, rate, by, publisher=None, names=JOINTS, amplitude=0.2):
        start = self.partner.state()[:7]
        ros2_partner.random.seed(1)
        begin = time.monotonic()
        sent = []
        for i in range(int(seconds * rate)):
            due = begin + i / rate + ros2_partner.random.uniform(0, 0.3 / rate)
            while time.monotonic() < due:
                self.partner.spin(max(min(0.002, due - time.monotonic()), 0))
            message = JointState(name=list(names), position=[q + by(i / rate, amplitude) for q in start])
            message.header.stamp = self.partner.node.get_clock().now().to_msg()
            (publisher or self.publisher).publish(message)
            sent.append((seconds_of(message.header.stamp), message.position[0]))
        self.partner.spin_for(0.3)
        return start, sent

    @staticmethod
    def up(t, amplitude):
        return amplitude * ros2_partner.swing(min(max((t - 1.5) / 2, 0), 1))[0]

    def test_unarmed_commands_are_ignored(self):
        start, _ = self.stream(1.0, 50, lambda t, amplitude: 0.05)
        self.assertLess(max(abs(a - b) for a, b in zip(start, self.partner.state())), 1e-3)
        self.assertIn("is not armed for it", self.twin.told())

    def test_follows(self):
        self.assertTrue(self.partner.arm().success)
        start = self.partner.state()[:7]
        self.partner.states.clear()
        _, sent = self.stream(4.5, 100, self.up)
        error, lag = ros2_partner.stream_error(self.partner.states, sent)
        gap = max(b - a for (a, _), (b, _) in zip(sent, sent[1:]))  # this host may stop the partner for a while
        print(f"  stream of 100 Hz with jitter: {1e3 * error:.2f} mrad, {1e3 * lag:.0f} ms later; longest gap {1e3 * gap:.0f} ms")
        fastest = 0.2 * math.pi / 4  # rad/s
        self.assertLess(error, 0.005 + fastest * max(gap - 0.02, 0))
        self.partner.until(lambda: "the commands have ended; the arm rests" in self.twin.told(), "the stream did not end")
        self.stream(4.5, 100, self.up, amplitude=-0.2)  # it may begin anew
        self.assertLess(abs(self.partner.state()[0] - start[0]), 0.005)
        self.assertNotIn("aborted", self.twin.told())

    def test_another_commander_is_ignored(self):
        self.partner.arm()
        other = Partner("other")
        try:
            second = other.node.create_publisher(JointState, "/robot_joint_commands", QoSProfile(depth=1))
            other.until(lambda: second.get_subscription_count() > 0)
            start = self.partner.state()[:7]
            self.stream(0.5, 100, lambda t, amplitude: 0)
            for _ in range(50):
                for publisher, by in ((self.publisher, 0.0), (second, 0.05)):
                    message = JointState(name=JOINTS, position=[q + by for q in start])
                    message.header.stamp = self.partner.node.get_clock().now().to_msg()
                    publisher.publish(message)
                self.partner.spin_for(0.01)
            self.assertLess(abs(self.partner.state()[0] - start[0]), 2e-3)
            self.assertIn("commands the arm too", self.twin.told())
        finally:
            other.end()

    def test_a_goal_does_not_fight_with_the_stream(self):
        self.partner.arm()
        start, _ = self.stream(1.0, 100, lambda t, amplitude: 0)
        goal = self.partner.send(FollowJointTrajectory, ARM, goal_of(start))
        response = self.partner.wait(goal.get_result_async())
        self.assertEqual(response.status, ABORTED)
        self.assertIn("the arm follows /robot_joint_commands", response.result.error_string)
        self.partner.until(lambda: "the commands have ended" in self.twin.told(), "the stream did not end")
        goal = self.partner.send(FollowJointTrajectory, ARM, goal_of(start, seconds=4.0))
        self.stream(1.5, 100, lambda t, amplitude: 0)
        self.assertIn("the arm is busy", self.twin.told())
        self.assertEqual(self.partner.wait(goal.get_result_async()).status, SUCCEEDED)

    def test_what_is_no_command(self):
        self.partner.arm()
        start = self.partner.state()[:7]
        for names, position, text in ((JOINTS[:6], start[:6], "lacks panda_joint7"), (JOINTS, [math.nan] * 7, "is commanded to nan"),
                                      (JOINTS, [9.0] * 7, "is commanded to 9"), (JOINTS, [], "has no positions")):
            for _ in range(2):
                self.publisher.publish(JointState(name=names, position=position))
                self.partner.spin_for(1.1)
            self.partner.until(lambda: text in self.twin.told(), f"the twin did not say: {text}")
        old = JointState(name=JOINTS, position=start)
        old.header.stamp.sec = int(time.time()) - 100  # as of a bag that is played
        self.publisher.publish(old)
        self.partner.until(lambda: "s ago; 1 s are permitted" in self.twin.told(), "the twin did not say that a command is old")
        self.assertLess(max(abs(a - b) for a, b in zip(start, self.partner.state())), 1e-3)


class RestartTest(unittest.TestCase):
    def test_twin_is_killed_and_comes_again(self):
        twin = Twin(PROGRAM, *Served.words)
        partner = Partner()
        try:
            for _ in range(2):
                status, result = partner.do(FollowJointTrajectory, ARM, goal_of(partner.state(), by=0.05, seconds=1.0))
                self.assertEqual(status, SUCCEEDED, result.error_string)
                twin.end(signal.SIGKILL)
                twin = Twin(PROGRAM, *Served.words, port=twin.port)
                partner.states.clear()
        finally:
            partner.end()
            twin.end()

    def test_robot_on_the_network_goes_and_comes_again(self):
        served = Twin(PROGRAM, *Served.words, ros=False)
        bridge = Twin(PROGRAM, "--robot", f"127.0.0.1:{served.port}", command="ros")
        partner = Partner()
        try:
            start = partner.state()
            begun = seconds_of(partner.states[-1].header.stamp)
            status, result = partner.do(FollowJointTrajectory, ARM, goal_of(start))
            self.assertEqual(status, SUCCEEDED, result.error_string)
            error, _ = ros2_partner.following_error(partner.states, start, begun)
            self.assertLess(error, 0.005)
            goal = GripperCommand.Goal()
            goal.command.position = 0.01
            self.assertEqual(partner.do(GripperCommand, HAND, goal)[0], SUCCEEDED)
            partner.until(lambda: abs(partner.state()[7] - 0.01) < 1e-3, "the fingers do not show")
            served.end(signal.SIGKILL)
            partner.until(lambda: "connecting anew" in bridge.told(), "the loss was not told")
            served = Twin(PROGRAM, *Served.words, port=served.port, ros=False)
            status, result = partner.do(FollowJointTrajectory, ARM, goal_of(partner.state(), by=0.05, seconds=1.0))
            self.assertEqual(status, SUCCEEDED, result.error_string)
        finally:
            bridge.end()
            served.end()
            partner.end()


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
        import pathlib
        import tempfile
        with tempfile.TemporaryDirectory() as folder:
            at_rest = self.run_once(str(pathlib.Path(folder) / "run.mcap"), end=1.505)  # half of the way, at the highest speed
        self.assertLess(abs(at_rest[0] - 0.1), 0.02)

    def test_the_same_bytes_twice(self):
        import pathlib
        import subprocess
        import tempfile
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
