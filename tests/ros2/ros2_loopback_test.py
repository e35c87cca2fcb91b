#!/usr/bin/env python3
"""What another machine of the network has of `serve --ros`: nothing, unless --ros-discovery subnet says so. The machine is a network namespace, which takes root."""

import os
import socket
import subprocess
import sys
import time
import unittest

import ros_env

PROGRAM = sys.argv[1]
SECONDS = 14
HERE, THERE = f"twinhere{os.getpid()}", f"twinthere{os.getpid()}"


def ip(*words):
    subprocess.run(["ip", *words], check=True)


class LoopbackTest(unittest.TestCase):
    def setUp(self):
        for name in (HERE, THERE):
            try:
                ip("netns", "add", name)
            except (FileNotFoundError, subprocess.CalledProcessError) as error:
                self.skipTest(f"this host permits no network namespace: {error}")
            self.addCleanup(ip, "netns", "delete", name)
        ip("link", "add", "veth0", "netns", HERE, "type", "veth", "peer", "name", "veth1", "netns", THERE)
        for name, link, address in ((HERE, "veth0", "10.77.0.1/24"), (THERE, "veth1", "10.77.0.2/24")):
            ip("-n", name, "link", "set", "lo", "up")
            ip("-n", name, "address", "add", address, "dev", link)
            ip("-n", name, "link", "set", link, "up", "multicast", "on")
            ip("-n", name, "route", "add", "224.0.0.0/4", "dev", link)

    def found_and_heard(self, *words):
        """@returns the nodes that a node of the other machine finds, which speaks to the robot's machine by its address, and how many datagrams of
        the robot's machine reach the other."""
        listener = subprocess.Popen(["ip", "netns", "exec", THERE, sys.executable, __file__, "listen"], stdout=subprocess.PIPE, text=True)
        self.assertEqual(listener.stdout.readline(), "ready\n")
        served = subprocess.Popen(["ip", "netns", "exec", HERE, PROGRAM, "serve", "--ros", "--drive", "lockstep", "--pace", "1", *words],
                                  stdout=subprocess.PIPE, text=True)
        try:
            while "ROS 2 domain" not in served.stdout.readline():
                self.assertIsNone(served.poll())
            environment = os.environ | ros_env.environment_of("jazzy", 0) | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "SUBNET", "ROS_STATIC_PEERS": "10.77.0.1"}
            nodes = subprocess.run(["ip", "netns", "exec", THERE, ros_env.python_of("jazzy"), __file__, "look"],
                                  env=environment, check=True, capture_output=True, text=True, timeout=60).stdout.split()
        finally:
            served.terminate()
            served.wait(timeout=60)
            served.stdout.close()
            heard, _ = listener.communicate(timeout=60)
        return nodes, int(heard)

    def test_other_machines_hear_nothing_and_are_not_heard(self):
        self.assertEqual(self.found_and_heard(), (["there"], 0))

    def test_subnet_hears_and_is_heard(self):
        nodes, heard = self.found_and_heard("--ros-discovery", "subnet")
        self.assertEqual(nodes, ["panda_twin", "there"])
        self.assertGreater(heard, 0)


def listen():
    """Counts datagrams of UDP from the robot's machine."""
    sniffer = socket.socket(socket.AF_PACKET, socket.SOCK_DGRAM, socket.htons(0x0800))
    sniffer.settimeout(0.2)
    print("ready", flush=True)
    heard, end = 0, time.monotonic() + SECONDS
    while time.monotonic() < end:
        try:
            header = sniffer.recv(2048)
            heard += header[9] == 17 and header[12:16] == bytes([10, 77, 0, 1])
        except TimeoutError:
            pass
    print(heard)


def look():
    import rclpy
    rclpy.init()
    node, end = rclpy.create_node("there"), time.monotonic() + 8
    while time.monotonic() < end and len(node.get_node_names()) < 2:
        rclpy.spin_once(node, timeout_sec=0.1)
    print(*sorted(node.get_node_names()))


if __name__ == "__main__":
    if PROGRAM in ("listen", "look"):
        {"listen": listen, "look": look}[PROGRAM]()
    else:
        unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
