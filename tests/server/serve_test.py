#!/usr/bin/env python3
"""panda-twin serve, from a client's side: serve_test.py PROGRAM SOURCE_TREE [unittest options].

The server runs in lockstep, so nothing here depends on how fast the machine is.
"""

import hashlib
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import fci_wire as fci

PROGRAM = ""
SOURCE = pathlib.Path()

SCENARIO = """\
name: served
plant: {kind: ideal}
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""


class Server:
    """A served robot on ports of its own."""

    def __init__(self, folder, *flags, scenario=SCENARIO):
        file = pathlib.Path(folder) / "served.yaml"
        file.write_text(scenario)
        self.process = subprocess.Popen(
            [PROGRAM, "serve", file, "--data", SOURCE / "models", "--port", "0", "--hand-port", "0", *map(str, flags)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=dict(os.environ, XDG_CACHE_HOME=str(folder)))
        self.lines = []
        self.more = threading.Condition()
        self.reader = threading.Thread(target=self.read, daemon=True)
        self.reader.start()
        self.arm_port = int(self.await_line(r"^  arm   127\.0\.0\.1:(\d+)$").group(1))
        self.hand_port = int(self.await_line(r"^  hand  127\.0\.0\.1:(\d+)$").group(1))

    def read(self):
        for line in self.process.stdout:
            with self.more:
                self.lines.append(line.rstrip("\n"))
                self.more.notify_all()

    def await_line(self, pattern):
        """The first line that matches."""
        def find():
            return next((m for m in (re.search(pattern, line) for line in self.lines) if m), None)
        with self.more:
            if not self.more.wait_for(lambda: find() or self.process.poll() is not None, fci.LIMIT) or not find():
                raise AssertionError(f"no line {pattern!r} in {self.lines}")
            return find()

    def end(self, how=signal.SIGTERM):
        """@returns (exit code, what stderr got). More than once: as the first time."""
        if self.process.stderr.closed:
            return self.process.returncode, ""
        if self.process.poll() is None:
            self.process.send_signal(how)
        self.reader.join(fci.LIMIT)
        errors = self.process.stderr.read()
        self.process.stderr.close()
        self.process.stdout.close()
        return self.process.wait(fci.LIMIT), errors


class ServeTest(unittest.TestCase):
    FLAGS = ("--drive", "lockstep")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def serve(self, *flags, scenario=SCENARIO):
        server = Server(self.folder, *self.FLAGS, *flags, scenario=scenario)
        self.addCleanup(server.end)
        return server

    def arm(self, server, **options):
        arm = fci.Arm(server.arm_port, **options)
        self.addCleanup(arm.close)
        return arm

    def check_serves(self, server):
        """A whole session goes well."""
        arm = self.arm(server)
        self.assertEqual(arm.connected, fci.SUCCESS)
        arm.read()
        _, end = arm.run_motion(cycles=200, amplitude=0.0002)
        self.assertEqual(end, fci.SUCCESS)
        arm.close()


class SessionTest(ServeTest):
    def test_states_flow_from_connect_on(self):
        arm = self.arm(self.serve())
        self.assertEqual((arm.connected, arm.version), (0, 5))
        states = [arm.read() for _ in range(50)]
        self.assertEqual([s.id - states[0].id for s in states], list(range(50)))
        for state in states:
            self.assertEqual((state.generator, state.controller, state.mode, state.success_rate), (0, 3, fci.IDLE, 0))

    def test_another_version_is_told_ours(self):
        server = self.serve()
        arm = self.arm(server, version=4)
        self.assertEqual((arm.connected, arm.version), (1, 5))
        self.assertEqual(arm.tcp.recv(1), b"")
        self.check_serves(server)

    def test_a_motion_runs_to_its_end(self):
        arm = self.arm(self.serve("--idle", "freeze"))  # else its first command might come too late
        arm.read()
        start = arm.read().q_d
        states, end = arm.run_motion(cycles=400, amplitude=0.02)
        self.assertEqual(end, fci.SUCCESS)
        self.assertEqual([s.id - states[0].id for s in states], list(range(len(states))))
        for state in states[:-1]:
            self.assertEqual((state.generator, state.controller, state.mode), (1, 0, fci.MOVING))
            self.assertEqual(state.success_rate, 1)
        for k, state in enumerate(states[:400]):  # states[k] shows the command that answered state k
            self.assertAlmostEqual(state.q_d[0], start[0] + fci.there_and_back(k / 400, 0.02), places=12)
        self.assertEqual((states[-1].generator, states[-1].controller), (0, 3))

    def test_a_discontinuity_is_a_reflex_until_it_is_recovered_from(self):
        server = self.serve()
        arm = self.arm(server)
        arm.read()
        request = arm.start()
        q = list(arm.state.q_d)
        while arm.state.mode == fci.MOVING:
            if arm.state.success_rate == 1:  # the first command was taken
                q[3] += 0.01
            arm.send(fci.command(arm.state.id, q))
            arm.read()
        first = arm.state
        self.assertEqual((first.mode, first.generator, first.controller), (fci.REFLEX, 0, 3))
        self.assertIn(14, first.errors)
        self.assertEqual(first.errors, first.reflex_reason)
        self.assertEqual(arm.answer(request), bytes([fci.REFLEX_ABORTED]))
        self.assertEqual(arm.ask(fci.STOP_MOVE), bytes([fci.SUCCESS]))
        self.assertEqual(arm.move()[1], fci.NOT_POSSIBLE)
        self.assertEqual(arm.ask(fci.SET_JOINT_IMPEDANCE, struct.pack("<7d", *[500] * 7)), bytes([fci.SETTING_NOT_POSSIBLE]))
        while arm.ask(fci.RECOVERY) != bytes([fci.SUCCESS]):  # refused while the reference ramps down
            arm.read()
        arm.await_mode(fci.IDLE)
        self.assertEqual(arm.newest().errors, [])
        server.await_line(r"motion aborted by reflex: joint_motion_generator_velocity_discontinuity: joint 4, ")
        server.await_line(r"Move refused: not possible in the current mode \(\"Reflex\"\)")
        self.assertEqual(arm.run_motion()[1], fci.SUCCESS)

    def test_stop_move_is_answered_before_the_move_it_preempts(self):
        arm = self.arm(self.serve())
        arm.read()
        move = arm.start()
        stops = []

        def stop(k, state):
            if k == 60:
                stops.append(arm.request(fci.STOP_MOVE))
        arm.wave(on_state=stop)
        self.assertEqual(arm.receive(), (fci.STOP_MOVE, stops[0], bytes([fci.SUCCESS])))
        self.assertEqual(arm.receive(), (fci.MOVE, move, bytes([fci.PREEMPTED])))
        self.assertEqual(arm.ask(fci.STOP_MOVE), bytes([fci.SUCCESS]))  # the client's second
        self.assertEqual(arm.run_motion()[1], fci.SUCCESS)

    def test_requests_while_moving_are_refused_and_do_no_harm(self):
        arm = self.arm(self.serve())
        arm.read()
        move = arm.start()
        answers = []

        def ask(k, state):
            if k == 30:
                answers.append(arm.ask(fci.SET_JOINT_IMPEDANCE, struct.pack("<7d", *[500] * 7)))
                answers.append(arm.ask(fci.MOVE, struct.pack("<II6d", 0, 0, 10, 3, 6, 10, 3, 6)))
                answers.append(arm.ask(fci.GET_CARTESIAN_LIMIT, struct.pack("<i", 1))[:1])
        arm.wave(on_state=ask)
        self.assertEqual(answers, [bytes([fci.SETTING_NOT_POSSIBLE]), bytes([fci.NOT_POSSIBLE]), b"\0"])
        self.assertEqual(arm.answer(move), bytes([fci.SUCCESS]))

    def test_settings_show_in_the_state_and_bad_ones_are_refused(self):
        server = self.serve()
        arm = self.arm(server)
        load = struct.pack("<d3d9d", 0.5, 0, 0, 0, *[0] * 9)
        self.assertEqual(arm.ask(fci.SET_LOAD, load), b"\0")
        while arm.newest().m_load != 0.5:
            pass
        for bad in (-1.0, float("nan")):
            self.assertEqual(arm.ask(fci.SET_LOAD, struct.pack("<d3d9d", bad, 0, 0, 0, *[0] * 9)), b"\2")
        server.await_line(r"Set Load refused: load_mass is -1")

    def test_a_load_that_is_no_body_is_refused_and_does_no_harm(self):
        server = self.serve()
        arm = self.arm(server)
        for inertia in ([-1, 0, 0, 0, -1, 0, 0, 0, -1], [0, 1, 0, 1, 0, 0, 0, 0, 0], [1, 1, 0, 0, 1, 0, 0, 0, 1]):
            self.assertEqual(arm.ask(fci.SET_LOAD, struct.pack("<d3d9d", 1, 0, 0, 0, *inertia)), b"\2")
        server.await_line(r"Set Load refused: load_inertia must be that of a body")
        arm.read()
        self.assertEqual(arm.run_motion()[1], fci.SUCCESS)

    def test_an_error_without_a_motion_is_told_at_once(self):
        text = SCENARIO.replace("kind: ideal", "kind: mujoco") + """
perturbations:
  - push: {body: panda_hand, begin: 300 ms, duration: 1 s, rise: 100 ms, force: [0 N, 90 N, 0 N]}
"""
        server = self.serve(scenario=text)
        server.await_line(r"arm: error without a motion: (cartesian|joint)_reflex: .* in the cycle of state")

    def test_there_are_no_virtual_walls(self):
        answer = self.arm(self.serve()).ask(fci.GET_CARTESIAN_LIMIT, struct.pack("<i", 3))
        self.assertEqual(len(answer), 154)
        self.assertEqual((answer[0], struct.unpack_from("<3d", answer, 1), answer[153]), (0, (0, 0, 0), 0))

    def test_the_model_library_is_a_shared_object(self):
        answer = self.arm(self.serve()).ask(fci.LOAD_MODEL_LIBRARY, b"\0\0")
        self.assertEqual(answer[:5], b"\0\x7fELF")
        self.assertLess(len(answer), 65536)
        arm = self.arm(self.serve())
        self.assertEqual(arm.ask(fci.LOAD_MODEL_LIBRARY, b"\3\0"), b"\1")  # for ARM64

    def test_a_motion_that_is_not_answered_is_stopped(self):
        server = self.serve("--idle", "freeze", "--session-timeout", 1)
        arm = self.arm(server)
        arm.read()
        move = arm.start()
        arm.newest()
        arm.send(fci.command(arm.state.id, arm.state.q_d))
        self.assertEqual(arm.answer(move), bytes([fci.PREEMPTED]))
        server.await_line("not answered for too long")

    def test_requests_come_in_any_pieces(self):
        arm = self.arm(self.serve())
        frames = b"".join(arm.head.pack(fci.STOP_MOVE, i, 12) for i in (1, 2, 3))
        for byte in frames[:20]:
            arm.tcp.sendall(bytes([byte]))
        arm.tcp.sendall(frames[20:])
        self.assertEqual([arm.receive()[1] for _ in range(3)], [1, 2, 3])


class ClientsTest(ServeTest):
    def test_a_second_client_is_sent_away_and_the_first_stays(self):
        server = self.serve()
        arm = self.arm(server)
        with self.assertRaises(ConnectionError):
            fci.Arm(server.arm_port)
        server.await_line("refused: another client is connected")
        arm.read()
        self.assertEqual(arm.run_motion()[1], fci.SUCCESS)
        arm.close()
        self.check_serves(server)

    def test_a_client_may_vanish_at_every_phase(self):
        server = self.serve()

        def before_connect(arm):
            pass

        def inside_connect(arm):
            arm.tcp.sendall(b"\0\0\0\0\0")

        def reading(arm):
            arm.read()

        def asked(arm):
            arm.request(fci.RECOVERY)

        def starting(arm):
            arm.move()

        def started(arm):
            arm.start()

        def moving(arm):
            arm.start()
            arm.wave(until=100)

        def stopping(arm):
            moving(arm)
            arm.request(fci.STOP_MOVE)

        for phase in (before_connect, inside_connect, reading, asked, starting, started, moving, stopping):
            for leave in (fci.Arm.close, fci.Arm.vanish):
                with self.subTest(phase.__name__, leave=leave.__name__):
                    arm = self.arm(server, connect=phase not in (before_connect, inside_connect))
                    phase(arm)
                    leave(arm)
                    self.check_serves(server)

    def test_frames_that_are_none_end_the_session_and_nothing_else(self):
        server = self.serve()
        for frame in (b"\xff" * 12, struct.pack("<III", 99, 1, 12), struct.pack("<III", 1, 1, 4),
                      struct.pack("<III", 1, 1, 1 << 31), struct.pack("<IIIB", 2, 1, 13, 0), struct.pack("<IIIHH", 0, 1, 16, 5, 1)):
            with self.subTest(frame.hex()):
                arm = self.arm(server)
                arm.tcp.sendall(frame)
                with self.assertRaises(ConnectionError):
                    arm.receive()
                arm.close()
        arm = self.arm(server, connect=False)
        with self.assertRaises(ConnectionError):
            arm.ask(fci.STOP_MOVE)
        self.check_serves(server)

    def test_datagrams_of_others_and_malformed_ones_are_ignored(self):
        server = self.serve()
        arm = self.arm(server)
        arm.read()
        stranger = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(stranger.close)
        move = arm.start()

        def disturb(k, state):
            if k == 0:
                return
            far = [1.0] * 7
            for _ in range(10):
                stranger.sendto(fci.command(state.id, far), arm.robot)
            arm.send(fci.command(state.id, far)[:-1])
            arm.send(fci.command(state.id, far) + b"\0")
            arm.send(fci.command(state.id, [float("nan")] * 7))
            arm.send(fci.command(state.id + 1000, far))
            arm.send(b"")
        arm.wave(on_state=disturb)
        self.assertEqual(arm.answer(move), bytes([fci.SUCCESS]))
        arm.close()
        ignored = server.await_line(r"datagrams ignored: (\d+) of others or for want of room, (\d+) malformed, (\d+) that answer no state")
        self.assertTrue(all(int(count) >= 200 for count in ignored.groups()), ignored.group(0))

    def test_replayed_commands_do_nothing(self):
        arm = self.arm(self.serve())
        arm.read()
        sent = []
        _, end = arm.run_motion(on_state=lambda k, state: [arm.send(old) for old in sent[-5:]] + [
            sent.append(fci.command(state.id - 1, [0.0] * 7, True))])
        self.assertEqual(end, fci.SUCCESS)

    def test_a_client_that_does_not_read_its_answers_is_dropped(self):
        server = self.serve()
        arm = self.arm(server)
        many = arm.head.pack(fci.GET_CARTESIAN_LIMIT, 1, 16) + b"\0\0\0\0"
        with self.assertRaises(OSError):
            for _ in range(100_000):
                arm.tcp.sendall(50 * many)
        server.await_line("does not read its answers")
        self.check_serves(server)


class HandTest(ServeTest):
    def test_the_hand_homes_moves_and_tells_its_state(self):
        server = self.serve()
        hand = fci.Hand(server.hand_port)
        self.addCleanup(hand.close)
        self.assertEqual((hand.connected, hand.version), (0, 3))
        before = hand.read()
        self.assertEqual(hand.do(fci.HAND_HOMING), 0)
        self.assertEqual(hand.do(fci.HAND_MOVE, struct.pack("<2d", 0.03, 0.1)), 0)
        state = hand.read()
        while state[2] == 0 or abs(state[1] - 0.03) > 1e-3:
            state = hand.read()
        self.assertGreater(state[0], before[0])
        self.assertAlmostEqual(state[2], 0.08, places=3)

    def test_stop_aborts_what_runs_and_bad_widths_fail(self):
        server = self.serve()
        hand = fci.Hand(server.hand_port)
        self.addCleanup(hand.close)
        homing = hand.request(fci.HAND_HOMING)
        stop = hand.request(fci.HAND_STOP)
        self.assertEqual(hand.answer(homing), b"\3\0")
        self.assertEqual(hand.answer(stop), b"\0\0")
        self.assertEqual(hand.do(fci.HAND_MOVE, struct.pack("<2d", 7.0, 0.1)), 1)
        server.await_line("hand: Move refused: width is 7")

    def test_arm_and_hand_are_served_apart(self):
        server = self.serve()
        hand = fci.Hand(server.hand_port)
        self.check_serves(server)
        hand.vanish()
        self.check_serves(server)
        hand = fci.Hand(server.hand_port)
        self.addCleanup(hand.close)
        self.assertEqual(hand.do(fci.HAND_STOP), 0)


class ProgramTest(ServeTest):
    def test_it_ends_after_its_time(self):
        server = self.serve("--for", 0.1)
        self.assertEqual(server.process.wait(fci.LIMIT), 0)

    def test_an_arm_does_not_start_within_itself(self):
        scenario = pathlib.Path(self.folder) / "within.yaml"
        scenario.write_text("name: within\nrobot: {q_start: {unit: rad, values: [-0.2088, -0.3707, 0.3834, -2.9844, -0.3372, 0.9397, 0.2327]}}\n")
        done = subprocess.run([PROGRAM, "serve", scenario, "--port", "0", "--hand-port", "0", "--for", "1"], capture_output=True, text=True)
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertRegex(done.stderr, r"^panda-twin: error: the start: there panda_\w+ would lie at least \d+\.\d mm deep in panda_\w+; 1 mm at most is a touch\n$")

    def test_an_interrupt_ends_it_and_resets_who_waits(self):
        for how in (signal.SIGINT, signal.SIGTERM):
            server = self.serve()
            arm = self.arm(server)
            arm.start()
            code, errors = server.end(how)
            self.assertEqual(code, 130, errors)
            with self.assertRaises(ConnectionResetError):
                arm.receive()

    def test_a_log_holds_the_cycles(self):
        log = pathlib.Path(self.folder) / "session.mcap"
        server = self.serve("--log", log)
        self.check_serves(server)
        server.end()
        subprocess.run([PROGRAM, "export", log, "--out", pathlib.Path(self.folder) / "csv"], check=True, capture_output=True)
        self.assertGreater(len((pathlib.Path(self.folder) / "csv/cycles.csv").read_text().splitlines()), 50)

    def test_a_capture_holds_what_was_said_in_order(self):
        capture = pathlib.Path(self.folder) / "session.pcapng"
        server = self.serve("--capture", capture)
        arm = self.arm(server)
        arm.read()
        states, end = arm.run_motion(cycles=200, amplitude=0.0002)
        self.assertEqual(end, fci.SUCCESS)
        arm.close()
        port, hand_port = str(server.arm_port), str(server.hand_port)
        server.end()

        def decode(*flags):
            return subprocess.run([PROGRAM, "decode", capture, "--port", port, "--hand-port", hand_port, *flags], check=True,
                                  capture_output=True, text=True).stdout
        brief = decode("--brief")
        told = re.findall(r"(?:request|answer) \d+: .*", brief)
        self.assertEqual(told, ["request 0: Connect", "answer 0: Connect", "request 1: Move", "answer 1: Move",
                                "answer 1: Move"])
        ids = [int(k) for k in re.findall(r" state (\d+):", brief)]
        self.assertEqual(ids, sorted(ids))
        self.assertLessEqual({s.id for s in states}, set(ids))
        self.assertGreaterEqual(brief.count("command for state"), 50)
        full = decode()
        self.assertIn("    version = 5\n", full)
        self.assertIn("    status = 1 (motion_started)\n", full)
        elsewhere = subprocess.run([PROGRAM, "decode", capture, "--brief", "--port", "1", "--hand-port", "2"], check=True,
                                   capture_output=True, text=True)
        self.assertIn("between other ports", elsewhere.stdout)
        self.assertEqual(elsewhere.stderr.count("name them with --port, --hand-port and --vacuum-port"), 1)

    def refused(self, *flags):
        result = subprocess.run([PROGRAM, "serve", *flags, "--data", SOURCE / "models"], capture_output=True, text=True,
                                timeout=fci.LIMIT)
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertEqual(result.stdout, "")
        return result.stderr

    def test_what_does_not_go_together_is_refused(self):
        self.assertIn("--allow", self.refused("--bind", "0.0.0.0"))
        self.assertIn("--drive lockstep", self.refused("--idle", "freeze"))
        self.assertIn("--drive realtime", self.refused("--drive", "lockstep", "--clock-ppm", "5"))
        self.assertIn("no-such", self.refused("--drive", "no-such"))
        self.assertIn("realtime or lockstep", self.refused("--drive", "remote"))
        self.assertIn("neither run nor freeze", self.refused("--drive", "lockstep", "--idle", "no-such"))
        self.assertIn("--session-timeout", self.refused("--session-timeout", "0"))
        self.assertIn("--for", self.refused("--for", "-1"))
        self.assertIn("12.0.0.0/99", self.refused("--allow", "12.0.0.0/99"))
        self.assertIn("one of a, b", self.refused("--lab", "nowhere"))

    def test_a_port_that_is_taken_is_named(self):
        server = self.serve()
        result = subprocess.run([PROGRAM, "serve", "--port", str(server.arm_port), "--data", SOURCE / "models"],
                                capture_output=True, text=True, timeout=fci.LIMIT)
        self.assertEqual(result.returncode, 4, result.stderr)
        self.assertIn(str(server.arm_port), result.stderr)


class LabTest(ServeTest):
    def gravity_torque(self, plant):
        """What the second joint bears of an arm at rest at such a site, Nm."""
        lab = pathlib.Path(self.folder) / "lab.yaml"
        lab.write_text(f"plant: {plant}\nlink: {{state_delay: 5 ms}}\n")
        server = self.serve("--lab", lab, scenario=SCENARIO.replace("plant: {kind: ideal}\n", ""))
        arm = self.arm(server)
        while arm.read().id < 1500:  # it sags by its own weight, against springs
            pass
        torques = [arm.read().tau_J[1] for _ in range(100)]
        self.check_delay(arm)
        server.end()
        return sum(torques) / len(torques)

    def check_delay(self, arm):
        """The robot has an answer in time, as over a link that delays nothing: from the first on no cycle of the motion is lost."""
        states, end = arm.run_motion(cycles=200, amplitude=0.0002)
        self.assertEqual(end, fci.SUCCESS)
        rates = [state.success_rate for state in states[:-1]]
        served = rates[next(i for i, rate in enumerate(rates) if rate > 0):]  # before it time runs by the wall clock
        self.assertEqual(set(served), {1})
        self.assertGreater(len(served), 100)

    def test_the_arm_is_that_of_the_lab_and_the_wire_that_which_is_there(self):
        usual = self.gravity_torque("{friction: none}")
        heavy = self.gravity_torque("{friction: none, mass_scale: 1.05}")
        self.assertAlmostEqual(heavy / usual, 1.05, delta=0.002)


class FreezeTest(ServeTest):
    """The default body is MuJoCo's: physics that would move on if it could."""

    FLAGS = ("--drive", "lockstep", "--idle", "freeze")
    SCENARIO = SCENARIO.replace("plant: {kind: ideal}", "plant: {kind: mujoco}\nlink: {command_loss: 3 %}\nseed: 5")

    def session(self, pause):
        """One program. @param pause  seconds between two things it does. @returns a hash per motion."""
        server = self.serve(scenario=self.SCENARIO)
        arm = self.arm(server)
        hashes = []
        arm.read()
        for motion in range(3):
            time.sleep(pause)
            states, end = arm.run_motion(amplitude=0.01, joint=motion)
            self.assertEqual(end, fci.SUCCESS)
            hashes.append(hashlib.sha256(b"".join(state.content for state in states)).hexdigest())
            time.sleep(pause)
            self.assertEqual(arm.ask(fci.SET_LOAD, struct.pack("<d12d", 0.1 * motion, *[0] * 12)), b"\0")
            self.assertEqual(arm.ask(fci.RECOVERY), b"\0")
        server.end()
        return hashes

    def test_a_program_repeats_bit_for_bit_whatever_passes_between_its_motions(self):
        self.assertEqual(self.session(0), self.session(0.11))

    def test_states_go_on_while_physics_stands_still(self):
        arm = self.arm(self.serve(scenario=self.SCENARIO))
        first = arm.read()
        for i in range(1, 100):
            state = arm.read()
            self.assertEqual(state.id, first.id + i)
            self.assertEqual(state.content, first.content)


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1] + sys.argv[3:])
