"""Logs as columns: what the program's log has, without copies, and what other programs' logs have."""

import gc
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np
import pandas
import polars
import pyarrow
import pyarrow.parquet

import panda_twin
from panda_twin import Log, parquet

SOURCE = pathlib.Path(__file__).parents[2]
PROGRAM = pathlib.Path(panda_twin._core.__file__).resolve().parents[2] / "panda-twin"


class Logs(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.out = cls.folder / "out"
        subprocess.run(
            [PROGRAM, "run", SOURCE / "models/scenarios/smoke.yaml", "--out", cls.out, "--no-video"],
            check=True, capture_output=True, text=True,
        )
        cls.path = cls.out / "run.mcap"
        cls.csv = cls.folder / "csv"
        subprocess.run([PROGRAM, "export", cls.path, "--out", cls.csv], check=True, capture_output=True)

    def setUp(self):
        self.log = Log(self.out)

    def export(self, *arguments):
        return subprocess.run([PROGRAM, "export", *arguments], capture_output=True, text=True)

    def test_columns_share_the_memory_of_their_owner(self):
        q = self.log.cycles["q"]
        self.assertEqual((q.ndim, q.shape[1], q.dtype), (2, 7, np.float64))
        self.assertEqual(self.log.cycles["O_T_EE"].shape[1], 16)
        self.assertEqual(self.log.cycles["K_F_ext_hat_K"].shape[1], 6)
        self.assertTrue(np.shares_memory(q, self.log.cycles["q"]))
        self.assertFalse(q.flags.owndata)
        with self.assertRaises(ValueError):
            q[0, 0] = 1
        before = q.copy()
        del self.log
        self.assertTrue(np.array_equal(q, before))  # kept alive by its owner

    def test_columns_are_those_of_the_csv(self):
        table = polars.read_csv(self.csv / "cycles.csv")  # its defaults get every type right
        self.assertEqual(table["control_command_success_rate"].dtype, polars.Float64)
        self.assertEqual(table.height, len(self.log.cycles))
        for name in ["q", "tau_J", "O_T_EE", "K_F_ext_hat_K"]:
            values = self.log.cycles[name]
            for i in range(values.shape[1]):
                self.assertTrue(np.array_equal(table[f"{name}[{i}]"].to_numpy(), values[:, i]), name)
        self.assertTrue(np.array_equal(table["at_ns"].to_numpy(), self.log.cycles["at_ns"]))
        self.assertEqual(table["fate"].to_list(), self.log.cycles["fate"].tolist())
        for file in self.csv.glob("*.csv"):
            self.assertEqual(polars.read_csv(file).height, len(self.log.table(file.stem)), file)

    def test_names_are_texts_and_numbers(self):
        cycles = self.log.cycles
        self.assertEqual(cycles.texts("fate"), ("none", "served", "held"))
        served = cycles["fate"] == "served"
        self.assertGreater(served.sum(), 100)
        self.assertTrue(np.array_equal(cycles.codes("fate") == 1, served))
        with self.assertRaisesRegex(ValueError, "no texts"):
            cycles.codes("q")
        self.assertIn("motion", self.log.events["kind"].tolist())

    def test_times_are_seconds_and_poses_matrices(self):
        cycles, ticks = self.log.cycles, self.log.ticks
        np.testing.assert_allclose(np.diff(cycles.time), 1e-3, atol=1e-12)
        np.testing.assert_allclose(ticks.time, 1e-9 * ticks["read_ns"], rtol=1e-15)
        np.testing.assert_allclose(cycles.poses("O_T_EE"), panda_twin.model.fk(cycles["q"]), atol=1e-6)
        for name in ("q", "fate"):
            with self.assertRaisesRegex(ValueError, f"column {name} has no poses"):
                cycles.poses(name)

    def test_of_a_result_keeps_its_temporary_folder(self):
        cycles = Log(panda_twin.run("scenarios/smoke.yaml")).motions[0].cycles
        gc.collect()
        self.assertEqual(cycles["q"].shape, (len(cycles), 7))

    def test_unknown_columns_name_the_nearest(self):
        with self.assertRaisesRegex(ValueError, "did you mean tau_J"):
            self.log.cycles["tau_j"]
        with self.assertRaisesRegex(ValueError, "choose one of cycles"):
            self.log.table("cycle")

    def test_arrow_polars_and_pandas_have_all_columns(self):
        cycles = self.log.cycles
        arrow = pyarrow.table(cycles)
        arrow.validate(full=True)
        self.assertEqual(tuple(arrow.column_names), cycles.names)
        self.assertEqual(arrow.schema.field("q").type, pyarrow.list_(pyarrow.float64(), 7))
        self.assertTrue(np.shares_memory(arrow["q"].chunk(0).flatten().to_numpy(), cycles["q"]))
        self.assertEqual(arrow["fate"].to_pylist(), cycles["fate"].tolist())
        frame = cycles.to_polars("q", "fate")
        self.assertEqual(frame.columns, ["fate", "q"])
        self.assertTrue(np.array_equal(frame["q"].to_numpy(), cycles["q"]))
        self.assertEqual(frame["fate"].cast(polars.String).to_list(), cycles["fate"].tolist())
        table = cycles.to_pandas()
        self.assertTrue(np.array_equal(table["q[3]"], cycles["q"][:, 3]))
        self.assertEqual(table["fate"].tolist(), cycles["fate"].tolist())
        self.assertIsInstance(table["fate"].dtype, pandas.CategoricalDtype)
        ticks = self.log.ticks.to_arrow()
        ticks.validate(full=True)
        self.assertEqual(ticks["stalled"].to_pylist(), self.log.ticks["stalled"].tolist())

    def test_a_part_has_its_rows_and_arrow_of_them(self):
        part = self.log.between(0.1, 0.2)
        times = part.cycles["at_ns"]
        whole = self.log.cycles["at_ns"]
        expected = (whole >= 100_000_000) & (whole < 200_000_000)
        self.assertTrue(np.array_equal(times, whole[expected]))
        self.assertTrue(np.array_equal(part.cycles["q"], self.log.cycles["q"][expected]))
        self.assertEqual(part.between(0.15, 9).cycles.to_arrow("q").num_rows, int((times >= 150_000_000).sum()))
        self.assertEqual(len(self.log.between(1e5, 2e5).cycles), 0)
        with self.assertRaisesRegex(ValueError, "t0 <= t1"):
            self.log.between(2, 1)

    def test_motions_are_the_cycles_that_are_not_idle(self):
        motions = self.log.motions
        modes = self.log.cycles["motion_generator_mode"]
        self.assertGreaterEqual(len(motions), 1)
        self.assertEqual(sum(len(motion.cycles) for motion in motions), int((modes != "idle").sum()))
        self.assertNotIn("idle", motions[0].cycles["motion_generator_mode"])

    def test_says_of_its_run(self):
        meta = self.log.meta
        self.assertEqual((meta.drive, meta.truncated), ("lockstep", False))
        self.assertIn(f'name: "{meta.scenario}"', self.log.scenario)
        self.assertGreater(meta.last, meta.first)

    def test_large_logs_are_read_by_column(self):
        cycles = Log(self.path, threads=2).cycles
        cycles._source.is_small = lambda from_ns, until_ns: False
        for name in ["q", "at_ns", "fate"]:
            self.assertTrue(np.array_equal(cycles[name], self.log.cycles[name]))
        self.assertEqual(sorted(cycles._loaded.names), ["at_ns", "fate", "q"])
        self.assertTrue(cycles.to_arrow().equals(self.log.cycles.to_arrow()))

    def test_npz_has_the_same_arrays(self):
        done = self.export(self.path, "--format", "npz", "--out", self.folder / "npz")
        self.assertEqual(done.returncode, 0, done.stderr)
        with np.load(self.folder / "npz" / "cycles.npz") as arrays:
            for name in ["q", "O_T_EE", "at_ns", "message_id", "lost_in_row"]:
                self.assertTrue(np.array_equal(arrays[name], self.log.cycles[name]), name)
                self.assertEqual(arrays[name].dtype, self.log.cycles[name].dtype)
            self.assertEqual(arrays["fate.names"][arrays["fate"]].tolist(), self.log.cycles["fate"].tolist())
        with np.load(self.folder / "npz" / "events.npz") as arrays:
            self.assertEqual(arrays["text.names"][arrays["text"]].tolist(), self.log.events["text"].tolist())

    def test_export_writes_the_columns_that_are_named(self):
        out = self.folder / "some"
        self.assertEqual(self.export(self.path, "--columns", "q,fate,q_c", "--out", out).returncode, 0)
        self.assertEqual(sorted(file.name for file in out.iterdir()), ["cycles.csv", "plans.csv", "ticks.csv"]
                         if len(self.log.table("plans")) else ["cycles.csv", "ticks.csv"])
        self.assertEqual(polars.read_csv(out / "cycles.csv").columns, ["at_ns", "fate", *(f"q[{i}]" for i in range(7))])
        done = self.export(self.path, "--columns", "tau_j", "--out", out)
        self.assertEqual(done.returncode, 3)
        self.assertIn("did you mean tau_J?", done.stderr)

    def test_parquet_reads_back(self):
        out = self.folder / "parquet"
        with unittest.mock.patch.dict(os.environ, PANDA_TWIN_PYTHON=sys.executable):
            done = self.export(self.path, "--format", "parquet", "--out", out, "--columns", "q,fate")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        table = pyarrow.parquet.read_table(out / "cycles.parquet")
        self.assertEqual(table.column_names, ["at_ns", "fate", "q"])
        self.assertTrue(np.array_equal(table["q"].combine_chunks().flatten().to_numpy(), self.log.cycles["q"].ravel()))
        self.assertEqual(table["fate"].to_pylist(), self.log.cycles["fate"].tolist())
        with self.assertRaisesRegex(ValueError, "did you mean tau_J"):
            parquet.write(self.log, out, ("tau_j",))

    def test_csv_reads_back(self):
        log = Log.from_csv(self.csv)
        self.assertEqual(log.cycles.names, self.log.cycles.names)
        for name in log.cycles.names:
            self.assertTrue(np.array_equal(log.cycles[name], self.log.cycles[name]), name)
        for name in log.ticks.names:
            same = np.array_equal(log.ticks[name], self.log.ticks[name], equal_nan=name == "margin")
            self.assertTrue(same, name)
        one = Log.from_csv(self.csv / "events.csv")
        self.assertEqual(one.events["text"].tolist(), self.log.events["text"].tolist())
        self.assertEqual(len(one.cycles), 0)
        self.assertEqual(len(log.between(0.1, 0.2).cycles), len(self.log.between(0.1, 0.2).cycles))
        with self.assertRaisesRegex(ValueError, "nothing to draw"):
            log.picture(0)

    def test_takes_the_log_of_panda_py(self):
        # As Panda.get_log() of panda_py: lists of vectors, milliseconds.
        n = 5
        given = {
            name: [np.full(size, k + 0.5) for k in range(n)]
            for name, size in [("q", 7), ("dq", 7), ("tau_J", 7), ("O_T_EE", 16), ("elbow", 2), ("K_F_ext_hat_K", 6),
                               ("O_F_ext_hat_K", 6), ("tau_ext_hat_filtered", 7), ("control_command_success_rate", 1)]
        }
        given["time"] = [np.array([100.0 + k]) for k in range(n)]
        log = Log.from_panda_py(given)
        self.assertEqual(log.cycles["q"].tolist(), [[k + 0.5] * 7 for k in range(n)])
        self.assertEqual(log.cycles["control_command_success_rate"].shape, (n,))
        self.assertEqual(log.cycles["at_ns"].tolist(), [(100 + k) * 10**6 for k in range(n)])
        self.assertEqual(len(log.between(0.101, 0.103).cycles), 2)
        with self.assertRaisesRegex(ValueError, "no column dddq_d in its cycles"):
            log.cycles["dddq_d"]
        with self.assertRaisesRegex(ValueError, "no 'time'"):
            Log.from_panda_py({"q": []})
        with self.assertRaisesRegex(ValueError, "q has shape"):
            Log.from_panda_py({"time": given["time"], "q": [[1.0]] * n})
        with self.assertRaisesRegex(ValueError, "time goes back in row 1"):
            Log.from_panda_py({"time": [[2.0], [1.0]]})

    def test_takes_the_csv_of_libfranka(self):
        # The heading of libfranka 0.9.2, with its spaces.
        groups = [("state.q", 7), ("state.q_d", 7), ("state.dq", 7), ("state.dq_d", 7), ("state.tau_J", 7),
                  ("state.tau_ext_hat_filtered", 7), ("cmd.q_d", 7), ("cmd.dq_d", 7), ("cmd.O_T_EE_d", 16),
                  ("cmd.O_dP_EE_d", 6), ("cmd.tau_J_d", 7)]
        heading = "time, success_rate, " + ",".join(
            ", ".join(f"{name}[{i}]" for i in range(size)) for name, size in groups
        )
        width = sum(size for _, size in groups)
        file = self.folder / "franka.csv"
        file.write_text(heading + "\n" + "\n".join(
            ",".join([str(10 + k), "0.99", *(str(k + i / 8) for i in range(width))]) for k in range(3)
        ) + "\n")
        log = Log.from_libfranka_csv(file)
        self.assertEqual(log.cycles["q"][2].tolist(), [2 + i / 8 for i in range(7)])
        self.assertEqual(log.ticks["q_c"][1].tolist(), [1 + (42 + i) / 8 for i in range(7)])
        self.assertEqual(log.ticks["tau_J_d"][0, 6], (width - 1) / 8)
        self.assertEqual(log.cycles["at_ns"].tolist(), [10**7, 11 * 10**6, 12 * 10**6])
        with self.assertRaisesRegex(ValueError, "is no log of libfranka"):
            Log.from_libfranka_csv(self.csv / "cycles.csv")
        file.write_text(heading + "\n1,2\n")
        with self.assertRaisesRegex(ValueError, "record 2 has 2 values"):
            Log.from_libfranka_csv(file)

    def test_refuses_what_is_no_log(self):
        file = self.folder / "no.mcap"
        file.write_bytes(b"not a log")
        with self.assertRaisesRegex(ValueError, "no.mcap is not an MCAP file"):
            Log(file)
        with self.assertRaisesRegex(ValueError, "cannot read"):
            Log(self.folder / "nope.mcap")
        data = self.path.read_bytes()
        file.write_bytes(data[: len(data) // 2])
        cut = Log(file)
        self.assertTrue(cut.meta.truncated)
        self.assertTrue(np.array_equal(cut.cycles["q"], self.log.cycles["q"][: len(cut.cycles)]))
        self.assertGreater(len(cut.cycles), 0)
        file.write_bytes(data[: len(data) // 2] + bytes([data[len(data) // 2] ^ 1]) + data[len(data) // 2 + 1 :])
        with self.assertRaisesRegex(ValueError, "no.mcap"):
            Log(file).cycles["q"]

    def test_draws_the_run(self):
        picture = self.log.picture(0.3, size=(160, 120))
        self.assertEqual((picture.shape, picture.dtype), ((120, 160, 3), np.uint8))
        self.assertGreater(picture.std(), 5)
        self.assertFalse(picture.flags.writeable)
        frames = list(self.log.between(0.1, 0.3).frames(10, size=(160, 120)))
        self.assertEqual(len(frames), 2)
        self.assertTrue(np.array_equal(frames[0], self.log.picture(0.1, size=(160, 120))))
        self.assertFalse(np.array_equal(picture, self.log.picture(0.3, camera="gripper", size=(160, 120))))
        with self.assertRaisesRegex(ValueError, "no_such"):
            self.log.picture(0, camera="no_such")

    def test_the_program_describes_all_columns(self):
        described = self.export("--describe").stdout
        for name in ["cycles", "ticks", "events", "contacts", "config", "base", "accelerometers", "pushes", "scenes", "plans"]:
            self.assertIn(f"\n## {name}\n", described)
            for column in self.log.table(name).names:
                self.assertIn(f"\n| `{column}` | ", described)
        page = (SOURCE / "docs/reference/logs.md").read_text()
        self.assertIn("<!-- output: panda-twin export --describe -->", page)


if __name__ == "__main__":
    unittest.main()
