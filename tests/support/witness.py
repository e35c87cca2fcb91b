"""What this host does to a run on the wall clock, and when that excuses the run: for tests that are scripts.

The rule is that of undisturbed.h. A run that failed is repeated, and at last its test skipped, when a witness at the same priority saw
the host spoil so many cycles of 1 ms in a row that it can have made what failed; whatever the failure says, otherwise it is one.
"""

import json
import pathlib
import subprocess
import unittest

# How many cycles in a row the host must have spoilt to make what failed, by what the failure says.
ONE_SECOND = 900
ENDS_A_MOTION = {"communication_constraints_violation": 20}
# Where a client was held up, one command of its own is lost, and the next is a jump from what the robot made of that.
JUMPS = {"discontinuity": 1}
# What `run --backend fci` checks before a motion, of 500 cycles: that 5 % at most of the robot's are missing, 10 % of the answers.
REFUSES = {"FAILED states": 25, "FAILED communication": 50}
GIVES_UP = {"no robot state": ONE_SECOND, "this machine gives it no time": ONE_SECOND}
A_CLIENT = ENDS_A_MOTION | JUMPS | REFUSES | GIVES_UP
PRIORITY = 98  # FIFO: of a robot in real time; clients have 99


class Witness:
    """with Witness(PROGRAM) as host: ...; then host.spoilt_in_row, host.latest_ms. PROGRAM: any of the build's folder."""

    def __init__(self, program, priority=PRIORITY):
        self.command = [pathlib.Path(program).parent / "tests/support/host_witness", str(priority)]
        self.spoilt_in_row, self.latest_ms = 0, 0.0

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self.process.stdout.readline() != "watching\n":
            raise RuntimeError(f"{self.command} does not watch")
        return self

    def __exit__(self, *_):
        said = json.loads(self.process.communicate()[0])
        self.spoilt_in_row, self.latest_ms = said["spoilt_in_row"], said["latest_ms"]


def needed(failure, excuses):
    """Cycles in a row, or None when no lateness of the host can have made it."""
    return max((cycles for sign, cycles in excuses.items() if sign in failure), default=None)


def undisturbed(watch, attempt, excuses, attempts=5):
    """What the first attempt() gives that does not fail. Skips the test when the host spoilt every attempt.

    watch     makes a context for each attempt, as Witness is one
    attempt   fails by AssertionError, with what was said in its text
    excuses   some of the above: what of a failure's text needs how many cycles
    """
    for _ in range(attempts):
        with watch() as host:
            try:
                return attempt()
            except AssertionError as error:
                failure = error
        cycles = needed(str(failure), excuses)
        if cycles is None or host.spoilt_in_row < cycles:
            raise AssertionError(f"{failure}\nthe host spoilt {host.spoilt_in_row} cycles in a row, by up to {host.latest_ms} ms; "
                                 f"needed for an excuse: {cycles}") from failure
    raise unittest.SkipTest(f"this host spoilt each of {attempts} runs: in the last {host.spoilt_in_row} cycles in a row, by up to "
                            f"{host.latest_ms} ms")


def undisturbed_before(program, attempt):
    """As undisturbed, of a motion in lockstep: before it states come by the wall clock, on a thread of no priority, and half of the 500
    that are checked must come."""
    return undisturbed(lambda: Witness(program, 0), attempt, {"FAILED states": 250})
