"""What panda-python offers its users: moves, controllers, the hand. See panda_programs.py."""

import math
import time

import numpy as np
import panda_py
from panda_py import constants, controllers, libfranka

from panda_common import HIGH, TOUCH, distance, pose_of, program


class Stopwatch:
    """Seconds of the robot against seconds of the wall, over a motion."""

    def __init__(self, panda):
        self.panda = panda

    def __enter__(self):
        self.wall, self.robot = time.monotonic(), self.panda.get_state().time.to_sec()
        return self

    def __exit__(self, *_):
        self.robot = self.panda.get_state().time.to_sec() - self.robot
        self.wall = time.monotonic() - self.wall

    def figures(self):
        return {"robot_seconds": self.robot, "wall_seconds": self.wall}


def at_start(address):
    panda = panda_py.Panda(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    panda.move_to_start()
    return panda


@program
def connect_and_load_model(address):
    panda = panda_py.Panda(address)
    model, state = panda.get_model(), panda.get_state()
    mass = np.array(model.mass(state)).reshape(7, 7)
    flange_offset = panda_py.fk(state.q)[:3, 3] - pose_of(state)[:3, 3]
    return {
        "version": panda.get_robot().server_version(),
        "mode": state.robot_mode.name,
        "model_pose_error": float(np.max(np.abs(np.array(model.pose(libfranka.Frame.kEndEffector, state)) - state.O_T_EE))),
        "own_kinematics_error": float(np.linalg.norm(flange_offset)),
        "mass_asymmetry": float(np.max(np.abs(mass - mass.T))),
        "least_mass_eigenvalue": float(np.min(np.linalg.eigvalsh(mass))),
        "gravity_error": distance(state.tau_J, model.gravity(state)),
        "m_total": state.m_total,
    }


@program
def joint_moves(address):
    panda = panda_py.Panda(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    start = np.array(constants.JOINT_POSITION_START)
    goals = [start + [0.3, 0.2, -0.2, 0.25, 0.2, 0.3, -0.4], start + [-0.2, 0.1, 0.1, -0.2, -0.3, 0.2, 0.3]]
    with Stopwatch(panda) as stopwatch:
        facts = {"returned": [panda.move_to_start()]}
        facts["errors"] = [distance(panda.q, start)]
        for goal in goals:
            facts["returned"].append(panda.move_to_joint_position(goal))
            facts["errors"].append(distance(panda.q, goal))
        facts["returned"].append(panda.move_to_joint_position([goals[0], start], speed_factor=0.3))
        facts["errors"].append(distance(panda.q, start))
    return facts | stopwatch.figures()


@program
def pose_moves(address):
    panda = at_start(address)
    start = panda.get_pose()
    stiff = np.diag([2500.0] * 3 + [100.0] * 3)  # with little in the null space, as its torques leak into the pose
    facts = {"returned": [], "errors": [], "turned": []}
    for shift in ([0.1, 0.1, -0.1], [0.15, -0.1, 0.05], [0, 0, 0]):
        goal = start.copy()
        goal[:3, 3] += shift
        facts["returned"].append(panda.move_to_pose(goal, impedance=stiff, nullspace_stiffness=0.5))
        reached = panda.get_pose()
        facts["errors"].append(float(np.linalg.norm(reached[:3, 3] - goal[:3, 3])))
        cosine = (np.trace(reached[:3, :3].T @ goal[:3, :3]) - 1) / 2
        facts["turned"].append(math.acos(min(1.0, max(-1.0, cosine))))
    return facts


def steer(panda, controller, seconds, control):
    """control(t) every now and then, for so many seconds of the robot's time; then the controller is stopped."""
    panda.start_controller(controller)
    while (t := controller.get_time()) < seconds:
        panda.raise_error()
        control(t)
        time.sleep(0.0005)
    panda.stop_controller()
    panda.raise_error()


@program
def integrated_velocity(address):
    panda = at_start(address)
    start = np.array(panda.q)
    controller = controllers.IntegratedVelocity()
    velocity = np.array([0.1, 0, 0, 0.1, 0, 0, 0.2])
    last = {}

    def control(t):
        controller.set_control(velocity if t < 2 else np.zeros(7))
        last["q_d"] = np.array(controller.get_qd())

    steer(panda, controller, 4, control)
    return {"error": distance(panda.q, last["q_d"]), "way": (last["q_d"] - start).tolist()}


@program
def context(address):
    """A loop of the program's own, which panda-python paces by the wall clock."""
    panda = at_start(address)
    controller = controllers.JointPosition()
    panda.start_controller(controller)
    start = np.array(panda.q)
    with panda.create_context(frequency=100, max_runtime=3) as context, Stopwatch(panda) as stopwatch:
        while context.ok():
            controller.set_control(start)
    return stopwatch.figures()


@program
def velocity_by_the_wall_clock(address):
    panda = at_start(address)
    controller = controllers.IntegratedVelocity()
    panda.start_controller(controller)
    time.sleep(0.1)
    start = controller.get_qd()[0]
    begin = time.monotonic()
    with panda.create_context(frequency=100, max_runtime=2) as context:
        while context.ok():
            controller.set_control([0.1, 0, 0, 0, 0, 0, 0])
    controller.set_control(np.zeros(7))
    seconds = time.monotonic() - begin
    time.sleep(0.5)
    way = controller.get_qd()[0] - start
    panda.stop_controller()
    return {"wall_seconds": seconds, "way": way}


@program
def pause_between_motions(address):
    panda = panda_py.Panda(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    robot = panda.get_robot()
    wall, begin = time.monotonic(), robot.read_once().time.to_sec()
    for _ in range(2):
        panda.move_to_start()
        time.sleep(2)  # so long that a host's 20 ms are less than one per cent
    return {"robot_seconds": robot.read_once().time.to_sec() - begin, "wall_seconds": time.monotonic() - wall}


@program
def joint_position(address):
    panda = at_start(address)
    start = np.array(panda.q)
    way = np.array([0.1, 0.1, -0.1, 0.1, 0.1, 0.1, 0.2])
    controller = controllers.JointPosition(filter_coeff=0.01)

    def control(t):
        share = 0.5 - 0.5 * math.cos(math.pi * min(t / 3, 1))
        controller.set_control(start + share * way)

    steer(panda, controller, 5, control)
    return {"error": distance(panda.q, start + way)}


@program
def cartesian_impedance(address):
    panda = at_start(address)
    position, orientation = panda.get_position(), panda.get_orientation()
    goal = position + [0.0, 0.1, -0.05]
    controller = controllers.CartesianImpedance(np.diag([2500.0] * 3 + [100.0] * 3), filter_coeff=0.01)

    def control(t):
        share = 0.5 - 0.5 * math.cos(math.pi * min(t / 3, 1))
        controller.set_control(position + share * (goal - position), orientation, panda_py.constants.JOINT_POSITION_START)

    steer(panda, controller, 5, control)
    return {"error": float(np.linalg.norm(panda.get_position() - goal))}


def shift_z(by):
    """In the hand's axes, whose z points down."""
    transform = np.eye(4)
    transform[2, 3] = by
    return transform


@program
def force_on_table(address):
    """Presses on the table top, at (0.5, 0.2), with 5 N; forces as the robot feels them."""
    panda = panda_py.Panda(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    libfranka.Gripper(address).move(0.0, 0.1)
    above = panda_py.ik(np.array([0.5, 0.2, 0.34]), np.array([1.0, 0, 0, 0]))
    panda.move_to_joint_position(above)
    panda.move_to_pose(panda.get_pose() @ shift_z(panda.get_pose()[2, 3] - TOUCH - 0.003), speed_factor=0.1)
    height = panda.get_position()[2]
    bias = np.array(panda.get_state().O_F_ext_hat_K[:3])
    controller = controllers.Force(threshold=0.03, filter_coeff=0.001)
    felt = []

    def control(t):
        controller.set_control(np.array([0.0, 0.0, -5.0]))
        if t > 4:
            felt.append(np.array(panda.get_state().O_F_ext_hat_K[:3]) - bias)

    steer(panda, controller, 5, control)
    return {"height_before": float(height), "height": float(panda.get_position()[2]), "force": np.mean(felt, axis=0).tolist()}


def move_hand_to(panda, height):
    """Above the place of the box, or round it."""
    return panda.move_to_joint_position(panda_py.ik(np.array([0.5, 0.0, height]), np.array([1.0, 0, 0, 0])))


@program
def reach_for_box(address):
    """Brings the open hand round the 50 mm box at (0.5, 0, 0.325) m."""
    panda, gripper = panda_py.Panda(address), libfranka.Gripper(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    return {"homing": gripper.homing(), "above": move_hand_to(panda, 0.45), "there": move_hand_to(panda, 0.325)}


@program
def grasp_box(address):
    """Fetches the box and lifts it by 15 cm."""
    panda, gripper = panda_py.Panda(address), libfranka.Gripper(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    facts = {"version": gripper.server_version(), "homing": gripper.homing()}
    state = gripper.read_once()
    facts |= {"max_width": state.max_width, "open_width": state.width, "grasped_before": state.is_grasped}
    facts["empty_grasp"] = gripper.grasp(0.03, 0.1, 30.0, 0.001, 0.001)
    facts["moved"] = gripper.move(0.08, 0.1)
    move_hand_to(panda, 0.45)
    move_hand_to(panda, 0.325)
    facts["grasp"] = gripper.grasp(0.05, 0.05, 40.0, 0.005, 0.005)
    state = gripper.read_once()
    facts |= {"grasped": state.is_grasped, "width": state.width}
    move_hand_to(panda, 0.475)
    state = gripper.read_once()
    facts |= {"grasped_lifted": state.is_grasped, "width_lifted": state.width}
    facts["weight"] = -panda.get_state().O_F_ext_hat_K[2]
    facts["stop"] = gripper.stop()
    facts["released"] = gripper.move(0.08, 0.1)
    facts["grasped_after"] = gripper.read_once().is_grasped
    return facts
