#!/usr/bin/env python3
"""Hours of a served robot, and what they leave: docs/reference/reliability.md, section Soak.

    soak.py PROGRAM SOURCE_TREE --lockstep HOURS   hours of the robot's time, as fast as they go
    soak.py PROGRAM SOURCE_TREE --realtime HOURS   hours of the wall clock

Prints a row per quarter of an hour (per minute of less than two hours) and a table at the end. Exit code 1: a bound of that
table is broken.
"""

import argparse
import pathlib
import sys
import tempfile

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "server"))
sys.dont_write_bytecode = True

import lockstep_soak  # noqa: E402
import realtime_soak  # noqa: E402
import serve_test  # noqa: E402


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("source", type=pathlib.Path, help="source tree of the program, for its models")
    mode = parser.add_mutually_exclusive_group(required=True)
    mode.add_argument("--lockstep", type=float, metavar="HOURS")
    mode.add_argument("--realtime", type=float, metavar="HOURS")
    parser.add_argument("--seed", type=int, default=1, help="of the robot's random numbers (default: 1)")
    parser.add_argument("--wall-limit", type=float, metavar="S", default=float("inf"), help="end after so much of the wall clock")
    options = parser.parse_args()
    serve_test.PROGRAM, serve_test.SOURCE = str(options.program.resolve()), options.source.resolve()
    with tempfile.TemporaryDirectory(prefix="soak-") as folder:
        if options.lockstep is not None:
            findings = lockstep_soak.soak(pathlib.Path(folder), options.lockstep, options.seed, options.wall_limit)
        else:
            findings = realtime_soak.soak(pathlib.Path(folder), options.realtime, options.seed, options.wall_limit)
    return 0 if findings.show() else 1


if __name__ == "__main__":
    sys.exit(main())
