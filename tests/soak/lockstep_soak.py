"""Hours of the robot's time in lockstep: client after client moves the arm, the log is split, and states repeat.

A client answers every state within tens of microseconds: its commands are made before, a datagram each but for the state's id.
"""

import hashlib
import itertools
import math
import os
import socket
import struct
import time

import fci_wire as fci
import serve_test
from serve_control_test import Channel
from soak_figures import Findings, Progress, Samples

SCENARIO = serve_test.SCENARIO.replace("plant: {kind: ideal}\n", "")  # bodies, friction, noise
LAP = 10_000  # cycles of a lap: there and back, all joints
AMPLITUDES = ((0.3, 0.1, -0.2, 0.15, 0.3, 0.2, -0.4), (-0.3, 0.15, 0.2, -0.1, -0.3, 0.1, 0.4),
              (0.1, -0.2, 0.3, 0.2, 0.1, -0.2, 0.2), (-0.2, 0.2, -0.1, 0.1, 0.4, 0.3, -0.1))  # rad
LAPS = 6  # of a motion, which takes a minute
SHORT = 0.1  # h: a soak below it has one lap a motion
SPLIT_S, SHORT_SPLIT_S = 600, 5  # of the robot's time in a file of the log; in a short soak
REPEATED = 1 / 3  # of a soak, but at most SHORT: run twice
ID = struct.Struct("<Q")
GENERATOR = 2280  # offset of a state's motion generator mode: 0 when no motion runs
KEPT_FILES = 4  # of the split log; more than end within a motion


def tables(start):
    """Datagrams of every kind of lap without the state's id, and that which ends a motion."""
    shape = [fci.there_and_back(k / LAP, 1.0) for k in range(LAP)]
    laps = [[fci.command(0, [q + a * s for q, a in zip(start, amplitudes)])[8:] for s in shape] for amplitudes in AMPLITUDES]
    return laps, fci.command(0, start, finished=True)[8:]


class SplitLog:
    """The files of a log, each looked at when it has ended, before the server removes it."""

    def __init__(self, folder, split_s):
        self.folder, self.split_s = folder, split_s
        self.cycles = []  # of each file
        self.bytes = 0
        self.begin, self.end = None, None  # ns

    def flags(self):
        return "--log", self.folder / "soak.mcap", "--log-split", f"{self.split_s} s", "--log-keep", KEPT_FILES

    def look(self):
        """Takes the files that have ended since the last look."""
        while (file := self.folder / f"soak_{len(self.cycles) + 1:04}.mcap").exists():
            counts, begin, self.end = log_statistics(file)
            self.begin = begin if self.begin is None else self.begin
            self.cycles.append(counts["/robot/cycle"])
            self.bytes += file.stat().st_size

    def kept(self):
        return len(list(self.folder.glob("soak_*.mcap*")))


class Server:
    """A robot in lockstep whose physics stands between motions, and its control channel."""

    def __init__(self, folder, seed, split_s=None):
        """split_s: seconds of the robot's time after which its log goes on in a new file; None: no log."""
        folder.mkdir()
        self.log = SplitLog(folder, split_s) if split_s else None
        flags = self.log.flags() if self.log else ()
        self.served = serve_test.Server(folder, "--drive", "lockstep", "--idle", "freeze", "--seed", seed,
                                        "--control", folder / "control", *flags, scenario=SCENARIO)
        self.channel = Channel(folder / "control")
        self.process, self.arm_port = self.served.process, self.served.arm_port

    def clock(self):
        """(cycles, milliseconds) of the robot's time."""
        answer = self.channel.ask(do="status")
        return answer["cycle"], round(answer["time_s"] * 1000)

    def end(self):
        """@returns (exit code, what stderr got)."""
        self.channel.close()
        return self.served.end()


class Mover:
    """Clients of a server, one after the other."""

    def __init__(self, server, laps_per_motion):
        self.server, self.laps_per_motion = server, laps_per_motion
        self.cycles = 0  # answered
        self.drift = 0  # ms, between message ids and the robot's clock, summed without sign
        self.hashes = []  # of the states of each motion
        self.table = None

    def session(self, number):
        """Connects, moves and leaves: in order, or by a reset of the connection."""
        arm = fci.Arm(self.server.arm_port)
        if arm.connected != fci.SUCCESS:
            raise AssertionError(f"client {number} is refused: {arm.connected}")
        arm.read()
        request = arm.start()
        start = arm.state.q_d
        if self.table is None:
            self.table = start, *tables(start)
        if self.table[0] != start:
            raise AssertionError(f"motion {number} starts at {start}, the first one at {self.table[0]}")
        before, first = self.server.clock(), arm.state.id
        last = self.motion(arm, number)
        if arm.answer(request) != bytes([fci.SUCCESS]):
            raise AssertionError(f"motion {number} failed")
        self.drift += abs((last[1][0] - before[0]) - (last[0] - first)) + abs((last[1][1] - before[1]) - (last[0] - first))
        arm.vanish() if number % 10 == 9 else arm.close()

    def motion(self, arm, number):
        """@returns (id, clock) of the last state of the motion that is answered."""
        _, laps, end = self.table
        arm.udp.settimeout(None)
        arm.udp.setsockopt(socket.SOL_SOCKET, socket.SO_RCVTIMEO, struct.pack("ll", fci.LIMIT, 0))
        arm.udp.connect(arm.robot)
        tails = itertools.chain.from_iterable(laps[(number + lap) % len(laps)] for lap in range(self.laps_per_motion))
        state = bytearray(fci.STATE_BYTES)
        digest = hashlib.blake2b(digest_size=8)
        answered = arm.state.id
        for tail in tails:
            answered = self.exchange(arm.udp, answered, tail, state, digest)
        last = answered, self.server.clock()
        while state[GENERATOR]:
            answered = self.exchange(arm.udp, answered, end, state, digest)
        self.hashes.append(digest.hexdigest())
        return last

    def exchange(self, udp, answered, tail, state, digest):
        """Answers a state and takes the next into `state`. @returns its id."""
        answer = ID.pack(answered) + tail
        while True:
            udp.send(answer)
            udp.recv_into(state)
            received, = ID.unpack_from(state)
            if received == answered + 1:
                break
            if received != answered:  # a state is sent again when its answer takes 100 ms
                raise AssertionError(f"state {received} follows state {answered}")
        digest.update(memoryview(state)[8:])
        self.cycles += 1
        return received


def log_statistics(path):
    """Of a finished MCAP file, from its summary: {topic: messages}, log times of the first and the last message, ns."""
    with open(path, "rb") as file:
        file.seek(-28, os.SEEK_END)
        summary, = struct.unpack("<Q", file.read(8))
        file.seek(summary)
        data = file.read()
    topics, counts, begin, end, at = {}, {}, 0, 0, 0
    while at + 9 <= len(data):
        kind, length = struct.unpack_from("<BQ", data, at)
        body = data[at + 9:at + 9 + length]
        if kind == 4:  # channel
            topics[struct.unpack_from("<H", body)[0]] = body[8:8 + struct.unpack_from("<I", body, 4)[0]].decode()
        elif kind == 11:  # statistics
            begin, end, size_of_map = struct.unpack_from("<QQI", body, 26)
            counts = dict(struct.iter_unpack("<HQ", body[46:46 + size_of_map]))
        at += 9 + length
    return {topics[channel]: count for channel, count in counts.items()}, begin, end


def soak(folder, hours, seed, wall_limit):
    """@returns Findings."""
    laps = LAPS if hours >= SHORT else 1
    motions = max(3, math.ceil(hours * 3_600_000 / (laps * LAP)))
    repeated = math.ceil(motions * min(REPEATED, SHORT / hours))
    first = Mover(Server(folder / "first", seed), laps)
    for number in range(repeated):
        first.session(number)
    first.server.end()

    findings, begin = Findings(), time.monotonic()
    server = Server(folder / "soak", seed, SPLIT_S if hours >= SHORT else SHORT_SPLIT_S)
    mover, samples, progress = Mover(server, laps), Samples(server.process), Progress(hours)
    for number in range(motions):
        mover.session(number)
        past = mover.cycles / 3.6e6
        usage = samples.take(past)
        server.log.look()
        progress.row(past, usage, f"log {server.log.bytes / 1e6:.0f} MB in {len(server.log.cycles)} files  drift {mover.drift} ms  "
                                  f"motions {number + 1}  wall {time.monotonic() - begin:.0f} s  states {mover.hashes[-1]}")
        if time.monotonic() - begin > wall_limit:
            break
    at_end = server.clock()
    code, errors = server.end()
    report(findings, mover, first.hashes, time.monotonic() - begin)
    report_log(findings, server.log, at_end, mover.cycles / 3.6e6)
    findings.usage(samples)
    findings.bound("server's exit code", code, "130", code == 130)
    print(errors, end="")
    return findings


def report(findings, mover, hashes, wall):
    past = mover.cycles / 3.6e6
    findings.figure("robot time in motions", f"{past:.3f} h in {len(mover.hashes)} motions, a client each")
    findings.figure("wall clock", f"{wall:.0f} s, {wall / mover.cycles * 1e6:.0f} us a cycle")
    findings.bound("drift, ids to robot time", f"{mover.drift} ms", "0", mover.drift == 0)
    digest = hashlib.blake2b("".join(mover.hashes).encode(), digest_size=8).hexdigest()
    findings.figure("hash of all states in motions", digest)
    findings.figure("different hashes of motions", f"{len(set(mover.hashes))}, of {len(AMPLITUDES)} kinds of lap")
    same = hashes == mover.hashes[:len(hashes)]
    findings.bound("states when run again", f"{len(hashes)} motions, {'the same' if same else 'others'}", "the same", same)


def report_log(findings, log, at_end, past):
    log.look()
    cycles = sum(log.cycles)
    findings.figure("size of the log", f"{log.bytes / 1e9:.3f} GB, {log.bytes / 1e9 / past:.2f} GB/h, {len(log.cycles)} files")
    drift = (log.end - log.begin) / 1e6 - (cycles - 1)
    findings.bound("drift, cycles in the log to its time", f"{drift:.6f} ms", "0", drift == 0)
    wrong = [number + 1 for number, count in enumerate(log.cycles[:-1]) if count != log.split_s * 1000]
    findings.bound("files but the last with other cycles", wrong or "none", f"none: each has {log.split_s} s", not wrong)
    findings.bound("files that are kept", log.kept(), f"{min(KEPT_FILES, len(log.cycles))}",
                   log.kept() == min(KEPT_FILES, len(log.cycles)))
    missing = at_end[0] - cycles
    findings.bound("cycles not in the log", f"{missing} of {at_end[0]}", "<= 0 (it runs on until it ends)", missing <= 0)
