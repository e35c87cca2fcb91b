"""Logs of robots and programs as `Recording`: each format, its times, and what is refused or suspected."""

import contextlib
import pathlib
import pickle
import random
import subprocess
import sys
import tempfile
import time
import unittest
import warnings

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.interfaces import Nodetype
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

import panda_twin as pt
from panda_twin import model
from panda_twin.identify import Block, Recording, suspicions

SOURCE = pathlib.Path(__file__).parents[2]
STORE = get_typestore(Stores.ROS2_JAZZY)
MESSAGES = SOURCE / "tests/ros2/interfaces/franka_msgs/msg"
STORE.register({key: value for name in ("CollisionIndicators", "Elbow", "Errors", "FrankaRobotState")
                for key, value in get_types_from_msg((MESSAGES / f"{name}.msg").read_text(), f"franka_msgs/msg/{name}").items()})
# The older layout, of arrays; shortened.
STORE.register(get_types_from_msg("std_msgs/Header header\nfloat64[7] q\nfloat64[7] dq\nfloat64[7] tau_j\nfloat64[6] o_f_ext_hat_k\nfloat64[16] o_t_ee\nfloat64 time\n",
                                  "franka_msgs/msg/FrankaState"))
MAPPING = {"columns": {"time": {"from": "t", "unit": "ms"}, "q": {"from": "q", "unit": "deg"}, "dq": "dq", "tau_J": "tau"}}
JOINTS = [f"panda_joint{i}" for i in range(1, 8)]


def motion(n=400):
    """A motion with the torques that it takes: dict of arrays, times in s."""
    t = np.arange(n) * 1e-3
    a, w = np.array([0.5, 0.3, 0.4, 0.4, 0.5, 0.4, 0.6]), 2 * np.array([1.1, 0.9, 1.3, 0.8, 1.7, 1.2, 2.1])
    q = model.Q_READY + a * np.sin(w * t[:, None])
    dq, ddq = a * w * np.cos(w * t[:, None]), -a * w * w * np.sin(w * t[:, None])
    tau = model.gravity(q) + model.coriolis(q, dq) + np.einsum("nij,nj->ni", model.mass(q), ddq)
    return {"t": t, "q": q, "dq": dq, "tau": tau}


def names_of(column, n=7):
    return [f"{column}[{i}]" for i in range(n)]


def libfranka_csv(file, m, ids=None):
    """As logToCSV() of libfranka 0.9.2 writes."""
    zero = 0 * m["q"]
    groups = [("state.q", m["q"]), ("state.q_d", m["q"]), ("state.dq", m["dq"]), ("state.dq_d", m["dq"]), ("state.tau_J", m["tau"]),
              ("state.tau_ext_hat_filtered", zero), ("cmd.q_d", m["q"]), ("cmd.dq_d", zero), ("cmd.O_T_EE_d", np.zeros((len(zero), 16))),
              ("cmd.O_dP_EE_d", np.zeros((len(zero), 6))), ("cmd.tau_J_d", zero)]
    ids = np.arange(len(zero)) + 5000 if ids is None else ids
    rows = np.hstack([values for _, values in groups])
    heading = "time, success_rate, " + ",".join(", ".join(names_of(name, values.shape[1])) for name, values in groups)
    file.write_text(heading + "\n" + "".join(f"{k},0.98,{','.join(map(repr, row))}\n" for k, row in zip(ids.tolist(), rows.tolist())))
    return file


def table_csv(file, m, separator=",", encoding="utf-8", decimal="."):
    names = ["t", *(f"{name}{i}" for name in ("q", "dq", "tau") for i in range(1, 8))]
    rows = np.hstack([1e3 * m["t"][:, None], np.degrees(m["q"]), m["dq"], m["tau"]])
    lines = [separator.join(names), *(separator.join(map(repr, row)).replace(".", decimal) for row in rows.tolist())]
    file.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return file


def blank(name):
    """A message of zeros."""
    values = []
    for _, (kind, detail) in STORE.fielddefs[name][1]:
        if kind == Nodetype.BASE:
            values.append({"string": "", "bool": False}.get(detail[0], 0))
        elif kind == Nodetype.NAME:
            values.append(blank(detail))
        elif kind == Nodetype.ARRAY:
            values.append(np.zeros(detail[1]))
        else:
            values.append([] if detail[0][1][0] == "string" else np.empty(0))
    return STORE.types[name](*values)


def put(message, **values):
    for key, value in values.items():
        object.__setattr__(message, key, value)
    return message


def header(ns, frame=""):
    return STORE.types["std_msgs/msg/Header"](STORE.types["builtin_interfaces/msg/Time"](ns // 10**9, ns % 10**9), frame)


def joint_state(ns, q, dq=(), tau=(), names=None):
    make = STORE.types["sensor_msgs/msg/JointState"]
    return make(header(ns), JOINTS if names is None else names, *(np.ascontiguousarray(x, float) for x in (q, dq, tau)))


def bag(folder, topics, plugin=StoragePlugin.MCAP):
    """`topics`: name: (type, [(ns, message)])."""
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        sent = []
        for topic, (kind, messages) in topics.items():
            connection = writer.add_connection(topic, kind, typestore=STORE)
            sent += [(ns, connection, kind, message) for ns, message in messages]
        for ns, connection, kind, message in sorted(sent, key=lambda one: one[0]):
            writer.write(connection, ns, STORE.serialize_cdr(message, kind))
    return folder


EPOCH = 1_700_000_000 * 10**9


def arm_topic(m, names=None):
    rows = zip((EPOCH + np.rint(1e9 * m["t"]).astype(int)).tolist(), m["q"], m["dq"], m["tau"])
    return "sensor_msgs/msg/JointState", [(ns, joint_state(ns, *row, names=names)) for ns, *row in rows]


def whole(recording, *names, **options):
    blocks = list(recording.blocks(*names, **options))
    return np.concatenate([b.t for b in blocks]), *(np.concatenate([b.columns[name] for b in blocks]) for name in names)


class RecordingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.motion = motion()
        cls.run_ = pt.run("scenarios/smoke.yaml", out=cls.folder / "run", video=False, plots=False)
        cls.csv = libfranka_csv(cls.folder / "franka.csv", cls.motion)
        cls.table = table_csv(cls.folder / "table.csv", cls.motion)
        cls.npz = cls.folder / "panda_py.npz"
        np.savez(cls.npz, **cls.panda_py())
        cls.bag = bag(cls.folder / "bag", {"/joint_states": arm_topic(cls.motion)})

    @classmethod
    def panda_py(cls):
        m = cls.motion
        return {"time": 1e3 + 1e3 * m["t"][:, None].round(3), "q": m["q"], "dq": m["dq"], "tau_J": m["tau"], "O_T_EE": np.tile(np.eye(4).ravel(), (len(m["t"]), 1))}

    def refused(self, text, path, mapping=None, kind=ValueError, names=()):
        with self.assertRaisesRegex(kind, text) as caught:
            for _ in Recording.open(path, mapping).blocks(*names):
                pass
        said = str(caught.exception)
        self.assertNotIn("\n", said)
        self.assertLess(len(said), 700)

    def same(self, recording, *names):
        self.assertEqual(recording.rows, len(self.motion["t"]))
        t, *values = whole(recording, *names)
        np.testing.assert_allclose(t, self.motion["t"], atol=3e-7)
        for name, value in zip(names, values):
            np.testing.assert_allclose(value, self.motion[{"tau_J": "tau"}.get(name, name)], rtol=1e-12, atol=1e-12, err_msg=name)

    # --- formats

    def test_own_log_has_its_commands_and_scenario(self):
        for path in (self.folder / "run", self.folder / "run/run.mcap"):
            recording = Recording.open(path)
            log = pt.Log(path)
            self.assertEqual((recording.kind, recording.by_id, recording.rows), ("panda-twin", True, len(log.cycles)))
            self.assertEqual(recording.scenario.name, "smoke")
            t, q, q_d, q_c, fate = whole(recording, "q", "q_d", "q_c", "fate")
            np.testing.assert_array_equal(q, log.cycles["q"])
            self.assertEqual(fate.tolist(), log.cycles["fate"].tolist())
            served = (fate == "served") & np.isfinite(q_c[:, 0])
            self.assertGreater(served.sum(), 1000)
            np.testing.assert_allclose(q_c[served], q_d[served], atol=1e-12)  # the row's command is the one that its state shows
            self.assertEqual(recording.sha256, Recording.open(self.folder / "run/run.mcap").sha256)
            self.assertIn("tau_J_c", dict(recording.missing))
            self.assertGreater(recording.timing.success[1][100], 1000)

    def test_libfranka_csv(self):
        recording = Recording.open(self.csv)
        self.assertEqual((recording.kind, recording.by_id), ("libfranka", True))
        self.same(recording, "q", "dq", "tau_J")
        self.assertLessEqual({"q_c", "q_d", "message_id", "control_command_success_rate"}, recording.columns)
        self.assertNotIn("tau_J_c", recording.columns)  # zero throughout
        self.assertIn("tau_J_d", dict(recording.missing))
        self.assertEqual(recording.head(0.01, "message_id").columns["message_id"].tolist(), list(range(5000, 5010)))

    def test_panda_py_as_file_and_dict(self):
        for given in (self.npz, self.panda_py(), {key: list(values) for key, values in self.panda_py().items()}):
            recording = Recording.open(given)
            self.assertEqual((recording.kind, recording.by_id), ("panda-py", True))
            self.same(recording, "q", "dq", "tau_J")
        compressed = self.folder / "compressed.npz"
        np.savez_compressed(compressed, **{key: np.asfortranarray(values) for key, values in self.panda_py().items()})
        self.same(Recording.open(compressed), "q", "tau_J")

    def test_tables_by_a_mapping(self):
        self.same(Recording.open(self.table, MAPPING), "q", "dq", "tau_J")
        file = self.folder / "map.yaml"
        file.write_text("robot: panda\ncolumns:\n  time: {from: t, unit: ms}\n  q: {from: [q1, q2, q3, q4, q5, q6, q7], unit: deg}\n  dq: dq\n  tau_J: {from: tau, unit: Nm}\n")
        self.same(Recording.open(self.table, file), "q", "dq", "tau_J")
        m = self.motion
        lists = pa.FixedSizeListArray.from_arrays(pa.array(np.degrees(m["q"]).ravel()), 7)
        ragged = pa.array([row.tolist() for row in m["tau"]])
        flat = {f"dq_{i}": m["dq"][:, i] for i in range(7)}
        pq.write_table(pa.table({"t": pa.array(EPOCH + np.rint(1e9 * m["t"]).astype(np.int64)), "q": lists, "tau": ragged, **flat}), self.folder / "t.parquet", row_group_size=150)
        self.same(Recording.open(self.folder / "t.parquet", {"columns": {**MAPPING["columns"], "time": {"from": "t", "unit": "ns"}}}), "q", "dq", "tau_J")
        np.savez(self.folder / "t.npz", t=1e3 * m["t"], q=np.degrees(m["q"]), dq=m["dq"].astype(">f8"), tau=m["tau"])
        self.same(Recording.open(self.folder / "t.npz", MAPPING), "q", "dq", "tau_J")

    def test_csv_of_any_separator_encoding_and_decimal(self):
        for separator, encoding, decimal in ((";", "utf-8-sig", ","), ("\t", "utf-16", "."), (" ", "utf-8", "."), (",", "utf-8-sig", "."), ("|", "latin-1", ".")):
            with self.subTest(separator=separator, encoding=encoding):
                self.same(Recording.open(table_csv(self.folder / "any.csv", self.motion, separator, encoding, decimal), MAPPING), "q", "dq", "tau_J")
        rows = self.table.read_text().splitlines()[1:]
        (self.folder / "bare.csv").write_text("\n".join(rows) + "\n")
        columns = {"time": {"from": 0, "unit": "ms"}, "q": {"from": list(range(1, 8)), "unit": "deg"}, "dq": list(range(8, 15)), "tau_J": list(range(15, 22))}
        self.same(Recording.open(self.folder / "bare.csv", {"columns": columns}), "q", "dq", "tau_J")

    def test_exported_tables_need_no_mapping(self):
        m = self.motion
        np.savez(self.folder / "cycles.npz", at_ns=np.rint(1e9 * m["t"]).astype(np.int64), message_id=1 + np.arange(len(m["t"]), dtype=np.uint64), q=m["q"], dq=m["dq"], tau_J=m["tau"])
        recording = Recording.open(self.folder / "cycles.npz")
        self.assertEqual((recording.kind, recording.by_id), ("table", True))
        self.same(recording, "q", "dq", "tau_J")

    def test_bags_of_joint_states(self):
        self.same(Recording.open(self.bag), "q", "dq", "tau_J")
        self.same(Recording.open(self.bag / "bag.mcap"), "q", "tau_J")
        m = self.motion
        order = [6, 5, 4, 3, 2, 1, 0]
        turned = {**m, **{name: m[name][:, order] for name in ("q", "dq", "tau")}}
        wrench, vector = STORE.types["geometry_msgs/msg/Wrench"], STORE.types["geometry_msgs/msg/Vector3"]
        forces = [(EPOCH + k * 10**7, STORE.types["geometry_msgs/msg/WrenchStamped"](header(EPOCH + k * 10**7, "fr3_link0"), wrench(vector(float(k), 0, 0), vector(0, 0, 0)))) for k in range(40)]
        path = bag(self.folder / "turned", {"/left/joint_states": arm_topic(turned, [f"fr3_joint{i + 1}" for i in order]), "/f": ("geometry_msgs/msg/WrenchStamped", forces)}, StoragePlugin.SQLITE3)
        recording = Recording.open(path)
        self.same(recording, "q", "dq", "tau_J")
        self.assertRegex(" ".join(recording.notes), "Franka Research 3.*|40 messages for 400 rows")
        self.assertEqual(whole(recording, "O_F_ext_hat_K")[1][[0, 10, 11, 200], 0].tolist(), [0, 1, 1, 20])

    def test_bags_of_franka_states_of_both_layouts(self):
        m = self.motion
        for kind in ("FrankaRobotState", "FrankaState"):
            messages = []
            for k, ns in enumerate((EPOCH + np.rint(1e9 * m["t"]).astype(int)).tolist()):
                ns += (k % 3) * 100_000  # stamps jitter; the robot's time does not
                message = put(blank(f"franka_msgs/msg/{kind}"), header=header(ns), time=100 + k * 1e-3)
                if kind == "FrankaState":
                    put(message, q=m["q"][k], dq=m["dq"][k], tau_j=m["tau"][k], o_t_ee=np.arange(16.0))
                else:
                    put(message, measured_joint_state=joint_state(ns, m["q"][k], m["dq"][k], m["tau"][k]), robot_mode=2, control_command_success_rate=1.0)
                    message.current_errors.joint_reflex = k > 300
                    put(message.o_t_ee.pose.position, x=0.5), put(message.o_t_ee.pose.orientation, x=1.0, w=0.0)
                messages.append((ns, message))
            with self.subTest(kind=kind):
                recording = Recording.open(bag(self.folder / kind, {"/robot_state": (f"franka_msgs/msg/{kind}", messages)}))
                self.assertTrue(recording.by_id)
                self.same(recording, "q", "dq", "tau_J")
                pose = whole(recording, "O_T_EE")[1][7]
                if kind == "FrankaState":
                    self.assertEqual(pose.tolist(), list(range(16)))
                    continue
                self.assertEqual(pose.tolist(), [1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0.5, 0, 0, 1])
                _, errors, modes = whole(recording, "errors", "robot_mode")
                self.assertEqual((errors[300], errors[301], modes[0]), ("", "joint_reflex", "Move"))

    # --- blocks and times

    def test_blocks_cover_the_log_once_and_overlap_as_asked(self):
        recording = Recording.open(self.csv)
        blocks = list(recording.blocks("q", seconds=0.15, overlap=0.05))
        self.assertEqual([(round(b.t[0], 3), round(b.t[-1], 3)) for b in blocks], [(0, 0.149), (0.1, 0.249), (0.2, 0.349), (0.3, 0.399)])
        t, q = whole(recording, "q", seconds=0.033)
        np.testing.assert_array_equal(q, self.motion["q"])
        self.assertEqual(recording.head(0.02, "q").columns["q"].shape, (20, 7))
        with self.assertRaisesRegex(ValueError, "overlap is 2"):
            next(recording.blocks("q", seconds=1, overlap=2))
        with self.assertRaisesRegex(ValueError, "has no column tau_J_c"):
            next(recording.blocks("tau_J_c"))

    def test_gaps_repeats_and_lateness_are_counted(self):
        m = motion(400)
        keep = np.delete(np.arange(400), [100, 200, 201, 202, 203, 204, 205, 206, 207])
        keep = np.sort(np.append(keep, [50, 60, 60]))
        part = {name: values[keep] for name, values in m.items()}
        for path, by_id in ((libfranka_csv(self.folder / "gaps.csv", part, keep), True), (table_csv(self.folder / "gaps_t.csv", part), False)):
            recording = Recording.open(path, None if by_id else MAPPING)
            timing = recording.timing
            self.assertEqual((recording.by_id, recording.rows, timing.repeated, timing.lost), (by_id, 391, 3, 9))
            self.assertAlmostEqual(timing.longest, 9, 6)
            self.assertAlmostEqual(timing.longest_at, 0.199, 6)
            self.assertAlmostEqual(timing.median, 1, 6)
            self.assertEqual(timing.intervals[1].sum(), 390)
            self.assertIn("3 rows have the time of the row before", " ".join(recording.notes))
            t, q = whole(recording, "q")
            np.testing.assert_allclose(q, m["q"][np.unique(keep)])
        late = {**m, "t": m["t"] + 0.3e-3 * (np.arange(400) % 40 == 7)}
        self.assertEqual(Recording.open(table_csv(self.folder / "late.csv", late), MAPPING).timing.late, 10)

    def test_held_cycles_are_counted_by_runs(self):
        log = Recording.open(pt.run("scenarios/packet_loss.yaml", out=self.folder / "loss", video=False, plots=False).folder)
        fate = whole(log, "fate")[1]
        edges = np.flatnonzero(np.diff(fate == "held", prepend=False, append=False))
        runs, counts = np.unique(edges[1::2] - edges[::2], return_counts=True)
        self.assertGreater(len(runs), 0)
        self.assertEqual(log.timing.held, dict(zip(runs.tolist(), counts.tolist())))

    def test_ids_that_do_not_count_ms_give_way_to_stamps(self):
        m = {name: values for name, values in motion(800).items()}
        np.savez(self.folder / "ids.npz", t=5 * m["t"], n=np.arange(800), q=m["q"], dq=m["dq"], tau=m["tau"])
        columns = {"time": {"from": "t", "unit": "s"}, "message_id": "n", "q": "q", "tau_J": "tau"}
        recording = Recording.open(self.folder / "ids.npz", {"columns": columns})
        self.assertFalse(recording.by_id)
        self.assertIn("rises by one in 5 ms", recording.notes[0])
        np.savez(self.folder / "ids.npz", t=m["t"], n=np.arange(800) % 500, q=m["q"], tau=m["tau"])
        recording = Recording.open(self.folder / "ids.npz", {"columns": columns})
        self.assertEqual((recording.by_id, recording.rows), (False, 800))
        self.assertIn("goes back in row 501", recording.notes[0])

    def test_messages_out_of_order_are_sorted_by_stamps(self):
        kind, messages = arm_topic(self.motion)
        stamps = [ns for ns, _ in messages]
        mixed = [messages[k ^ 1][1] for k in range(len(messages))]  # pairs exchanged
        recording = Recording.open(bag(self.folder / "mixed", {"/joint_states": (kind, list(zip(stamps, mixed)))}))
        self.same(recording, "q", "tau_J")
        self.assertFalse(recording.timing.sorted)

    def test_a_log_of_20_hz_has_its_period(self):
        m = {name: values[::50] for name, values in motion(4000).items()}
        timing = Recording.open(table_csv(self.folder / "slow.csv", m), MAPPING).timing
        self.assertAlmostEqual(timing.median, 50, 6)
        self.assertEqual(timing.lost, 0)

    # --- bad logs

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
        self.refused(r"column state.q\[3\] has 'oops', which is no number", file, names=["q"])
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
            return {"/joint_states": ("sensor_msgs/msg/JointState", [(k * 10**6, joint_state(k * 10**6, q, names=names)) for k in range(3)])}

        for k, (names, text) in enumerate((
            (["shoulder_pan_joint", "shoulder_lift_joint", "elbow_joint", "wrist_1_joint", "wrist_2_joint", "wrist_3_joint"], "no joints of a Panda"),
            ([f"iiwa_joint_{i}" for i in range(1, 8)], "no joints of a Panda"),
            (JOINTS[:3], "3 of the 7 joints of a Panda"),
            ([f"{side}_joint{i}" for side in ("left", "right") for i in range(1, 8)], "joints of 2 arms"),
            (["panda_finger_joint1", "panda_finger_joint2"], "no joint positions of a Panda"),
        )):  # fmt: skip
            with self.subTest(text=text):
                self.refused(text, bag(self.folder / f"other{k}", topic(names)))
        string = STORE.types["std_msgs/msg/String"]
        self.refused("its topics are /chatter", bag(self.folder / "chatter", {"/chatter": ("std_msgs/msg/String", [(1, string("x"))])}))

    def test_a_sparse_file_of_10_gb_is_refused_at_once(self):
        file = self.folder / "huge.csv"
        for begin, text in ((b"", "bytes that no text has"), (self.csv.read_bytes(), "after row 400|row 401 has|no number|no CSV")):
            with open(file, "wb") as out:
                out.write(begin)
                out.truncate(10 << 30)
            before = time.monotonic()
            self.refused(text, file)
            self.assertLess(time.monotonic() - before, 5)
        file.unlink()

    def test_missing_packages_are_named(self):
        for package, path, mapping in (("pyarrow", self.csv, None), ("rosbags", self.bag, None), ("ruamel.yaml", self.table, "m.yaml")):
            code = f"import sys; sys.modules[{package!r}] = None; from panda_twin.identify import Recording; Recording.open({str(path)!r}, {mapping!r})"
            done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
            self.assertRegex(done.stderr.splitlines()[-1], r"^ImportError: .* pip install 'panda-twin\[(identify|ros)\]'")

    def test_damaged_files_are_read_or_refused(self):
        """200 of each kind; anything but ValueError and OSError is a bug."""
        random_ = random.Random(24)
        small = motion(60)
        bag(self.folder / "small", {"/joint_states": arm_topic(small)})
        bag(self.folder / "small3", {"/joint_states": arm_topic(small)}, StoragePlugin.SQLITE3)
        np.savez(self.folder / "small.npz", t=small["t"], q=small["q"], dq=small["dq"], tau=small["tau"])
        pq.write_table(pa.table({"t": 1e3 * small["t"], **{f"{n}{i + 1}": small[n][:, i] for n in ("q", "dq", "tau") for i in range(7)}}), self.folder / "small.parquet")
        kinds = {
            "own.mcap": ((self.folder / "run/run.mcap").read_bytes()[:200_000], None),
            "franka.csv": (libfranka_csv(self.folder / "small.csv", small).read_bytes(), None),
            "table.csv": (table_csv(self.folder / "small_t.csv", small, ";", "utf-16").read_bytes(), MAPPING),
            "log.npz": ((self.folder / "small.npz").read_bytes(), {"columns": {"time": {"from": "t", "unit": "s"}, "q": "q", "tau_J": "tau"}}),
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


class SuspicionsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.motion = motion(4000)

    def said(self, **changed):
        m = self.motion
        return suspicions(Block(changed.pop("t", m["t"]), {"q": m["q"], "dq": m["dq"], "tau_J": m["tau"], **changed}))

    def exchanged(self, name, i, j):
        values = self.motion[name].copy()
        values[:, [i - 1, j - 1]] = values[:, [j - 1, i - 1]]
        return values

    def test_a_right_log_is_not_suspected(self):
        self.assertEqual(self.said(), [])
        self.assertEqual(self.said(q_d=self.motion["q"]), [])
        noise = np.random.default_rng(1).normal(0, 0.2, self.motion["q"].shape)
        self.assertEqual(self.said(tau_J=self.motion["tau"] + noise + np.sign(self.motion["dq"]), dq=self.motion["dq"] + 0.05 * noise), [])
        load = model.gravity(self.motion["q"], **model.HAND) - model.gravity(self.motion["q"])
        self.assertEqual(self.said(tau_J=self.motion["tau"] + load), [])

    def test_units_and_signs_are_named(self):
        m = self.motion
        for changed, text in (
            ({"q": np.degrees(m["q"])}, "q looks like degrees: joint . is from .*; map it with unit: deg"),
            ({"dq": np.degrees(m["dq"])}, "dq looks like deg/s: it is 57.3 times"),
            ({"dq": -m["dq"]}, "dq has the opposite sign"),
            ({"dq": 0 * m["dq"]}, "dq is zero throughout"),
            ({"t": 1.2 * m["t"]}, "dq is 1.2 times the slope of q"),
            ({"tau_J": 1e3 * m["tau"]}, "tau_J looks like mNm: it is 1000 times"),
            ({"tau_J": -m["tau"]}, "tau_J has the opposite sign"),
            ({"tau_J": m["tau"] - model.gravity(m["q"])}, "tau_J has no gravity in it"),
            ({"tau_J": model.gravity(m["q"], g_earth=(9.81, 0, 0))}, "another robot, another direction of gravity, or a heavy load"),
            ({"q_d": np.degrees(m["q"])}, "q_d looks like degrees"),
            ({"q": np.repeat(m["q"][::4], 4, axis=0)}, "q changes only once in 4.0 rows"),
            ({"q": m["q"] + 4}, "q is not a Panda's"),
        ):
            with self.subTest(text=text):
                self.assertRegex("\n".join(self.said(**changed)), text)

    def test_exchanged_columns_are_named(self):
        for i, j in ((1, 2), (3, 4), (2, 4), (4, 6), (5, 6), (2, 7)):
            for names in (("dq",), ("tau",), ("q", "dq"), ("q", "dq", "tau")):
                with self.subTest(joints=(i, j), names=names):
                    said = self.said(**{"tau_J" if name == "tau" else name: self.exchanged(name, i, j) for name in names})
                    self.assertRegex("\n".join(said), f"{i} and {j}")


if __name__ == "__main__":
    unittest.main()
