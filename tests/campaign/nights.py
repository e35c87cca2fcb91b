#!/usr/bin/env python3
"""Goes on with a campaign that takes nights: worlds after those in its ledger, in blocks, and may be broken off at any time.

    nights.py PROGRAM LEDGER [--worlds N] [--block N]      default: 100000 worlds in blocks of 8000

The ledger has a line of JSON per block: seed of its first world, worlds, hours of the robot's time, seconds of the wall clock, refused worlds,
violations, digest, the night's largest memory so far, and the program's hash. Prints what it holds in all. Exit code 1: a block of this night has a violation.
"""

import argparse
import hashlib
import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import time

# The worlds before are those of CI.
FIRST_SEED = 2001
SAID = re.compile(r"^(\d+) worlds from seed (\d+): ([0-9.]+) h of the robot's time, (\d+) refused, (\d+) violated an invariant; digest ([0-9a-f]+)", re.MULTILINE)


def blocks_of(ledger):
    return [json.loads(line) for line in ledger.read_text().splitlines()] if ledger.exists() else []


def run_block(program, seed, worlds, out):
    began = time.monotonic()
    threads = 2 * (os.cpu_count() or 1)  # since clients' worlds wait more than they compute
    done = subprocess.run([program, "--worlds", str(worlds), "--seed", str(seed), "--threads", str(threads), "--out", out], capture_output=True, text=True, check=False)
    said = SAID.search(done.stdout)
    if not said:
        raise SystemExit(f"{program} ended with {done.returncode}: {done.stdout[-2000:]}{done.stderr}")
    if done.returncode != 0:
        print(done.stdout, flush=True)
    return {"seed": seed, "worlds": int(said[1]), "robot_h": float(said[3]), "wall_s": round(time.monotonic() - began, 1), "refused": int(said[4]), "violations": int(said[5]),
            "digest": said[6], "peak_mb": resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024, "program": hashlib.sha256(program.read_bytes()).hexdigest()[:16]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", type=pathlib.Path)
    parser.add_argument("ledger", type=pathlib.Path)
    parser.add_argument("--worlds", type=int, default=100000)
    parser.add_argument("--block", type=int, default=8000)
    options = parser.parse_args()
    options.ledger.parent.mkdir(parents=True, exist_ok=True)
    violations, left = 0, options.worlds
    while left > 0:
        seed = max((block["seed"] + block["worlds"] for block in blocks_of(options.ledger)), default=FIRST_SEED)
        block = run_block(options.program, seed, min(left, options.block), options.ledger.parent / "campaign")
        with options.ledger.open("a") as ledger:
            ledger.write(json.dumps(block) + "\n")
        violations += block["violations"]
        left -= block["worlds"]
    blocks = blocks_of(options.ledger)
    total = {key: sum(block[key] for block in blocks) for key in ("worlds", "robot_h", "wall_s", "violations")}
    print(f"{total['worlds']} worlds from seed {FIRST_SEED} in {len(blocks)} blocks: {total['robot_h'] / 24:.2f} days of the robot's time in "
          f"{total['wall_s'] / 3600:.2f} h, {total['violations']} violated an invariant")
    return 1 if violations else 0


if __name__ == "__main__":
    sys.exit(main())
