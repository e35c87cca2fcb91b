"""What libfranka offers below panda-python: every setter, every kind of motion. See panda_programs.py."""

import math

import numpy as np
from panda_py import libfranka

from panda_common import HIGH, SENSITIVE, distance, program


@program
def setters(address):
    """Every one of them, and what the state says afterwards."""
    robot = libfranka.Robot(address)
    robot.set_collision_behavior(*SENSITIVE)
    robot.set_collision_behavior(*[[20.0] * 7] * 4, *[[20.0] * 6] * 4)
    robot.set_joint_impedance([3000.0] * 4 + [2000.0] * 3)
    robot.set_cartesian_impedance([2000.0] * 3 + [200.0] * 3)
    robot.set_guiding_mode([True, True, True, False, False, False], True)
    frame = [1.0, 0, 0, 0, 0, 1.0, 0, 0, 0, 0, 1.0, 0, 0.01, 0.02, 0.03, 1.0]
    robot.set_k(frame)
    robot.set_ee(frame)
    robot.set_load(0.5, [0.0, 0.0, 0.1], [0.001, 0, 0, 0, 0.002, 0, 0, 0, 0.003])
    state = robot.read_once()
    facts = {"EE_T_K": state.EE_T_K, "frame": frame, "m_load": state.m_load, "m_total": state.m_total - state.m_ee}
    expected = np.array(state.F_T_EE).reshape(4, 4).T[2, 3]
    facts["z_of_EE_in_flange"] = float(expected)
    try:
        robot.set_joint_impedance([-1.0] * 7)
    except RuntimeError as error:
        facts["bad"] = str(error)
    return facts


@program
def raw_interfaces(address):
    """Every kind of motion that libfranka has, a second each."""
    robot = libfranka.Robot(address)
    robot.set_collision_behavior(*HIGH)
    ways = {}

    def run(name, control, make):
        clock, first = [0.0], []

        def callback(state, period):
            clock[0] += period.to_sec()
            if not first:
                first.append(state)
            command = make(first[0], clock[0])
            command.motion_finished = clock[0] >= 1
            return command

        before = robot.read_once()
        control(callback)
        after = robot.read_once()
        ways[name] = [distance(after.q, before.q), abs(after.O_T_EE[14] - before.O_T_EE[14])]

    def smooth(t):
        return 0.5 - 0.5 * math.cos(2 * math.pi * t)

    def raised(pose, by):
        return list(pose[:14]) + [pose[14] + by, 1.0]

    def still(state, period):
        return libfranka.Torques([0.0] * 7)

    def positions(first, t):
        return libfranka.JointPositions([first.q_d[0] + 0.02 * smooth(t / 2)] + list(first.q_d[1:]))

    def velocities(first, t):
        return libfranka.JointVelocities([0.04 * smooth(t)] + [0.0] * 6)

    def poses(first, t):
        return libfranka.CartesianPose(raised(first.O_T_EE_c, 0.02 * smooth(t / 2)))

    def twists(first, t):
        return libfranka.CartesianVelocities([0.0, 0.0, 0.04 * smooth(t), 0.0, 0.0, 0.0])

    def torques(first, t):
        return libfranka.Torques([0.5 * math.sin(2 * math.pi * t)] + [0.0] * 6)

    cartesian = libfranka.ControllerMode.kCartesianImpedance
    run("joint_position", robot.control_joint_position, positions)
    run("joint_velocity", robot.control_joint_velocity, velocities)
    run("cartesian_pose", robot.control_cartesian_pose, poses)
    run("cartesian_velocity", robot.control_cartesian_velocity, twists)
    run("cartesian_pose_impedance", lambda f: robot.control_cartesian_pose(f, cartesian), poses)
    run("torque", robot.control, torques)
    run("torque_joint_position", lambda f: robot.control_torque_joint_position(still, f), positions)
    run("torque_joint_velocity", lambda f: robot.control_torque_joint_velocity(still, f), velocities)
    run("torque_cartesian_pose", lambda f: robot.control_torque_cartesian_pose(still, f), poses)
    run("torque_cartesian_velocity", lambda f: robot.control_torque_cartesian_velocity(still, f), twists)
    return {"ways": ways}
