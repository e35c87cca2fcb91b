#!/usr/bin/env python3
"""Clients that are killed, vanish without a word, or hang: serve_killed_test.py PROGRAM SOURCE_TREE DRIVE [unittest options].

Whatever becomes of one, the robot comes to rest and the next is served. DRIVE is the server's: lockstep or realtime. What the
machine loses decides nothing: the robot forgives any number of lost commands, and clients stand still.
"""

import pathlib
import signal
import socket
import struct
import subprocess
import sys
import unittest

import doomed_client
import fci_wire as fci
import serve_test

TCP_REPAIR = 19  # Linux: a socket that is closed under it sends neither FIN nor RST
DOOMED = pathlib.Path(__file__).parent / "doomed_client.py"
SCENARIO = serve_test.SCENARIO + "onboard: {abort_after_lost: 100000}\n"


class KilledTest(serve_test.ServeTest):
    def setUp(self):
        super().setUp()
        self.server = self.serve(scenario=SCENARIO)

    def doomed(self, phase):
        """A client of its own process, in that phase."""
        client = subprocess.Popen([sys.executable, "-B", DOOMED, phase, str(self.server.arm_port), str(self.server.hand_port)],
                                  stdout=subprocess.PIPE, text=True)
        self.addCleanup(client.stdout.close)
        self.addCleanup(client.wait, fci.LIMIT)
        self.addCleanup(client.kill)
        self.assertEqual(client.stdout.readline(), "there\n")
        return client

    def connected_arm(self):
        return self.arm(self.server)

    def moving_arm(self):
        """A client of this process, in a motion."""
        arm = self.arm(self.server)
        arm.read()
        arm.start()
        for _ in range(20):
            arm.send(fci.command(arm.state.id, arm.state.q_d))
            arm.newest()
        self.assertEqual(arm.state.mode, fci.MOVING)
        return arm

    def check_next_is_served(self, may_be_in_reflex=False):
        """The next client finds the robot Idle and moves it, and the next one's hand obeys."""
        arm = self.arm(self.server)
        self.assertEqual(arm.connected, fci.SUCCESS)
        arm.newest()
        if may_be_in_reflex and arm.state.mode == fci.REFLEX:
            arm.ask(fci.RECOVERY)  # refused when the recovery begins this instant that its forerunner asked for
        if may_be_in_reflex:
            arm.await_mode(fci.IDLE)
        self.assertEqual((arm.state.mode, arm.state.errors), (fci.IDLE, []))
        move, q, count = arm.start(), arm.state.q_d, 0
        while arm.state.mode == fci.MOVING:
            arm.send(fci.command(arm.state.id, q, count >= 20))
            arm.newest()
            count += 1
        self.assertEqual(arm.answer(move), bytes([fci.SUCCESS]))
        arm.close()
        hand = fci.Hand(self.server.hand_port)
        self.assertEqual((hand.connected, hand.do(fci.HAND_STOP)), (0, 0))
        hand.close()

    def test_a_client_may_be_killed_at_every_phase(self):
        for phase in doomed_client.PHASES:
            with self.subTest(phase):
                client = self.doomed(phase)
                client.send_signal(signal.SIGKILL)
                client.wait(fci.LIMIT)
                self.check_next_is_served(phase in ("reflex", "recovering"))

    def test_a_client_that_is_gone_without_a_word_is_found_out(self):
        for phase in (self.connected_arm, self.moving_arm):
            with self.subTest(phase.__name__):
                arm = phase()
                try:
                    arm.tcp.setsockopt(socket.IPPROTO_TCP, TCP_REPAIR, 1)
                except PermissionError:
                    self.skipTest("only root may close a connection without a word")
                arm.close()
                self.check_when_free()

    def check_when_free(self):
        """Until the server has found out it sends others away."""
        while True:
            try:
                return self.check_next_is_served()
            except ConnectionError:
                continue

    def test_a_client_that_sends_no_more_requests_has_left(self):
        arm = self.moving_arm()
        arm.tcp.shutdown(socket.SHUT_WR)
        self.check_next_is_served()
        with self.assertRaises(ConnectionError):  # the end of its motion was owed to it
            while True:
                arm.receive()

    def test_connections_that_say_nothing_keep_nobody_out(self):
        silent = [fci.Arm(self.server.arm_port, connect=False) for _ in range(8)]
        for one in silent:
            self.addCleanup(one.close)
        for one in silent[::2]:
            one.tcp.sendall(struct.pack("<I", fci.CONNECT))
        self.check_next_is_served()
        self.check_next_is_served()


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    KilledTest.FLAGS = ("--drive", sys.argv[3])
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
