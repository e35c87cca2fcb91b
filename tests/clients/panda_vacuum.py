"""The vacuum gripper of panda-python's libfranka, unmodified. See panda_programs.py."""

import datetime

import numpy as np
import panda_py
from panda_py import libfranka

from panda_common import HIGH, program

BOX_TOP = 0.4  # m, where it stands
SECOND = datetime.timedelta(seconds=1)


def facts_of(pump):
    """Of the fifth state from now: what was commanded has had 40 ms."""
    state = [pump.read_once() for _ in range(5)][-1]
    return {"present": state.part_present, "detached": state.part_detached, "in_range": state.in_control_range,
            "status": state.device_status.name, "power": state.actual_power, "vacuum": state.vacuum}


def move_cup_to(panda, height, sideways=0.0):
    """The cup's face above (0.5, sideways), looking down. panda-python's kinematics know only the Franka Hand, so correct by what the
    robot says."""
    aim = height
    for _ in range(3):
        panda.move_to_joint_position(panda_py.ik(np.array([0.5, sideways, aim]), np.array([1.0, 0, 0, 0])), speed_factor=0.1)
        aim += height - panda.get_state().O_T_EE[14]


@program
def vacuum_box(address):
    """Sucks air, fetches the box, lifts it, drops it beside where it stood, and looks for it there."""
    panda, pump = panda_py.Panda(address), libfranka.VacuumGripper(address)
    panda.get_robot().set_collision_behavior(*HIGH)
    facts = {"version": pump.server_version(), "before": facts_of(pump)}
    facts["in_the_air"] = pump.vacuum(60, 0.3 * SECOND)
    facts["after_air"] = facts_of(pump)
    move_cup_to(panda, BOX_TOP + 0.05)
    empty = panda.get_state().O_F_ext_hat_K[2]
    panda.move_to_joint_position(panda_py.ik(np.array([0.5, 0, BOX_TOP - 0.004]), np.array([1.0, 0, 0, 0])), speed_factor=0.05)
    facts["touched"] = panda.get_state().O_T_EE[14]
    facts["held"] = pump.vacuum(60, SECOND, libfranka.VacuumGripperProductionSetupProfile.kP2)
    move_cup_to(panda, BOX_TOP + 0.1, 0.1)
    facts["lifted"] = facts_of(pump)
    facts["weight"] = panda.get_state().O_F_ext_hat_K[2] - empty
    move_cup_to(panda, BOX_TOP + 0.02, 0.1)
    facts["dropped"] = pump.drop_off(SECOND)
    facts["after_drop"] = facts_of(pump)
    facts["again_in_the_air"] = pump.vacuum(60, 0.3 * SECOND)
    panda.move_to_joint_position(panda_py.ik(np.array([0.5, 0.1, BOX_TOP - 0.004]), np.array([1.0, 0, 0, 0])), speed_factor=0.05)
    facts["found"] = pump.vacuum(100, SECOND)
    facts["stopped"] = pump.stop()
    facts["at_the_end"] = facts_of(pump)
    return facts
