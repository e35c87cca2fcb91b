"""Runs a panda-py program, unchanged, against a twin that this process serves.

    serve_panda_py.py [SCENARIO] [--log FILE]

For a program in another process, pass it `robot.hostname` instead.
"""

import argparse
import pathlib

import panda_py

import panda_twin as pt


def program(hostname: str) -> None:
    """The program as it is for the real robot: 10 cm down from the start, and 10 degrees at joint 7."""
    panda = panda_py.Panda(hostname)
    panda.move_to_start()
    position = panda.get_position()
    position[2] -= 0.1
    panda.move_to_pose(position, panda.get_orientation())
    q = panda.q
    q[6] += 0.17
    panda.move_to_joint_position(q)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", nargs="?", help="robot, scene and start; the ready pose without it")
    parser.add_argument("--log", type=pathlib.Path, help="MCAP file of all cycles")
    arguments = parser.parse_args()

    with pt.serve(arguments.scenario, log=arguments.log) as robot:
        program(robot.hostname)
        print("joint positions, rad:", robot.status.q.round(3))
    for event in robot.events:
        print(f"{event.kind:8} {event.text}")


if __name__ == "__main__":
    main()
