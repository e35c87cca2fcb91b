#!/usr/bin/env python3
"""What --allow-hardware demands, tried on a served twin: rehearsal_test.py PROGRAM SOURCE_TREE [unittest options].
"""

import datetime
import json
import os
import pathlib
import pty
import resource
import signal
import subprocess
import sys
import tempfile
import unittest

import own_client_test
from twin_server import TwinServer

PROGRAM, SOURCE = "", pathlib.Path()
READY = "0.7853981633974483"


class RehearsalTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.tmp = pathlib.Path(folder.name)
        self.environment = dict(os.environ, XDG_STATE_HOME=str(self.tmp / "state"))
        self.scenario = self.tmp / "scenario.yaml"
        self.write(READY)

    def write(self, start):
        self.scenario.write_text(own_client_test.MOTION.replace("INTERFACE", "joint_position").replace("CONTROLLER", "")
                                 .replace("START", start))

    def command(self, out, *flags):
        return [PROGRAM, "run", self.scenario, "--data", SOURCE / "models", "--out", self.tmp / out, *flags]

    def run_it(self, out, *flags):
        return subprocess.run(self.command(out, *flags), capture_output=True, text=True, timeout=120, env=self.environment,
                              stdin=subprocess.DEVNULL)

    def rehearse(self, *flags):
        done = self.run_it("rehearsal", "--no-video", *flags)
        self.assertEqual(done.returncode, 0, done.stderr)

    @staticmethod
    def there(server, *flags):
        return ["--backend", "fci", "--robot", server.address, "--robot-time", "states", "--allow-hardware", *flags]

    def end_there(self, code, out, *flags):
        done = self.run_it(out, *flags)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def drive(self, server, out, *flags):
        """@returns its summary's record of the robot."""
        self.end_there(0, out, *self.there(server, "--yes", *flags))
        return json.loads((self.tmp / out / "summary.json").read_text())["hardware"]

    def check_refused(self, server, why, *flags):
        done = self.run_it("refused", *self.there(server, "--yes", *flags))
        self.assertEqual(done.returncode, 3, done.stdout + done.stderr)
        self.assertIn(why, done.stderr)
        self.assertIn(f"panda-twin run {self.scenario}", done.stderr)  # what makes one
        self.assertRegex(done.stdout, r"(?m)^FAILED rehearsal")
        self.assertNotIn("reach", done.stdout)  # before anything is asked of a robot
        self.assertFalse((self.tmp / "refused").exists())

    def test_a_scenario_runs_in_the_twin_first_and_then_slowly(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            self.check_refused(server, "the twin has not run this scenario as it is now")
            self.rehearse()
            first = self.drive(server, "first")
            self.assertEqual((first["max_speed"], first["no_rehearsal"], first["confirmed"]), (0.2, "", False))
            datetime.datetime.strptime(first["rehearsed"], "%Y-%m-%dT%H:%M:%SZ")
            self.assertEqual(self.drive(server, "second")["max_speed"], 1)
            self.assertEqual(self.drive(server, "slow", "--max-speed", "0.5")["max_speed"], 0.5)
            self.write("0.7853981633974484")  # another hash, and the same start to the robot
            self.check_refused(server, "the twin has not run this scenario as it is now")
        seconds = [json.loads((self.tmp / out / "summary.json").read_text())["simulated_s"] for out in ("first", "second", "slow")]
        # The planned motion takes 1 s, and 5 s and 2 s at those speeds; the rest is settling, the same in all.
        self.assertAlmostEqual(seconds[0] - seconds[1], 4, delta=0.2)
        self.assertAlmostEqual(seconds[2] - seconds[1], 1, delta=0.2)

    def test_a_rehearsal_grows_old_and_may_have_been_too_slow(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            self.rehearse("--max-speed", "0.1")
            self.check_refused(server, "the last one was at 0.1 of the scenario's speed, and this run is at 0.2")
            self.rehearse()
            [kept] = (self.tmp / "state/panda-twin").iterdir()
            record = json.loads(kept.read_text())
            self.assertEqual((record["scenario"], record["outcome"], len(record["q_start_rad"])), ("there_and_back", "success", 7))
            record["ended_ns"] -= 25 * 3600 * 10**9
            kept.write_text(json.dumps(record))
            self.check_refused(server, "the last one ended 25.0 h ago, and 24.0 h are allowed")
            self.assertIsNotNone(self.drive(server, "out", "--rehearsed-within", "26h")["rehearsed"])

    def test_a_rehearsal_that_ends_early_replaces_a_success(self):
        def write_little():
            resource.setrlimit(resource.RLIMIT_FSIZE, (2**16, 2**16))
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            self.rehearse()
            done = subprocess.run(self.command("rehearsal", "--no-video"), capture_output=True, text=True, timeout=120,
                                  env=self.environment, preexec_fn=write_little)
            self.assertEqual(done.returncode, 4, done.stderr)  # its log has no room
            self.check_refused(server, "the last one failed: ")

    def test_a_command_to_copy_names_the_data_and_quotes(self):
        self.scenario = self.tmp / "two words.yaml"
        self.write(READY)
        done = self.run_it("out", "--backend", "fci", "--robot", "127.0.0.1:9", "--allow-hardware", "--yes")
        self.assertIn(f"panda-twin run '{self.scenario}' --data {SOURCE / 'models'}", done.stderr)

    def test_a_reason_replaces_a_rehearsal_and_is_recorded(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            record = self.drive(server, "out", "--no-rehearsal", "the twin lacks this tool")
        self.assertEqual((record["no_rehearsal"], record["rehearsed"]), ("the twin lacks this tool", None))

    def test_a_twin_without_the_flag_is_a_rehearsal_itself(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            self.end_there(0, "out", *[flag for flag in self.there(server) if flag != "--allow-hardware"])
            self.assertNotIn("hardware", json.loads((self.tmp / "out/summary.json").read_text()))
            self.assertIsNotNone(self.drive(server, "again")["rehearsed"])

    def test_check_only_counts_every_failure_and_leaves_nothing(self):
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            done = self.end_there(1, "out", *self.there(server, "--check-only"))
            self.assertRegex(done.stdout, r"(?m)^FAILED rehearsal")
            self.assertIn("1 of the checks before the first motion failed", done.stderr)
            self.rehearse()
            done = self.end_there(0, "out", *self.there(server, "--check-only"))
            self.assertTrue(done.stdout.endswith("ready; nothing has moved\n"), done.stdout)
            self.assertNotIn("FAILED", done.stdout)
            # It was no run on this robot: the next one is still the first.
            self.assertEqual(self.drive(server, "first")["max_speed"], 0.2)
        self.assertFalse((self.tmp / "out").exists())

    def test_without_a_terminal_nobody_can_be_asked(self):
        done = self.run_it("out", "--backend", "fci", "--robot", "127.0.0.1:9", "--allow-hardware")
        self.assertEqual(done.returncode, 3)
        self.assertIn("say --yes", done.stderr)
        done = self.run_it("out", "--yes")
        self.assertEqual(done.returncode, 3)
        self.assertIn("go with --allow-hardware", done.stderr)

    def ask(self, server, out):
        """A run on a terminal, at its question. @returns process, terminal."""
        terminal, its_end = pty.openpty()
        self.addCleanup(os.close, terminal)
        process = subprocess.Popen(self.command(out, *self.there(server)), stdin=its_end, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, env=self.environment)
        os.close(its_end)
        said = ""
        for line in process.stdout:
            said += line
            if "press Enter to move" in line:
                return process, terminal
        self.fail(said + process.communicate()[1])

    def test_enter_moves_after_a_countdown_and_an_interrupt_does_not(self):
        self.rehearse()
        with TwinServer(PROGRAM, SOURCE, "lockstep") as server:
            process, _ = self.ask(server, "out")
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
            self.assertEqual(process.returncode, 130)
            self.assertFalse((self.tmp / "out/summary.json").exists())
            process, terminal = self.ask(server, "out")
            os.write(terminal, b"\n")
            said, errors = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, errors)
        self.assertLess(said.index("moves in 3 s"), said.index("moves in 1 s"))
        self.assertTrue(json.loads((self.tmp / "out/summary.json").read_text())["hardware"]["confirmed"])


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
