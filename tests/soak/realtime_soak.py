"""Hours of the wall clock: clients connect, move, and leave in order, by a reset, killed, or without a word."""

import collections
import pathlib
import signal
import socket
import subprocess
import sys
import time

import doomed_client
import fci_wire as fci
import serve_test
from soak_figures import Findings, Progress, Samples

SCENARIO = serve_test.SCENARIO.replace("plant: {kind: ideal}\n", "")
MOVE_MS = 3000
HOME = (0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854)  # of the scenario
OFFSET = 0.1  # rad to either side of it, all joints
TCP_REPAIR = 19  # Linux: a socket that is closed under it sends neither FIN nor RST


def smooth(x):
    """From 0 to 1 without a step in acceleration or jerk at either end."""
    return x ** 4 * (35 - 84 * x + 70 * x ** 2 - 20 * x ** 3) if x < 1 else 1.0


class Clients:
    """Of a server, one after the other."""

    def __init__(self, server):
        self.server = server
        self.number = 0
        self.motions, self.aborted, self.recovered, self.away = 0, 0, 0, 0
        self.states, self.missed, self.lost_commands = 0, 0, 0
        self.lateness = None  # ms by which the robot's time fell behind the wall clock
        self.origin = None
        self.leaves = collections.Counter()
        self.slowest = 0.0  # s until the robot served the next

    def connect(self):
        """The robot turns clients away until it has found out that the last one is gone."""
        begin = time.monotonic()
        while True:
            try:
                arm = fci.Arm(self.server.arm_port)
                break
            except ConnectionError:
                self.away += 1
                if time.monotonic() - begin > fci.LIMIT:
                    raise
                time.sleep(0.1)
        arm.newest()
        self.slowest = max(self.slowest, time.monotonic() - begin)
        if arm.state.mode == fci.REFLEX:
            self.recovered += 1
            while arm.state.mode != fci.IDLE:
                arm.ask(fci.RECOVERY)  # refused while the arm is not at rest yet
                arm.newest()
        arm.await_mode(fci.IDLE)
        self.note_time(arm)
        return arm

    def note_time(self, arm):
        now = time.monotonic() * 1000 - arm.newest().id
        self.origin = now if self.origin is None else self.origin
        self.lateness = now - self.origin

    def move(self, arm, until_ms=MOVE_MS):
        """Towards the next goal, and to its end unless it breaks off before. @returns whether the motion goes on or went well."""
        request = arm.start()
        start, first = arm.state.q_d, arm.state.id
        goal = [q + (OFFSET if self.number % 2 else -OFFSET) for q in HOME]
        self.motions += 1
        before = first
        while arm.state.mode == fci.MOVING:
            k = arm.state.id - first
            if k >= until_ms and until_ms < MOVE_MS:
                return True
            s = smooth(k / MOVE_MS)
            arm.send(fci.command(arm.state.id, [a + (b - a) * s for a, b in zip(start, goal)], k >= MOVE_MS))
            arm.newest()
            self.states += 1
            self.missed += arm.state.id - before - 1
            before = arm.state.id
            if arm.state.mode == fci.MOVING and k >= 100:
                self.lost_commands += arm.state.success_rate < 1
        well = arm.answer(request) == bytes([fci.SUCCESS])
        self.aborted += not well
        return well

    def session(self):
        leave = (self.in_order, self.reset, self.in_order, self.killed, self.in_order, self.half_open)[self.number % 6]
        leave()
        self.leaves[leave.__name__] += 1
        self.number += 1

    def in_order(self):
        arm = self.connect()
        self.move(arm)
        hand = fci.Hand(self.server.hand_port)
        hand.do(fci.HAND_STOP)
        hand.close()
        arm.close()

    def reset(self):
        arm = self.connect()
        self.move(arm, MOVE_MS // 2)
        arm.vanish()

    def half_open(self):
        """The connection's other end is gone and nobody said so; without the right to do that, one direction of it is shut."""
        arm = self.connect()
        self.move(arm, MOVE_MS // 2)
        try:
            arm.tcp.setsockopt(socket.IPPROTO_TCP, TCP_REPAIR, 1)
        except PermissionError:
            arm.tcp.shutdown(socket.SHUT_WR)
        arm.close()

    def killed(self):
        """kill -9 of a process, in a phase of its session that differs each time."""
        self.connect().close()
        phase = doomed_client.PHASES[self.number // 6 % len(doomed_client.PHASES)]
        doomed = pathlib.Path(doomed_client.__file__)
        with subprocess.Popen([sys.executable, "-B", doomed, phase, str(self.server.arm_port), str(self.server.hand_port)],
                              stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as client:
            client.stdout.readline()  # "there", or nothing when a lost cycle has ended its session
            client.send_signal(signal.SIGKILL)


def soak(folder, hours, seed, wall_limit):
    """@returns Findings."""
    server = serve_test.Server(folder, "--drive", "realtime", "--seed", seed, scenario=SCENARIO)
    clients, samples, progress, findings = Clients(server), Samples(server.process), Progress(hours), Findings()
    begin = time.monotonic()
    past = 0.0
    while past < hours and past * 3600 < wall_limit:
        clients.session()
        past = (time.monotonic() - begin) / 3600
        progress.row(past, samples.take(past), f"clients {clients.number}  motions {clients.motions}  aborted {clients.aborted}  "
                                               f"late {clients.lateness:.1f} ms")
    clients.connect().close()
    code, errors = server.end()
    findings.figure("wall clock", f"{past:.3f} h")
    findings.figure("clients, by how they left", ", ".join(f"{count} {name}" for name, count in sorted(clients.leaves.items())))
    findings.figure("turned away meanwhile", clients.away)
    findings.figure("longest until the next is served", f"{clients.slowest:.2f} s")
    findings.figure("motions, aborted, recovered", f"{clients.motions}, {clients.aborted}, {clients.recovered}")
    findings.figure("cycles late, of the robot", f"{clients.lateness:.1f} ms in all")
    findings.figure("states that a client missed", f"{clients.missed} of {clients.states + clients.missed}")
    findings.figure("states with success rate < 1", f"{clients.lost_commands} of {clients.states}")
    findings.usage(samples)
    findings.bound("server's exit code", code, "130", code == 130)
    print(errors, end="")
    return findings
