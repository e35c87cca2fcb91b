#!/usr/bin/env python3
"""Client after client: serve_rounds_test.py PROGRAM SOURCE_TREE ROUNDS [unittest options].

Each connects, moves and leaves: in order, in the middle of its motion, or by a reset; a hand's client comes and goes beside it.
Every round must be served, and memory, descriptors and threads of the server stay what they were.
"""

import pathlib
import re
import sys
import unittest

import fci_wire as fci
import serve_test

ROUNDS = 60
WARM_UP = 20  # rounds until everything has been used once
MOST_GROWTH_KB = 512  # of what the allocator keeps; a leak of 1 KiB a round is more in 1000


class Usage:
    """What a process holds."""

    def __init__(self, process):
        folder = pathlib.Path(f"/proc/{process.pid}")
        status = (folder / "status").read_text()
        self.memory_kb = int(re.search(r"VmRSS:\s+(\d+) kB", status).group(1))
        self.threads = int(re.search(r"Threads:\s+(\d+)", status).group(1))
        self.descriptors = len(list((folder / "fd").iterdir()))


class RoundsTest(serve_test.ServeTest):
    FLAGS = ("--drive", "lockstep", "--idle", "freeze")

    def round(self, server, number):
        arm = fci.Arm(server.arm_port)
        self.assertEqual(arm.connected, fci.SUCCESS)
        hand = fci.Hand(server.hand_port) if number % 3 == 0 else None
        arm.read()
        how = number % 4
        if how == 0:
            arm.start()
            self.assertEqual(len(arm.wave(until=10)), 10)
            arm.vanish()
        elif how == 1:
            self.assertEqual(arm.move()[1], fci.MOTION_STARTED)
            arm.close()
        else:
            self.assertEqual(arm.run_motion(cycles=20, amplitude=0.00002)[1], fci.SUCCESS)
            arm.close()
        if hand:
            self.assertEqual(hand.do(fci.HAND_STOP), 0)
            hand.close()

    def test_rounds_leave_nothing_behind(self):
        server = self.serve()
        usages = []
        for number in range(ROUNDS):
            with self.subTest(round=number):
                self.round(server, number)
            usages.append(Usage(server.process))
        self.check_serves(server)
        for what, most in (("memory_kb", MOST_GROWTH_KB), ("descriptors", 1), ("threads", 0)):
            values = [getattr(usage, what) for usage in usages]
            before, after = max(values[:WARM_UP]), max(values[WARM_UP:])
            print(f"{ROUNDS} rounds: {what}: at most {before} in the first {WARM_UP}, {after} after them, {values[-1]} at the end")
            self.assertLessEqual(after, before + most, what)


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE, ROUNDS = sys.argv[1], pathlib.Path(sys.argv[2]), int(sys.argv[3])
    unittest.main(argv=sys.argv[:1] + sys.argv[4:])
