#!/usr/bin/env python3
"""Sweeps of many runs: sweep_long_test.py PROGRAM SOURCE_TREE [unittest options]."""

import concurrent.futures
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

MIXED = """name: mixed
scenario: {scenario}
axes:
  - {{key: link.command_loss, uniform: {{from: 0 %, to: 60 %}}}}
{axes}first_seed: {first_seed}
seeds: {seeds}
"""
PLANTS = """  - {key: plant, values: {ideal: {kind: ideal}, simulated: {kind: mujoco}}}
  - {key: robot.hand, values: [none, franka_hand]}
"""
# Scenario, axes and their points, seeds: 1000 runs. Their models, hands, objects, plans and reflexes take turns.
SWEEPS = (("smoke.yaml", PLANTS, 4, 100), ("collision.yaml", "", 1, 200), ("wrong_load.yaml", "", 1, 150), ("push.yaml", "", 1, 130),
          ("user_stop.yaml", "", 1, 90), ("../applications/plan_and_execute.yaml", "", 1, 30))
SMOKE = """name: many
scenario: smoke.yaml
axes:
  - {{key: link.command_loss, uniform: {{from: 0 %, to: 60 %}}}}
seeds: {seeds}
"""


class SweepTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_sweep_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.file = self.folder / "s.yaml"

    def command(self, what, *more, out="out"):
        where = [] if what == "plan" else ["--out", str(self.folder / out)]
        return [PROGRAM, "sweep", what, str(self.file), *where, "--data", str(SOURCE / "models"), *more]

    def call(self, what, *more, out="out"):
        done = subprocess.run(self.command(what, *more, out=out), capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout

    def timed(self, what, *more, out="out"):
        begin = time.monotonic()
        self.call(what, *more, out=out)
        return time.monotonic() - begin

    def measured(self, what, *more):
        """Wall-clock time, s, and the most memory that was resident, MB."""
        begin = time.monotonic()
        child = subprocess.Popen(self.command(what, *more), stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        self.assertEqual(child.returncode, 0)
        return time.monotonic() - begin, usage.ru_maxrss / 1024

    def digest(self, out="out"):
        return re.search(r"^digest  (\w{16})$", self.call("merge", out=out), re.MULTILINE).group(1)

    def results(self, out="out"):
        return {file.name: file.read_bytes() for file in (self.folder / out / "runs").rglob("*.json")}


class CanonicalTest(SweepTest):
    def test_any_number_of_shards_and_processes_gives_the_same_digest(self):
        self.file = SOURCE / "models/sweeps/canonical_losses.yaml"
        took = self.timed("run", "--jobs", "1", out="of1")
        digest, results = self.digest("of1"), self.results("of1")
        self.assertEqual(len(results), 200)
        for shards in (2, 7):
            for i in range(shards):
                self.call("run", "--jobs", "1", "--shard", f"{i}/{shards}", out=f"of{shards}")
            self.assertEqual(self.results(f"of{shards}"), results)
            self.assertEqual(self.digest(f"of{shards}"), digest)
        pool = self.timed("run", out="pool")
        self.assertEqual(self.digest("pool"), digest)
        print(f"\n200 canonical runs: {took:.1f} s by one process, {pool:.1f} s by one for each of {os.cpu_count()} processors; {digest}")


class WarmTest(SweepTest):
    def test_a_process_that_has_run_others_gives_the_bytes_of_a_fresh_one(self):
        chance = random.Random(11)
        self.assertEqual(sum(points * seeds for _, _, points, seeds in SWEEPS), 1000)
        for number, (scenario, axes, points, seeds) in enumerate(SWEEPS):
            self.file = self.folder / f"{number}.yaml"
            self.file.write_text(MIXED.format(scenario=scenario, axes=axes, first_seed=chance.randrange(1, 1 << 40), seeds=seeds))
            runs = points * seeds
            with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
                list(pool.map(lambda i: self.call("run", "--jobs", "1", "--shard", f"{i}/{runs}", out=f"fresh{number}"), range(runs)))
            self.call("run", "--jobs", "1", out=f"warm{number}")
            self.assertEqual(len(self.results(f"warm{number}")), runs)
            self.assertEqual(self.results(f"warm{number}"), self.results(f"fresh{number}"), scenario)


class CostTest(SweepTest):
    def test_a_plan_of_a_million_points_costs_next_to_nothing(self):
        axes = "name: s\nscenario: smoke.yaml\naxes:\n  - {key: link.command_loss, from: 0 %, to: 50 %}\n  - {key: tick.lambda, from: 0.001, to: 0.1}\n"
        kinds = (axes.replace("}", ", steps: 1000}"), *(axes + f"samples: {{kind: {kind}, points: 1000000}}\n" for kind in ("latin_hypercube", "sobol")))
        self.file.write_text(axes.replace("}", ", steps: 2}"))
        _, least = self.measured("plan")
        for text in kinds:
            self.file.write_text(text)
            seconds, megabytes = self.measured("plan")
            print(f"\nplan of a million points: {seconds:.2f} s, {megabytes:.0f} MB (of four: {least:.0f} MB)")
            self.assertLess(seconds, 2)
            self.assertLess(megabytes, least + 12)  # 4 bytes of a sample

    def test_a_worker_stays_small_over_10000_runs(self):
        self.file.write_text(SMOKE.format(seeds=10000))
        child = subprocess.Popen(self.command("run", "--jobs", "1", "-q"), stdout=subprocess.DEVNULL)
        resident = []  # MB, once a second
        ended = threading.Event()

        def watch():
            while not ended.wait(1):
                pages = pathlib.Path(f"/proc/{child.pid}/statm").read_text().split()
                if len(pages) > 1 and int(pages[1]) > 0:
                    resident.append(int(pages[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6)

        watcher = threading.Thread(target=watch)
        watcher.start()
        os.waitid(os.P_PID, child.pid, os.WEXITED | os.WNOWAIT)
        ended.set()
        watcher.join()
        self.assertEqual(child.wait(), 0)
        self.assertEqual(len(self.results()), 10000)
        quarter = len(resident) // 4
        early, late = max(resident[:quarter]), max(resident[-quarter:])
        print(f"\n10000 smoke runs: {early:.1f} MB in the first quarter, {late:.1f} MB in the last")
        self.assertLess(late, 200)
        self.assertLess(late, early + 2)

    def test_processes_run_as_fast_as_one_that_is_warm(self):
        processors = len(os.sched_getaffinity(0))
        self.file.write_text(SMOKE.format(seeds=1000))
        for attempt in range(3):
            one = Spent(lambda: self.call("run", "--jobs", "1", out=f"one{attempt}"))
            pool = Spent(lambda: self.call("run", "--jobs", str(processors), out=f"all{attempt}"))
            share = one.seconds / pool.seconds / processors
            print(f"\n1000 smoke runs: {one.seconds:.2f} s by one process, {pool.seconds:.2f} s by {processors}: {share:.3f} of what is there; "
                  f"processor time {one.processor:.2f} s and {pool.processor:.2f} s, others meanwhile {pool.others:.2f} s")
            if share >= 0.9:
                return
            if pool.others < 0.05 * pool.processor:
                self.assertGreaterEqual(share, 0.9)
        self.skipTest("others use this machine")


class Spent:
    """What some work took: wall-clock time, processor time of its processes and that of all others, s."""

    def __init__(self, work):
        begin, all_begin, own_begin = time.monotonic(), self.of_all(), self.of_own()
        work()
        self.seconds, self.processor = time.monotonic() - begin, self.of_own() - own_begin
        self.others = self.of_all() - all_begin - self.processor

    @staticmethod
    def of_all():
        user, nice, system, _, _, irq, softirq, steal = map(int, pathlib.Path("/proc/stat").read_text().split()[1:9])
        return (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")

    @staticmethod
    def of_own():
        usage = resource.getrusage(resource.RUSAGE_CHILDREN)
        return usage.ru_utime + usage.ru_stime


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
