"""Reads a log of ours with the readers of other people: PyPI mcap and mcap-protobuf-support.

usage: check_mcap.py RECORD_WRITE_SAMPLE WORK_FOLDER
"""

import os
import subprocess
import sys

try:
    from mcap.reader import make_reader, SeekingReader
    from mcap.records import Attachment, Chunk, DataEnd, Footer, Message, MessageIndex, Metadata
    from mcap.stream_reader import StreamReader
    from mcap_protobuf.decoder import DecoderFactory
except ImportError as missing:
    sys.exit(f"{missing}; run scripts/setup, which puts the tools of the tests into .venv")

CYCLES = 1500
CONFIGS = 3  # the sample changes its configuration every 500 cycles


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
    check(messages == 2 * CYCLES + CONFIGS + 1, f"{messages} messages in the stream")


def check_summary(reader):
    summary = reader.get_summary()
    statistics = summary.statistics
    check(statistics.message_count == 2 * CYCLES + CONFIGS + 1, "message count of the statistics")
    check(statistics.chunk_count == len(summary.chunk_indexes), "chunk count of the statistics")
    check(statistics.message_end_time == (CYCLES - 1) * 1_000_000 + 200_000, "end time")
    topics = {channel.topic: statistics.channel_message_counts[channel.id] for channel in summary.channels.values()}
    check(topics == {"/robot/cycle": CYCLES, "/ext/tick": CYCLES, "/robot/config": CONFIGS, "/event": 1},
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


def check_messages(reader):
    """Through the indexes, every message decoded by the schema in the file."""
    cycles = ticks = configs = 0
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
        else:
            check((decoded.kind, decoded.text) == ("mode", "Idle → Move"), "event")
    check((cycles, ticks, configs) == (CYCLES, CYCLES, CONFIGS), "numbers of decoded messages")
    seconds = list(reader.iter_decoded_messages(topics=["/robot/cycle"],
                                                 starting_at=1_000_000_000, ending_before=1_200_000_000))
    check([m.message_id for _, _, _, m in seconds] == list(range(2000, 2200)), "messages of a span of time")


def main(writer, folder):
    os.makedirs(folder, exist_ok=True)
    path = os.path.join(folder, "sample.mcap")
    subprocess.run([writer, path, str(CYCLES)], check=True)
    check_stream(path)
    with open(path, "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()], validate_crcs=True)
        check(isinstance(reader, SeekingReader), "not seekable")
        check_summary(reader)
        check_messages(reader)
    os.remove(path)


if __name__ == "__main__":
    main(sys.argv[1], sys.argv[2])
