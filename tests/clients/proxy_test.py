#!/usr/bin/env python3
"""Our client on a robot behind `panda-twin proxy`, in real time: proxy_test.py PROGRAM SOURCE_TREE [unittest options].

A run that this machine spoilt, as a witness saw, is repeated.
"""

import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import unittest

import own_client_test
import twin_server
from own_client_test import witness

PROGRAM, SOURCE = "", pathlib.Path()


class Proxy:
    """with Proxy(robot's address, "--state-delay", "80 us") as proxy: proxy.address"""

    def __init__(self, robot, *flags):
        self.address = twin_server.own_address()
        self.command = [PROGRAM, "proxy", "--robot", robot, "--bind", self.address, *flags]
        self.said = ""

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        for _ in range(4):  # it listens before it says so
            self.said += self.process.stdout.readline()
        return self

    def __exit__(self, *_):
        self.process.send_signal(signal.SIGTERM)
        try:
            self.said += self.process.communicate(timeout=60)[0]
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.communicate()
        if self.process.returncode not in twin_server.GOOD_ENDS:
            raise RuntimeError(f"{self.command} ended with {self.process.returncode}:\n{self.said}")

    def counts(self, what):
        """After its end: {"came": 812, ...} of "arm states", say."""
        names = next(line for line in self.said.splitlines() if line.startswith("datagrams ")).split()[1:]
        row = next(line for line in self.said.splitlines() if line.startswith(what))
        return dict(zip(names, map(int, row.removeprefix(what).split())))


class ProxyTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.scenario = self.tmp / "scenario.yaml"
        self.scenario.write_text(own_client_test.MOTION.replace("INTERFACE", "joint_position").replace("CONTROLLER", "")
                                 .replace("START", "0.7853981633974483"))

    def run_behind(self, check, *faults):
        """A run on a robot of its own that passes check(what came of it, the proxy). @returns the proxy."""
        def attempt():
            done, proxy = self.attempt_behind(*faults)
            check(done, proxy)
            return proxy
        return witness.undisturbed(lambda: witness.Witness(PROGRAM), attempt, witness.A_CLIENT)

    def attempt_behind(self, *faults):
        with twin_server.TwinServer(PROGRAM, SOURCE, "realtime") as server, Proxy(server.address, *faults) as proxy:
            done = subprocess.run([PROGRAM, "run", self.scenario, "--backend", "fci", "--robot", proxy.address,
                                   "--data", SOURCE / "models", "--out", self.tmp / "out"],
                                  capture_output=True, text=True, timeout=120)
        return done, proxy

    def test_a_run_behind_a_mild_delay_succeeds(self):
        proxy = self.run_behind(lambda done, _: self.assertEqual(done.returncode, 0, done.stdout + done.stderr), "--state-delay",
                                "{log_normal: {median: 60 us, sigma: 0.3}}", "--command-delay", "60 us", "--seed", "3")
        self.assertEqual(json.loads((self.tmp / "out/summary.json").read_text())["outcome"], "success")
        states, commands = proxy.counts("arm states"), proxy.counts("arm commands")
        self.assertGreater(commands["relayed"], 800)  # one a cycle of the 1 s motion, but for what came late
        for counts in (states, commands):
            self.assertEqual(counts["delayed"], counts["came"])
            self.assertEqual((counts["lost"], counts["duplicated"], counts["dropped"], counts["foreign"]), (0, 0, 0, 0))

    def test_a_burst_of_lost_commands_ends_the_motion(self):
        link = self.tmp / "link.yaml"
        link.write_text("link: {command_loss: {scripted: [{at: 300 ms, count: 100}]}}\n")
        def check(done, proxy):
            self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
            self.assertGreaterEqual(proxy.counts("arm commands")["lost"], 10, done.stderr)
            self.assertIn("communication_constraints_violation", done.stderr)
        self.run_behind(check, "--link", link)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
