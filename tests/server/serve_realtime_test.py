#!/usr/bin/env python3
"""panda-twin serve on the wall clock, from a client's side: serve_realtime_test.py PROGRAM SOURCE_TREE [unittest options].

What the machine loses decides nothing: the robot forgives any number of lost commands, and the client stands still.
"""

import pathlib
import struct
import sys
import unittest

import fci_wire as fci
import serve_test

SCENARIO = serve_test.SCENARIO + "onboard: {abort_after_lost: 100000}\n"


class RealtimeTest(serve_test.ServeTest):
    FLAGS = ("--drive", "realtime", "--clock-ppm", "20")

    def setUp(self):
        super().setUp()
        self.server = self.serve(scenario=SCENARIO)
        self.robot = self.arm(self.server)

    def hold(self, until):
        """Commands the arm to stay where it is, until `until(k, state)` says so; k counts states that were answered."""
        q, k = self.robot.state.q_d, 0
        while self.robot.state.mode == fci.MOVING:
            finished = until(k, self.robot.state)
            self.robot.send(fci.command(self.robot.state.id, q, finished))
            self.robot.newest()
            k += 1

    def test_states_are_a_millisecond_apart_by_id(self):
        ids = [self.robot.read().id for _ in range(200)]
        self.assertTrue(all(b > a for a, b in zip(ids, ids[1:])))

    def test_a_motion_ends_when_it_is_finished(self):
        self.robot.read()
        move = self.robot.start()
        self.hold(lambda k, state: k > 100)
        self.assertEqual(self.robot.answer(move), bytes([fci.SUCCESS]))

    def test_a_stop_ends_a_motion_that_nobody_commands(self):
        self.robot.read()
        move = self.robot.start()
        self.assertEqual(self.robot.ask(fci.STOP_MOVE), bytes([fci.SUCCESS]))
        self.assertEqual(self.robot.answer(move), bytes([fci.PREEMPTED]))

    def test_a_motion_without_a_first_command_is_aborted(self):
        self.robot.read()
        move = self.robot.start()
        self.assertEqual(self.robot.answer(move), bytes([fci.REFLEX_ABORTED]))
        while self.robot.newest().mode != fci.REFLEX:
            pass
        self.assertEqual(self.robot.state.reflex_reason, [25])
        self.assertEqual(self.robot.ask(fci.RECOVERY), b"\0")
        self.robot.await_mode(fci.IDLE)

    def test_settings_are_answered_while_states_flow(self):
        for i in range(20):
            self.assertEqual(self.robot.ask(fci.SET_LOAD, struct.pack("<d12d", 0.01 * i, *[0] * 12)), b"\0")
            self.robot.read()

    def test_a_client_that_vanishes_makes_room_for_the_next(self):
        for _ in range(5):
            self.robot.read()
            self.robot.start()
            self.robot.vanish()
            self.robot = self.arm(self.server)
        self.robot.read()
        self.robot.start()
        self.hold(lambda k, state: k > 20)


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
