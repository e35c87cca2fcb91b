#!/usr/bin/env python3
"""The twin and a client that shares no code with ROS or eProsima: crate ros2-client (RustDDS), compiled here, which takes 5 minutes of processor time."""

import os
import pathlib
import re
import subprocess
import sys
import unittest

import ros2_partner

PROGRAM = sys.argv[1]
SOURCE = pathlib.Path(__file__).resolve().parent / "ros2_client"
TARGET = pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache") / "panda-twin/ros2_client"
LEAST_CARGO = (1, 85)  # the crate's edition


def cargo():
    try:
        version = subprocess.run(["cargo", "--version"], capture_output=True, text=True, check=True).stdout
    except (FileNotFoundError, subprocess.CalledProcessError):
        return None
    return tuple(map(int, re.search(r"(\d+)\.(\d+)", version).groups()))


class RustClientTest(unittest.TestCase):
    def setUp(self):
        if (cargo() or (0, 0)) < LEAST_CARGO:
            self.skipTest("no cargo of %d.%d or newer: %s" % (*LEAST_CARGO, cargo()))
        subprocess.run(["cargo", "build", "--release", "--locked", "--quiet", "--target-dir", str(TARGET)], cwd=SOURCE, check=True, timeout=1800)

    def check(self, *mapping):
        os.environ["ROS_DOMAIN_ID"] = str(ros2_partner.free_domain())
        # RustDDS looks for others by multicast alone.
        twin = ros2_partner.Twin(PROGRAM, "--drive", "lockstep", "--pace", "1", "--ros-discovery", "subnet", *(["--ros-service-header"] if mapping else []))
        try:
            told = subprocess.run([TARGET / "release/ros2_partner", *mapping], capture_output=True, text=True, timeout=ros2_partner.PATIENCE).stdout
        finally:
            twin.end()
        self.assertEqual(told.splitlines(), ["state 9 panda_joint1", "service true disarmed", "accepted true", "feedback 7 7", "result Succeeded 0 ", "moved 0.100"])

    def test_as_rmw_fastrtps_does(self):
        self.check()

    def test_as_rmw_cyclonedds_does(self):
        self.check("cyclone")


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
