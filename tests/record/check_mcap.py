"""Reads a log of ours with the readers of other people: PyPI mcap and mcap-protobuf-support.

usage: check_mcap.py RECORD_WRITE_SAMPLE MODELS_ROBOTS WORK_FOLDER
"""

import math
import os
import subprocess
import sys
from xml.etree import ElementTree

try:
    from mcap.reader import make_reader, SeekingReader
    from mcap.records import Attachment, Chunk, DataEnd, Footer, Message, MessageIndex, Metadata
    from mcap.stream_reader import StreamReader
    from mcap_protobuf.decoder import DecoderFactory
except ImportError as missing:
    sys.exit(f"{missing}; run scripts/setup, which puts the tools of the tests into .venv")

CYCLES = 1500
CONFIGS = 3  # the sample changes its configuration every 500 cycles
FRAMES = CYCLES // 20  # 50 a second
SCENES = (CYCLES + 39) // 40  # 25 a second
MESSAGES = 2 * CYCLES + CONFIGS + FRAMES + SCENES + 2  # and an event, and a plan


def check(condition, what):
    if not condition:
        sys.exit(f"check_mcap: {what}")


def check_stream(path):
    """Front to back: every record, with chunk and data section CRCs."""
    with open(path, "rb") as file:
        records = list(StreamReader(file, validate_crcs=True, emit_chunks=True).records)
    count = lambda kind: sum(isinstance(record, kind) for record in records)
    check(count(Chunk) > 3, "fewer chunks than expected")
    check(count(MessageIndex) >= 2 * count(Chunk), "a chunk without its message indexes")
    check(all(r.compression == "zstd" and r.uncompressed_crc for r in records if isinstance(r, Chunk)),
          "a chunk without zstd or CRC")
    check(count(DataEnd) == 1 and count(Footer) == 1, "no end")
    with open(path, "rb") as file:
        flat = list(StreamReader(file, validate_crcs=True).records)
    messages = sum(isinstance(record, Message) for record in flat)
    check(messages == MESSAGES, f"{messages} messages in the stream")


def check_summary(reader):
    summary = reader.get_summary()
    statistics = summary.statistics
    check(statistics.message_count == MESSAGES, "message count of the statistics")
    check(statistics.chunk_count == len(summary.chunk_indexes), "chunk count of the statistics")
    check(statistics.message_end_time == (CYCLES - 1) * 1_000_000 + 200_000, "end time")
    topics = {channel.topic: statistics.channel_message_counts[channel.id] for channel in summary.channels.values()}
    check(topics == {"/robot/cycle": CYCLES, "/ext/tick": CYCLES, "/robot/config": CONFIGS, "/event": 1, "/tf": FRAMES,
                     "/scene": SCENES, "/plan": 1},
          f"message counts by topic {topics}")
    attachments = list(reader.iter_attachments())
    check([(a.name, a.data) for a in attachments] == [("scenario.yaml", "name: sample\n# ü\n".encode())], "attachment")
    metadata = list(reader.iter_metadata())
    check([(m.name, m.metadata) for m in metadata] == [("run", {
        "scenario": "sample", "seed": "18446744073709551615", "version": "0.1.0", "drive": "lockstep"})], "metadata")


def check_cycle(k, message, log_time):
    check(log_time == message.at_ns == k * 1_000_000, f"log time of cycle {k}")
    check(message.message_id == k + 1000, f"message_id of cycle {k}")
    check(list(message.q) == [0.5 * k + 0.125 * i for i in range(7)], f"q of cycle {k}")
    check(len(message.O_T_EE) == 16 and len(message.tau_J) == 7, f"lengths of cycle {k}")
    check(message.fate == (2 if k == 3 else 1), f"fate of cycle {k}")
    check(message.HasField("violation") == (k == 5), f"violation of cycle {k}")
    if k == 5:
        error = message.DESCRIPTOR.fields_by_name["errors"].enum_type
        names = [error.values_by_number[number].name for number in message.errors]
        check(names == ["joint_position_limits_violation", "base_acceleration_invalid_reading"], f"errors {names}")


def read_joints(robots):
    """The joints of the robot's URDF, by child link: (parent, xyz, rpy, moves about its z axis)."""
    joints = {}
    for file in ("panda/panda.urdf", "hand/hand.urdf"):
        for joint in ElementTree.parse(os.path.join(robots, file)).getroot().iter("joint"):
            origin = joint.find("origin")
            xyz, rpy = ([float(x) for x in origin.get(key).split()] for key in ("xyz", "rpy"))
            moves = joint.get("type") == "revolute"
            check(not moves or joint.find("axis").get("xyz") == "0 0 1", "a joint about another axis than z")
            joints[joint.find("child").get("link")] = (joint.find("parent").get("link"), xyz, rpy, moves)
    return joints


def product(a, b):
    return [[sum(a[r][i] * b[i][c] for i in range(3)) for c in range(3)] for r in range(3)]


def about(axis, angle):
    """Rotation matrix about x (0), y (1) or z (2)."""
    c, s = math.cos(angle), math.sin(angle)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix = [[float(r == k) for k in range(3)] for r in range(3)]
    matrix[i][i] = matrix[j][j] = c
    matrix[i][j], matrix[j][i] = -s, s
    return matrix


def of_quaternion(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    check(abs(x * x + y * y + z * z + w * w - 1) < 1e-12, "a quaternion that is not of unit length")
    return [[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]]


def check_frames(number, message, log_time, joints):
    """Every frame against the URDF's own joint, at the q that the sample has there."""
    k = 20 * number
    check(log_time == k * 1_000_000, f"log time of frames {number}")
    children = [frame.child_frame_id for frame in message.transforms]
    check(children == [f"panda_link{i}" for i in range(1, 9)] + ["panda_hand"], f"frames {children}")
    for i, frame in enumerate(message.transforms):
        where = f"{frame.child_frame_id} at cycle {k}"
        check(frame.timestamp.ToNanoseconds() == log_time, f"timestamp of {where}")
        parent, xyz, (roll, pitch, yaw), moves = joints[frame.child_frame_id]
        check(frame.parent_frame_id == parent, f"parent of {where}")
        angle = 0.5 * k + 0.125 * i if moves else 0.0
        expected = product(product(about(2, yaw), about(1, pitch)), product(about(0, roll), about(2, angle)))
        actual = of_quaternion(frame.rotation)
        translation = frame.translation
        pairs = list(zip((translation.x, translation.y, translation.z), xyz))
        pairs += [(actual[r][c], expected[r][c]) for r in range(3) for c in range(3)]
        check(all(abs(a - b) < 1e-9 for a, b in pairs), f"pose of {where}: {pairs}")


def check_messages(reader, joints):
    """Through the indexes, every message decoded by the schema in the file."""
    cycles = ticks = configs = frames = scenes = 0
    for schema, channel, message, decoded in reader.iter_decoded_messages():
        if channel.topic == "/robot/cycle":
            check_cycle(cycles, decoded, message.log_time)
            cycles += 1
        elif channel.topic == "/ext/tick":
            check(decoded.written_ns - decoded.read_ns == 20_000 + ticks % 7, f"d_EXT of tick {ticks}")
            ticks += 1
        elif channel.topic == "/robot/config":
            check(len(decoded.I_ee) == 9, "inertia")
            configs += 1
        elif channel.topic == "/tf":
            check(schema.name == "foxglove.FrameTransforms", f"schema of the frames: {schema.name}")
            check_frames(frames, decoded, message.log_time, joints)
            frames += 1
        elif channel.topic == "/scene":
            k = 40 * scenes
            check(message.log_time == decoded.at_ns == k * 1_000_000, f"log time of scene {scenes}")
            check((len(decoded.qpos), len(decoded.contacts), len(decoded.pushes)) == (16, k % 4, k % 2),
                  f"lengths of scene {scenes}")
            scenes += 1
        elif channel.topic == "/plan":
            check((decoded.id, decoded.object, message.log_time) == ("place", "block", 20_000_000), "plan")
            check(list(decoded.way) == [0.5, 0, 0.25, 0.5, 0.125, 0.5] and decoded.O_T_object[14] == 0.75, "way and goal")
        else:
            check((decoded.kind, decoded.text) == ("mode", "Idle → Move"), "event")
    check((cycles, ticks, configs, frames, scenes) == (CYCLES, CYCLES, CONFIGS, FRAMES, SCENES), "numbers of decoded messages")
    seconds = list(reader.iter_decoded_messages(topics=["/robot/cycle"],
                                                 starting_at=1_000_000_000, ending_before=1_200_000_000))
    check([m.message_id for _, _, _, m in seconds] == list(range(2000, 2200)), "messages of a span of time")


def main(writer, robots, folder):
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "sample.mcap")
    subprocess.run([writer, path, str(CYCLES)], check=True)
    check_stream(path)
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        check(isinstance(reader, SeekingReader), "not seekable")
        check_summary(reader)
        check_messages(reader, read_joints(robots))
    os.remove(path)


if __name__ == "__main__":
    main(*sys.argv[1:4])
