#!/usr/bin/env python3
"""A twin served by `serve --ros` and commanded by nodes of real ROS 2: arguments are the program and a distribution (jazzy, kilted)."""

import math
import os
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree

import ros2_partner
from ros2_partner import ARM, HAND, JOINTS, Partner, Twin, goal_of, seconds_of

PROGRAM = sys.argv[1]
ros2_partner.enter(sys.argv[2])
from action_msgs.msg import GoalStatusArray  # noqa: E402
from action_msgs.srv import CancelGoal  # noqa: E402
from control_msgs.action import FollowJointTrajectory, GripperCommand  # noqa: E402
from control_msgs.msg import JointTolerance  # noqa: E402
from franka_msgs.action import ErrorRecovery, Grasp, Homing, Move  # noqa: E402
from franka_msgs.msg import FrankaRobotState  # noqa: E402
from franka_msgs.srv import SetFullCollisionBehavior, SetJointStiffness, SetLoad  # noqa: E402
from geometry_msgs.msg import PoseStamped  # noqa: E402
from rclpy.action import get_action_server_names_and_types_by_node  # noqa: E402
from rclpy.parameter import Parameter  # noqa: E402
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy, qos_profile_sensor_data  # noqa: E402
from rclpy.time import Time as RosTime  # noqa: E402
from rosgraph_msgs.msg import Clock  # noqa: E402
from sensor_msgs.msg import CameraInfo, CompressedImage, Image, JointState  # noqa: E402
from simulation_interfaces.action import SimulateSteps  # noqa: E402
from simulation_interfaces.srv import GetEntities, GetEntityState, GetSimulationState, SetEntityState, SetSimulationState, StepSimulation  # noqa: E402
from std_msgs.msg import String  # noqa: E402
from std_srvs.srv import Trigger  # noqa: E402
from unique_identifier_msgs.msg import UUID  # noqa: E402

from ros2_served import ABORTED, CANCELED, SUCCEEDED, Served  # noqa: E402

LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class GraphTest(Served):
    def setUp(self):
        super().setUp()
        self.partner.until(lambda: ("panda_twin", "/") in self.partner.node.get_node_names_and_namespaces(), "no node panda_twin")

    def check_type(self, topic, kind, entries, own):
        """@param entries, own  look up the endpoints of the twin's topic, and one of rclpy's own of the same type"""
        self.partner.until(lambda: entries() and own(), topic)
        ours, theirs = entries()[0], own()[0]
        self.assertEqual((ours.topic_type, str(ours.topic_type_hash)), (theirs.topic_type, str(theirs.topic_type_hash)), f"{topic}: {kind}")

    def test_topics(self):
        node = self.partner.node
        written = dict(node.get_publisher_names_and_types_by_node("panda_twin", "/"))
        for topic in ("/joint_states", "/robot_joint_states", "/clock", "/robot_description", "/tf", "/franka_robot_state_broadcaster/robot_state",
                      f"{ARM}/_action/status", f"{ARM}/_action/feedback", f"{HAND}/_action/status"):
            self.assertIn(topic, written)
        del written["/tf"]  # no wheel has its type
        for topic, (kind,) in written.items():
            own = node.create_publisher(ros2_partner.interface_of(kind), "/own", 10)
            self.check_type(topic, kind, lambda: node.get_publishers_info_by_topic(topic), lambda: node.get_publishers_info_by_topic("/own"))
            info = node.get_publishers_info_by_topic(topic)
            self.assertEqual([one.node_name for one in info], ["panda_twin"], topic)
            is_latched = topic == "/robot_description" or topic.endswith("/_action/status")
            is_picture = topic.startswith("/camera/")
            self.assertEqual((info[0].qos_profile.reliability, info[0].qos_profile.durability),
                             (ReliabilityPolicy.BEST_EFFORT if is_picture else ReliabilityPolicy.RELIABLE,
                              DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE), topic)
            node.destroy_publisher(own)
            self.partner.until(lambda: not node.get_publishers_info_by_topic("/own"))
        read = dict(node.get_subscriber_names_and_types_by_node("panda_twin", "/"))
        self.assertEqual(read, {"/robot_joint_commands": ["sensor_msgs/msg/JointState"]})
        own = node.create_subscription(JointState, "/own", lambda message: None, 10)
        self.check_type("/robot_joint_commands", "JointState", lambda: node.get_subscriptions_info_by_topic("/robot_joint_commands"),
                        lambda: node.get_subscriptions_info_by_topic("/own"))
        info = node.get_subscriptions_info_by_topic("/robot_joint_commands")[0].qos_profile
        self.assertEqual((info.reliability, info.durability), (ReliabilityPolicy.RELIABLE, DurabilityPolicy.VOLATILE))
        node.destroy_subscription(own)
        print(f"  types and hashes of {len(written)} publishers, 1 subscription")

    def test_services_and_actions(self):
        node = self.partner.node
        services = dict(node.get_service_names_and_types_by_node("panda_twin", "/"))
        self.assertEqual(services["/service_server/set_load"], ["franka_msgs/srv/SetLoad"])
        self.assertEqual(services["/panda_twin/arm"], ["std_srvs/srv/SetBool"])
        self.assertEqual(services["/panda_twin/recover"], ["std_srvs/srv/Trigger"])
        for i, (name, (kind,)) in enumerate(services.items()):
            own = node.create_service(ros2_partner.interface_of(kind), f"/own{i}", lambda request, response: response)
            self.check_type(name, kind, lambda: node.get_publishers_info_by_topic(f"rr{name}Reply", no_mangle=True),
                            lambda: node.get_publishers_info_by_topic(f"rr/own{i}Reply", no_mangle=True))
            self.check_type(name, kind, lambda: node.get_subscriptions_info_by_topic(f"rq{name}Request", no_mangle=True),
                            lambda: node.get_subscriptions_info_by_topic(f"rq/own{i}Request", no_mangle=True))
            node.destroy_service(own)
        actions = dict(get_action_server_names_and_types_by_node(node, "panda_twin", "/"))
        self.assertEqual(actions, {ARM: ["control_msgs/action/FollowJointTrajectory"], HAND: ["control_msgs/action/GripperCommand"],
                                   "/action_server/error_recovery": ["franka_msgs/action/ErrorRecovery"],
                                   **{f"/panda_gripper/{name.lower()}": [f"franka_msgs/action/{name}"] for name in ("Grasp", "Homing", "Move")},
                                   "/simulate_steps": ["simulation_interfaces/action/SimulateSteps"]})
        print(f"  types and hashes of {len(services)} services; {len(actions)} actions")

    def test_late_joiner_gets_what_is_latched(self):
        got = self.partner.collect(String, "/robot_description", LATCHED)
        statuses = [self.partner.collect(GoalStatusArray, f"{name}/_action/status", LATCHED) for name in (ARM, HAND)]
        self.partner.until(lambda: got and all(statuses))
        joints = {joint.get("name") for joint in xml.etree.ElementTree.fromstring(got[0].data).iter("joint")}
        self.assertLessEqual({*JOINTS, "panda_finger_joint1", "panda_finger_joint2"}, joints)

    def test_states_and_clock(self):
        delays = []
        fast = self.partner.collect(JointState, "/robot_joint_states", qos_profile_sensor_data)
        clock = self.partner.collect(Clock, "/clock", qos_profile_sensor_data)
        self.partner.node.create_subscription(JointState, "/joint_states", lambda m: delays.append(abs(time.time() - seconds_of(m.header.stamp))), 10)
        self.partner.states.clear()
        self.partner.until(lambda: len(fast) > 1500 and len(clock) > 100 and len(self.partner.states) > 200)
        for messages, period in ((fast, 0.001), (self.partner.states, 0.01)):
            stamps = [seconds_of(m.header.stamp) for m in messages]
            steps = sorted(b - a for a, b in zip(stamps, stamps[1:]))
            self.assertAlmostEqual(steps[len(steps) // 2], period, delta=0.02 * period)
            self.assertGreater(steps[0], 0)
            print(f"  every {1e3 * steps[len(steps) // 2]:.2f} ms; {sum(step > 1.5 * period for step in steps)} of {len(steps)} steps longer")
        self.assertEqual(list(self.partner.states[-1].name), [*JOINTS, "panda_finger_joint1", "panda_finger_joint2"])
        self.assertLess(min(delays), 0.3)
        times = [seconds_of(m.clock) for m in clock]
        self.assertEqual(sorted(set(times)), times)

    def test_use_sim_time(self):
        other = Partner("sim_time", [Parameter("use_sim_time", value=True)])
        try:
            other.until(lambda: other.node.get_clock().now().nanoseconds > 0, "the node got no time")
            clock = other.collect(Clock, "/clock", qos_profile_sensor_data)
            other.until(lambda: len(clock) > 10)
            self.assertTrue(other.node.get_clock().ros_time_is_active)
            own = other.node.get_clock()
            other.until(lambda: own.now().nanoseconds in [RosTime.from_msg(m.clock).nanoseconds for m in clock[-5:]], "the node has another time")
        finally:
            other.end()


class TrajectoryTest(Served):
    def check_following(self, **how):
        start = self.partner.state()
        feedback = []
        status, result = self.follow(goal_of(start, **how), feedback)
        self.assertEqual((status, result.error_code, result.error_string), (SUCCEEDED, 0, ""))
        self.assertTrue(feedback)
        error, delay = ros2_partner.following_error(self.partner.states, feedback, start, how.get("by", 0.2), how.get("seconds", 2.0))
        print(f"  {how}: {1e3 * error:.2f} mrad, {1e3 * delay:.0f} ms late")
        self.assertLess(error, 0.005)
        self.assertLess(delay, 0.05)
        self.assertEqual(list(feedback[-1].joint_names), JOINTS)
        errors = sorted(max(map(abs, one.error.positions)) for one in feedback)
        self.assertLess(errors[len(errors) // 2], 0.005)

    def test_follows(self):
        for i, how in enumerate(({"step": 0.1, "derivatives": 2}, {"step": 0.01}, {"step": 0.01, "derivatives": 1}, {"step": 0.01, "derivatives": 2},
                                 {"step": 0.5, "derivatives": 1}, {"step": 0.1}, {"step": 0.05, "names": JOINTS[::-1]})):
            with self.subTest(**how):
                self.check_following(by=0.1 * (-1)**i, seconds=1.0, **how)

    def refused(self, goal, code, text):
        before = self.partner.state()
        status, result = self.follow(goal)
        self.assertEqual((status, result.error_code), (ABORTED, code), result.error_string)
        self.assertIn(text, result.error_string)
        self.stays(before)

    def test_refusals_say_why(self):
        _, start = self.partner.rest()

        def changed(change, **how):
            goal = goal_of(start, **how)
            change(goal.trajectory)
            return goal

        def point(index, **values):
            return lambda trajectory: [setattr(trajectory.points[index], name, value) for name, value in values.items()]

        def stamp(seconds):
            at = self.partner.states[-1].header.stamp.sec + seconds
            return lambda trajectory: setattr(trajectory.header.stamp, "sec", at)

        nan, inf = [0.0] * 6 + [math.nan], [math.inf] * 7
        tolerance = goal_of(start)
        tolerance.path_tolerance = [JointTolerance(name="panda_joint8", position=0.1)]
        cases = (
            (goal_of(start, names=[*JOINTS[:6], "panda_joint8"]), -2, "joint_names are"),
            (goal_of(start, names=JOINTS[:6]), -2, "joint_names are"),
            (goal_of(start, names=[*JOINTS[:6], JOINTS[0]]), -2, "joint_names are"),
            (changed(point(3, positions=nan)), -1, "points[3].positions has a value that is not finite"),
            (changed(point(3, positions=inf)), -1, "points[3].positions has a value that is not finite"),
            (changed(point(3, velocities=nan)), -1, "points[3].velocities has a value that is not finite"),
            (changed(point(3, accelerations=[0.0] * 6)), -1, "points[3].accelerations has 6 values for 7 joints"),
            (changed(point(3, positions=[])), -1, "points[3] has no positions"),
            (changed(point(5, time_from_start=ros2_partner.duration_of(0.4))), -1, "points[5].time_from_start"),
            (changed(point(5, time_from_start=ros2_partner.duration_of(0.3))), -1, "points[5].time_from_start"),
            (goal_of(start, begin=-1.0), -1, "points[0].time_from_start"),
            (changed(stamp(-10)), -3, "in the past"),
            (changed(stamp(10)), -1, "in the future"),
            (goal_of([q + 0.1 for q in start]), -1, "Plan from where the arm is"),
            (goal_of(start, by=2.5, seconds=30.0, step=1.0), -1, "not inside its limits"),
            (goal_of(start, by=0.5, seconds=0.2, step=0.02), -1, "limit"),
            (changed(lambda trajectory: trajectory.points.clear()), -1, "no points"),
            (changed(lambda trajectory: trajectory.points.__delitem__(slice(1, None))), -1, "the only point is at time 0"),
            (changed(point(-1, velocities=[0.1] * 7), derivatives=1), -1, "must rest there"),
            (tolerance, -1, "path_tolerance names panda_joint8"),
        )
        for goal, code, text in cases:
            with self.subTest(text=text):
                self.refused(goal, code, text)
        self.is_well()

    def test_a_goal_of_years_is_refused_at_once(self):
        start = self.partner.state()
        goal = goal_of(start, names=["x" * 100000, *JOINTS[1:]])
        self.refused(goal, -2, "joint_names are")
        self.assertLess(max(map(len, self.twin.told().splitlines())), 1000)
        goal = goal_of(start, by=0.0, seconds=1.0, step=1.0, derivatives=1)
        goal.trajectory.points[1].time_from_start.sec = 200_000
        before = self.twin.memory_kb("VmHWM")
        self.refused(goal, -1, "half an hour")
        self.assertLess(self.twin.memory_kb("VmHWM") - before, 200_000)

    def test_cancel(self):
        start = self.partner.state()
        handle = self.partner.send(FollowJointTrajectory, ARM, goal_of(start))
        self.partner.until(lambda: abs(self.partner.states[-1].position[0] - start[0]) > 0.05, "the arm did not begin")
        answer = self.partner.call(Trigger, "/panda_twin/recover")
        self.assertEqual((answer.success, answer.message), (False, "the arm moves; wait until its goal has ended, or cancel it"))
        at = seconds_of(self.partner.states[-1].header.stamp)
        answer = self.partner.wait(handle.cancel_goal_async())
        self.assertEqual(len(answer.goals_canceling), 1)
        response = self.partner.wait(handle.get_result_async())
        self.assertEqual((response.status, response.result.error_string), (CANCELED, "canceled; the arm was stopped"))
        states = self.partner.states[:]
        self.is_well()
        moving = [m for m in states + self.partner.states if max(map(abs, m.velocity[:7])) > 2e-3]
        took = seconds_of(moving[-1].header.stamp) - at - sum(by for since, by in ros2_partner.leaps_of(states) if since > at)
        print(f"  canceled: at rest after {took:.3f} s")
        self.assertLess(took, 0.5)
        again = self.partner.wait(handle.cancel_goal_async())
        self.assertEqual((again.return_code, len(again.goals_canceling)), (CancelGoal.Response.ERROR_GOAL_TERMINATED, 0))
        self.check_following(by=-0.1, seconds=1.0)

    def test_goals_nobody_knows(self):
        request = CancelGoal.Request()
        request.goal_info.goal_id.uuid = [7] * 16
        answer = self.partner.call(CancelGoal, f"{ARM}/_action/cancel_goal", request)
        self.assertEqual((answer.return_code, list(answer.goals_canceling)), (CancelGoal.Response.ERROR_UNKNOWN_GOAL_ID, []))
        service = FollowJointTrajectory.Impl.GetResultService
        answer = self.partner.call(service, f"{ARM}/_action/get_result", service.Request(goal_id=request.goal_info.goal_id))
        self.assertEqual(answer.status, 0)
        answer = self.partner.call(CancelGoal, f"{ARM}/_action/cancel_goal")  # all of none
        self.assertEqual((answer.return_code, list(answer.goals_canceling)), (CancelGoal.Response.ERROR_NONE, []))

    def test_all_goals_canceled_and_an_id_twice(self):
        statuses = self.partner.collect(GoalStatusArray, f"{ARM}/_action/status", LATCHED)
        client = self.partner.action(FollowJointTrajectory, ARM)
        own = UUID(uuid=[*os.urandom(16)])
        goal = goal_of(self.partner.state(), seconds=20.0)
        handle = self.partner.wait(client.send_goal_async(goal, goal_uuid=own))
        self.assertFalse(self.partner.wait(client.send_goal_async(goal, goal_uuid=own)).accepted)
        answer = self.partner.call(CancelGoal, f"{ARM}/_action/cancel_goal")
        self.assertEqual([list(one.goal_id.uuid) for one in answer.goals_canceling], [list(own.uuid)])
        self.assertEqual(self.partner.wait(handle.get_result_async()).status, CANCELED)
        self.partner.until(lambda: statuses and statuses[-1].status_list and statuses[-1].status_list[-1].status == CANCELED, "the status was not told")
        self.assertEqual(list(statuses[-1].status_list[-1].goal_info.goal_id.uuid), list(own.uuid))
        self.is_well()

    def test_a_newer_goal_takes_over(self):
        start = self.partner.state()
        first = self.partner.send(FollowJointTrajectory, ARM, goal_of(start))
        self.partner.until(lambda: abs(self.partner.states[-1].position[0] - start[0]) > 0.05, "the arm did not begin")
        self.succeed(goal_of(start, by=0.0, seconds=0.5, begin=1.0))
        response = self.partner.wait(first.get_result_async())
        self.assertEqual(response.status, ABORTED)
        self.assertIn("preempted", response.result.error_string)
        self.stays(start)
        self.is_well()

    def test_path_tolerance(self):
        goal = goal_of(self.partner.state(), by=-0.1, begin=0.5)
        goal.path_tolerance = [JointTolerance(name=JOINTS[0], position=1e-7)]
        status, result = self.follow(goal)
        self.assertEqual((status, result.error_code), (ABORTED, -4))
        self.assertIn("path_tolerance permits", result.error_string)
        self.is_well()

    def test_goal_tolerance(self):
        start = self.partner.state()
        goal = goal_of(start, by=-0.05, seconds=0.5)
        goal.goal_tolerance = [JointTolerance(name=name, position=1e-9) for name in JOINTS]
        status, result = self.follow(goal)
        self.assertEqual((status, result.error_code), (ABORTED, -5))
        self.assertIn("goal_tolerance permits", result.error_string)
        goal = goal_of(self.partner.state(), by=0.05, seconds=0.5)
        goal.goal_tolerance = [JointTolerance(name=name, position=1e-9) for name in JOINTS]
        goal.goal_time_tolerance.sec = 1000
        handle = self.partner.send(FollowJointTrajectory, ARM, goal)
        self.partner.until(lambda: abs(self.partner.state()[0] - start[0]) < 1e-3, "the arm is not at the goal")
        self.partner.wait(handle.cancel_goal_async())  # while the arm waits to come nearer
        self.assertIn(self.partner.wait(handle.get_result_async()).status, (SUCCEEDED, CANCELED))

    def test_goals_canceled_at_once(self):
        start = self.partner.state()
        ends = []
        for i in range(20):
            handle = self.partner.send(FollowJointTrajectory, ARM, goal_of(start, by=0.0, seconds=1.0))
            self.partner.spin_for(0.002 * i)
            self.partner.wait(handle.cancel_goal_async())
            ends.append(self.partner.wait(handle.get_result_async()).status)
        self.assertEqual(ends, [CANCELED] * 20)
        self.stays(start)
        self.is_well()

    def test_goals_one_upon_another(self):
        client = self.partner.action(FollowJointTrajectory, ARM)
        start = self.partner.state()
        accepted = [client.send_goal_async(goal_of(start, by=0.0, seconds=0.3)) for _ in range(10)]  # as many as a service of ROS keeps
        results = [self.partner.wait(one).get_result_async() for one in accepted]
        self.assertEqual([self.partner.wait(one).status for one in results], [ABORTED] * 9 + [SUCCEEDED])
        self.is_well()

    def test_two_clients(self):
        other = Partner("other")
        try:
            start = self.partner.state()
            self.succeed(goal_of(start, by=0.05, seconds=0.5))
            self.succeed(goal_of(self.partner.state(), by=-0.05, seconds=0.5), other)
            self.stays(start)
            first = self.partner.send(FollowJointTrajectory, ARM, goal_of(start))
            second = other.send(FollowJointTrajectory, ARM, goal_of(start, by=0.1, seconds=0.5, begin=0.5))
            self.assertEqual(self.partner.wait(first.get_result_async()).status, ABORTED)
            self.assertEqual(other.wait(second.get_result_async()).status, SUCCEEDED)
            self.succeed(goal_of(self.partner.state(), by=-0.1, seconds=1.0))
            self.stays(start)
        finally:
            other.end()

    def test_client_dies_in_its_goal(self):
        child = subprocess.run([sys.executable, ros2_partner.__file__], timeout=ros2_partner.PATIENCE)
        self.assertEqual(child.returncode, -signal.SIGKILL)
        self.partner.until(lambda: "motion finished" in self.told() or "motion stopped" in self.told(), "the dead client's goal did not end")
        self.is_well()
        self.check_following(by=-0.1, seconds=1.0)

    def test_user_stop_and_recovery(self):
        handle = self.partner.send(FollowJointTrajectory, ARM, goal_of(self.partner.state(), seconds=20.0, by=-0.2))
        self.partner.until(lambda: "motion started" in self.told(), "the arm did not begin")
        self.twin.ctl("user-stop", "press")
        response = self.partner.wait(handle.get_result_async())
        self.assertEqual(response.status, ABORTED)
        self.assertIn("user stop", response.result.error_string)
        _, start = self.partner.rest()
        self.refused(goal_of(start), -1, "not Idle")
        answer = self.partner.call(Trigger, "/panda_twin/recover")
        self.assertFalse(answer.success)
        self.assertIn("release the user stop", answer.message)
        self.twin.ctl("user-stop", "release")
        self.assertTrue(self.partner.call(Trigger, "/panda_twin/recover").success)
        self.check_following(by=0.1, seconds=1.0)


class FrankaTest(Served):
    words = ["models/scenarios/grasp.yaml", *Served.words]

    def test_gripper_command(self):
        def goal_of_hand(position, effort=0.0):
            goal = GripperCommand.Goal()
            goal.command.position = position
            goal.command.max_effort = effort
            return goal

        def command(position, effort=0.0):
            return self.partner.do(GripperCommand, HAND, goal_of_hand(position, effort))

        for position in (0.01, 0.04, 0.0, 0.035):
            status, result = command(position)
            self.assertEqual((status, result.reached_goal, result.stalled), (SUCCEEDED, True, False))
            self.partner.until(lambda: abs(self.partner.state()[7] - position) < 1e-3, "joint_states have another opening")
        first = self.partner.send(GripperCommand, HAND, goal_of_hand(0.0))
        self.partner.until(lambda: self.partner.state()[7] < 0.033, "the fingers did not begin")
        self.assertEqual(len(self.partner.wait(first.cancel_goal_async()).goals_canceling), 1)
        self.assertEqual(self.partner.wait(first.get_result_async()).status, CANCELED)
        first = self.partner.send(GripperCommand, HAND, goal_of_hand(0.04))
        self.assertEqual(command(0.03)[0], SUCCEEDED)
        self.assertIn(self.partner.wait(first.get_result_async()).status, (SUCCEEDED, ABORTED))
        status, result = command(0.0, effort=20.0)
        print(f"  closed with 20 N on nothing: status {status}, position {result.position:.4f} m, stalled {result.stalled}, reached {result.reached_goal}")
        self.assertEqual((status, result.reached_goal), (SUCCEEDED, True))
        self.assertEqual(command(0.04)[0], SUCCEEDED)
        for position, effort in ((0.2, 0.0), (-0.1, 0.0), (math.nan, 0.0), (0.01, math.nan), (0.01, -1.0)):
            self.since = len(self.twin.told())
            self.assertEqual(command(position, effort)[0], ABORTED)
            self.partner.until(lambda: "position is that of one finger" in self.told(), "no sentence")
        self.assertAlmostEqual(self.partner.state()[7], 0.04, delta=0.001)

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


class RestartTest(unittest.TestCase):
    def test_twin_is_killed_and_comes_again(self):
        twin = Twin(PROGRAM, *Served.words)
        partner = Partner()
        try:
            for turn in range(2):
                status, result = partner.do(FollowJointTrajectory, ARM, goal_of(partner.state(), by=0.05, seconds=1.0))
                self.assertEqual(status, SUCCEEDED, f"turn {turn}: {result.error_string}\n{twin.told()}")
                twin.end(signal.SIGKILL)
                twin = Twin(PROGRAM, *Served.words, port=twin.port)
        finally:
            partner.end()
            twin.end()

    def test_robot_on_the_network_goes_and_comes_again(self):
        served = Twin(PROGRAM, *Served.words, ros=False)
        bridge = Twin(PROGRAM, "--robot", f"127.0.0.1:{served.port}", command="ros")
        partner = Partner()
        try:
            for by in (0.2, -0.2, 0.2):  # when the host is late, stamps follow the wall clock
                start, feedback = partner.state(), []
                status, result = partner.do(FollowJointTrajectory, ARM, goal_of(start, by=by), feedback)
                self.assertEqual(status, SUCCEEDED, result.error_string)
                error, delay = ros2_partner.following_error(partner.states, feedback, start, by)
                print(f"  panda-twin ros: {1e3 * error:.2f} mrad, {1e3 * delay:.0f} ms late")
                if error < 0.005:
                    break
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


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]], verbosity=1)
