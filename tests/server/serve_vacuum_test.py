#!/usr/bin/env python3
"""The vacuum gripper that `panda-twin serve` serves: serve_vacuum_test.py PROGRAM SOURCE_TREE [unittest options].

The arm stands; a box is where its cup is, on a table.
"""

import pathlib
import socket
import struct
import sys
import unittest

sys.path.append(str(pathlib.Path(__file__).resolve().parent.parent / "clients"))

import fci_wire as fci  # noqa: E402: found by the path above
import serve_test  # noqa: E402
from twin_server import HAND_PORT, VACUUM_PORT, TwinServer, is_listening  # noqa: E402

# In the ready pose the cup's face is at (0.3069, 0, 0.4853) m.
BOX = """\
name: box
robot: {hand: cobot_pump}
objects:
  - {name: table, shape: box, size: [0.3 m, 0.3 m, 0.38 m], position: [0.307 m, 0 m, 0.19 m]}
  - {name: box, shape: box, size: [0.1 m, 0.1 m, 0.1055 m], mass: 500 g, "on": table}
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7853981634, 0, -2.3561944902, 0, 1.5707963268, 0.7853981634]}
      - {q: [0.1, -0.7853981634, 0, -2.3561944902, 0, 1.5707963268, 0.7853981634]}
"""


def suck(set_point=60, timeout_ms=2000, profile=0):
    return struct.pack("<BBq", set_point, profile, timeout_ms)


class ServeVacuumTest(serve_test.ServeTest):
    def pump(self, server):
        pump = fci.Vacuum(server.hand_port)
        self.addCleanup(pump.close)
        return pump

    def await_state(self, pump, done):
        state = pump.read()
        while not done(state):
            state = pump.read()
        return state

    def test_holds_a_part_and_drops_it(self):
        pump = self.pump(self.serve(scenario=BOX))
        self.assertEqual((pump.connected, pump.version), (0, 1))
        before = pump.read()
        self.assertEqual(before[1:], (False, False, False, 0, 0, 0))
        self.assertEqual(pump.do(fci.VACUUM, suck()), 0)
        held = self.await_state(pump, lambda state: state[1])
        self.assertGreater(held[0], before[0])
        self.assertEqual(held[1:5], (True, False, True, 0))
        self.assertGreaterEqual(held[6], 540)
        self.assertEqual(pump.do(fci.VACUUM_DROP_OFF, struct.pack("<q", 1000)), 0)
        gone = self.await_state(pump, lambda state: state[2])
        self.assertEqual(gone[1:6], (False, True, False, 0, 0))

    def test_without_a_part_it_is_unsuccessful_and_says_so(self):
        pump = self.pump(self.serve(scenario=BOX.split("objects:")[0] + "motion:" + BOX.split("motion:")[1]))
        self.assertEqual(pump.do(fci.VACUUM, suck(timeout_ms=200)), 2)
        self.assertEqual(self.await_state(pump, lambda state: state[4])[4], 1)

    def test_stop_aborts_what_runs_and_bad_values_fail(self):
        server = self.serve(scenario=BOX.split("objects:")[0] + "motion:" + BOX.split("motion:")[1])
        pump = self.pump(server)
        vacuum = pump.request(fci.VACUUM, suck(timeout_ms=100_000))
        stop = pump.request(fci.VACUUM_STOP)
        self.assertEqual(pump.answer(vacuum), b"\3\0")
        self.assertEqual(pump.answer(stop), b"\0\0")
        self.assertEqual(pump.do(fci.VACUUM, suck(set_point=0)), 1)
        server.await_line("hand: Vacuum refused: vacuum is 0")

    def test_another_version_is_told_ours(self):
        server = self.serve(scenario=BOX)
        stranger = fci.Vacuum(server.hand_port, version=3)
        self.addCleanup(stranger.close)
        self.assertEqual((stranger.connected, stranger.version), (1, 1))
        self.assertEqual(self.pump(server).connected, 0)

    def test_what_the_arm_has_not_refuses(self):
        file = pathlib.Path(self.folder) / "box.yaml"
        file.write_text(BOX)
        with TwinServer(serve_test.PROGRAM, serve_test.SOURCE, "lockstep", file, hand_port=VACUUM_PORT) as server:
            self.assertFalse(is_listening(server.address, HAND_PORT))
            with self.assertRaises(ConnectionRefusedError):
                socket.create_connection((server.address, HAND_PORT), timeout=fci.LIMIT)
        with TwinServer(serve_test.PROGRAM, serve_test.SOURCE, "lockstep") as server:
            with self.assertRaises(ConnectionRefusedError):
                socket.create_connection((server.address, VACUUM_PORT), timeout=fci.LIMIT)


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
