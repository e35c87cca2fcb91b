#!/usr/bin/env python3
"""Programs of a user of an FR3, each with a client that others wrote: fr3_programs.py PROGRAM ADDRESS. Prints facts as JSON."""

import json
import math
import sys
import time

PROGRAMS = {}
READY = [0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4]


def program(function):
    PROGRAMS[function.__name__] = function
    return function


def farthest(a, b):
    return max(abs(x - y) for x, y in zip(a, b))


class Pylibfranka:
    """pylibfranka's Robot, set up as its examples do."""

    def __init__(self, address):
        import pylibfranka
        self.lib = pylibfranka
        self.robot = pylibfranka.Robot(address, pylibfranka.RealtimeConfig.kIgnore)
        high = [100.0] * 7, [100.0] * 7, [100.0] * 6, [100.0] * 6
        self.robot.set_collision_behavior(*high)
        self.robot.set_joint_impedance([3000, 3000, 3000, 2500, 2500, 2000, 2000])
        self.robot.set_cartesian_impedance([3000, 3000, 3000, 300, 300, 300])

    def settled(self):
        """A state that was sent after the last request had been answered: one from before may still be queued."""
        return [self.robot.read_once() for _ in range(10)][-1]

    def run(self, control, command_at, seconds):
        """Drives an active control to its end. command_at(time, first state, state) gives the command. @returns the last state."""
        time, first, state = 0.0, None, None
        while True:
            state, period = control.readOnce()
            first = first or state
            time += period.to_sec()
            command = command_at(time, first, state)
            command.motion_finished = time >= seconds
            control.writeOnce(command)
            if command.motion_finished:
                return first, state


def swing(time, seconds):
    """From 0 to 1 and back to 0, at rest at both ends."""
    return (1 - math.cos(2 * math.pi * min(time, seconds) / seconds)) / 2


def reach(time, seconds):
    """From 0 to 1, at rest at both ends."""
    return (1 - math.cos(math.pi * min(time, seconds) / seconds)) / 2


@program
def pylibfranka_reads(address):
    arm = Pylibfranka(address)
    state = arm.robot.read_once()
    model = arm.robot.load_model()
    gravity, mass = model.gravity(state), model.mass(state)
    arm.robot.set_load(0.5, [0, 0, 0.05], [0.001, 0, 0, 0, 0.001, 0, 0, 0, 0.001])
    loaded = arm.settled()
    arm.robot.set_EE([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.02, 1])
    arm.robot.set_K([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0.01, 1])
    moved = arm.settled()
    return {"q": state.q, "O_T_EE": state.O_T_EE, "tau_J": state.tau_J, "gravity": list(gravity),
            "asymmetry": max(abs(mass[7 * i + j] - mass[7 * j + i]) for i in range(7) for j in range(7)),
            "mass_11": mass[0], "mode": state.robot_mode.name, "m_load": loaded.m_load,
            "raised": state.O_T_EE[14] - moved.O_T_EE[14], "gravity_with_load": list(model.gravity(loaded))}


@program
def pylibfranka_joint_positions(address):
    arm = Pylibfranka(address)
    control = arm.robot.start_joint_position_control(arm.lib.ControllerMode.JointImpedance)

    def command_at(time, first, _):
        q = list(first.q_d)
        for joint in (3, 4, 6):
            q[joint] += 0.3 * reach(time, 2)
        return arm.lib.JointPositions(q)
    first, _ = arm.run(control, command_at, 2.1)
    last = arm.robot.read_once()
    goal = [q + (0.3 if joint in (3, 4, 6) else 0) for joint, q in enumerate(first.q_d)]
    return {"miss": farthest(last.q, goal), "mode": last.robot_mode.name, "success_rate": first.control_command_success_rate}


@program
def pylibfranka_joint_velocities(address):
    arm = Pylibfranka(address)
    control = arm.robot.start_joint_velocity_control(arm.lib.ControllerMode.CartesianImpedance)

    def command_at(time, _first, _state):
        return arm.lib.JointVelocities([0, 0, 0, 0.2 * math.sin(math.pi * min(time, 2) / 2), 0, 0, 0])
    first, _ = arm.run(control, command_at, 2.05)
    return {"turned": arm.robot.read_once().q[3] - first.q[3]}  # 0.8 / pi


@program
def pylibfranka_cartesian_pose(address):
    arm = Pylibfranka(address)
    control = arm.robot.start_cartesian_pose_control(arm.lib.ControllerMode.JointImpedance)

    def command_at(time, first, _):
        pose = list(first.O_T_EE_c)
        pose[12] += 0.1 * reach(time, 2)
        pose[14] -= 0.05 * reach(time, 2)
        return arm.lib.CartesianPose(pose)
    first, _ = arm.run(control, command_at, 2.1)
    last = arm.robot.read_once()
    return {"moved": [last.O_T_EE[i] - first.O_T_EE[i] for i in (12, 13, 14)]}


@program
def pylibfranka_cartesian_velocities(address):
    arm = Pylibfranka(address)
    control = arm.robot.start_cartesian_velocity_control(arm.lib.ControllerMode.CartesianImpedance)

    def command_at(time, _first, _state):
        return arm.lib.CartesianVelocities([0, 0.1 * math.sin(math.pi * min(time, 2) / 2), 0, 0, 0, 0])
    first, _ = arm.run(control, command_at, 2.05)
    return {"moved": arm.robot.read_once().O_T_EE[13] - first.O_T_EE[13]}  # 0.4 / pi


@program
def pylibfranka_torques(address):
    """A spring about the start, and a push of it by its rest length: torque alone, without a motion generator."""
    arm = Pylibfranka(address)
    model = arm.robot.load_model()
    control = arm.robot.start_torque_control()
    stiffness = [600, 600, 600, 600, 250, 150, 50]
    rates, q_d, farthest_dq = [], [], 0.0

    def command_at(time, first, state):
        nonlocal farthest_dq
        rates.append(state.control_command_success_rate)
        q_d.append(list(state.q_d))
        farthest_dq = max(farthest_dq, max(map(abs, state.dq)))
        coriolis = model.coriolis(state)
        tau = [k * (q_0 + (0.1 * swing(time, 2) if i == 3 else 0) - q) - 2 * math.sqrt(k) * dq + c for i, (k, q_0, q, dq, c) in
               enumerate(zip(stiffness, first.q, state.q, state.dq, coriolis))]
        return arm.lib.Torques(tau)
    first, state = arm.run(control, command_at, 2.5)
    last = arm.robot.read_once()
    return {"miss": farthest(last.q, first.q), "rate": rates[-1], "reference_moved": farthest(q_d[-1], q_d[0]), "dq": farthest_dq,
            "mode": last.robot_mode.name}


@program
def pylibfranka_asynchronous(address):
    """Goals, one after the other, the second before the first is reached."""
    arm = Pylibfranka(address)
    lib = arm.lib
    handler_type = lib.AsyncPositionControlHandler
    result = handler_type.configure(arm.robot, handler_type.Configuration([0.6] * 7, 0.001))
    if result.error_message:
        raise RuntimeError(result.error_message)
    handler = result.handler
    goals = [[q + d for q in READY] for d in (0.3, -0.1)]
    fastest, seen = 0.0, []
    for goal, cycles in zip(goals, (300, 6000)):
        done = handler.set_joint_position_target(handler_type.JointPositionTarget(goal))
        if not done.was_successful:
            raise RuntimeError(done.error_message)
        for _ in range(cycles):
            feedback = handler.get_target_feedback()
            if feedback.error_message:
                raise RuntimeError(feedback.error_message)
            seen.append(feedback.status.name)
            if seen[-1] == "kTargetReached":
                break
    handler.stop_control()
    last = arm.robot.read_once()
    return {"miss": farthest(last.q, goals[-1]), "reached": seen[-1], "executing": seen.count("kExecuting"),
            "mode": last.robot_mode.name}


@program
def pylibfranka_error(address):
    """A jump aborts; after recovery the arm moves again."""
    arm = Pylibfranka(address)
    control = arm.robot.start_joint_position_control(arm.lib.ControllerMode.JointImpedance)
    said = ""
    try:
        arm.run(control, lambda time, first, _: arm.lib.JointPositions([q + (0.05 if time > 0.1 else 0) for q in first.q_d]), 1)
    except arm.lib.ControlException as error:
        said = str(error)
    del control
    reflex = arm.robot.read_once().robot_mode.name
    arm.robot.automatic_error_recovery()
    control = arm.robot.start_joint_position_control(arm.lib.ControllerMode.JointImpedance)
    arm.run(control, lambda time, first, _: arm.lib.JointPositions(first.q_d), 0.2)
    return {"said": said, "reflex": reflex, "mode": arm.robot.read_once().robot_mode.name}


@program
def pylibfranka_too_fast_near_the_end(address):
    """2 rad/s is within the limit of joint 1 in the middle of its range, and beyond it close to the end."""
    arm = Pylibfranka(address)
    control = arm.robot.start_joint_velocity_control(arm.lib.ControllerMode.JointImpedance)
    fastest = {"q": 0.0}

    def command_at(time, _first, state):
        fastest["q"] = state.q_d[0]
        return arm.lib.JointVelocities([2 * reach(time, 0.8), 0, 0, 0, 0, 0, 0])
    try:
        arm.run(control, command_at, 3)
        return {"said": ""}
    except arm.lib.ControlException as error:
        return {"said": str(error), "q": fastest["q"]}


@program
def pylibfranka_gripper(address):
    import pylibfranka
    gripper = pylibfranka.Gripper(address)
    gripper.homing()
    opened = gripper.read_once().max_width
    moved = gripper.move(0.03, 0.1)
    return {"version": gripper.server_version(), "opened": opened, "moved": moved, "width": gripper.read_once().width}


@program
def pylibfranka_refused(address):
    import pylibfranka
    try:
        pylibfranka.Robot(address, pylibfranka.RealtimeConfig.kIgnore)
    except Exception as error:
        return {"said": str(error)}
    return {"said": ""}


@program
def franky_moves(address):
    """As in the README of franky: motions in joint and Cartesian space, with blending of two, and the gripper."""
    import franky
    robot = franky.Robot(address, realtime_config=franky.RealtimeConfig.Ignore)
    robot.relative_dynamics_factor = 0.05
    robot.set_collision_behavior([100.0] * 7, [100.0] * 7, [100.0] * 6, [100.0] * 6)
    robot.recover_from_errors()
    robot.move(franky.JointMotion(franky.JointState(READY)))
    start = robot.current_cartesian_state.pose.end_effector_pose.translation.tolist()
    robot.move(franky.CartesianMotion(franky.Affine([0.05, 0.0, -0.05]), franky.ReferenceType.Relative))
    moved = robot.current_cartesian_state.pose.end_effector_pose.translation.tolist()
    robot.move(franky.JointWaypointMotion([franky.JointWaypoint(franky.JointState([q + d for q in READY])) for d in (0.1, 0.0)]))
    robot.move(franky.JointVelocityMotion([0.1, 0, 0, 0, 0, 0, 0], franky.Duration(500)))
    robot.move(franky.JointVelocityStopMotion())
    turned = robot.current_joint_state.position.tolist()
    gripper = franky.Gripper(address)
    gripper.homing()
    gripper.open(0.1)
    return {"moved": [b - a for a, b in zip(start, moved)], "turned": [b - a for a, b in zip(READY, turned)],
            "width": gripper.width, "errors": bool(robot.has_errors)}


def stream_to(targets, distance, goal, tolerance):
    """Streams to the goal, until the measured state is there, and ends the motion in order. @returns how near it came"""
    with targets as stream:
        stream.move_to(goal)
        for _ in range(3000):
            if (left := distance(stream.state())) < tolerance:
                break
            time.sleep(0.01)
    return left


@program
def franka_rs_all(address):
    """What franka-rs has: target streams by each backend, its model of the served URDF, an error with recovery, the hand."""
    import franka
    robot = franka.Robot(address, realtime="ignore")
    robot.set_collision_behavior_simple([100.0] * 7, [100.0] * 7, [100.0] * 6, [100.0] * 6)
    robot.set_joint_impedance([3000.0, 3000.0, 3000.0, 2500.0, 2500.0, 2000.0, 2000.0])
    robot.set_cartesian_impedance([3000.0, 3000.0, 3000.0, 300.0, 300.0, 300.0])
    [state] = [robot.read_once() for _ in range(10)][-1:]
    model, at = robot.model(), [state.O_T_EE[row][3] for row in range(3)]
    facts = {"version": robot.fci_version, "tau_J": list(state.tau_J),
             "gravity": list(model.gravity(state.q, state.m_total, state.F_x_Ctotal)),
             "pose": farthest([model.pose("ee", state.q, state.F_T_EE, state.EE_T_K)[row][3] for row in range(3)], at)}
    for backend in ("robot", "impedance"):
        for name, step in (("there", 0.1), ("back", 0.0)):
            goal = [q + step for q in READY]
            facts[f"joint_{backend}_{name}"] = stream_to(robot.joint_targets(backend=backend), lambda now: farthest(now.q, goal), goal, 5e-3)
        for name, step in (("there", 0.05), ("back", 0.0)):
            goal = [x + step for x in at]
            facts[f"cartesian_{backend}_{name}"] = stream_to(
                robot.cartesian_targets(backend=backend), lambda now: farthest([now.O_T_EE[row][3] for row in range(3)], goal), goal, 4e-3)
    stream = robot.joint_targets()
    stream.move_to([q + 0.5 for q in READY])
    robot.stop()
    try:
        stream.stop()
        facts["said"] = ""
    except franka.ControlException as error:
        facts["said"] = str(error)
    robot.automatic_error_recovery()
    hand = robot.gripper()
    hand.homing()
    facts["moved"], facts["width"] = hand.move(0.03, 0.1), hand.read_once().width
    facts["mode"] = [robot.read_once() for _ in range(10)][-1].robot_mode
    return facts


if __name__ == "__main__":
    print(json.dumps(PROGRAMS[sys.argv[1]](sys.argv[2])))
