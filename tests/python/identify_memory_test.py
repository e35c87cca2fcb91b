"""An hour's log of each kind, 3.6 million rows: made, then read in blocks, and compared with the twin, by a process of its own whose memory is measured."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from mcap.reader import make_reader
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import StoragePlugin, Writer

import panda_twin as pt
from identify_logs import EPOCH, STORE, joint_state, libfranka_csv, motion, names_of

ROWS = 3_600_000
MINUTE = 60_000
MOST = 500  # MB

READ = """
import sys, time
from panda_twin.identify import Recording, compare
begin = time.monotonic()
recording = Recording.open(sys.argv[1])
rows = sum(len(block.t) for block in recording.blocks("q", "dq", "tau_J", *sys.argv[2:]))
assert rows == recording.rows, (rows, recording.rows)
compare(sys.argv[1])
peak = next(int(line.split()[1]) for line in open("/proc/self/status") if line.startswith("VmHWM"))  # ru_maxrss has the parent's
print(rows, recording.timing.lost, peak // 1024, round(time.monotonic() - begin, 1))
"""


def varint(value):
    out = bytearray()
    while value > 127:
        out.append(value & 127 | 128)
        value >>= 7
    return bytes([*out, value])


def own_log(run, file):
    """The log of a run again and again: of a number that a message has twice, the last one counts."""
    with open(run, "rb") as source, open(file, "wb") as out:
        reader = make_reader(source)
        summary = reader.get_summary()
        wanted = {"/robot/cycle": [], "/ext/tick": []}
        for _, channel, message in reader.iter_messages(topics=list(wanted)):
            wanted[channel.topic].append(message.data)
        writer = McapWriter(out, chunk_size=1 << 19, compression=CompressionType.ZSTD)
        writer.start(library=reader.get_header().library)
        schemas = {k: writer.register_schema(s.name, s.encoding, s.data) for k, s in summary.schemas.items()}
        channels = {
            c.topic: writer.register_channel(c.topic, c.message_encoding, schemas[c.schema_id]) for c in summary.channels.values()
        }
        for attachment in reader.iter_attachments():
            writer.add_attachment(
                attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
            )
        for record in reader.iter_metadata():
            writer.add_metadata(record.name, record.metadata)
        cycles, ticks = wanted["/robot/cycle"], wanted["/ext/tick"]
        for k in range(1, ROWS + 1):
            at = k * 10**6
            cycle = cycles[k % 1000 + 500] + b"\x08" + varint(at) + b"\x10" + varint(k)
            writer.add_message(channels["/robot/cycle"], at, cycle, at)
            command = b"\x08" + varint(k)
            tick = ticks[k % 1000 + 500] + b"\x08" + varint(at) + b"\x18" + varint(k) + b"\x3a" + varint(len(command)) + command
            writer.add_message(channels["/ext/tick"], at, tick, at)
        writer.finish()
    return file


class MemoryTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.motion = motion(MINUTE)

    def read(self, path, *columns):
        size = sum(file.stat().st_size for file in ([path] if path.is_file() else path.iterdir()))
        done = subprocess.run([sys.executable, "-c", READ, str(path), *columns], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        rows, lost, megabytes, seconds = done.stdout.split()
        print(f"{path.name}: {size / 1e9:.2f} GB, {rows} rows read in {seconds} s with {megabytes} MB", flush=True)
        self.assertEqual((int(rows), int(lost)), (ROWS, 0))
        self.assertLess(int(megabytes), MOST)

    def test_csv_of_libfranka(self):
        file = self.folder / "franka.csv"
        lines = libfranka_csv(file, {name: values.round(6) for name, values in self.motion.items()}).read_text().splitlines()
        rows = [line.partition(",")[2] for line in lines[1:]]
        with open(file, "w") as out:
            out.write(lines[0] + "\n")
            for k in range(ROWS // MINUTE):
                out.write("".join(f"{k * MINUTE + i},{row}\n" for i, row in enumerate(rows)))
        self.read(file)

    def test_arrays_of_panda_py(self):
        many = ROWS // MINUTE
        arrays = {"time": np.arange(float(ROWS))[:, None]} | {
            column: np.tile(self.motion[name], (many, 1)) for column, name in (("q", "q"), ("dq", "dq"), ("tau_J", "tau"))
        }
        np.savez(self.folder / "log.npz", **arrays)
        self.read(self.folder / "log.npz")

    def test_parquet(self):
        m = self.motion
        table = {
            name: values[:, i]
            for column, key in (("q", "q"), ("dq", "dq"), ("tau_J", "tau"))
            for i, (name, values) in enumerate((n, m[key]) for n in names_of(column))
        }
        with pq.ParquetWriter(
            self.folder / "log.parquet", pa.schema([("at_ns", pa.int64()), *((name, pa.float64()) for name in table)])
        ) as writer:
            for k in range(ROWS // MINUTE):
                at = np.rint(1e9 * m["t"]).astype(np.int64) + k * 60 * 10**9
                writer.write_table(pa.table({"at_ns": at, **table}), row_group_size=1 << 20)
        self.read(self.folder / "log.parquet")

    def test_bag(self):
        kind = "sensor_msgs/msg/JointState"
        raw = [
            STORE.serialize_cdr(joint_state(EPOCH, *row), kind)
            for row in zip(self.motion["q"], self.motion["dq"], self.motion["tau"])
        ]
        raw = [bytes(one) for one in raw]
        with Writer(self.folder / "bag", version=9, storage_plugin=StoragePlugin.MCAP) as writer:
            connection = writer.add_connection("/joint_states", kind, typestore=STORE)
            for k in range(ROWS):
                sec, nanosec = divmod(EPOCH + k * 10**6, 10**9)
                data = raw[k % MINUTE]
                writer.write(
                    connection,
                    EPOCH + k * 10**6,
                    data[:4] + sec.to_bytes(4, "little") + nanosec.to_bytes(4, "little") + data[12:],
                )
        self.read(self.folder / "bag")

    def test_own_log(self):
        run = pt.run("scenarios/smoke.yaml", out=self.folder / "run", video=False, plots=False)
        self.read(own_log(run.folder / "run.mcap", self.folder / "hour.mcap"), "q_c", "fate")


if __name__ == "__main__":
    unittest.main()
