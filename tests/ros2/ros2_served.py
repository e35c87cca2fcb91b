"""What tests have in common that command a served twin from a node. Of an environment of ros_env.py: import it after ros2_partner.enter()."""

import sys
import unittest

from control_msgs.action import FollowJointTrajectory

from ros2_partner import ARM, Partner, Twin

SUCCEEDED, CANCELED, ABORTED = 4, 5, 6  # action_msgs/msg/GoalStatus


class Served(unittest.TestCase):
    """One twin, of the program that is the first argument, and one partner for all cases of a class."""

    words = ["--drive", "lockstep", "--pace", "1"]

    @classmethod
    def setUpClass(cls):
        cls.twin = Twin(sys.argv[1], *cls.words)
        cls.partner = Partner()

    @classmethod
    def tearDownClass(cls):
        cls.partner.end()
        cls.twin.end()

    def setUp(self):
        self.since = len(self.twin.told())

    def told(self):
        """In this case."""
        return self.twin.told(self.since)

    def follow(self, goal, feedback=None):
        return self.partner.do(FollowJointTrajectory, ARM, goal, feedback)

    def succeed(self, goal, partner=None):
        status, result = (partner or self.partner).do(FollowJointTrajectory, ARM, goal)
        self.assertEqual((status, result.error_code, result.error_string), (SUCCEEDED, 0, ""))

    def stays(self, before):
        self.assertLess(max(abs(a - b) for a, b in zip(before[:7], self.partner.state())), 1e-3)

    def is_well(self):
        """The robot has no error, and the arm rests."""
        self.partner.rest()
        status = self.twin.ctl("status")
        self.assertEqual((status["mode"], status["errors"]), ("Idle", []))
