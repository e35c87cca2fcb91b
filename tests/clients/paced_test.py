#!/usr/bin/env python3
"""Programs that pace themselves by the wall clock, on a robot served with `--drive lockstep --pace`, beside two programs that compute:

    paced_test.py PROGRAM SOURCE_TREE [unittest options]

The programs are of unmodified panda-python. A host that cannot run the loop in time at all slows the robot: that is told apart by a
witness.
"""

import concurrent.futures
import contextlib
import importlib.util
import pathlib
import subprocess
import sys
import unittest

import panda_python_test
from twin_server import TwinServer

PROGRAM, SOURCE = "", pathlib.Path()
HOG = [sys.executable, "-c", "while True: pass"]
WITHIN = 0.01


@contextlib.contextmanager
def hogs(count):
    programs = [subprocess.Popen(HOG) for _ in range(count)]
    try:
        yield
    finally:
        for program in programs:
            program.kill()
            program.wait()


class PacedTest(unittest.TestCase):
    def run_beside_hogs(self, name, *options):
        with hogs(2), TwinServer(PROGRAM, SOURCE, "lockstep", "--pace", "1", *options) as server:
            return panda_python_test.run_client(server, name)[0]

    def test_a_context_of_three_seconds_is_three_seconds_of_the_robot(self):
        facts = self.run_beside_hogs("context")
        self.assertAlmostEqual(facts["wall_seconds"], 3, delta=0.1)
        self.assertAlmostEqual(facts["robot_seconds"], facts["wall_seconds"], delta=WITHIN * facts["wall_seconds"])

    def test_a_velocity_moves_as_far_as_it_says(self):
        facts = self.run_beside_hogs("velocity_by_the_wall_clock")
        meant = 0.1 * facts["wall_seconds"]
        self.assertAlmostEqual(facts["wall_seconds"], 2, delta=0.1)
        self.assertAlmostEqual(facts["way"], meant, delta=WITHIN * meant)

    def test_time_between_motions_is_the_wall_clock_s(self):
        facts = self.run_beside_hogs("pause_between_motions")
        self.assertAlmostEqual(facts["robot_seconds"], facts["wall_seconds"], delta=WITHIN * facts["wall_seconds"])


class TwoRobotsTest(unittest.TestCase):
    def test_two_programs_each_lead_their_own(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as first, TwinServer(PROGRAM, SOURCE, "lockstep") as second, \
                concurrent.futures.ThreadPoolExecutor() as threads:
            self.assertNotEqual(first.address, second.address)
            moved = threads.submit(panda_python_test.run_client, first, "joint_moves")
            posed = threads.submit(panda_python_test.run_client, second, "pose_moves")
            self.assertEqual(moved.result()[0]["returned"], [True] * 4)
            self.assertEqual(posed.result()[0]["returned"], [True] * 3)


if __name__ == "__main__":
    if importlib.util.find_spec("panda_py") is None:
        print("missing: panda-python is not installed: scripts/setup")
        sys.exit(panda_python_test.SKIPPED)
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
