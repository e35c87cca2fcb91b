"""Holds the arm by a PD law on joint torques, called once a cycle as libfranka's callback, while a force pushes it.

    joint_pd.py [--stiffness K] [--log FILE]
"""

import argparse
import pathlib

import numpy as np

import panda_twin as pt
from panda_twin.scenario_types import ScenarioKeys

SECONDS = 3.0
PUSHED: ScenarioKeys = {
    "perturbations": [{"push": {"body": "panda_hand", "begin": "1 s", "duration": "1 s", "force": ["0 N", "10 N", "0 N"]}}],
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stiffness", type=float, default=200.0, help="of each joint, Nm/rad")
    parser.add_argument("--log", type=pathlib.Path, help="MCAP file of the session")
    arguments = parser.parse_args()

    with pt.Session(PUSHED, log=arguments.log) as session:
        goal = session.state.q
        kp = np.full(7, arguments.stiffness)
        kd = 2 * np.sqrt(kp)
        farthest = np.zeros(7)

        def law(state: pt.RobotState, dt: float) -> pt.Torques:
            """tau_J without gravity, which the robot adds; Nm."""
            np.maximum(farthest, np.abs(state.q - goal), out=farthest)
            return pt.Torques(kp * (goal - state.q) - kd * state.dq)

        session.control(law, until=SECONDS)
        rest = np.abs(session.state.q - goal)

    print("farthest from the goal, mrad:", (1e3 * farthest).round(1))
    print("at the end, mrad:            ", (1e3 * rest).round(1))


if __name__ == "__main__":
    main()
