#!/usr/bin/env python3
"""`panda-twin proxy` as a command: proxy_command_test.py PROGRAM SOURCE_TREE [unittest options]. No robot is there."""

import pathlib
import re
import socket
import subprocess
import sys
import tempfile
import unittest

PROGRAM, SOURCE = "", pathlib.Path()
LIMIT = 60
OK, USAGE, BAD_INPUT, ENVIRONMENT = 0, 2, 3, 4


class ProxyCommandTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)

    def run_proxy(self, *flags):
        for flag, value in (("--robot", "127.0.0.1:9"), ("--port", "0"), ("--hand-port", "0"), ("--for", "0.05")):
            flags = flags if flag in flags else (*flags, flag, value)
        return subprocess.run([PROGRAM, "proxy", *map(str, flags)], capture_output=True, text=True, timeout=LIMIT)

    def refused(self, code, *flags):
        done = self.run_proxy(*flags)
        self.assertEqual((done.returncode, done.stdout), (code, ""), done.stderr)
        self.assertEqual(done.stderr.count("\n"), 1)
        return done.stderr

    def file(self, text):
        path = self.tmp / "link.yaml"
        path.write_text(text)
        return path

    def test_tells_where_it_listens_and_what_it_has_relayed(self):
        done = self.run_proxy("--seed", "7")
        self.assertEqual(done.returncode, OK, done.stderr)
        self.assertRegex(done.stdout, r"^panda-twin proxy to the robot at 127\.0\.0\.1:9, seed 7\n  arm   127\.0\.0\.1:\d+\n"
                                      r"  hand  127\.0\.0\.1:\d+\n  open to this machine only\n")
        for what in ("arm states", "arm commands", "hand states"):
            self.assertTrue(re.search(rf"(?m)^{what}( +0){{8}}$", done.stdout), done.stdout)

    def test_takes_the_link_of_a_scenario_or_of_a_file_of_its_own(self):
        own = self.file("link: {state_delay: 80 us, command_loss: {scripted: [{at: 2 s, count: 25}]}}\n")
        for path in (own, SOURCE / "models/scenarios/bursts.yaml"):
            done = self.run_proxy("--link", path)
            self.assertEqual(done.returncode, OK, done.stderr)

    def test_takes_all_of_a_link_as_flags(self):
        done = self.run_proxy(*[part for direction in ("state", "command") for part in (
            f"--{direction}-delay", "{gamma: {shape: 2, scale: 30 us, offset: 20 us}}", f"--{direction}-loss", "0.1 %",
            f"--{direction}-duplication", "{share: 1 %, delay: 1 ms}", f"--{direction}-reordering", "{share: 1 %, by: 2 ms}")])
        self.assertEqual(done.returncode, OK, done.stderr)

    def test_what_is_wrong_with_the_faults_is_named_with_its_place(self):
        self.assertIn("link.yaml:2: link: unknown key \"state_dely\"", self.refused(
            BAD_INPUT, "--link", self.file("link:\n  state_dely: 80 us\n")))
        self.assertIn("accepted: link", self.refused(BAD_INPUT, "--link", self.file("state_delay: 80 us\n")))
        self.assertIn("state_delay: \"80\"", self.refused(BAD_INPUT, "--state-delay", "80"))
        self.assertIn("command_loss", self.refused(BAD_INPUT, "--command-loss", "150 %"))

    def test_a_file_and_flags_do_not_go_together(self):
        self.assertIn("--link", self.refused(BAD_INPUT, "--link", self.file("link: {}\n"), "--state-loss", "1 %"))

    def test_nobody_from_elsewhere_unless_named(self):
        self.assertIn("--allow", self.refused(BAD_INPUT, "--bind", "0.0.0.0"))
        done = self.run_proxy("--bind", "0.0.0.0", "--allow", "192.0.2.0/24")
        self.assertEqual(done.returncode, OK, done.stderr)
        self.assertIn("192.0.2.0/24: who is there can move the robot", done.stdout)

    def test_other_wrong_flags_are_named(self):
        self.assertIn("--for", self.refused(BAD_INPUT, "--for", "-1"))
        self.assertIn("--seed", self.refused(USAGE, "--seed", "-1"))
        self.assertIn("is no port", self.refused(BAD_INPUT, "--robot", "127.0.0.1:0"))
        done = subprocess.run([PROGRAM, "proxy"], capture_output=True, text=True, timeout=LIMIT)
        self.assertEqual(done.returncode, USAGE)
        self.assertIn("--robot", done.stderr)

    def test_a_port_that_is_taken_is_named(self):
        with socket.create_server(("127.0.0.1", 0)) as taken:
            port = taken.getsockname()[1]
            self.assertIn(f"127.0.0.1:{port}", self.refused(ENVIRONMENT, "--port", port))


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
