"""What this host does to a run on the wall clock, and when that excuses the run: for tests that are scripts.

The rule is that of undisturbed.h. A run that failed is repeated, and at last its test skipped, when a witness at the same priority saw
the host spoil so many cycles of 1 ms in a row that it can have made what failed; whatever the failure says, otherwise it is one.
"""

import json
import pathlib
import subprocess
import unittest

# How many cycles of 1 ms the host must have spoilt to make what failed, by what the failure says: in a row, or of 500.
IN_ROW, OF_500 = "in_row", "of_500"
ENDS_A_MOTION = {"communication_constraints_violation": (IN_ROW, 20)}
# A stream with nothing behind it, of a client's own program or by the paper's law alone: after one lost command the next may be a jump
# from what the robot made of that.
JUMPS = {"discontinuity": (IN_ROW, 1)}
# What `run --backend fci` checks before a motion, over 500 cycles: that 5 % at most of the robot's are missing, 10 % of the answers.
REFUSES = {"FAILED states": (OF_500, 25), "FAILED communication": (OF_500, 50)}
GIVES_UP = {"no robot state": (IN_ROW, 900), "this machine gives it no time": (IN_ROW, 900)}  # after 1 s
# The default chain rejoins after a loss, so that positions, velocities and poses have no such excuse. Torques cannot rejoin.
TORQUES_JUMP = {"controller_torque_discontinuity": (IN_ROW, 1)}
A_CLIENT = ENDS_A_MOTION | TORQUES_JUMP | REFUSES | GIVES_UP
PRIORITY = 98  # FIFO: of a robot in real time; clients have 99


class Witness:
    """with Witness(PROGRAM) as host: ...; then host.saw: in_row, of_500, latest_ms. PROGRAM: any of the build's folder."""

    def __init__(self, program, priority=PRIORITY):
        self.command = [pathlib.Path(program).parent / "tests/support/host_witness", str(priority)]
        self.saw = {}

    def __enter__(self):
        self.process = subprocess.Popen(self.command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        if self.process.stdout.readline() != "watching\n":
            raise RuntimeError(f"{self.command} does not watch")
        return self

    def __exit__(self, *_):
        self.saw = json.loads(self.process.communicate()[0])


def undisturbed(watch, attempt, excuses, attempts=5):
    """What the first attempt() gives that does not fail. Skips the test when the host spoilt every attempt.

    watch     makes a context for each attempt, as Witness is one
    attempt   fails by AssertionError, with what was said in its text
    excuses   some of the above; a failure that says several needs all of them, and one that says none has no excuse
    """
    for _ in range(attempts):
        with watch() as host:
            try:
                return attempt()
            except AssertionError as error:
                failure = error
        needed = [excuse for sign, excuse in excuses.items() if sign in str(failure)]
        if not needed or any(host.saw[what] < cycles for what, cycles in needed):
            raise AssertionError(f"{failure}\nno excuse: it needs {needed or 'one'} cycles that the host spoilt, and a witness saw "
                                 f"{host.saw}") from failure
    raise unittest.SkipTest(f"this host spoilt each of {attempts} runs; in the last a witness saw {host.saw}")
