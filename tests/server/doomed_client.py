#!/usr/bin/env python3
"""A client that is to be killed: doomed_client.py PHASE ARM_PORT HAND_PORT.

Says "there" once it is in that phase of a session, and stays in it until somebody ends it. The names of phases are those of the
functions below.
"""

import struct
import sys
import threading
import time

import fci_wire as fci

JUMP = 0.01  # rad in one cycle: no motion survives it


class Doomed:
    def __init__(self, arm_port, hand_port):
        self.ports = arm_port, hand_port
        self.arm = None

    def connected(self):
        self.arm = fci.Arm(self.ports[0])
        self.arm.read()

    def inside_connect(self):
        self.arm = fci.Arm(self.ports[0], connect=False)
        self.arm.tcp.sendall(b"\0\0\0\0\0")

    def inside_a_frame(self):
        self.connected()
        self.arm.tcp.sendall(self.arm.head.pack(fci.MOVE, 1, 68) + b"\0\0\0\0\0\0")

    def move_requested(self):
        self.connected()
        self.arm.request(fci.MOVE, struct.pack("<II6d", 0, 0, 10, 3.12, 6.28, 10, 3.12, 6.28))

    def move_granted(self):
        self.connected()
        self.arm.start()

    def hold(self, cycles):
        q = self.arm.state.q_d
        while cycles > 0 and self.arm.state.generator == 1:
            self.arm.send(fci.command(self.arm.state.id, q))
            self.arm.newest()
            cycles -= 1

    def moving(self):
        self.move_granted()
        self.hold(50)

    def stopping(self):
        self.moving()
        self.arm.request(fci.STOP_MOVE)

    def stopped(self):
        self.moving()
        self.arm.ask(fci.STOP_MOVE)

    def reflex(self):
        self.moving()
        q = [value + JUMP for value in self.arm.state.q_d]
        while self.arm.state.mode == fci.MOVING:
            self.arm.send(fci.command(self.arm.state.id, q))
            self.arm.newest()

    def recovering(self):
        self.reflex()
        self.arm.request(fci.RECOVERY)

    def library_requested(self):
        self.connected()
        for _ in range(8):
            self.arm.request(fci.LOAD_MODEL_LIBRARY, b"\0\0")

    def hand_connected(self):
        self.arm = fci.Hand(self.ports[1])
        self.arm.read()

    def hand_command_pending(self):
        self.hand_connected()
        self.arm.request(fci.HAND_HOMING)

    def inside_a_hand_frame(self):
        self.hand_connected()
        self.arm.tcp.sendall(self.arm.head.pack(fci.HAND_MOVE, 1, 26) + b"\0")


PHASES = ("inside_connect", "connected", "inside_a_frame", "move_requested", "move_granted", "moving", "stopping", "stopped",
          "reflex", "recovering", "library_requested", "hand_connected", "hand_command_pending", "inside_a_hand_frame")


def main():
    phase, arm_port, hand_port = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    doomed = Doomed(arm_port, hand_port)
    getattr(doomed, phase)()
    # One that moves is killed between two of its commands, not after the last.
    if phase == "moving":
        threading.Thread(target=doomed.hold, args=(10**9,), daemon=True).start()
    print("there", flush=True)
    time.sleep(fci.LIMIT)


if __name__ == "__main__":
    main()
