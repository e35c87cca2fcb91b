#!/usr/bin/env python3
"""Whether the page's pictures disturb a realtime arm: page_bench.py PROGRAM SOURCE_TREE [--seconds S] [--rounds N].

One run in real time. A watcher who takes no pictures looks on all the time; a second visitor takes all there are in every other window of S
seconds. Told: pictures a second, and cycles without a command in the windows with and without. Fails below 10 pictures a second, and when
the share of unserved cycles is higher by more than half a percentage point with pictures than without.
"""

import argparse
import pathlib
import sys
import tempfile
import threading
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "page"))
import page_server_test  # noqa: E402

LEAST_PICTURES = 10.0
MOST_POINTS = 0.5


class Taker(threading.Thread):
    """Takes pictures while `on` is set, and counts them."""

    def __init__(self, served):
        super().__init__(daemon=True)
        self.visitor = served.connect()
        self.on = threading.Event()
        self.taken = 0

    def run(self):
        try:
            while True:
                self.visitor.picture()
                self.taken += 1
                self.on.wait()
                self.visitor.say("shown")
        except OSError:  # the run is over
            pass


def cycles(watcher):
    """(served, held) as of now: what had piled up meanwhile is passed over."""
    watcher.say("ping", sent_ms=time.monotonic())
    watcher.hear("pong")
    arm = watcher.hear(lambda message: message["type"] == "state" and message["arm"])["arm"]
    return arm["served"], arm["held"]


def scenario(seconds):
    ready = "0, -0.7854, 0, -2.3562, 0, 1.5708"
    points = "".join(f"      - {{at: {2 * i} s, q: [{ready}, {0.7854 if i % 2 == 0 else 0.4}]}}\n" for i in range(int(seconds / 2) + 1))
    return f"name: page\nscene: scenes/floor.xml\nmotion:\n  trajectory:\n    unit: rad\n    waypoints:\n{points}record: false\n"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program")
    parser.add_argument("source")
    parser.add_argument("--seconds", type=float, default=5)
    parser.add_argument("--rounds", type=int, default=10)
    args = parser.parse_args()
    page_server_test.PROGRAM, page_server_test.SOURCE = args.program, pathlib.Path(args.source)
    with tempfile.TemporaryDirectory(prefix="panda_twin_page_bench_") as folder:
        whole = scenario(2 * args.rounds * (args.seconds + 1) + 20)
        served = page_server_test.Run(folder, whole, ["--drive", "realtime"])
        try:
            tallies, pictures = measure(served, args)
        finally:
            served.end()
    shares = {on: 100 * held / max(1, good + held) for on, (good, held) in tallies.items()}
    print(f"pictures      {pictures:.1f} a second at 640 x 480, {args.rounds} windows of {args.seconds:g} s")
    for on, name in ((False, "without"), (True, "with")):
        print(f"{name:<13} {tallies[on][1]} of {sum(tallies[on])} cycles unserved, {shares[on]:.3f} %")
    print(f"difference    {shares[True] - shares[False]:+.3f} percentage points")
    return 0 if pictures >= LEAST_PICTURES and shares[True] - shares[False] <= MOST_POINTS else 1


def measure(served, args):
    watcher = served.connect()
    watcher.hear(lambda message: message["type"] == "state" and message["arm"] and message["arm"]["mode"] == "Move")
    taker = Taker(served)
    taker.start()
    tallies = {False: [0, 0], True: [0, 0]}
    taken = spent = 0
    for window in range(2 * args.rounds):
        on = window % 2 == 1
        (taker.on.set if on else taker.on.clear)()
        time.sleep(0.5)  # what the last window left under way is in neither
        before, pictures, begin = cycles(watcher), taker.taken, time.monotonic()
        until = begin + args.seconds
        while time.monotonic() < until:
            watcher.hear("state")
        after, end = cycles(watcher), time.monotonic()
        for i in range(2):
            tallies[on][i] += after[i] - before[i]
        if on:
            taken += taker.taken - pictures
            spent += end - begin
    return tallies, taken / spent


if __name__ == "__main__":
    sys.exit(main())
