"""Bad logs: a sentence each, and no exception but ValueError and OSError for what is damaged."""

import contextlib
import pickle
import random
import subprocess
import sys
import time
import unittest
import warnings

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin

from panda_twin.identify import Recording, compare
from identify_logs import JOINTS, MAPPING, STORE, LogsCase, arm_topic, bag, joint_state, libfranka_csv, motion, table_csv, whole


class BadLogsTest(LogsCase):
    def test_strange_mappings_are_refused(self):
        random_ = random.Random(5)
        text = "robot: panda\ncolumns:\n  time: {from: t, unit: ms}\n  q: {from: [q1, q2], unit: deg}\n  tau_J: {from: tau}\n"
        file = self.folder / "strange.yaml"
        for _ in range(200):
            strange = list(text)
            for _ in range(random_.choice([1, 4])):
                strange[random_.randrange(len(strange))] = random_.choice("{}[]:,&*!|>%@`'\"#-? \n\tq1é")
            file.write_text("".join(strange))
            with contextlib.suppress(ValueError):
                Recording.open(self.table, file)

    def test_what_is_no_log_is_refused(self):
        here = self.folder
        (here / "empty.csv").write_bytes(b"")
        self.refused("empty.csv is empty", here / "empty.csv")
        (here / "image.csv").write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
        self.refused("is no log but a picture", here / "image.csv")
        (here / "noise.mcap").write_bytes(random.Random(1).randbytes(5000))
        self.refused("noise.mcap is no log", here / "noise.mcap")
        (here / "log.pkl").write_bytes(pickle.dumps({"q": 1}))
        self.refused("is a pickle, and reading one runs whatever code it holds", here / "log.pkl")
        (here / "hidden.npz").write_bytes(pickle.dumps({"q": 1}, protocol=4))
        self.refused("is a pickle", here / "hidden.npz")
        (here / "folder").mkdir()
        self.refused("neither a log of the twin .* nor a bag", here / "folder")
        (here / "old.bag").write_bytes(b"#ROSBAG V2.0\n" + bytes(50))
        self.refused("a bag of ROS 1; convert it", here / "old.bag")
        (here / "log.csv.gz").write_bytes(b"\x1f\x8b" + bytes(50))
        self.refused("compressed .gzip.; unpack it", here / "log.csv.gz")
        self.refused("No such file", here / "none.csv", kind=OSError)
        lines = self.csv.read_text().splitlines()
        (here / "heading.csv").write_text(lines[0] + "\n")
        self.refused("has a heading only, of 87 columns", here / "heading.csv")
        (here / "prose.txt").write_text("Dear robot,\nwhat did you do\nyesterday?\n")
        self.refused("does not have the twin's names.*give a column mapping", here / "prose.txt")
        pq.write_table(pa.table({"t": pa.array([], pa.float64())}), here / "none.parquet")
        self.refused("and no row", here / "none.parquet")

    def test_bad_rows_are_named(self):
        lines = self.csv.read_text().splitlines(keepends=True)
        cells = lines[10].split(",")
        file = self.folder / "bad.csv"

        def with_line(text):
            file.write_text("".join([*lines[:10], text, *lines[11:]]))

        with_line(",".join([*cells[:5], "nan", *cells[6:]]))
        self.refused(r"q\[3\] is nan in row 10; remove the row", file, names=["q"])
        self.assertEqual(len(whole(Recording.open(file), "dq")[0]), 400)
        with_line(",".join([*cells[:5], "oops", *cells[6:]]))
        self.refused(r"column state.q\[3\] has 'oops', which is no number, in row 10", file, names=["q"])
        with_line("17,1\n")
        self.refused("row 10 has 2 values and the heading 87", file)
        with_line(",".join(["17", *cells[1:]]))
        self.refused("message_id goes back in row 10, from 0.008000 to -4.983000 s", file)
        with_line(",".join(["nan", *cells[1:]]))
        self.refused("message_id is nan in row 10", file)
        file.write_text("".join(lines[:-1]) + lines[-1][:100])  # a killed program
        recording = Recording.open(file)
        self.assertEqual(recording.rows, 399)
        self.assertIn("the last row is not whole", recording.notes[-1])

    def test_truncated_files_are_refused_or_said(self):
        m = self.motion
        pq.write_table(pa.table({"t": m["t"]}), self.folder / "cut.parquet")
        for path in (self.npz, self.folder / "cut.parquet", self.bag / "bag.mcap"):
            cut = self.folder / f"half{path.suffix}"
            cut.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
            self.refused("damaged", cut, MAPPING if path.suffix == ".parquet" else None)
        data = (self.folder / "run/run.mcap").read_bytes()
        (self.folder / "half_run.mcap").write_bytes(data[: len(data) // 2])
        recording = Recording.open(self.folder / "half_run.mcap")
        self.assertIn("the run was killed", " ".join(recording.notes))
        self.assertGreater(recording.rows, 100)

    def test_bad_arrays_are_refused(self):
        here, log = self.folder / "bad.npz", self.panda_py()
        np.savez(here, **{**log, "q": log["q"][:-3]})
        self.refused("different lengths: .*q 397 rows", here)
        np.savez(here, **{**log, "q": log["q"].astype(object)})
        self.refused("q holds Python objects, whose reading would run code", here)
        np.savez(here, **{**log, "q": log["q"][:, :3]})
        self.refused("q has 3 of 7 numbers in a row", here)
        np.savez(here, **{**log, "time": log["time"] * 1.0001e-3})
        self.refused("time is not in whole ms", here)
        np.savez(here, **{**log, "q": np.full(log["q"].shape, "x")})
        self.refused("q is of type <U1; numbers are needed", here)
        self.refused("q is no array of numbers", {**log, "q": [[1, 2], [3]]})
        np.savez(here, x=np.zeros(3))
        self.refused("does not have the twin's names", here)

    def test_wrong_units_of_time_are_refused(self):
        for unit, text in (("s", "unit were 0.001 s"), ("us", "unit were 0.001 s")):
            mapping = {"columns": {**MAPPING["columns"], "time": {"from": "t", "unit": unit}}}
            self.refused(f"rises by .* from row to row.*{text}", self.table, mapping)

    def test_bad_mappings_are_refused(self):
        def changed(**columns):
            return {"columns": {**MAPPING["columns"], **columns}}

        for mapping, text in (
            (changed(q={"from": ["q1", "q2", "q3"]}), "has 3 of 7 numbers in a row; all seven joints"),
            (changed(q={"from": "a_"}), "has no column a_"),
            (changed(q=["q1", "q2", "q3", "q4", "q5", "q6", "q8"]), "has no column q8.*did you mean"),
            (changed(q=["q1", "q2", "q3", "q4", "q5", "q6", "q6"]), "names a column twice for q"),
            (changed(q={"from": "q", "unit": "grad"}), "q has unit grad; it must be one of rad, deg"),
            (changed(tau_j="tau"), "tau_j is no column of the twin; did you mean tau_J"),
            (changed(q={"form": "q"}), "q has a key form"),
            (changed(q={"from": 3.5}), "q comes from 3.5"),
            (changed(time="t"), "time has no unit"),
            (changed(fate="t"), "fate is of texts"),
            ({"columns": {"q": "q"}}, "names neither time nor message_id"),
            ({"columns": {"time": {"from": "t", "unit": "s"}}}, "names no column but the time"),
            ({"columns": [1]}, "must have a section 'columns'"),
            ({**MAPPING, "robot": "iiwa"}, "robot is iiwa; the twin is a Panda"),
            ({**MAPPING, "colums": 1}, "colums is not one of"),
        ):
            with self.subTest(text=text):
                self.refused(text, self.table, mapping)
        file = self.folder / "bad.yaml"
        file.write_text("columns: [")
        self.refused("bad.yaml is not YAML", self.table, file)
        self.refused("is a log of the twin, whose columns are known", self.folder / "run", MAPPING)
        self.refused("is a bag of ROS 2, whose columns are known", self.bag, MAPPING)

    def test_bags_of_other_robots_are_refused(self):
        def topic(names, n=None):
            q = np.zeros(len(names))
            return {
                "/joint_states": (
                    "sensor_msgs/msg/JointState",
                    [(k * 10**6, joint_state(k * 10**6, q, names=names)) for k in range(3)],
                )
            }

        for k, (names, text) in enumerate((
            (["shoulder_pan_joint", "elbow_joint", *(f"wrist_{i}_joint" for i in (1, 2, 3))], "no joints of a Panda"),
            ([f"iiwa_joint_{i}" for i in range(1, 8)], "no joints of a Panda"),
            (JOINTS[:3], "3 of the 7 joints of a Panda"),
            ([f"{side}_joint{i}" for side in ("left", "right") for i in range(1, 8)], "joints of 2 arms"),
            (["panda_finger_joint1", "panda_finger_joint2"], "no joint positions of a Panda"),
        )):  # fmt: skip
            with self.subTest(text=text):
                self.refused(text, bag(self.folder / f"other{k}", topic(names)))
        string = STORE.types["std_msgs/msg/String"]
        self.refused(
            "its topics are /chatter", bag(self.folder / "chatter", {"/chatter": ("std_msgs/msg/String", [(1, string("x"))])})
        )

    def test_tables_of_other_robots_are_refused_or_said(self):
        for name in ("fr3_joint", "iiwa_joint_"):
            file = self.folder / "robot.csv"
            file.write_text(self.table.read_text().replace(",q", f",{name}", 7))
            mapping = {"columns": {**MAPPING["columns"], "q": {"from": name, "unit": "deg"}}}
            if name == "fr3_joint":
                self.assertIn("Franka Research 3", " ".join(Recording.open(file, mapping).notes))
            else:
                self.refused("column iiwa_joint_1 is named after another robot", file, mapping)
        self.refused("q has 6 of 7 numbers", {**self.panda_py(), "q": self.motion["q"][:, :6]})
        self.refused("it has no row", {**self.panda_py(), "q": []})

    def test_a_twin_with_dynamics_of_its_own_is_refused(self):
        way = [{"q": [0, -0.8, 0, -2.4, 0, 1.6, 0.8]}, {"q": [0.2, -0.8, 0, -2.4, 0, 1.6, 0.8]}]
        fr3 = {"name": "a", "robot": {"model": "fr3"}, "motion": {"trajectory": {"unit": "rad", "duration": "2 s", "waypoints": way}}}
        with self.assertRaisesRegex(ValueError, "robot.model is fr3: .* the Panda's dynamics only"):
            compare(self.table, mapping=MAPPING, against=fr3)

    def test_a_bag_without_metadata_and_mcap_of_others(self):
        cut = bag(self.folder / "cut_short", {"/joint_states": arm_topic(self.motion)}, StoragePlugin.SQLITE3)
        (cut / "metadata.yaml").unlink()
        self.same(Recording.open(cut), "q", "tau_J")
        with open(self.folder / "other.mcap", "wb") as out:
            writer = McapWriter(out)
            writer.start(profile="", library="another")
            writer.finish()
        self.refused("other.mcap", self.folder / "other.mcap")

    def test_a_sparse_file_of_10_gb_is_refused_at_once(self):
        file = self.folder / "huge.csv"
        for begin, text in (
            (b"", "bytes that no text has"),
            (self.csv.read_bytes(), "after row 400|row 401 has|no number|no CSV"),
        ):
            with open(file, "wb") as out:
                out.write(begin)
                out.truncate(10 << 30)
            before = time.monotonic()
            self.refused(text, file)
            self.assertLess(time.monotonic() - before, 5)
        file.unlink()

    def test_missing_packages_are_named(self):
        for package, path, mapping in (
            ("pyarrow", self.csv, None),
            ("rosbags", self.bag, None),
            ("ruamel.yaml", self.table, "m.yaml"),
        ):
            opened = f"from panda_twin.identify import Recording; Recording.open({str(path)!r}, {mapping!r})"
            code = f"import sys; sys.modules[{package!r}] = None; {opened}"
            done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
            self.assertRegex(done.stderr.splitlines()[-1], r"^ImportError: .* pip install 'panda-twin\[(identify|ros)\]'")

    def test_damaged_files_are_read_or_refused(self):
        """200 of each kind; anything but ValueError and OSError is a bug."""
        random_ = random.Random(24)
        small = motion(60)
        bag(self.folder / "small", {"/joint_states": arm_topic(small)})
        bag(self.folder / "small3", {"/joint_states": arm_topic(small)}, StoragePlugin.SQLITE3)
        np.savez(self.folder / "small.npz", t=small["t"], q=small["q"], dq=small["dq"], tau=small["tau"])
        pq.write_table(
            pa.table({"t": 1e3 * small["t"], **{f"{n}{i + 1}": small[n][:, i] for n in ("q", "dq", "tau") for i in range(7)}}),
            self.folder / "small.parquet",
        )
        kinds = {
            "own.mcap": ((self.folder / "run/run.mcap").read_bytes()[:200_000], None),
            "franka.csv": (libfranka_csv(self.folder / "small.csv", small).read_bytes(), None),
            "table.csv": (table_csv(self.folder / "small_t.csv", small, ";", "utf-16").read_bytes(), MAPPING),
            "log.npz": (
                (self.folder / "small.npz").read_bytes(),
                {"columns": {"time": {"from": "t", "unit": "s"}, "q": "q", "tau_J": "tau"}},
            ),
            "log.parquet": ((self.folder / "small.parquet").read_bytes(), MAPPING),
            "bag.mcap": ((self.folder / "small/small.mcap").read_bytes(), None),
            "bag.db3": ((self.folder / "small3/small3.db3").read_bytes(), None),
        }
        whole_ = 0
        for name, (data, mapping) in kinds.items():
            path = self.folder / f"damaged_{name}"
            for k in range(200):
                content = bytearray(data)
                for _ in range(random_.choice([1, 3, 30])):
                    content[random_.randrange(len(content) if k % 2 else min(len(content), 2000))] = random_.randrange(256)
                if k % 5 == 0:
                    del content[random_.randrange(len(content)) :]
                path.write_bytes(content)
                with self.subTest(name=name, k=k), contextlib.suppress(ValueError, OSError), warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    for _ in Recording.open(path, mapping).blocks(seconds=0.02):
                        pass
                    whole_ += 1
        self.assertGreater(whole_, 50)


if __name__ == "__main__":
    unittest.main()
