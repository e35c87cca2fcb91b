#!/usr/bin/env python3
"""The real program where its host, its input or its robot fail it: cli_faults_test.py PROGRAM SOURCE_TREE [unittest options]."""

import json
import pathlib
import resource
import signal
import subprocess
import sys
import unittest

import cli_test
from cli_test import SHORT, CliTest

MUJOCO = SHORT.replace("kind: ideal", "kind: mujoco")


class BadScenario(CliTest):
    def test_a_second_document(self):
        for text in (SHORT + "---\n" + SHORT, SHORT + "---\nlambda: 3\n"):
            self.assert_refused(self.run_scenario(text), 3, "scenario.yaml: holds 2 YAML documents; one belongs in a file")
        self.assertEqual(self.run_scenario("---\n" + SHORT + "...\n").returncode, 0)

    def test_a_long_value_is_told_in_short(self):
        endless = "9" * 5000
        for text in (self.spoil("0.001", endless), self.spoil("1 s", endless + " s"), self.spoil("name: short", "name: " + endless),
                     SHORT + f"backend: {endless}\n", SHORT + f"robot: {{model: x{endless}}}\n",
                     self.spoil("[0.1,", f"[{endless},"), SHORT + f"scene: {endless}\n", SHORT + f"{endless}: 1\n",
                     SHORT + f"controller: {{type: {endless}}}\n", SHORT + f"controller: {{library: {endless}}}\n"):
            done = self.run_scenario(text)
            self.assert_refused(done, 3, "scenario.yaml")
            self.assertLess(len(done.stderr), 2200)

    def test_a_capture_that_is_one_of_the_runs_results_is_refused(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        before = {name: (self.out / name).read_bytes() for name in self.files()}
        for name in ("run.mcap", "run.mcap.partial", "../out/summary.json", "plots/joints.svg"):
            with self.subTest(name=name):
                done = self.run_scenario(SHORT, "--backend", "fci", "--robot", "127.0.0.1:9", "--capture", self.out / name)
                self.assert_error(done, 3, "is one of the run's own results; name another file")
                self.assertEqual({name: (self.out / name).read_bytes() for name in self.files()}, before)


    def test_a_run_does_not_replace_the_scenario_that_it_runs(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        before = (self.out / "scenario.yaml").read_bytes()
        done = subprocess.run([cli_test.PROGRAM, "run", self.out / "scenario.yaml", "--out", self.out], capture_output=True, text=True)
        self.assert_error(done, 3, "which this run would replace; choose another --out")
        self.assertEqual((self.out / "scenario.yaml").read_bytes(), before)


class BadEnvironment(CliTest):
    def test_a_file_that_may_not_grow_leaves_a_log_that_can_be_read(self):
        limit = 300_000  # less than the log of 20 s
        done = subprocess.run([cli_test.PROGRAM, *map(str, self.run_arguments(SHORT.replace("1 s", "20 s")))], cwd=self.folder,
                              env=self.environment, capture_output=True, text=True, timeout=120,
                              preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit)))
        self.assert_error(done, 4, "run.mcap.partial: File too large")
        [warning] = [line for line in done.stderr.splitlines() if "warning:" in line]
        self.assertRegex(warning, "File too large; .*The run goes on without its log")  # at once, not at the end
        self.assertEqual(self.files(), {"run.mcap.partial"})
        done = self.call("export", self.out / "run.mcap.partial")
        self.assertEqual(done.returncode, 0, done.stderr)
        cycles = (self.out / "csv" / "cycles.csv").read_text().count("\n")
        self.assertGreater(cycles, 100)

    def test_corrupt_cache(self):
        self.assertEqual(self.run_scenario(MUJOCO).returncode, 0)
        cached = [p for p in (self.folder / "cache").rglob("*") if p.is_file()]
        self.assertTrue(cached)
        for path in cached:
            content = bytearray(path.read_bytes())
            content[len(content) // 2] ^= 0xFF
            path.write_bytes(content)
        done = self.run_scenario(MUJOCO)
        self.assertEqual(done.returncode, 0, done.stderr)
        [note] = done.stderr.splitlines()
        self.assertIn(f"note: {cached[0]}: the compiled model that was kept is damaged", note)
        self.assertNotIn("--", note)
        done = self.run_scenario(MUJOCO)  # it is whole again
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_cache_that_cannot_be_written(self):
        self.environment["XDG_CACHE_HOME"] = str(self.scenario())  # a file
        for _ in range(2):
            done = self.run_scenario(MUJOCO)
            self.assertEqual(done.returncode, 0, done.stderr)
            [note] = done.stderr.splitlines()
            self.assertIn("note: ", note)
            self.assertIn("compiled models cannot be kept there", note)
            self.assertNotIn("--", note)

    def test_log_has_details_and_lines_of_json(self):
        self.assert_refused(self.call("schema", "--log-format", "xml"), 2, "--log-format")
        (self.folder / "cache").write_text("no folder\n")  # of which a note tells
        self.assertEqual(self.run_scenario(SHORT, "-q", "-v").stdout, "")
        done = self.run_scenario(SHORT, "-q", "-v", "--log-format", "json")
        lines = [json.loads(line) for line in done.stderr.splitlines()]
        self.assertEqual({line["level"] for line in lines}, {"debug", "note"})
        self.assertTrue(any(line["message"].startswith("models ") for line in lines), done.stderr)
        for line in lines:
            self.assertRegex(line["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
        done = self.call("validate", "none.yaml", "--log-format", "json")
        self.assertEqual((done.returncode, json.loads(done.stderr)["level"]), (3, "error"))


class EarlyEnd(CliTest):
    def test_a_run_that_fails_before_its_first_motion_leaves_a_summary(self):
        self.assertEqual(self.run_scenario().returncode, 0)
        done = self.run_scenario(SHORT.replace("  command_loss: 0 %", "  state_loss: 100 %"))
        self.assert_error(done, 1, "no robot state arrived within 3 s")
        self.assertEqual(self.files(), {"scenario.yaml", "summary.json"})  # and nothing of the run before
        summary = json.loads((self.out / "summary.json").read_text())
        self.assertEqual((summary["outcome"], summary["scenario"]), ("failed", "short"))
        self.assertIn("no robot state arrived within 3 s", summary["failure"])
        done = self.run_scenario(SHORT, "--backend", "fci", "--robot", "127.0.0.1:9")
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertEqual(json.loads((self.out / "summary.json").read_text())["drive"], "remote")

    def test_under_nohup_a_terminal_may_be_closed(self):
        process = subprocess.Popen(["nohup", cli_test.PROGRAM, *map(str, self.run_arguments(SHORT.replace("1 s", "60 s")))],
                                   cwd=self.folder, env=self.environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True)
        process.stdout.readline()  # the first tenth is done
        process.send_signal(signal.SIGHUP)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, stderr)


if __name__ == "__main__":
    cli_test.PROGRAM, cli_test.SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
