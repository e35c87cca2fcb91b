#!/usr/bin/env python3
"""What another machine of the network hears of `serve --ros`: nothing, unless --ros-discovery subnet says so. The machine is a network namespace, which takes root."""

import os
import socket
import subprocess
import sys
import time
import unittest

PROGRAM = sys.argv[1]
SECONDS = 4
HERE, THERE = f"twinhere{os.getpid()}", f"twinthere{os.getpid()}"


def ip(*words):
    subprocess.run(["ip", *words], check=True)


class LoopbackTest(unittest.TestCase):
    def setUp(self):
        for name, address in ((HERE, "10.77.0.1/24"), (THERE, "10.77.0.2/24")):
            ip("netns", "add", name)
            self.addCleanup(ip, "netns", "delete", name)
        ip("link", "add", "veth0", "netns", HERE, "type", "veth", "peer", "name", "veth1", "netns", THERE)
        for name, link, address in ((HERE, "veth0", "10.77.0.1/24"), (THERE, "veth1", "10.77.0.2/24")):
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "address", "add", address, "dev", link)
            ip("-n", name, "link", "set", link, "up", "multicast", "on")
            ip("-n", name, "route", "add", "224.0.0.0/4", "dev", link)

    def datagrams_heard(self, *words):
        """@returns how many IPv4 datagrams reach the other machine while the robot is served."""
        listener = subprocess.Popen(["ip", "netns", "exec", THERE, sys.executable, __file__, "listen"], stdout=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "ready\n")
        subprocess.run(["ip", "netns", "exec", HERE, PROGRAM, "serve", "--ros", "--drive", "lockstep", "--pace", "1", "--for", str(SECONDS), *words],
                       check=True, capture_output=True, timeout=60)
        out, _ = listener.communicate(timeout=60)
        return int(out)

    def test_other_machines_hear_nothing(self):
        self.assertEqual(self.datagrams_heard(), 0)

    def test_subnet_is_heard(self):
        self.assertGreater(self.datagrams_heard("--ros-discovery", "subnet"), 0)


def listen():
    """Counts IPv4 datagrams of UDP for a while."""
    sniffer = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
    sniffer.settimeout(0.2)
    print("ready", flush=True)
    heard, end = 0, time.monotonic() + SECONDS + 3
    while time.monotonic() < end:
        try:
            heard += sniffer.recv(2048)[9] == 17
        except TimeoutError:
            pass
    print(heard)


if __name__ == "__main__":
    if PROGRAM == "listen":
        listen()
    else:
        unittest.main(argv=[sys.argv[0]])
