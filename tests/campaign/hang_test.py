#!/usr/bin/env python3
"""Checks that a world that does not end in time ends the campaign, with its seed and scenario.

    hang_test.py PROGRAM
"""

import pathlib
import subprocess
import sys
import tempfile

SEED = 7  # of a scenario


def main():
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([program, "--worlds", "1", "--seed", str(SEED), "--patience", "0.001", "--out", out], capture_output=True, text=True, check=False)
        file = pathlib.Path(out) / f"world_{SEED}.yaml"
        expected = f"world {SEED} violates the invariant ends: it still ran after --patience 0.001 s; {file}\n"
        print(done.stdout, done.stderr)
        printed = subprocess.run([program, "--seed", str(SEED), "--print"], capture_output=True, text=True, check=True)
        return 0 if (done.returncode, done.stdout) == (1, expected) and file.read_text() == printed.stdout else 1


if __name__ == "__main__":
    sys.exit(main())
