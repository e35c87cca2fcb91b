"""d_EXT from a trace of panda-twin's tracepoints, and whether a log has the same."""

import csv
import dataclasses
import math
import pathlib
import re
import subprocess
import tempfile

from tracing.session import TraceError

TOLERANCE_NS = 5_000
PERCENTILES = (("median", 0.5), ("p99", 0.99), ("max", 1.0))
SHOWN_FIGURES = (("d_EXT", "d_EXT"), ("write", "of it the write"), ("read", "the read before"),
                 ("read_to_read", "read to read"))
SHOWN = 5  # of a list of commands

EVENT = re.compile(r"\[(\d+)\.(\d{9})\] (?:\S+ )?panda_twin:(\w+): "
                   r".*\bvpid = (\d+), vtid = (\d+) .*\bmessage_id = (\d+)")


class TraceFault(Exception):
    """What was recorded cannot be right, or is not what the log says."""


@dataclasses.dataclass
class Command:
    """Instants in ns: the look for the state begins, its read has ended; the command's write begins, and has ended."""

    message_id: int
    look: int
    read: int
    begin: int = 0
    end: int = 0

    @property
    def d_EXT(self):
        return self.end - self.read


@dataclasses.dataclass
class Motion:
    """What one communication thread wrote while it ran."""

    process: int
    reads: list = dataclasses.field(default_factory=list)  # ns, of all states
    commands: list = dataclasses.field(default_factory=list)

    def periods(self):
        """From read to read while commands were written, ns."""
        reads = [t for t in self.reads if self.commands[0].read <= t <= self.commands[-1].read]
        return [b - a for a, b in zip(reads, reads[1:])]


def read_events(folder):
    """(ns, event, process, thread, message_id) in the order of time.

    @throws TraceError when babeltrace2 cannot read them.
    """
    command = ["babeltrace2", "--clock-seconds", "--no-delta", str(folder)]
    with (tempfile.TemporaryFile("w+") as errors,
          subprocess.Popen(command, stdout=subprocess.PIPE, stderr=errors, text=True) as reader):
        for line in reader.stdout:
            found = EVENT.match(line)
            if not found:
                reader.kill()
                raise TraceError(f"babeltrace2 shows what is not understood: {line.strip()}")
            seconds, nanoseconds, event, process, thread, message_id = found.groups()
            yield int(seconds) * 10**9 + int(nanoseconds), event, int(process), int(thread), int(message_id)
        if reader.wait() != 0:
            errors.seek(0)
            raise TraceError(f"babeltrace2 cannot read {folder}: {errors.read().strip()[-500:]}")


def motions_of(events):
    """The motions in which commands were written, in the order in which they began. Another thread, or message_ids that
    begin anew, are another motion.

    @throws TraceFault when a write has no read, or no beginning.
    """
    motions, running, pending, looks = [], {}, {}, {}
    for at, event, process, thread, message_id in events:
        key = (process, thread)
        if event == "read_begin":
            looks[key] = at
            continue
        if event == "state_read":
            last = pending.get(key)
            if last is None or message_id <= last.message_id:
                running[key] = Motion(process)
                motions.append(running[key])
            running[key].reads.append(at)
            pending[key] = Command(message_id, looks.get(key, at), at)
            continue
        command = pending.get(key)
        if command is None or command.message_id != message_id or (event == "write_end" and not command.begin):
            raise TraceFault(f"{event} of message_id {message_id}, process {process}, does not follow its state's read")
        if event == "write_begin":
            command.begin = at
        else:
            command.end = at
            running[key].commands.append(command)
    return [motion for motion in motions if motion.commands]


def percentile(values, share):
    """The smallest value that this share of them does not exceed."""
    return sorted(values)[max(math.ceil(share * len(values)) - 1, 0)]


def percentiles(values):
    ordered = sorted(values)
    return {name: percentile(ordered, share) for name, share in PERCENTILES}


def figures(motion):
    """What is told of a motion; durations in ns."""
    result = {"process": motion.process, "commands": len(motion.commands), "first_id": motion.commands[0].message_id,
              "last_id": motion.commands[-1].message_id, "d_EXT": percentiles([c.d_EXT for c in motion.commands]),
              "read": percentiles([c.read - c.look for c in motion.commands]),
              "write": percentiles([c.end - c.begin for c in motion.commands])}
    if periods := motion.periods():
        result["read_to_read"] = percentiles(periods)
    return result


def describe(number, told):
    """Lines for people. @param told  by figures()."""
    yield (f"motion {number}: process {told['process']}, {told['commands']} commands, message_id {told['first_id']} to "
           f"{told['last_id']}")
    for key, name in SHOWN_FIGURES:
        if key in told:
            shown = (f"{what} {told[key][what] / 1000:9.3f} us" for what, _ in PERCENTILES)
            yield f"  {name:16}" + "   ".join(shown)


def read_ticks(log, program):
    """{message_id: d_EXT in ns} of the commands of a log: its ticks.csv, run.mcap or folder.

    @param program  exports it.
    """
    log = pathlib.Path(log)
    if log.is_dir():
        log = log / "run.mcap"
    if not log.exists():
        raise TraceError(f"{log}: no such log to compare with")
    with tempfile.TemporaryDirectory(prefix="twin-trace-") as folder:
        table = log
        if log.suffix != ".csv":
            done = subprocess.run([program, "export", log, "--out", folder], capture_output=True, text=True)
            if done.returncode != 0:
                raise TraceError(f"{log}: {done.stderr.strip()}")
            table = pathlib.Path(folder, "ticks.csv")
        with open(table, newline="") as rows:
            return {int(row["message_id"]): int(row["written_ns"]) - int(row["read_ns"])
                    for row in csv.DictReader(rows) if row["action"] in ("written", "finished")}


def some(ids):
    ids = sorted(ids)
    return ", ".join(map(str, ids[:SHOWN])) + (f" and {len(ids) - SHOWN} more" if len(ids) > SHOWN else "")


@dataclasses.dataclass
class Comparison:
    """The same commands in trace and log. The log's readings of the clock are just outside the tracepoints: none of its
    d_EXT is shorter than the trace's, and one is longer where the thread was interrupted between the two.
    """

    trace: dict  # percentiles, ns
    log: dict
    excess: dict  # message_id -> d_EXT of the log minus that of the trace, ns

    def apart(self):
        """The percentiles that differ by more than TOLERANCE_NS."""
        return [name for name, _ in PERCENTILES if abs(self.log[name] - self.trace[name]) > TOLERANCE_NS]

    def commands_apart(self):
        return [message_id for message_id, excess in self.excess.items() if abs(excess) > TOLERANCE_NS]

    def describe(self):
        """Lines for people."""
        for name, _ in PERCENTILES:
            trace, log = self.trace[name] / 1000, self.log[name] / 1000
            yield f"  {name:8} trace {trace:9.3f} us   log {log:9.3f} us   log - trace {log - trace:7.3f} us"
        spread = sorted(self.excess.values())
        yield (f"  each command: log - trace from {spread[0] / 1000:.3f} to {spread[-1] / 1000:.3f} us, median "
               f"{percentile(spread, 0.5) / 1000:.3f} us")
        if apart := self.commands_apart():
            yield (f"  {len(apart)} apart by more than {TOLERANCE_NS / 1000:g} us, interrupted between two readings of the "
                   f"clock if few: message_id {some(apart)}")


def compare(motion, ticks):
    """@param ticks  by read_ticks(). @throws TraceFault when not the same commands were written."""
    trace = {command.message_id: command.d_EXT for command in motion.commands}
    if trace.keys() != ticks.keys():
        only = [f"{len(ids)} only in the {where} (message_id {some(ids)})"
                for where, ids in (("trace", trace.keys() - ticks.keys()), ("log", ticks.keys() - trace.keys())) if ids]
        raise TraceFault(f"trace and log are not of the same commands: {', '.join(only)}")
    return Comparison(percentiles(trace.values()), percentiles(ticks.values()),
                      {message_id: ticks[message_id] - d_EXT for message_id, d_EXT in trace.items()})
