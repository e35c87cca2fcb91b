#!/usr/bin/env python3
"""Nobody reads what serve and proxy print: unread_output_test.py PROGRAM SOURCE_TREE [unittest options].

Clients are served and a signal ends the program all the same. The pipe holds 4 kB, which two dozen clients fill.
"""

import fcntl
import pathlib
import re
import signal
import subprocess
import sys
import unittest

import fci_wire as fci
import serve_test

CLIENTS = 100  # their lines are four times what the pipe holds
MANY = 1500    # more than is kept for a reader who comes late
LIMIT_S = 60   # one that waits for its reader never ends


class UnreadOutputTest(serve_test.ServeTest):
    def begin(self, *args):
        """@returns (process, the arm's port): what it says first is read, the rest is not."""
        process = subprocess.Popen([serve_test.PROGRAM, *map(str, args), "--port", "0", "--hand-port", "0"], stdout=subprocess.PIPE,
                                   stderr=subprocess.DEVNULL, bufsize=0)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        fcntl.fcntl(process.stdout, fcntl.F_SETPIPE_SZ, 4096)
        port = 0
        for line in process.stdout:
            if match := re.search(rb"^  arm   127\.0\.0\.1:(\d+)$", line):
                port = int(match[1])
            if b"open to" in line:
                return process, port
        self.fail("it does not serve")

    def serve_unread(self):
        file = pathlib.Path(self.folder) / "served.yaml"
        file.write_text(serve_test.SCENARIO)
        return self.begin("serve", file, "--data", serve_test.SOURCE / "models", "--drive", "lockstep")

    def visit(self, port, clients):
        for _ in range(clients):
            arm = fci.Arm(port)  # waits for the answer to its Connect
            self.assertEqual(arm.connected, fci.SUCCESS)
            arm.close()

    def test_a_server_serves_and_ends(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            with self.subTest(how.name):
                process, port = self.serve_unread()
                self.visit(port, CLIENTS)
                process.send_signal(how)
                self.assertEqual(process.wait(LIMIT_S), 130)

    def test_a_proxy_relays_and_ends(self):
        _, robot = self.serve_unread()
        process, port = self.begin("proxy", "--robot", f"127.0.0.1:{robot}")
        self.visit(port, CLIENTS)
        process.send_signal(signal.SIGTERM)
        self.assertEqual(process.wait(LIMIT_S), 130)

    def test_who_reads_late_is_told_how_much_is_missing(self):
        process, port = self.serve_unread()
        self.visit(port, MANY)
        process.send_signal(signal.SIGTERM)
        # Reading makes room again, also for the line that follows what was dropped.
        said = process.stdout.read().decode()
        self.assertEqual(process.wait(LIMIT_S), 130)
        lines = said.splitlines()
        missing = sum(int(match[1]) for match in re.finditer(r"(?m)^ +(\d+) lines were not printed", said))
        kept = sum(" connected; " in line or " disconnected: " in line for line in lines)
        self.assertGreater(missing, 0)
        self.assertGreaterEqual(kept + missing, 2 * MANY)
        self.assertTrue(all(re.match(r" +\d+(\.\d{3} s  \S| lines were not printed)", line) for line in lines), lines)


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
