#!/usr/bin/env python3
"""What excuses a run on the wall clock: witness_test.py HOST_WITNESS_PROGRAM [unittest options]."""

import pathlib
import signal
import subprocess
import sys
import time
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "clients"))

import own_client_test  # noqa: E402: found by the path above
import witness  # noqa: E402

PROGRAM = ""
ABORT = 'motion aborted by reflex! ["communication_constraints_violation"]'


class Host:
    """A witness that saw so many cycles spoilt in a row."""

    def __init__(self, spoilt):
        self.saw = {"in_row": spoilt, "of_500": spoilt, "latest_ms": float(spoilt)}

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass


class UndisturbedTest(unittest.TestCase):
    def setUp(self):
        self.runs = 0

    def run_that_says(self, text, succeeds_at=1000):
        def attempt():
            self.runs += 1
            if self.runs < succeeds_at:
                raise AssertionError(text)
            return "done"
        return attempt

    def test_an_abort_beside_a_quiet_witness_fails_at_once(self):
        for spoilt in (0, 19):
            with self.assertRaisesRegex(AssertionError, "communication_constraints(.|\n)*no excuse: it needs .*20"):
                witness.undisturbed(lambda spoilt=spoilt: Host(spoilt), self.run_that_says(ABORT), witness.ENDS_A_MOTION)
        self.assertEqual(self.runs, 2)

    def test_an_abort_beside_a_late_witness_is_repeated_and_then_skips(self):
        with self.assertRaisesRegex(unittest.SkipTest, "this host spoilt each of 4 runs; .*'in_row': 20"):
            witness.undisturbed(lambda: Host(20), self.run_that_says(ABORT), witness.ENDS_A_MOTION, attempts=4)
        self.assertEqual(self.runs, 4)

    def test_a_repeated_run_may_succeed(self):
        self.assertEqual(witness.undisturbed(lambda: Host(20), self.run_that_says(ABORT, 3), witness.ENDS_A_MOTION), "done")
        self.assertEqual(self.runs, 3)

    def test_what_no_lateness_makes_is_never_excused(self):
        with self.assertRaisesRegex(AssertionError, "no excuse: it needs one"):
            witness.undisturbed(lambda: Host(100000), self.run_that_says("cartesian_reflex"), witness.ENDS_A_MOTION)
        self.assertEqual(self.runs, 1)

    def test_what_says_two_things_needs_the_lateness_for_both(self):
        excuses = witness.ENDS_A_MOTION | witness.JUMPS
        self.assertEqual(witness.undisturbed(lambda: Host(1), self.run_that_says("discontinuity", 2), excuses), "done")
        with self.assertRaises(AssertionError):
            witness.undisturbed(lambda: Host(19), self.run_that_says(ABORT + " discontinuity"), excuses)


class WitnessTest(unittest.TestCase):
    def test_sees_that_it_was_not_run(self):
        with witness.Witness(PROGRAM) as host:
            host.process.send_signal(signal.SIGSTOP)
            time.sleep(0.05)
            host.process.send_signal(signal.SIGCONT)
        self.assertGreaterEqual(host.saw["in_row"], 49)
        self.assertGreaterEqual(host.saw["of_500"], 49)
        self.assertGreaterEqual(host.saw["latest_ms"], 48)


class ClientTest(unittest.TestCase):
    def test_no_abort_is_excused_by_its_name(self):
        case = own_client_test.OwnClientTest("test_every_interface_reaches_the_goal")
        ended = subprocess.CompletedProcess([], 1, "", ABORT)
        with mock.patch.multiple(own_client_test, TwinServer=mock.MagicMock(), DRIVE="realtime", PROGRAM=PROGRAM), \
                mock.patch.object(case, "run_there", return_value=ended):
            try:
                case.succeed(None, None)
            except unittest.SkipTest as skip:
                self.fail(f"it is skipped: {skip}")
            except AssertionError:
                return
        self.fail("it passes")


if __name__ == "__main__":
    PROGRAM = pathlib.Path(sys.argv[1]).parents[2] / "program"  # as though it were one of the build's folder
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
