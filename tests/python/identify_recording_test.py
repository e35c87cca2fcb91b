"""Logs of robots and programs as `Recording`: each format, blocks and times."""

import unittest
import unittest.mock

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from rosbags.rosbag2 import StoragePlugin

import panda_twin as pt
from panda_twin.identify import Recording
from identify_logs import (
    EPOCH,
    JOINTS,
    MAPPING,
    STORE,
    LogsCase,
    arm_topic,
    bag,
    blank,
    header,
    joint_state,
    libfranka_csv,
    motion,
    put,
    table_csv,
    whole,
)


class RecordingTest(LogsCase):
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
        file.write_text(
            "robot: panda\ncolumns:\n  time: {from: t, unit: ms}\n  q: {from: [q1, q2, q3, q4, q5, q6, q7], unit: deg}\n  dq: "
            "dq\n  tau_J: {from: tau, unit: Nm}\n"
        )
        self.same(Recording.open(self.table, file), "q", "dq", "tau_J")
        m = self.motion
        lists = pa.FixedSizeListArray.from_arrays(pa.array(np.degrees(m["q"]).ravel()), 7)
        ragged = pa.array([row.tolist() for row in m["tau"]])
        flat = {f"dq_{i}": m["dq"][:, i] for i in range(7)}
        pq.write_table(
            pa.table({"t": pa.array(EPOCH + np.rint(1e9 * m["t"]).astype(np.int64)), "q": lists, "tau": ragged, **flat}),
            self.folder / "t.parquet",
            row_group_size=150,
        )
        self.same(
            Recording.open(self.folder / "t.parquet", {"columns": {**MAPPING["columns"], "time": {"from": "t", "unit": "ns"}}}),
            "q",
            "dq",
            "tau_J",
        )
        np.savez(self.folder / "t.npz", t=1e3 * m["t"], q=np.degrees(m["q"]), dq=m["dq"].astype(">f8"), tau=m["tau"])
        self.same(Recording.open(self.folder / "t.npz", MAPPING), "q", "dq", "tau_J")

    def test_csv_of_any_separator_encoding_and_decimal(self):
        for separator, encoding, decimal in (
            (";", "utf-8-sig", ","),
            ("\t", "utf-16", "."),
            (" ", "utf-8", "."),
            (",", "utf-8-sig", "."),
            ("|", "latin-1", "."),
        ):
            with self.subTest(separator=separator, encoding=encoding):
                self.same(
                    Recording.open(table_csv(self.folder / "any.csv", self.motion, separator, encoding, decimal), MAPPING),
                    "q",
                    "dq",
                    "tau_J",
                )
        rows = self.table.read_text().splitlines()[1:]
        (self.folder / "bare.csv").write_text("\n".join(rows) + "\n")
        columns = {
            "time": {"from": 0, "unit": "ms"},
            "q": {"from": list(range(1, 8)), "unit": "deg"},
            "dq": list(range(8, 15)),
            "tau_J": list(range(15, 22)),
        }
        self.same(Recording.open(self.folder / "bare.csv", {"columns": columns}), "q", "dq", "tau_J")

    def test_exported_tables_need_no_mapping(self):
        m = self.motion
        np.savez(
            self.folder / "cycles.npz",
            at_ns=np.rint(1e9 * m["t"]).astype(np.int64),
            message_id=1 + np.arange(len(m["t"]), dtype=np.uint64),
            q=m["q"],
            dq=m["dq"],
            tau_J=m["tau"],
        )
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
        forces = [
            (
                EPOCH + k * 10**7,
                STORE.types["geometry_msgs/msg/WrenchStamped"](
                    header(EPOCH + k * 10**7, "fr3_link0"), wrench(vector(float(k), 0, 0), vector(0, 0, 0))
                ),
            )
            for k in range(40)
        ]
        path = bag(
            self.folder / "turned",
            {
                "/left/joint_states": arm_topic(turned, [f"fr3_joint{i + 1}" for i in order]),
                "/f": ("geometry_msgs/msg/WrenchStamped", forces),
            },
            StoragePlugin.SQLITE3,
        )
        recording = Recording.open(path)
        self.same(recording, "q", "dq", "tau_J")
        self.assertRegex(" ".join(recording.notes), "Franka Research 3.*|40 messages for 400 rows")
        self.assertEqual(whole(recording, "O_F_ext_hat_K")[1][[0, 10, 11, 200], 0].tolist(), [0, 1, 1, 20])

    def test_large_bags_are_streamed(self):
        m = motion(9000)
        kind, messages = arm_topic(m)
        make = STORE.types["sensor_msgs/msg/JointState"]
        desired = [
            (ns + 40_000_000, make(header(ns), JOINTS, one.position, one.velocity, one.effort)) for ns, one in messages
        ]  # recorded later
        path = bag(self.folder / "large", {"/joint_states": (kind, messages), "/desired_joint_states": (kind, desired)})
        with unittest.mock.patch("panda_twin.identify.logs._bags._KEPT", 0):
            recording = Recording.open(path)
            t, q, q_d, tau_J = whole(recording, "q", "q_d", "tau_J", seconds=1.7)
        self.assertEqual((recording.rows, len(t)), (9000, 9000))
        np.testing.assert_array_equal(q, m["q"])
        np.testing.assert_array_equal(tau_J, m["tau"])
        np.testing.assert_array_equal(q_d, q)  # of the same stamp

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
                    put(
                        message,
                        measured_joint_state=joint_state(ns, m["q"][k], m["dq"][k], m["tau"][k]),
                        robot_mode=2,
                        control_command_success_rate=1.0,
                    )
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
        self.assertEqual(
            [(round(b.t[0], 3), round(b.t[-1], 3)) for b in blocks], [(0, 0.149), (0.1, 0.249), (0.2, 0.349), (0.3, 0.399)]
        )
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
        for path, by_id in (
            (libfranka_csv(self.folder / "gaps.csv", part, keep), True),
            (table_csv(self.folder / "gaps_t.csv", part), False),
        ):
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


if __name__ == "__main__":
    unittest.main()
