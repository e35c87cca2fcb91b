#!/usr/bin/env python3
"""A motion under ten times the datagrams it needs: serve_flood_test.py PROGRAM SOURCE_TREE DRIVE [unittest options].

DRIVE is the server's. In lockstep the flood must not change a bit of any state. In real time what the machine loses decides
nothing: the robot forgives any number of lost commands, and the client stands still.
"""

import pathlib
import re
import socket
import sys
import threading
import unittest

import fci_wire as fci
import serve_test

CYCLES = 1000
TIMES = 10  # of each kind, per cycle
DRIVE = ""
FAR = [1.0] * 7


class FloodTest(serve_test.ServeTest):
    def setUp(self):
        super().setUp()
        if DRIVE == "lockstep":
            # Physics, and losses that a command taken twice would draw otherwise.
            plant = "plant: {kind: mujoco}\nlink: {command_loss: 3 %}\nseed: 5"
            self.scenario = serve_test.SCENARIO.replace("plant: {kind: ideal}", plant)
        else:
            self.scenario = serve_test.SCENARIO + "onboard: {abort_after_lost: 100000}\n"
        self.stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(self.stranger.close)
        self.server = self.serve(scenario=self.scenario)

    def await_ignored(self, server):
        """@returns how many datagrams were foreign, malformed and early."""
        told = server.await_line(r"datagrams ignored: (\d+) of others or for want of room, (\d+) malformed, (\d+) that answer no state")
        return [int(count) for count in told.groups()]

    def flood(self, arm, state, answer):
        """Around the answer of a cycle."""
        junk = [answer[:-1], answer + b"\0", b"", fci.command(state.id, [float("nan")] * 7)]
        for i in range(TIMES):
            self.stranger.sendto(fci.command(state.id, FAR), arm.robot)
            arm.send(fci.command(state.id + 1000 + i, FAR))
            arm.send(fci.command(max(0, state.id - 1 - i), FAR, True))
            arm.send(junk[i % len(junk)])
        arm.send(answer)
        for _ in range(TIMES):
            arm.send(answer)
            arm.send(fci.command(state.id, FAR))  # the first answer counts

    def lockstep_motion(self, server, flooded):
        arm = self.arm(server)
        arm.read()
        move, start = arm.start(), arm.state.q_d
        first, states = arm.state.id, []
        while arm.state.generator != 0:
            k = arm.state.id - first
            q = list(start)
            q[3] += fci.there_and_back(k / CYCLES, 0.05)
            answer = fci.command(arm.state.id, q, k >= CYCLES)
            if flooded:
                self.flood(arm, arm.state, answer)
            else:
                arm.send(answer)
            states.append(arm.read())
        self.assertEqual(arm.answer(move), bytes([fci.SUCCESS]))
        arm.close()
        return states

    def test_it_changes_no_bit_of_any_state(self):
        quiet = self.lockstep_motion(self.server, False)
        self.server.end()
        server = self.serve(scenario=self.scenario)
        flooded = self.lockstep_motion(server, True)
        self.assertGreater(len(quiet), CYCLES)
        self.assertEqual([state.id - flooded[0].id for state in flooded], list(range(len(flooded))))
        self.assertEqual([state.content for state in quiet], [state.content for state in flooded])
        for count in self.await_ignored(server):
            self.assertGreaterEqual(count, CYCLES)

    def test_a_motion_is_served_beside_it(self):
        arm = self.arm(self.server)
        arm.read()
        move, q, ids = arm.start(), arm.state.q_d, [arm.state.id]
        ends = threading.Event()

        def pour():
            while not ends.is_set():
                self.stranger.sendto(fci.command(ids[-1], FAR), arm.robot)
        pouring = threading.Thread(target=pour)
        pouring.start()
        while arm.state.mode == fci.MOVING:
            answer = fci.command(arm.state.id, q, len(ids) > CYCLES)
            for _ in range(TIMES):
                arm.send(answer[:-1])
                arm.send(answer)
            ids.append(arm.newest().id)
        ends.set()
        pouring.join()
        self.assertEqual(arm.answer(move), bytes([fci.SUCCESS]))
        self.assertTrue(all(b > a for a, b in zip(ids, ids[1:])))
        arm.close()
        foreign, malformed, _ = self.await_ignored(self.server)
        self.assertGreater(foreign, CYCLES)
        self.assertGreater(malformed, CYCLES)
        arm = self.arm(self.server)
        arm.read()
        self.assertEqual((arm.connected, arm.ask(fci.STOP_MOVE)), (fci.SUCCESS, bytes([fci.SUCCESS])))


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE, DRIVE = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    # The wall clock never repeats; in lockstep more is asked for than that a motion is served.
    delattr(FloodTest, "test_a_motion_is_served_beside_it" if DRIVE == "lockstep" else "test_it_changes_no_bit_of_any_state")
    FloodTest.FLAGS = ("--drive", DRIVE, *(("--idle", "freeze") if DRIVE == "lockstep" else ()))
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
