#!/usr/bin/env python3
"""How many cycles our client serves over the wire in real time, beside the barest loop there can be.

    wire_realtime_bench.py PROGRAM BARE_LOOP SOURCE_TREE [SECONDS]

One server (`panda-twin serve --drive realtime`), one motion after the other for SECONDS (60) each: our client (`panda-twin run
--backend fci`) and BARE_LOOP, on an idle machine and beside two processes that use all the time they get. Both clients hold the
arm all but still, so that a loss ends no motion. Every figure is the robot's own, from the log of its cycles; nothing gates.
"""

import csv
import json
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

HOGS = 2
ATTEMPTS = 5
HOME = "0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966"
SERVED = "name: served\nonboard: {abort_after_lost: 1000000}\nmotion: {trajectory: {unit: rad, waypoints: [{q: [HOME, 0.7854]}, " \
         "{q: [HOME, 0.7855]}]}}\n".replace("HOME", HOME)
# Not quite still: a trajectory goes somewhere.
HOLD = f"""\
name: hold
onboard: {{abort_after_lost: 1000000}}
TICK
motion:
  trajectory:
    unit: rad
    duration: SECONDS s
    waypoints:
      - {{q: [{HOME}, 0.7854]}}
      - {{q: [{HOME}, 0.78545]}}
"""


class Bench:
    def __init__(self, program, bare_loop, source, seconds, folder):
        self.program, self.bare_loop, self.source, self.seconds = program, bare_loop, source, seconds
        self.folder = pathlib.Path(folder)
        self.address = "127.77.0.1"

    def serve(self, client, log):
        """Runs `client` against a server of its own. @returns whether it went well."""
        scenario = self.folder / "served.yaml"
        scenario.write_text(SERVED)
        server = subprocess.Popen([self.program, "serve", scenario, "--drive", "realtime", "--bind", self.address, "--data",
                                   self.source / "models", "--log", log], stdout=subprocess.PIPE, text=True)
        try:
            while "open to" not in server.stdout.readline():
                assert server.poll() is None, "the server does not serve"
            done = subprocess.run(client, capture_output=True, text=True, timeout=self.seconds + 120)
        finally:
            server.send_signal(signal.SIGTERM)
            server.communicate(timeout=60)
        if done.returncode != 0:
            print(f"  once more, since: {(done.stdout + done.stderr).strip().splitlines()[-1:]}", flush=True)
        return done.returncode == 0

    def measure(self, client):
        """@returns the robot's rows of the motion."""
        for _ in range(ATTEMPTS):
            log = self.folder / "server.mcap"
            if self.serve(client, log):
                subprocess.run([self.program, "export", log, "--out", self.folder / "csv"], check=True, capture_output=True)
                with open(self.folder / "csv/cycles.csv", newline="") as file:
                    rows = [row for row in csv.DictReader(file) if row["robot_mode"] == "Move"]
                first = next(i for i, row in enumerate(rows) if row["fate"] == "served")
                return rows[first:]
        sys.exit(f"every attempt failed: {client}")

    def ours(self, tick=""):
        scenario = self.folder / "hold.yaml"
        scenario.write_text(HOLD.replace("SECONDS", str(self.seconds)).replace("TICK", tick))
        out = self.folder / "out"
        rows = self.measure([self.program, "run", scenario, "--backend", "fci", "--robot", self.address, "--data",
                             self.source / "models", "--out", out, "--no-video"])
        loop = json.loads((out / "summary.json").read_text())
        return rows, loop.get("states_out_of_time")

    def ours_by_the_papers_rule(self):
        """States that come 250 us off their millisecond are not answered."""
        return self.ours("tick: {period_tolerance: 250 us}")

    def bare(self):
        return self.measure([self.bare_loop, self.address, "1337", str(self.seconds)]), None


def figures(rows):
    unserved = sum(row["fate"] == "held" for row in rows)
    rates = [float(row["control_command_success_rate"]) for row in rows[100:]]  # it looks at the last 100 cycles
    at = [int(row["at_ns"]) for row in rows]
    postponed = sum(max(0, round((b - a) / 1e6) - 1) for a, b in zip(at, at[1:]))
    return (f"{len(rows):7} {unserved:9} {100 * unserved / len(rows):8.3f} % {max(int(row['lost_in_row']) for row in rows):8} "
            f"{sum(rates) / len(rates):9.4f} {min(rates):6.2f} {postponed:9}")


def main():
    program, bare_loop, source = (pathlib.Path(path) for path in sys.argv[1:4])
    seconds = int(sys.argv[4]) if len(sys.argv) > 4 else 60
    print(f"{'machine':10} {'client':10} {'cycles':>7} {'unserved':>9} {'':>10} {'in a row':>8} {'rate mean':>9} {'least':>6} "
          f"{'postponed':>9}")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(program, bare_loop, source, seconds, folder)
        for load in (0, HOGS):
            hogs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(load)]
            try:
                time.sleep(1)  # until they run
                for name, run in (("ours", bench.ours), ("ours, rule", bench.ours_by_the_papers_rule), ("bare", bench.bare)):
                    rows, out_of_time = run()
                    note = "" if out_of_time is None else f"  ({out_of_time} states out of time, not answered)"
                    print(f"{f'{load} hogs' if load else 'idle':10} {name:10} {figures(rows)}{note}", flush=True)
            finally:
                for hog in hogs:
                    hog.kill()
                    hog.wait()


if __name__ == "__main__":
    main()
