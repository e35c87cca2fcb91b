#!/usr/bin/env python3
"""A night's campaign begins where the last one ended: nights_test.py PROGRAM."""

import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

PROGRAM = sys.argv[1]
NIGHTS = pathlib.Path(__file__).with_name("nights.py")


class NightsTest(unittest.TestCase):
    def night(self, ledger, worlds, program=PROGRAM):
        return subprocess.run([sys.executable, NIGHTS, program, ledger, "--worlds", str(worlds), "--block", "2"], capture_output=True, text=True, check=False)

    def test_goes_on_behind_the_last_block(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_nights_") as folder:
            ledger = pathlib.Path(folder, "ledger.jsonl")
            for worlds in (3, 2):
                self.assertEqual(self.night(ledger, worlds).returncode, 0)
            blocks = [json.loads(line) for line in ledger.read_text().splitlines()]
            self.assertEqual([(block["seed"], block["worlds"]) for block in blocks], [(2001, 2), (2003, 1), (2004, 2)])
            self.assertIn("5 worlds from seed 2001 in 3 blocks", self.night(ledger, 0).stdout)

    def test_a_program_that_fails_leaves_no_block(self):
        with tempfile.TemporaryDirectory(prefix="panda_twin_nights_") as folder:
            ledger = pathlib.Path(folder, "ledger.jsonl")
            self.assertEqual(self.night(ledger, 2, "/bin/false").returncode, 1)
            self.assertFalse(ledger.exists())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0]])
