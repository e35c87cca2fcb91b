#!/usr/bin/env python3
"""`run --backend fci --capture` against `serve --capture`: client_capture_test.py PROGRAM SOURCE_TREE [unittest options].

The server is in lockstep: within a motion no datagram is missing on either side, whatever this machine does.
"""

import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import own_client_test
from twin_server import TwinServer

PROGRAM, SOURCE = "", pathlib.Path()
HEAD = re.compile(r"^(\d+\.\d{9}) s  (\S+) > (\S+)  (.*)$")


class Message:
    """What a message says, without when it was captured."""

    def __init__(self, head, fields):
        at, self.source, self.target, self.summary = HEAD.match(head).groups()
        self.at = float(at)
        self.key = (self.source, self.target, self.summary, *fields)
        self.is_command = self.summary.startswith("command for state ")
        self.is_state = self.summary.startswith("state ")
        self.is_motions = self.is_command or (self.is_state and "joint_position" in self.summary)


def decode(capture):
    text = subprocess.run([PROGRAM, "decode", capture], check=True, capture_output=True, text=True).stdout
    messages, lines = [], text.splitlines()
    starts = [i for i, line in enumerate(lines) if HEAD.match(line)] + [len(lines)]
    return [Message(lines[a], lines[a + 1:b]) for a, b in zip(starts, starts[1:])]


class ClientCaptureTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.mine = self.tmp / "client.pcapng"

    def run_it(self, *flags, start="0.7853981633974483", extra=""):
        scenario = self.tmp / "scenario.yaml"
        scenario.write_text(own_client_test.MOTION.replace("INTERFACE", "joint_position").replace("CONTROLLER", extra)
                            .replace("START", start))
        return subprocess.run([PROGRAM, "run", scenario, "--data", SOURCE / "models", "--out", self.tmp / "out",
                               "--capture", self.mine, *flags], capture_output=True, text=True, timeout=120)

    def run_there(self, server, **options):
        return self.run_it("--backend", "fci", "--robot", server.address, "--robot-time", "states", **options)

    def succeed(self, *flags, **options):
        """On a robot of its own."""
        with TwinServer(PROGRAM, SOURCE, "lockstep", *flags) as server:
            done = self.run_there(server, **options)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_both_ends_capture_the_same(self):
        theirs = self.tmp / "server.pcapng"
        self.succeed("--capture", theirs, extra="hand: [{at: 0 s, homing: {}}]")
        client, robot = decode(self.mine), decode(theirs)

        def of(messages, wanted):
            return sorted(message.key for message in messages if wanted(message))
        # Between motions a client may leave states unread: what it has is what was sent, but perhaps not all.
        self.assertLessEqual({message.key for message in client}, {message.key for message in robot})
        motion = of(client, lambda message: message.is_motions)
        self.assertGreater(len(motion), 2000)
        self.assertEqual(motion, of(robot, lambda message: message.is_motions))
        self.assertEqual(of(client, lambda message: message.is_command), of(robot, lambda message: message.is_command))
        talk = [message.summary for message in client if re.match(r"request|answer", message.summary)]
        self.assertEqual(sorted(talk), of_summaries(robot))
        for needed in ("request 0: Connect", "answer 0: Connect"):
            self.assertEqual(talk.count(needed), 2)  # arm and hand
        self.assertTrue(any(message.summary.startswith("hand state ") for message in client))

    def test_the_captures_time_never_runs_back(self):
        self.succeed()
        messages = decode(self.mine)
        for kind in ("is_state", "is_command"):
            times = [message.at for message in messages if getattr(message, kind)]
            self.assertEqual(times, sorted(times))
        first_motion = next(message.at for message in messages if message.is_motions)
        self.assertGreater(first_motion, 0.5)  # the checks before it last half a second of states, on the wall

    def test_a_run_that_is_refused_leaves_a_whole_capture(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            self.assertEqual(self.run_there(server, start="0.9").returncode, 1)
        self.assertIn("request 0: Connect", [message.summary for message in decode(self.mine)])
        self.assertFalse(self.mine.with_name("client.pcapng.partial").exists())

    def test_only_a_robot_on_the_network_has_a_wire(self):
        done = self.run_it()
        self.assertEqual(done.returncode, 3)
        self.assertIn("--capture goes with --backend fci", done.stderr)
        self.assertFalse(self.mine.exists())

    def test_a_file_that_cannot_be_made_is_named(self):
        self.mine = self.tmp / "no such folder" / "client.pcapng"
        done = self.run_it("--backend", "fci", "--robot", "127.0.0.1:9")
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn(str(self.mine), done.stderr)


def of_summaries(messages):
    return sorted(message.summary for message in messages if re.match(r"request|answer", message.summary))


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
