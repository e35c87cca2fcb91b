#!/usr/bin/env python3
"""The control channel of `panda-twin serve --control`, and `panda-twin ctl`:

    serve_control_test.py PROGRAM SOURCE_TREE [unittest options]
"""

import contextlib
import json
import pathlib
import socket
import stat
import subprocess
import sys
import threading
import unittest

import fci_wire as fci
import serve_test


class Channel:
    """A connection to a control channel."""

    def __init__(self, path):
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(fci.LIMIT)
        self.socket.connect(str(path))
        self.lines = self.socket.makefile("r")

    def send(self, **request):
        self.socket.sendall(json.dumps(request).encode() + b"\n")

    def answer(self):
        return json.loads(self.lines.readline())

    def ask(self, **request):
        self.send(**request)
        return self.answer()

    def close(self):
        self.lines.close()
        self.socket.close()


class ControlTest(serve_test.ServeTest):
    def setUp(self):
        super().setUp()
        self.path = pathlib.Path(self.folder, "control")

    def serve(self, *flags, **more):
        return super().serve("--control", self.path, *flags, **more)

    def channel(self):
        """Closed when the test ends."""
        channel = Channel(self.path)
        self.addCleanup(channel.close)
        return channel

    def ctl(self, *words):
        """@returns (exit code, standard output, standard error)."""
        done = subprocess.run([serve_test.PROGRAM, "ctl", self.path, *words], capture_output=True, text=True, timeout=fci.LIMIT)
        return done.returncode, done.stdout, done.stderr


class TimeTest(ControlTest):
    def test_paused_between_motions_a_client_sees_the_same_state_and_steps_count(self):
        arm = self.arm(self.serve())
        channel = self.channel()
        paused = channel.ask(do="pause")
        self.assertTrue(paused["ok"] and paused["paused"] and paused["lockstep"], paused)
        self.assertEqual(channel.ask(do="status")["cycle"], paused["cycle"])
        first = arm.newest()
        for _ in range(20):
            self.assertEqual(arm.read().content, first.content)
        stepped = channel.ask(do="step", cycles=10)
        self.assertEqual(stepped["cycle"], paused["cycle"] + 10)
        self.assertAlmostEqual(stepped["time_s"], stepped["cycle"] * 1e-3)
        self.assertTrue(stepped["paused"])
        self.assertFalse(channel.ask(do="resume")["paused"])
        refused = channel.ask(do="step")
        self.assertFalse(refused["ok"])
        self.assertIn("pause first", refused["error"])
        _, end = arm.run_motion(cycles=200, amplitude=0.0002)
        self.assertEqual(end, fci.SUCCESS)

    def motion(self, on_state):
        server = self.serve("--idle", "freeze")
        arm = self.arm(server)
        arm.read()
        states, end = arm.run_motion(on_state=on_state)
        self.assertEqual(end, fci.SUCCESS)
        server.end()  # the next one takes its socket's place
        return [state.content for state in states]

    def test_steps_in_a_motion_change_no_bit_of_it(self):
        unpaused = self.motion(lambda k, state: None)
        channels = []

        def step(k, _):
            if k == 100:
                channels.append(self.channel())
                self.cycle = channels[0].ask(do="pause")["cycle"]
                channels[0].send(do="step", cycles=5)  # answered when the client has answered five states
            if k == 105:
                self.assertEqual(channels[0].answer()["cycle"], self.cycle + 5)
                self.assertTrue(channels[0].ask(do="status")["paused"])
                channels[0].ask(do="resume")
        self.assertEqual(self.motion(step), unpaused)
        self.assertEqual(len(channels), 1)

    def test_the_wall_clock_is_not_paused(self):
        self.FLAGS = ("--drive", "realtime")
        self.serve()
        for verb in ("pause", "step", "resume"):
            code, _, errors = self.ctl(verb)
            self.assertEqual(code, 1)
            self.assertIn(f"{verb}: this robot runs on the wall clock", errors)
            self.assertIn("--drive lockstep", errors)
        self.assertEqual(self.ctl("status")[0], 0)


class PanelTest(ControlTest):
    def test_the_user_stop_is_pressed_and_released(self):
        arm = self.arm(self.serve())
        self.assertEqual(self.ctl("user-stop", "press")[0], 0)
        arm.await_mode(5)
        self.assertEqual(arm.move()[1], fci.NOT_POSSIBLE)
        self.assertIn("mode User stopped", self.ctl("status")[1])
        self.assertEqual(self.ctl("user-stop", "release")[0], 0)
        arm.await_mode(fci.IDLE)
        self.assertEqual(arm.run_motion(cycles=200, amplitude=0.0002)[1], fci.SUCCESS)

    def test_the_arm_is_guided(self):
        arm = self.arm(self.serve())
        self.assertEqual(self.ctl("guiding", "on")[0], 0)
        arm.await_mode(3)
        self.assertEqual(self.ctl("guiding", "off")[0], 0)
        arm.await_mode(fci.IDLE)

    def test_an_error_is_recovered_from(self):
        arm = self.arm(self.serve())
        arm.read()
        self.assertEqual(arm.run_motion(amplitude=3.0)[1], fci.REFLEX_ABORTED)
        channel = self.channel()
        status = channel.ask(do="status")
        self.assertEqual(status["mode"], "Reflex")
        self.assertTrue(any(error.startswith("joint_motion_generator") for error in status["errors"]), status)
        while not (recovered := channel.ask(do="recover"))["ok"]:  # refused while the arm comes to rest
            pass
        self.assertEqual(recovered["mode"], "Idle")
        arm.await_mode(fci.IDLE)
        self.assertEqual(channel.ask(do="status")["errors"], [])

    def test_what_the_robot_does_not_accept_is_refused(self):
        arm = self.arm(self.serve())
        arm.start()
        code, _, errors = self.ctl("guiding", "on")
        self.assertEqual(code, 1)
        self.assertIn('the robot does not accept it in mode "Move"', errors)


class ResetTest(ControlTest):
    def test_after_a_reset_a_client_sees_the_same_bytes_again(self):
        arm = self.arm(self.serve("--idle", "freeze", "--reset", "on-command"))
        arm.read()

        def motion():
            states, end = arm.run_motion()
            self.assertEqual(end, fci.SUCCESS)
            return [state.content for state in states]
        first = motion()
        self.assertNotEqual(motion(), first, "an arm that has moved does not stand exactly where it began")
        code, _, errors = self.ctl("reset")
        self.assertEqual(code, 0, errors)
        self.assertEqual(motion(), first)

    def test_each_client_finds_the_robot_as_new(self):
        server = self.serve("--idle", "freeze", "--reset", "on-connect")
        first = self.arm(server)
        state = first.read()
        self.assertEqual(first.run_motion(amplitude=3.0)[1], fci.REFLEX_ABORTED)
        self.assertNotEqual(first.newest().content, state.content)
        first.close()
        second = self.arm(server)
        self.assertEqual(second.read().content, state.content)
        self.assertEqual(second.run_motion()[1], fci.SUCCESS)

    def test_the_arm_is_put_where_it_is_asked_to(self):
        arm = self.arm(self.serve("--reset", "on-command"))
        arm.read()
        self.assertEqual(self.ctl("reset", "0.3", "-0.5", "0", "-2", "0", "1.5", "0.7")[0], 0)
        while arm.newest().q_d[0] != 0.3:
            pass
        self.assertEqual(arm.run_motion(cycles=200, amplitude=0.0002)[1], fci.SUCCESS)
        code, _, errors = self.ctl("reset", "9", "-0.5", "0", "-2", "0", "1.5", "0.7")
        self.assertEqual(code, 1)
        self.assertIn("reset: joint 1 (rad) is 9", errors)
        self.assertEqual(self.ctl("reset", "ready")[0], 0)

    def test_the_arm_is_not_put_into_the_floor(self):
        arm = self.arm(self.serve("--reset", "on-command", scenario=serve_test.SCENARIO.replace("plant: {kind: ideal}\n", "")))
        before = arm.read().q_d
        code, _, errors = self.ctl("reset", "0", "1.5", "0", "-0.5", "0", "1.5", "0.7")
        self.assertEqual(code, 1)
        self.assertRegex(errors, r"reset: there panda_\w+ would lie at least \d+\.\d mm deep in floor")
        self.assertEqual(arm.newest().q_d, before)
        self.assertEqual(self.ctl("reset", "0.3", "-0.5", "0", "-2", "0", "1.5", "0.7")[0], 0)

    def test_a_motion_is_not_reset(self):
        arm = self.arm(self.serve("--reset", "on-command"))
        arm.start()
        code, _, errors = self.ctl("reset")
        self.assertEqual(code, 1)
        self.assertIn("refused in a motion", errors)

    def test_by_default_nothing_resets_it(self):
        self.serve()
        code, _, errors = self.ctl("reset")
        self.assertEqual(code, 1)
        self.assertIn("--reset on-command", errors)
        code, told, errors = self.ctl("--json", "reset")
        self.assertEqual(code, 1)
        self.assertIn(json.loads(told)["error"], errors)
        done = subprocess.run([serve_test.PROGRAM, "serve", "--drive", "realtime", "--reset", "on-connect"], capture_output=True,
                              text=True, timeout=fci.LIMIT)
        self.assertEqual(done.returncode, 3)
        self.assertIn("--reset goes with --drive lockstep", done.stderr)


OBJECTS = """\
name: served
objects:
  - {name: box, shape: box, size: [100 mm, 100 mm, 100 mm], mass: 200 g, position: [600 mm, 300 mm, 50 mm]}
  - {name: can, shape: cylinder, size: [60 mm, 60 mm, 100 mm], mass: 200 g, position: [600 mm, -300 mm, 50 mm]}
  - {name: wall, shape: box, size: [100 mm, 100 mm, 500 mm], position: [-600 mm, 0 m, 250 mm]}
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
"""


class RewindTest(ControlTest):
    def motion(self, arm):
        states, end = arm.run_motion()
        self.assertEqual(end, fci.SUCCESS)
        return [state.content for state in states]

    def test_from_a_snapshot_a_client_sees_the_same_bytes_each_time(self):
        arm = self.arm(self.serve("--idle", "freeze", scenario=OBJECTS))
        arm.read()
        self.motion(arm)
        code, _, errors = self.ctl("snapshot")
        self.assertEqual(code, 0, errors)
        cycle = self.channel().ask(do="status")["cycle"]
        went_on = self.motion(arm)
        for again in range(2):
            self.assertEqual(self.ctl("place", "box", "0.3", "0", "0.9")[0], 0)  # onto the arm
            self.assertNotEqual(self.motion(arm), went_on)
            last = arm.newest().id
            restored = self.channel().ask(do="restore")
            self.assertEqual(restored["cycle"], cycle)
            self.assertGreater(arm.newest().id, last)
            self.assertEqual(self.motion(arm), went_on, again)

    def test_with_a_pace_too(self):
        self.FLAGS = ("--drive", "lockstep", "--pace", "1")
        arm = self.arm(self.serve())
        arm.read()
        channel = self.channel()
        channel.ask(do="pause")  # the same cycles before each motion
        state = arm.newest().content
        self.assertTrue(channel.ask(do="snapshot", name="a")["ok"])
        self.assertTrue(channel.ask(do="user-stop", on=True)["ok"])
        channel.ask(do="step", cycles=50)
        self.assertEqual(channel.ask(do="status")["mode"], "User stopped")
        restored = channel.ask(do="restore", name="a")
        self.assertEqual((restored["mode"], restored["paused"]), ("Idle", True))
        while arm.newest().content != state:
            pass
        channel.ask(do="resume")
        self.assertEqual(arm.run_motion(cycles=200, amplitude=0.0002)[1], fci.SUCCESS)

    def test_an_error_is_told_again_after_its_time_was_taken_back(self):
        server = self.serve(scenario=OBJECTS.replace("mass: 200 g, position: [600 mm, 300", "mass: 20 kg, position: [600 mm, 300"))
        channel = self.channel()
        channel.ask(do="pause")
        while not channel.ask(do="snapshot", name="a")["ok"]:  # the robot's time has just begun
            pass
        channel.ask(do="step", cycles=5)
        told = "error without a motion"
        drop = {"do": "place", "name": "box", "position": [0.3, 0, 0.9]}  # onto the arm
        self.assertTrue(channel.ask(**drop)["ok"])
        channel.ask(do="step", cycles=1000)
        server.await_line(told)
        channel.ask(do="restore", name="a")
        self.assertTrue(channel.ask(**drop)["ok"])  # 5 cycles earlier than before
        channel.ask(do="step", cycles=1000)
        with server.more:
            def again():
                restored = next((i for i, line in enumerate(server.lines) if '"restore"' in line), len(server.lines))
                return any(told in line for line in server.lines[restored:])
            self.assertTrue(server.more.wait_for(again, fci.LIMIT), server.lines)

    def test_neither_is_for_the_middle_of_a_motion(self):
        arm = self.arm(self.serve())
        channel = self.channel()
        while not channel.ask(do="snapshot")["ok"]:  # the robot's time has just begun
            pass
        arm.start()
        for verb in ("snapshot", "restore"):
            code, _, errors = self.ctl(verb)
            self.assertEqual(code, 1)
            self.assertIn(f"{verb}: refused in a motion", errors)
        self.assertIn('no snapshot "b"; there are: last', self.ctl("restore", "b")[2])

    def test_an_object_is_put_where_it_is_asked_to(self):
        self.serve(scenario=OBJECTS)
        channel = self.channel()
        channel.ask(do="pause")
        self.assertTrue(channel.ask(do="place", name="box", position=[0.6, 0, 0.05], rpy=[0, 0, 0.5])["ok"])
        channel.ask(do="step", cycles=200)
        self.assertIn('"can" would lie', channel.ask(do="place", name="can", position=[0.6, 0, 0.05])["error"])
        self.assertIn("mm deep in box", channel.ask(do="place", name="can", position=[0.6, 0, 0.05])["error"])
        self.assertTrue(channel.ask(do="place", name="can", position=[0.6, 0, 0.15])["ok"], "it stands on the box")
        self.assertIn("those that move freely: box, can", channel.ask(do="place", name="cup", position=[0, 0, 1])["error"])
        self.assertIn('"wall" does not move freely', channel.ask(do="place", name="wall", position=[0, 0, 1])["error"])

    def test_the_wall_clock_places_objects_and_goes_back_to_nothing(self):
        self.FLAGS = ("--drive", "realtime")
        self.serve(scenario=OBJECTS)
        self.assertEqual(self.ctl("place", "box", "0.6", "0", "0.3", "0.1", "0", "-0.5")[0], 0)
        code, _, errors = self.ctl("snapshot")
        self.assertEqual(code, 1)
        self.assertIn("snapshot: this robot runs on the wall clock", errors)

    def test_the_ideal_plant_has_no_objects(self):
        self.serve()
        code, _, errors = self.ctl("place", "box", "0", "0", "1")
        self.assertEqual(code, 1)
        self.assertIn("the ideal plant has no objects", errors)


class ChannelTest(ControlTest):
    def test_bytes_that_are_no_request_end_the_connection_and_have_no_effect(self):
        self.serve()
        for sent in (b"POST / HTTP/1.1\r\n\r\n{\"do\":\"pause\"}\n", b"\xff\xfe\n{\"do\":\"pause\"}\n", b"{\"do\":\"fly\"}\n",
                     b"x" * 5000):
            with self.subTest(sent=sent[:20]):
                channel = self.channel()
                channel.socket.sendall(sent)
                answer = channel.answer()
                self.assertFalse(answer["ok"])
                self.assertTrue(answer["error"].isprintable())
                with contextlib.suppress(ConnectionResetError):  # bytes were left unread
                    self.assertEqual(channel.lines.readline(), "")
        self.assertFalse(self.channel().ask(do="status")["paused"])

    def test_several_programs_and_several_requests_at_once(self):
        self.serve()
        first, second = self.channel(), self.channel()
        first.socket.sendall(b'{"do":"pause"}\n{"do":"step","cycles":20}\n{"do":"status"}\n')
        paused, stepped, status = first.answer(), first.answer(), first.answer()
        self.assertEqual((stepped["cycle"], status["cycle"]), (paused["cycle"] + 20, paused["cycle"] + 20))
        self.assertEqual(second.ask(do="status")["cycle"], status["cycle"])
        for _ in range(20):  # more than are served at once, one after the other
            channel = Channel(self.path)
            self.assertTrue(channel.ask(do="status")["ok"])
            channel.close()

    def test_a_ninth_program_is_told_that_there_are_eight(self):
        self.serve()
        channels = [self.channel() for _ in range(8)]
        for channel in channels:
            self.assertTrue(channel.ask(do="status")["ok"])
        code, _, errors = self.ctl("status")
        self.assertEqual(code, 1, errors)
        self.assertIn("8 programs", errors)
        channels[0].close()
        self.assertEqual(self.ctl("status")[0], 0)

    def test_programs_that_have_ended_do_not_count(self):
        self.serve()
        for _ in range(200):
            channels = [Channel(self.path) for _ in range(8)]
            for channel in channels:
                channel.close()
            with contextlib.closing(Channel(self.path)) as channel:
                self.assertTrue(channel.ask(do="status")["ok"])

    def test_a_line_that_is_too_long_is_no_request_however_it_comes(self):
        self.serve()
        for pieces in ((5000,), (4000, 1000)):
            channel = self.channel()
            line = b'{"do":"pause"}'.ljust(sum(pieces)) + b"\n"
            with contextlib.suppress(BrokenPipeError):
                channel.socket.sendall(line[:pieces[0]])
                channel.socket.sendall(line[pieces[0]:])
            self.assertIn("at most 4096 bytes", channel.answer()["error"])
        self.assertFalse(self.channel().ask(do="status")["paused"])

    def test_what_answers_but_is_no_control_channel_is_told_so(self):
        for answer in (b"[]", b"\xff", b'{"ok":1}', b'{"ok":true}', b'{"ok":false}', b'{"ok":false,"error":1}', b'{"ok":true,"errors":[],"mode":1}'):
            with self.subTest(answer=answer), socket.socket(socket.AF_UNIX) as listener:
                self.path.unlink(missing_ok=True)
                listener.bind(str(self.path))
                listener.listen(1)

                def serve(listener=listener, answer=answer):
                    connection, _ = listener.accept()
                    with connection:
                        connection.recv(4096)
                        connection.sendall(answer + b"\n")
                server = threading.Thread(target=serve)
                server.start()
                code, _, errors = self.ctl("status")
                server.join()
                self.assertEqual(code, 4, errors)
                self.assertIn("no control channel", errors)

    def test_its_requests_are_events_of_the_session(self):
        server = self.serve("--out", pathlib.Path(self.folder, "out"))
        self.channel().ask(do="pause")
        self.channel().ask(do="resume")
        self.assertTrue(server.await_line(r'control: \{"do":"pause"\}'))
        server.end()
        self.assertIn("pause", pathlib.Path(self.folder, "out/report.html").read_text())

    def test_only_this_user_opens_the_socket_and_it_goes_with_the_server(self):
        server = self.serve()
        self.assertEqual(stat.S_IMODE(self.path.stat().st_mode), 0o600)
        server.end()
        self.assertFalse(self.path.exists())
        code, _, errors = self.ctl("status")
        self.assertEqual(code, 4)
        self.assertIn("no served robot has its control channel there", errors)

    def refused(self, code):
        done = subprocess.run([serve_test.PROGRAM, "serve", "--port", "0", "--hand-port", "0", "--drive", "lockstep", "--for", "0.1",
                               "--data", serve_test.SOURCE / "models", "--control", self.path], capture_output=True, text=True)
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def test_another_server_s_socket_and_other_files_are_kept_and_a_dead_one_is_replaced(self):
        self.path.write_text("mine")
        self.assertIn("is not a socket", self.refused(3))
        self.assertEqual(self.path.read_text(), "mine")
        self.path.unlink()
        dead = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        dead.bind(str(self.path))
        dead.close()
        self.serve()
        self.assertIn("another server", self.refused(4))
        self.assertTrue(self.channel().ask(do="status")["ok"])

    def test_words_that_are_no_request_are_refused(self):
        self.serve()
        for words, says in ((("fly",), "choose one of status"), (("step", "0"), "[1, "), (("user-stop",), "press or release")):
            code, _, errors = self.ctl(*words)
            self.assertEqual(code, 3)
            self.assertIn(says, errors)


if __name__ == "__main__":
    serve_test.PROGRAM, serve_test.SOURCE = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2]).resolve()
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
