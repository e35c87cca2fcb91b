#!/usr/bin/env python3
"""Who reaches a served robot from where: reach_test.py PROGRAM SOURCE_TREE [unittest options].

A client "from elsewhere" is this machine by its own address on the network, which is no loopback address.
"""

import os
import pathlib
import re
import socket
import stat
import struct
import subprocess
import sys
import unittest

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.append(str(SOURCE / "tests/server"))
import fci_wire as fci  # noqa: E402
import serve_test  # noqa: E402

LOOPBACK, LIMIT = 127, 10


def own_address():
    """As the network sees this machine; None without a network. Nothing is sent."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        try:
            probe.connect(("192.0.2.1", 9))
        except OSError:
            return None
        return probe.getsockname()[0]


def bound(process):
    """The first octets of all local addresses of a process's TCP and UDP sockets, of either version of IP."""
    inodes = set()
    for link in pathlib.Path(f"/proc/{process.pid}/fd").iterdir():
        if match := re.fullmatch(r"socket:\[(\d+)\]", os.readlink(link)):
            inodes.add(match[1])
    octets = []
    for table in ("tcp", "udp", "tcp6", "udp6"):
        file = pathlib.Path("/proc/net", table)
        lines = file.read_text().splitlines()[1:] if file.exists() else []
        octets += [int(line.split()[1][6:8], 16) if table in ("tcp", "udp") else None for line in lines if line.split()[9] in inodes]
    return octets


class ReachTest(serve_test.ServeTest):
    def page_of(self, server):
        return int(server.await_line(r"http://127\.0\.0\.1:(\d+)/#token=")[1])

    def test_by_default_every_socket_is_of_this_machine_alone(self):
        server = self.serve("--pace", "1", "--page=0", "--control", pathlib.Path(self.folder, "control"))
        arm = self.arm(server)
        arm.read()
        octets = bound(server.process)
        self.assertGreaterEqual(len(octets), 4)  # arm, hand, page, the arm's client
        self.assertEqual(set(octets), {LOOPBACK})

    def answers(self, here, network):
        """Which of arm, hand and page answer a client from `here` that says what each wants to hear."""
        file = pathlib.Path(self.folder, "served.yaml")
        file.write_text(serve_test.SCENARIO)
        flags = ("--bind", "0.0.0.0", "--allow", network, "--page-bind", "0.0.0.0", "--page-allow", network, *self.FLAGS, "--pace", "1")
        process = subprocess.Popen([serve_test.PROGRAM, "serve", file, "--data", SOURCE / "models", "--port", "0", "--hand-port", "0",
                                    "--page=0", *flags], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        try:
            ports = {}
            while len(ports) < 3:
                line = process.stdout.readline()
                self.assertNotEqual(line, "", "it ended")
                if match := re.search(r"^  (arm|hand)  +0\.0\.0\.0:(\d+)$|http://127\.0\.0\.1:()(\d+)/#token=", line):
                    ports[match[1] or "page"] = int(match[2] or match[4])
            return {name for name, port in ports.items() if self.is_answered(here, name, port)}
        finally:
            process.terminate()
            process.wait(LIMIT)
            process.stdout.close()

    def is_answered(self, here, name, port):
        requests = {"arm": struct.pack("<IIIHH", fci.CONNECT, 0, 16, 5, 1), "hand": struct.pack("<HIIHH", fci.HAND_CONNECT, 0, 14, 3, 1),
                    "page": f"GET / HTTP/1.1\r\nHost: {here}:{port}\r\nConnection: close\r\n\r\n".encode()}
        try:
            with socket.create_connection((here, port), timeout=LIMIT) as client:
                client.sendall(requests[name])
                return client.recv(1) != b""
        except ConnectionError:
            return False

    def test_who_is_not_of_the_named_network_is_refused(self):
        here = own_address()
        if here is None:
            self.skipTest("this host has no network")
        self.assertEqual(self.answers(here, "198.51.100.0/24"), set())  # of documentation: nobody's
        self.assertEqual(self.answers(here, f"{here}/32"), {"arm", "hand", "page"})

    def test_what_it_writes_is_of_its_user_as_the_mask_says(self):
        mask = os.umask(0o077)
        try:
            server = self.serve("--log", pathlib.Path(self.folder, "run.mcap"), "--capture", pathlib.Path(self.folder, "run.pcapng"))
        finally:
            os.umask(mask)
        self.check_serves(server)
        server.end()
        for name in ("run.mcap", "run.pcapng"):
            self.assertEqual(stat.S_IMODE(pathlib.Path(self.folder, name).stat().st_mode) & 0o077, 0, name)

    def test_a_package_of_the_working_folder_is_not_run(self):
        """compare and others hand over to Python, which by itself looks into the working folder first."""
        pathlib.Path(self.folder, "panda_twin.py").write_text("raise SystemExit(77)\n")
        tried = subprocess.run([sys.executable, "-c", "import panda_twin"], cwd=self.folder)
        self.assertEqual(tried.returncode, 77)
        done = subprocess.run([serve_test.PROGRAM, "compare", "no-such.mcap"], cwd=self.folder, capture_output=True, text=True,
                              env={**os.environ, "PANDA_TWIN_PYTHON": sys.executable})
        self.assertNotIn(done.returncode, (0, 77), done.stderr)
        self.assertNotEqual(done.stderr, "")


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
