"""Sweeps from Python: plan, run and merge as the program does them, Parquet, and what is refused. sweep_engines_test.py has engines and stores."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import pyarrow.parquet

from panda_twin import _host, sweep

SWEEP = """name: losses
scenario: smoke.yaml
axes:
  - {key: link.command_loss, values: [0 %, 80 %]}
  - {key: onboard.abort_after_lost, values: [10, 20]}
seeds: 3
"""


class SweepTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.file = self.folder / "s.yaml"
        self.file.write_text(SWEEP)

    def program(self, *words):
        environment = {**os.environ, "PANDA_TWIN_PYTHON": sys.executable}
        return subprocess.run([_host.executable, "sweep", *words], capture_output=True, text=True, cwd=self.folder, timeout=300, env=environment)

    def test_plan(self):
        plan = sweep.plan(self.file)
        self.assertEqual((plan.points, plan.runs), (4, 12))
        self.assertIn("link.command_loss", plan.text)

    def test_two_shards_give_what_the_program_gives(self):
        self.program("run", self.file, "--out", "there", "-q")
        there = self.program("merge", self.file, "--out", "there").stdout
        for shard in ("1/2", "0/2"):
            sweep.run(self.file, self.folder / "here", shard=shard, jobs=1)
        merged = sweep.merge(self.file, self.folder / "here")
        self.assertIn(f"digest  {merged.digest}\n", there)
        self.assertEqual((merged.runs, merged.failures, merged.out), (12, 6, str(self.folder / "here")))
        self.assertEqual((self.folder / "here/runs.csv").read_bytes(), (self.folder / "there/runs.csv").read_bytes())

    def test_parquet_has_the_rows_of_the_csv_with_their_types(self):
        sweep.run(self.file, self.folder / "out")
        done = self.program("merge", self.file, "--out", "out", "--parquet")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn(f"digest  {sweep.merge(self.file, self.folder / 'out').digest}\n", done.stdout)
        table = pyarrow.parquet.read_table(self.folder / "out/runs.parquet")
        self.assertEqual(table.num_rows, 12)
        rows = table.to_pylist()
        self.assertEqual((rows[0]["point"], rows[0]["seed"], rows[0]["link.command_loss"]), (1, 1, "0 %"))
        self.assertEqual({row["outcome"] for row in rows}, {"success", "aborted"})
        self.assertTrue(all(len(row["states_hash"]) == 16 and isinstance(row["duration_s"], float) for row in rows))

    def test_runs_that_are_missing(self):
        sweep.run(self.file, self.folder / "out", shard="0/2")
        with self.assertRaisesRegex(RuntimeError, "^6 of 12 runs are missing in .*/out, the first: point 1 "):
            sweep.merge(self.file, self.folder / "out")

    def test_a_demand_that_is_missed_leaves_the_report(self):
        self.file.write_text(SWEEP + "demand: {success: 95 %}\n")
        sweep.run(self.file, self.folder / "out")
        with self.assertRaisesRegex(RuntimeError, "^50.00 % of the runs succeeded; 95 % are demanded"):
            sweep.merge(self.file, self.folder / "out")
        for name in ("report.html", "runs.parquet"):
            self.assertTrue((self.folder / "out" / name).exists(), name)

    def test_what_is_refused(self):
        with self.assertRaisesRegex(ValueError, "none.yaml: No such file"):
            sweep.plan(self.folder / "none.yaml")
        with self.assertRaisesRegex(ValueError, 'shard "2/2": must be'):
            sweep.run(self.file, self.folder / "out", shard="2/2")
        with self.assertRaisesRegex(ValueError, '--on "slurm": must be ray, or'):
            sweep.run(self.file, self.folder / "out", on="slurm")
        with self.assertRaisesRegex(ValueError, "leave shard and jobs out"):
            sweep.run(self.file, self.folder / "out", on="ray", jobs=1)
        with self.assertRaisesRegex(ValueError, "shards is for on"):
            sweep.run(self.file, self.folder / "out", shards=3)
        with self.assertRaisesRegex(ValueError, "^s4://bucket/losses: "):
            sweep.run(self.file, "s4://bucket/losses")
        with self.assertRaisesRegex(OSError, "/proc/sweep"):
            sweep.run(self.file, "/proc/sweep")
        self.file.write_text(SWEEP.replace("80 %", "200 %"))
        with self.assertRaisesRegex(ValueError, r"^point 3 \(link.command_loss: 200 %"):
            sweep.run(self.file, self.folder / "out")


if __name__ == "__main__":
    unittest.main()
