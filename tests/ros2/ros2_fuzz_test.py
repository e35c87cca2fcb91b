#!/usr/bin/env python3
"""Mutated datagrams of real RTPS at all UDP ports of `serve --ros`, which goes on serving. Arguments: the program, then [DATAGRAMS]. Takes root."""

import os
import random
import re
import socket
import subprocess
import sys
import threading
import unittest

import ros2_partner
from ros2_partner import ARM, Partner, Twin, goal_of

PROGRAM = sys.argv[1]
DATAGRAMS = int(sys.argv[2]) if len(sys.argv) > 2 else 1_000_000
ros2_partner.enter("jazzy")
from control_msgs.action import FollowJointTrajectory  # noqa: E402


def mutated(packet, rng):
    packet = bytearray(packet)
    for _ in range(rng.choice((1, 1, 1, 2, 4, 16))):
        at = rng.randrange(len(packet))
        kind = rng.randrange(5)
        if kind == 0:
            packet[at] = rng.randrange(256)
        elif kind == 1:
            packet[at:at + 4] = rng.choice((0, 1, 0xFF, 0xFFFF, 0x7FFFFFFF, 0xFFFFFFFF)).to_bytes(4, "little")
        elif kind == 2 and len(packet) > 24:
            del packet[at:]
        elif kind == 3:
            packet[at:at] = packet[at:at + rng.randrange(64)]
        else:
            packet[at] ^= 1 << rng.randrange(8)
        if not packet:
            break
    return bytes(packet[:60000])


class FuzzTest(unittest.TestCase):
    def test_mutated_datagrams(self):
        if os.getuid() != 0:
            self.skipTest("listening to others' datagrams takes root")
        twin, partner = Twin(PROGRAM, "--drive", "lockstep", "--pace", "1"), Partner()
        try:
            told = subprocess.run(["ss", "-ulpn"], capture_output=True, text=True, check=True).stdout
            ports = [int(re.search(r":(\d+) ", line)[1]) for line in told.splitlines() if f"pid={twin.process.pid}," in line]
            seen, over = [], threading.Event()
            sniffer = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
            sniffer.settimeout(0.2)

            def listen():
                while not over.is_set():
                    try:
                        packet = sniffer.recv(65535)
                        ends = {int.from_bytes(packet[at:at + 2], "big") for at in (20, 22)}
                        if packet[9] == 17 and packet[28:32] == b"RTPS" and ends & set(ports):  # not those of other tests
                            seen.append(packet[28:])
                    except TimeoutError:
                        pass

            listener = threading.Thread(target=listen)
            listener.start()
            other = Partner("other")
            self.assertEqual(other.do(FollowJointTrajectory, ARM, goal_of(other.state(), by=0.02, seconds=1.0))[0], 4)
            other.end()
            over.set()
            listener.join()
            sniffer.close()
            kinds = {packet[20]: packet for packet in seen}  # one of each first submessage, and many more
            packets = [*kinds.values(), *random.Random(1).sample(seen, min(len(seen), 2000))]
            sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            rng = random.Random(2)
            for i in range(DATAGRAMS):
                sender.sendto(mutated(rng.choice(packets), rng), ("127.0.0.1", rng.choice(ports)))
                if i % 1000 == 0:
                    self.assertIsNone(twin.process.poll(), f"ended at datagram {i}: {twin.told()[-300:]}")
                    partner.spin(0)
            sender.close()
            print(f"  {DATAGRAMS} datagrams, {len(packets)} seeds, {len(ports)} ports; {twin.memory_kb()} kB")
            # Whose identity was forged may be lost; whoever comes is served.
            partner.end()
            partner = Partner("late")
            status, result = partner.do(FollowJointTrajectory, ARM, goal_of(partner.state(), by=-0.02, seconds=1.0))
            self.assertEqual(status, 4, result.error_string)
        finally:
            partner.end()
            twin.end()


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
