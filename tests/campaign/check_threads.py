#!/usr/bin/env python3
"""Checks that a campaign's digest is the same by one thread and by three.

    check_threads.py PROGRAM
"""

import re
import subprocess
import sys

WORLDS = 100


def digest(program, threads):
    done = subprocess.run([program, "--worlds", str(WORLDS), "--seed", "301", "--repeat-every", "0", "--threads", str(threads)],
                          capture_output=True, text=True, check=True)
    return re.search(r"digest ([0-9a-f]{16})", done.stdout).group(1)


def main():
    one, three = (digest(sys.argv[1], threads) for threads in (1, 3))
    print(f"one thread {one}, three {three}")
    return 0 if one == three else 1


if __name__ == "__main__":
    sys.exit(main())
