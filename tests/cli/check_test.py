#!/usr/bin/env python3
"""What `check` says about real time: check_test.py PROGRAM SOURCE_TREE [unittest options].

How well this machine keeps time decides no test: only that it is measured, and told in full.
"""

import re
import subprocess
import sys
import unittest

PROGRAM = ""
SOURCE = ""

SPREAD = r"(\d+) us p50, (\d+) us p99, (\d+) us p99\.9, (\d+) us at most"


def check(*arguments):
    return subprocess.run([PROGRAM, "check", "--data", f"{SOURCE}/models", *arguments], capture_output=True, text=True,
                          timeout=150)


class CheckTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.done = check("--seconds", "0.5")
        cls.lines = cls.done.stdout.splitlines()

    def line(self, subject):
        """The one line about `subject`, as (mark, text)."""
        found = [line for line in self.lines if line[6:18].strip() == subject]
        self.assertEqual(len(found), 1, self.done.stdout)
        return found[0][:5].strip(), found[0][19:]

    def spread(self, subject):
        text = self.line(subject)[1]
        match = re.search(SPREAD, text)
        self.assertIsNotNone(match, text)
        return [int(figure) for figure in match.groups()], int(re.search(r"\((\d+) samples", text).group(1))

    def test_wake_ups_are_told_with_samples_and_kernel(self):
        figures, samples = self.spread("wake-ups")
        self.assertEqual(figures, sorted(figures))
        self.assertTrue(1 <= samples <= 500, samples)
        release = subprocess.run(["uname", "-r"], capture_output=True, text=True, check=True).stdout.strip()
        self.assertIn(f"kernel {release}", self.line("wake-ups")[1])

    def test_answers_are_told_with_samples(self):
        figures, samples = self.spread("answers")
        self.assertEqual(figures, sorted(figures))
        self.assertTrue(1 <= samples <= 501, samples)

    def test_verdict_is_one_of_three_and_never_a_failure(self):
        mark, text = self.line("1 kHz")
        self.assertRegex(text, "^(good for real time|usable|not fit): ")
        self.assertEqual(mark, "ok" if text.startswith("good") else "note")

    def test_cures_are_told_exactly_when_something_is_to_be_cured(self):
        cures = [line for line in self.lines if line[6:18].strip() == "cure"]
        self.assertEqual(bool(cures), self.line("1 kHz")[0] == "note", self.done.stdout)

    def test_permissions_are_told(self):
        self.assertRegex(self.line("scheduler")[1], "SCHED_FIFO")
        self.assertRegex(self.line("memory lock")[1], "unlimited|limits.conf")

    def test_jitter_is_no_reason_to_fail(self):
        failures = [line for line in self.lines if line.startswith("FAIL")]
        self.assertEqual(self.done.returncode, 1 if failures else 0, self.done.stderr)

    def test_lines_fit_a_terminal(self):
        for line in self.lines:
            self.assertLessEqual(len(line), 240, line)
            self.assertRegex(line, "^(ok   |note |FAIL ) ")


class BadDuration(unittest.TestCase):
    def test_is_refused_with_its_range(self):
        for seconds in ["0.4", "60.1", "0", "-1", "nan", "inf"]:
            with self.subTest(seconds=seconds):
                done = check(f"--seconds={seconds}")
                self.assertEqual(done.returncode, 3, done.stderr)
                self.assertRegex(done.stderr, r"^panda-twin: error: --seconds .*\[0\.5, 60\]")
                self.assertEqual(done.stdout, "")

    def test_what_is_no_number_is_a_usage_error(self):
        self.assertEqual(check("--seconds", "two").returncode, 2)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1:3]
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
