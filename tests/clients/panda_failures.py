"""Motions that the robot ends, and what the user is told. See panda_programs.py."""

import math
import threading
import time

import numpy as np
import panda_py
from panda_py import libfranka

from panda_common import HIGH, SENSITIVE, TOUCH, pose_of, program


class Positions:
    """A callback that holds the joints still until `begin` ms, then does what `step` says, once."""

    def __init__(self, begin, step):
        self.begin, self.step, self.time, self.q = begin, step, 0, None

    def __call__(self, state, period):
        self.time += period.to_msec()
        if self.q is None:
            self.q = list(state.q_d)
        if self.begin is not None and self.time >= self.begin:
            self.begin = None
            self.step(self.q)
        return libfranka.JointPositions(self.q)


def failed_motion(robot, callback):
    """The text with which a motion of raw joint positions ends."""
    try:
        robot.control_joint_position(callback, limit_rate=False, cutoff_frequency=1000.0)
    except RuntimeError as error:
        return str(error)
    return ""


def aftermath(robot):
    """A refused motion, recovery, and a motion that works again."""
    facts = {"mode": robot.read_once().robot_mode.name, "current_errors": repr(robot.read_once().current_errors)}
    facts["refused"] = failed_motion(robot, Positions(None, None))
    robot.automatic_error_recovery()
    facts["mode_recovered"] = robot.read_once().robot_mode.name
    facts["errors_recovered"] = bool(robot.read_once().current_errors)
    finish = Positions(None, None)

    def finishing(state, period):
        command = finish(state, period)
        command.motion_finished = finish.time >= 50
        return command

    facts["afterwards"] = failed_motion(robot, finishing)
    return facts


@program
def jerk_too_large(address):
    """14e-6 rad in one cycle: 14 mrad/s and 14 rad/s^2 are allowed, the jerk of 14000 rad/s^3 is not."""
    robot = libfranka.Robot(address)

    def step(q):
        q[0] += 14e-6

    return {"text": failed_motion(robot, Positions(200, step))} | aftermath(robot)


@program
def acceleration_too_large(address):
    """0.1 mrad in one cycle: 0.1 rad/s, but 100 rad/s^2 and 1e5 rad/s^3."""
    robot = libfranka.Robot(address)

    def step(q):
        q[0] += 1e-4

    return {"text": failed_motion(robot, Positions(200, step))} | aftermath(robot)


@program
def torque_step(address):
    """2 Nm in one cycle, twice the rate allowed."""
    robot = libfranka.Robot(address)
    elapsed = 0

    def callback(state, period):
        nonlocal elapsed
        elapsed += period.to_msec()
        return libfranka.Torques([0.0 if elapsed < 200 else 2.0] + [0.0] * 6)

    try:
        robot.control(callback, limit_rate=False, cutoff_frequency=1000.0)
        text = ""
    except RuntimeError as error:
        text = str(error)
    return {"text": text} | aftermath(robot)


@program
def sleeper(address):
    """Answers no state for 0.2 s."""
    robot = libfranka.Robot(address)
    callback = Positions(200, lambda q: time.sleep(0.2))

    def bounded(state, period):
        command = callback(state, period)
        command.motion_finished = callback.time >= 500
        return command

    text = failed_motion(robot, bounded)
    return {"text": text} | (aftermath(robot) if text else {})


@program
def collision(address):
    """Lowers the hand onto the table beside the box, with thresholds of 20 N and 20 Nm."""
    panda = panda_py.Panda(address)
    robot = panda.get_robot()
    robot.set_collision_behavior(*HIGH)
    above = np.array([0.5, 0.2, TOUCH + 0.03])
    downwards = np.array([1.0, 0, 0, 0])
    panda.move_to_joint_position(panda_py.ik(above, downwards))
    robot.set_collision_behavior(*SENSITIVE)
    t, begin = 0.0, None

    def callback(state, period):
        nonlocal t, begin
        t += period.to_sec()
        if begin is None:
            begin = list(state.O_T_EE_c)
        pose = list(begin)
        pose[14] -= 0.06 * (0.5 - 0.5 * math.cos(math.pi * min(t / 4, 1)))
        command = libfranka.CartesianPose(pose)
        command.motion_finished = t >= 4
        return command

    try:
        robot.control_cartesian_pose(callback)
        text = ""
    except RuntimeError as error:
        text = str(error)
    state = robot.read_once()
    facts = {"text": text, "height": pose_of(state)[2, 3], "collision": state.cartesian_collision} | aftermath(robot)
    robot.set_collision_behavior(*HIGH)
    facts["returned"] = panda.move_to_joint_position(panda_py.ik(above, downwards))
    facts["errors_at_end"] = repr(robot.read_once().current_errors)  # why it did not, if it did not
    return facts


@program
def held(address):
    """Holds still until something ends the motion, and recovers when nothing pushes the hand any more."""
    robot = libfranka.Robot(address)
    robot.set_collision_behavior(*SENSITIVE)
    callback = Positions(None, None)

    def bounded(state, period):
        command = callback(state, period)
        command.motion_finished = callback.time >= 20000
        return command

    text = failed_motion(robot, bounded)
    if not text:
        return {"text": text}
    while max(map(abs, robot.read_once().K_F_ext_hat_K)) > 2:
        pass
    return {"text": text} | aftermath(robot)


@program
def preempted(address):
    """stop() from a second thread, during a motion."""
    robot = libfranka.Robot(address)
    stopper = threading.Timer(0.2, robot.stop)
    stopper.start()
    text = failed_motion(robot, Positions(None, None))
    stopper.join()
    return {"text": text, "mode": robot.read_once().robot_mode.name}


@program
def setter_during_motion(address):
    """Documentation says to set things before a motion, never during one."""
    robot = libfranka.Robot(address)
    said = []

    def set_load():
        try:
            robot.set_load(0.1, [0.0, 0.0, 0.0], [0.001, 0, 0, 0, 0.001, 0, 0, 0, 0.001])
        except RuntimeError as error:
            said.append(str(error))
        robot.stop()

    thread = threading.Timer(0.2, set_load)
    thread.start()
    failed_motion(robot, Positions(None, None))
    thread.join()
    return {"text": said[0] if said else ""}
