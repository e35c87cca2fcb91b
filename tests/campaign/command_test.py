#!/usr/bin/env python3
"""What the campaign's command says of worlds that hang or crash, and of wrong input: command_test.py PROGRAM."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time
import unittest

SEED = 7  # of a scenario


def user_s(pid):
    """Processor time of a process so far, s."""
    ticks = pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11]
    return int(ticks) / os.sysconf("SC_CLK_TCK")


class CommandTest(unittest.TestCase):
    program = pathlib.Path()

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write_far(self):
        """A scenario that no robot can run."""
        (self.folder / "far.yaml").write_text("name: far\nmotion: {trajectory: {unit: rad, waypoints: [{q: [0, 0, 0, -1, 0, 1, 0]}, {q: [9, 0, 0, -1, 0, 1, 0]}]}}\n")

    def run_program(self, *arguments, stdout=subprocess.PIPE):
        return subprocess.run([self.program, *map(str, arguments)], cwd=self.folder, stdout=stdout, stderr=subprocess.PIPE, text=True, check=False)

    def test_a_world_that_does_not_end_ends_the_campaign(self):
        done = self.run_program("--worlds", 1, "--seed", SEED, "--patience", 0.001, "--out", ".")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stdout, f"world {SEED} violates the invariant ends: it still ran after --patience 0.001 s; ./world_{SEED}.yaml\n")
        printed = self.run_program("--seed", SEED, "--print")
        self.assertEqual((self.folder / f"world_{SEED}.yaml").read_text(), printed.stdout)

    def test_a_crash_tells_its_world(self):
        with subprocess.Popen([self.program, "--worlds", "1000000", "--threads", "1", "--out", self.folder], stderr=subprocess.PIPE, text=True) as running:
            while user_s(running.pid) < 1:  # beyond its start
                time.sleep(0.01)
            running.send_signal(signal.SIGABRT)
            self.assertRegex(running.communicate()[1], r"^world \d+ crashed\n$")
        self.assertEqual(running.returncode, -signal.SIGABRT)

    def test_what_tests_nothing_is_refused(self):
        (self.folder / "file").write_text("")
        (self.folder / "real.yaml").write_text(self.run_program("--seed", SEED, "--print").stdout.replace("drive: lockstep", "drive: realtime"))
        (self.folder / "remote.yaml").write_text((self.folder / "real.yaml").read_text().replace('backend: "mujoco"', "backend: fci").replace("drive: realtime\n", ""))
        self.write_far()
        for arguments, said in ((("--seed", -1), '"-1" is not a whole number'),
                                (("--seed", 2**64), "is not a whole number"),
                                (("--seed", "010"), "is not a whole number"),
                                (("--seed", 2**64 - 1, "--worlds", 2), "beyond 2^64 - 1"),
                                (("--worlds", 0), "nothing would be tried"),
                                (("--patience", "nan"), "--patience nan"),
                                (("--data", "nowhere"), "--data nowhere"),
                                (("--around", "far.yaml", "--worlds", 3), "no world could run"),
                                (("far.yaml",), "1 of 1 scenarios could not run"),
                                (("real.yaml",), "real.yaml: drive: realtime: the campaign runs in lockstep"),
                                (("remote.yaml",), 'remote.yaml: backend: fci: the campaign runs emulated robots'),
                                (("far.yaml", "--seed", SEED), "--seed is for drawn worlds"),
                                (("--out", "file/folder"), "cannot be made")):
            with self.subTest(arguments=arguments):
                done = self.run_program(*arguments)
                self.assertEqual(done.returncode, 3, done.stdout)
                self.assertIn(said, done.stderr)

    def test_a_world_alone_tells_the_hash_that_run_tells(self):
        (self.folder / "world.yaml").write_text(self.run_program("--seed", SEED, "--print").stdout)
        twin = self.program.parents[2] / "panda-twin"
        run = subprocess.run([twin, "run", "world.yaml", "--out", "out"], cwd=self.folder, capture_output=True, text=True, check=False)
        hashes = [re.search(r"states hash +([0-9a-f]{16})", text) for text in (self.run_program("--worlds", 1, "--seed", SEED).stdout, run.stdout)]
        self.assertEqual(hashes[0][1], hashes[1][1])

    def test_scenario_files_are_checked_as_worlds_are(self):
        good = self.run_program("--seed", SEED, "--print").stdout
        (self.folder / "world.yaml").write_text(good)
        done = self.run_program("world.yaml", "world.yaml")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"^(world.yaml violates no invariant: .*; states hash [0-9a-f]{16}\n){2}$")
        self.write_far()
        done = self.run_program("far.yaml", "world.yaml")
        self.assertEqual(done.returncode, 3)
        self.assertRegex(done.stdout, r"^far.yaml is refused: .*\nworld.yaml violates no invariant")
        self.assertIn("1 of 2 scenarios could not run", done.stderr)
        done = self.run_program("world.yaml", "--patience", 0.001)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(done.stdout, "world.yaml violates the invariant ends: it still ran after --patience 0.001 s\n")

    def test_a_full_disk_behind_stdout_is_no_success(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = self.run_program("--worlds", 1, "--seed", SEED, stdout=full)
        self.assertEqual(done.returncode, 3)
        self.assertIn("standard output cannot be written", done.stderr)


if __name__ == "__main__":
    CommandTest.program = pathlib.Path(sys.argv.pop(1)).resolve()
    unittest.main()
