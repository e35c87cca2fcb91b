#!/usr/bin/env python3
"""Sweeps: plan, shards, resumption, merge: sweep_test.py PROGRAM SOURCE_TREE [unittest options]. SWEEP_KILLS says how many kills."""

import csv
import html
import json
import os
import pathlib
import random
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM, SOURCE = "", pathlib.Path()

SWEEP = """name: losses
scenario: smoke.yaml
axes:
  - {key: link.command_loss, values: [0 %, 60 %, 80 %]}
  - {key: onboard.abort_after_lost, values: [10, 20]}
seeds: 4
"""


class SweepTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_sweep_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)

    def write(self, text=SWEEP):
        (self.folder / "s.yaml").write_text(text)

    def command(self, what, *more, out="out"):
        where = [] if what == "plan" else ["--out", str(self.folder / out)]
        return [PROGRAM, "sweep", what, str(self.folder / "s.yaml"), *where, "--data", str(SOURCE / "models"), *more]

    def call(self, what, *more, out="out"):
        return subprocess.run(self.command(what, *more, out=out), capture_output=True, text=True, timeout=300)

    def run_sweep(self, *more, out="out"):
        done = self.call("run", *more, out=out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done

    def digest(self, out="out"):
        done = self.call("merge", out=out)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return re.search(r"^digest  ([0-9a-f]{16})$", done.stdout, re.MULTILINE).group(1)

    def refused(self, text, code, says, what="run", *more):
        self.write(text)
        done = self.call(what, *more)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        self.assertRegex(done.stderr, says)

    def table(self, out, name):
        return list(csv.DictReader((self.folder / out / name).read_text().splitlines()))

    def results(self, out="out"):
        return {file.relative_to(self.folder / out): file.read_bytes() for file in (self.folder / out / "runs").rglob("*.json")}


# What stands for Slurm: it carries a job out at once. sweep_slurm_test.py has the real one.
SBATCH = """#!/bin/sh
set -e
for word; do
  case $word in --array=0-*) last=${word##*-} ;; --output=*) log=${word#*=} ;; --wrap=*) wrap=${word#*=} ;; esac
done
for SLURM_ARRAY_TASK_ID in $(seq 0 "${last:-0}"); do
  export SLURM_ARRAY_TASK_ID
  sh -c "$wrap" >"$log" 2>&1
done
echo 7
"""


class SlurmScriptTest(SweepTest):
    def test_quotes_what_a_shell_would_take_apart(self):
        self.folder = self.folder / "it's a folder"
        self.folder.mkdir()
        self.write()
        self.run_sweep(out="here")
        (self.folder / "sbatch").write_text(SBATCH)
        (self.folder / "sbatch").chmod(0o755)
        script = self.call("slurm", "--shards", "3", out="there").stdout
        done = subprocess.run(["bash"], input=script, capture_output=True, text=True,
                              env={"PATH": f"{self.folder}:{os.environ['PATH']}"})
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn(f"digest  {self.digest('here')}\n", (self.folder / "there/slurm/merge.txt").read_text())
        command = re.search(r"<pre>(panda-twin run .*)</pre>", (self.folder / "here/report.html").read_text()).group(1)
        self.assertTrue(pathlib.Path(shlex.split(html.unescape(command))[-1]).is_file())

    def test_wants_to_know_how_many_shards(self):
        self.refused(SWEEP, 2, "--shards is required", "slurm")
        self.refused(SWEEP, 3, "--shards is 0; it must lie in", "slurm", "--shards", "0")


class SharingTest(SweepTest):
    def test_any_number_of_shards_and_processes_gives_the_same(self):
        self.write()
        self.run_sweep("--jobs", "1", out="one")
        digest, results = self.digest("one"), self.results("one")
        self.assertEqual(len(results), 24)
        for shards in (2, 7):
            out = f"of{shards}"
            for i in reversed(range(shards)):
                self.run_sweep("--jobs", "1", "--shard", f"{i}/{shards}", out=out)
            self.assertEqual(self.results(out), results)
            self.assertEqual(self.digest(out), digest)
        self.run_sweep("--jobs", "3", out="jobs")
        self.assertEqual(self.results("jobs"), results)
        self.assertEqual(self.digest("jobs"), digest)
        self.run_sweep("--jobs", "2", "--shard", "1/2", out="both")
        self.assertEqual(len(self.results("both")), 12)
        self.run_sweep("--jobs", "2", "--shard", "0/2", out="both")
        self.assertEqual(self.digest("both"), digest)

    def test_what_is_there_stays_and_what_is_not_whole_is_done_again(self):
        self.write()
        self.run_sweep("--jobs", "1")
        digest = self.digest()
        files = sorted((self.folder / "out" / "runs").rglob("*.json"))
        times = {file: file.stat().st_mtime_ns for file in files}
        files[0].write_text(files[0].read_text()[:50])
        files[1].unlink()
        self.run_sweep("--jobs", "1")
        self.assertEqual({file for file in files if file.stat().st_mtime_ns != times[file]}, set(files[:2]))
        self.assertEqual(self.digest(), digest)

    def test_kills_at_random_moments_lose_nothing(self):
        kills = int(os.environ.get("SWEEP_KILLS", "10"))
        self.write(SWEEP.replace("seeds: 4", f"seeds: {4 * kills}"))
        self.run_sweep(out="whole")
        digest = self.digest("whole")
        chance = random.Random(7)
        failures = {run["address"] for run in self.table("whole", "runs.csv") if run["outcome"] != "success"}
        for jobs in ("1", "2"):
            out = "killed" + jobs
            if jobs == "2":
                self.write((self.folder / "s.yaml").read_text() + "keep: failures\n")
            for _ in range((kills + 1) // 2):
                child = subprocess.Popen(self.command("run", "--jobs", jobs, "-q", out=out), stderr=subprocess.DEVNULL)
                time.sleep(chance.uniform(0.02, 0.5))
                child.send_signal(signal.SIGKILL)
                child.wait()
                for result in self.results(out).values():
                    json.loads(result)
            self.run_sweep("--jobs", jobs, out=out)
            self.assertEqual(self.results(out), self.results("whole"))
            self.assertEqual(self.digest(out), digest)
        logs = {folder.name: folder for folder in (self.folder / "killed2/logs").glob("*/*")}
        self.assertLessEqual(failures, set(logs))
        for address in failures:
            self.assertEqual(sorted(file.name for file in logs[address].iterdir()), ["run.mcap", "scenario.yaml", "summary.json", "timing.json"])

    def test_an_interrupt_leaves_whole_files_and_the_rest_to_do(self):
        self.write(SWEEP.replace("seeds: 4", "seeds: 2000"))
        child = subprocess.Popen(self.command("run", "-q"), stderr=subprocess.PIPE, text=True)
        deadline = time.monotonic() + 60
        while not self.results() and time.monotonic() < deadline:
            time.sleep(0.05)
        child.send_signal(signal.SIGINT)
        self.assertIn("interrupted", child.communicate(timeout=30)[1])
        self.assertEqual(child.returncode, 130)
        for result in self.results().values():
            json.loads(result)
        self.assertGreater(len(self.results()), 0)
        done = self.call("merge")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\d+ of 12000 runs are missing .*the first: point \d \(link.command_loss: \d+ %")


class MergeTest(SweepTest):
    def test_tables_report_and_worst(self):
        self.write(SWEEP + "description: What breaks.\ndemand: {success: 10 %}\n")
        self.run_sweep()
        self.digest()
        out = self.folder / "out"
        points = self.table("out", "points.csv")
        self.assertEqual(len(points), 6)
        self.assertEqual(points[0]["link.command_loss"], "0 %")
        self.assertEqual((points[0]["failures"], points[4]["failures"]), ("0", "4"))
        runs = self.table("out", "runs.csv")
        self.assertEqual(len(runs), 24)
        self.assertEqual(json.loads((out / "summary.json").read_text())["runs"], 24)
        page = (out / "report.html").read_text()
        self.assertEqual(page.count("<path d="), 3)
        self.assertRegex(page, r"0 %: 0 of 8 failed")
        for text in ("What breaks.", "background:#c0272d", "communication_constraints_violation"):
            self.assertIn(text, page)
        worst = sorted((out / "worst").glob("*.yaml"))
        self.assertIn(f"<pre>panda-twin run {out}/worst/", page)
        self.assertGreater(len(worst), 0)
        again = subprocess.run([PROGRAM, "run", worst[0], "--no-video", "--out", self.folder / "again", "--data", SOURCE / "models"],
                               capture_output=True, text=True, timeout=300)
        self.assertEqual(again.returncode, 1, again.stderr)
        states_hash = json.loads((self.folder / "again" / "summary.json").read_text())["states_hash"]
        self.assertEqual([run["states_hash"] for run in runs if run["address"] == worst[0].stem], [states_hash])

    def test_a_demand_that_is_missed(self):
        self.write(SWEEP + "demand: {success: 95 %}\n")
        self.run_sweep()
        done = self.call("merge")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"% of the runs succeeded; 95 % are demanded")
        self.assertIn("digest  ", done.stdout)

    def test_results_of_other_runs_are_left_aside(self):
        self.write()
        self.run_sweep()
        digest = self.digest()
        self.write(SWEEP.replace("80 %", "85 %"))
        done = self.call("merge")
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"8 of 24 runs are missing .*; other results there: 8 of another sweep or other models")
        self.run_sweep()
        self.assertNotEqual(self.digest(), digest)
        one = sorted(self.results())[0]
        text = (self.folder / "out" / one).read_text().replace(one.stem, "ff" * 16).replace('"version": "', '"version": "before ')
        (self.folder / "out/runs/ff").mkdir(exist_ok=True)
        (self.folder / "out/runs/ff" / ("ff" * 16 + ".json")).write_text(text)
        self.assertIn("results left aside: 1 of another version of the program, 8 of another sweep or other models\n",
                      self.call("merge").stderr)

    def test_logs_of_failures_are_kept_beside_the_same_results(self):
        self.write()
        self.run_sweep(out="without")
        digest = self.digest("without")
        failures = {run["address"] for run in self.table("without", "runs.csv") if run["outcome"] != "success"}
        self.write(SWEEP + "keep: failures\n")
        self.run_sweep()
        self.assertEqual(self.results(), self.results("without"))
        self.assertEqual(self.digest(), digest)
        logs = self.folder / "out" / "logs"
        self.assertEqual({log.parent.name for log in logs.rglob("run.mcap")}, failures)
        self.assertEqual(len(list(logs.glob("*/*"))), len(failures))
        worst = sorted(failures & {file.stem for file in (self.folder / "out/worst").iterdir()})[0]
        log = f"logs/{worst[:2]}/{worst}/run.mcap"
        self.assertIn(f'<a href="{log}">log</a>', (self.folder / "out/report.html").read_text())
        subprocess.run([PROGRAM, "run", self.folder / f"out/worst/{worst}.yaml", "--no-video", "--out", self.folder / "again", "--data",
                        SOURCE / "models"], capture_output=True, timeout=300)
        self.assertEqual((self.folder / "again/run.mcap").read_bytes(), (self.folder / "out" / log).read_bytes())
        shutil.rmtree(logs / worst[:2] / worst)
        self.run_sweep()
        self.assertTrue((self.folder / "out" / log).exists())
        self.write(SWEEP + "keep: all\n")
        self.run_sweep("--jobs", "1")
        self.assertEqual(len(list(logs.rglob("run.mcap"))), 24)
        self.assertEqual(self.digest(), digest)

    def test_a_point_ends_early(self):
        self.write(SWEEP.replace("seeds: 4", "seeds: 40\nstop_at_width: 0.4"))
        self.run_sweep("--jobs", "1", out="one")
        self.run_sweep("--jobs", "3", out="three")
        self.assertEqual(self.results("one"), self.results("three"))
        self.assertEqual(self.digest("one"), self.digest("three"))
        points = self.table("one", "points.csv")
        self.assertEqual(points[0]["runs"], "10")
        ended = sum(40 - int(point["runs"]) for point in points)
        self.write(SWEEP.replace("seeds: 4", "seeds: 40"))
        self.run_sweep(out="one")
        self.write(SWEEP.replace("seeds: 4", "seeds: 40\nstop_at_width: 0.4"))
        self.assertIn(f"results left aside: {ended} of points that ended before\n", self.call("merge", out="one").stderr)


class InputTest(SweepTest):
    def test_files_that_are_refused(self):
        self.refused(SWEEP + "colour: red\n", 3, r's.yaml:7: .*unknown key "colour"')
        self.refused(SWEEP.replace("[10, 20]", "[]"), 3, r"axes.*is empty; give at least one value")
        self.refused(SWEEP.replace("command_loss", "comand_loss"), 3, r'point 1 \(link.comand_loss: 0 %, .*unknown key "comand_loss"')
        self.refused(SWEEP.replace("80 %", "200 %"), 3, r"point 5 \(link.command_loss: 200 %, onboard.abort_after_lost: 10\): ")
        self.refused(SWEEP.replace("smoke.yaml", "none.yaml"), 3, r"there is no none.yaml beside")
        self.refused(SWEEP + "budget: 23\n", 3, r"24 runs; budget allows 23")
        self.refused(SWEEP + "keep: some\n", 3, r'"some" is unknown; accepted: summary, failures, all')
        self.refused(SWEEP.replace("seeds: 4", "seeds: 1000000"), 3, r"6000000 runs; .* in all; more than 1000000 take --yes")
        self.refused(SWEEP, 3, r'shard "3/3": must be i/n', "run", "--shard", "3/3")
        self.assertFalse((self.folder / "out" / "runs").exists())

    def test_a_point_that_only_its_run_refuses_costs_its_own_runs(self):
        for jobs in ("1", "2"):
            self.refused("name: s\nscenario: smoke.yaml\naxes: [{key: scene, values: [scenes/floor.xml, none.xml]}]\nseeds: 2\n", 3,
                         r"point 2 \(scene: none.xml\): .*there is no file", "run", "--jobs", jobs)
            self.assertEqual(len(self.results()), 2)

    def test_a_folder_that_cannot_be_made(self):
        self.write()
        for jobs in ("1", "2"):
            done = self.call("run", "--jobs", jobs, out="/proc/sweep")
            self.assertEqual(done.returncode, 4, done.stderr)
            self.assertIn("/proc/sweep", done.stderr)

    def test_a_folder_that_is_a_file(self):
        self.write()
        (self.folder / "out").write_text("")
        self.assertEqual(self.call("run", "--jobs", "1").returncode, 4)
        self.assertEqual(self.call("run", "--jobs", "2").returncode, 4)

    def test_what_the_python_package_does(self):
        self.write()
        self.assertRegex(self.call("run", "--shards", "3").stderr, "--shards is for --on")
        self.assertRegex(self.call("run", "--on", "ray", "--jobs", "2").stderr, "leave --shard and --jobs out")
        there = (pathlib.Path(PROGRAM).parent / "python").is_dir()  # built with the package
        pythons = {self.folder / "none": (4, "none: No such file"), sys.executable: (3, '"dask": must be ray') if there else (4, "does not load")}
        for python, (code, says) in pythons.items():
            environment = {**os.environ, "PANDA_TWIN_PYTHON": str(python)}
            done = subprocess.run(self.command("run", "--on", "dask"), capture_output=True, text=True, env=environment)
            self.assertEqual(done.returncode, code, done.stderr)
            self.assertIn(says, done.stderr)

    def test_plan(self):
        self.write(SWEEP.replace("values: [10, 20]", "from: 10, to: 20, steps: 11"))
        done = self.call("plan")
        self.assertEqual(done.returncode, 0, done.stderr)
        for line in (r"^link.command_loss +3 values: 0 %, 60 %, 80 %$", r"^points  33$", r"^runs    132 \(4 seeds of each point\)$",
                     r"^cost    .* s a run on one core, as the first point's took: .* in all$"):
            self.assertRegex(done.stdout, re.compile(line, re.MULTILINE))


class DrawTest(SweepTest):
    DRAWN = """name: drawn
scenario: smoke.yaml
axes:
  - {key: link.command_loss, from: 0 %, to: 50 %}
  - {key: tick.lambda, from: 0.001, to: 0.1, scale: log}
  - {key: robot.clock_drift, normal: {mean: 0 ppm, deviation: 10 ppm}}
samples: {kind: latin_hypercube, points: 8}
seeds: 2
"""

    def test_a_hypercube_has_one_point_in_each_stratum_and_draws_anew_for_each_run(self):
        self.write(self.DRAWN)
        self.run_sweep("--jobs", "1", out="one")
        self.run_sweep("--jobs", "2", out="two")
        self.assertEqual(self.digest("one"), self.digest("two"))
        runs = self.table("one", "runs.csv")
        losses = {float(run["link.command_loss"].split()[0]) for run in runs}
        self.assertEqual(sorted(int(loss / 50 * 8) for loss in losses), list(range(8)))
        self.assertEqual(len({run["robot.clock_drift"] for run in runs}), 16)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
