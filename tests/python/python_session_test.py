"""A session: motions, hand, objects, snapshots, threads and Ctrl-C, in one process."""

import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import numpy as np

import panda_twin as pt

PANDA_TWIN = pathlib.Path(pt.__file__).parents[2] / "panda-twin"
REST = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
IDEAL = f"""name: ideal
plant: {{kind: ideal}}
robot: {{q_start: {{unit: rad, values: {REST}}}}}
"""
TABLE = f"""name: table
scene: scenes/table_box.xml
robot: {{q_start: {{unit: rad, values: {REST}}}}}
link: {{state_delay: 60 us, command_delay: 60 us}}
plant: {{noise: {{q: 1e-6 rad}}}}
"""


def turned(angle, joint=0):
    q = list(REST)
    q[joint] += angle
    return q


def trajectory(*points, **pace):
    return pt.Trajectory(list(points), **pace)


class Motions(unittest.TestCase):
    def test_moves_there_and_back(self):
        with pt.Session(IDEAL) as session:
            there = session.move(trajectory(REST, turned(0.2)), name="there")
            self.assertTrue(there.succeeded)
            self.assertEqual((there.name, there.end, there.errors), ("there", "success", []))
            self.assertLess(there.final_error, 1e-3)
            self.assertAlmostEqual(session.state.q[0], 0.2, places=3)
            back = session.move(trajectory(session.state.q_d, REST), interface="joint_velocity")
            self.assertGreater(back.begun, there.planned)
            self.assertAlmostEqual(session.time, back.ended, places=6)
        self.assertEqual(session.result.motions, 2)
        self.assertRegex(session.states_hash, r"^[0-9a-f]{16}$")

    def test_repeats_with_the_seed(self):
        def bits(seed):
            with pt.Session(TABLE, seed=seed) as session:
                session.move(trajectory(REST, turned(0.1)))
                session.hand.move(0.04)
            return session.states_hash

        self.assertEqual(bits(1), bits(1))
        self.assertNotEqual(bits(2), bits(1))

    def test_gives_the_bits_of_a_run(self):
        scenarios = pathlib.Path(__file__).parents[2] / "models/scenarios"
        for name in ("smoke", "canonical", "torque", "grasp"):
            with self.subTest(name), tempfile.TemporaryDirectory() as out:
                scenario = scenarios / f"{name}.yaml"
                subprocess.run(
                    [PANDA_TWIN, "run", scenario, "--seed", "7", "--no-video", "--out", out],
                    check=True, capture_output=True,
                )
                summary = json.loads(pathlib.Path(out, "summary.json").read_text())
                with pt.Session(scenario, seed=7) as session:
                    self.assertEqual(session.state.message_id, 0)  # looking changes nothing
                    session.move()
                self.assertEqual(session.states_hash, summary["states_hash"])

    def test_a_trajectory_beyond_a_limit_is_refused(self):
        with self.assertRaisesRegex(ValueError, "point 2: joint 4"):
            trajectory(REST, turned(3, joint=3))
        with self.assertRaisesRegex(ValueError, "joint 1"):
            trajectory(REST, turned(1), duration=0.1)
        with self.assertRaisesRegex(ValueError, r"waypoint 1: q, rad: has shape \(6,\)"):
            trajectory(REST[:6], REST)
        with self.assertRaisesRegex(ValueError, "finite"):
            trajectory([float("nan")] * 7, REST)
        with self.assertRaisesRegex(ValueError, "3 for 2 waypoints"):
            trajectory(REST, turned(0.1), times=[0, 1, 2])
        path = trajectory(REST, turned(0.1), times=[0, 2])
        self.assertEqual(path.duration, 2)
        q, dq, ddq = path.sample(1)
        self.assertAlmostEqual(q[0], 0.05)
        self.assertGreater(dq[0], 0)
        self.assertEqual(ddq.shape, (7,))

    def test_a_motion_from_elsewhere_is_refused(self):
        with pt.Session(IDEAL) as session:
            with self.assertRaises(ValueError):
                session.move(trajectory(turned(0.3), REST))
            with self.assertRaisesRegex(ValueError, "no motion of its own"):
                session.move()
            with self.assertRaisesRegex(ValueError, "joint_position, joint_velocity"):
                session.move(trajectory(REST, turned(0.1)), interface="x")

    def test_plans_around_the_scene(self):
        with pt.Session(TABLE) as session:
            result = session.move_to(turned(0.5))
            self.assertTrue(result.succeeded)
            self.assertAlmostEqual(session.state.q[0], 0.5, places=2)
            with self.assertRaisesRegex(ValueError, "table"):
                session.move_to([0, 0.9, 0, -1.6, 0, 2.5, 0.7854])

    def test_an_abort_raises_with_its_details(self):
        with pt.Session(IDEAL) as session:
            q = np.array(REST)

            def law(state, dt):
                return pt.JointPositions(q + (0.2 if state.time > 0.1 else 0))

            options = {"until": 1.0, "tick": {"generator": "none", "rate_matching": False}}
            with self.assertRaises(pt.RobotFault) as caught:
                session.control(law, **options)
            fault = caught.exception
            self.assertIsInstance(fault, pt.MotionFault)
            self.assertIn("joint_motion_generator_velocity_discontinuity", fault.errors)
            self.assertEqual(fault.joint, 1)
            self.assertGreater(abs(fault.value), abs(fault.limit))
            self.assertGreater(fault.cycle, 100)
            self.assertEqual(session.state.robot_mode, "Reflex")
            with self.assertRaises(pt.RobotFault):
                session.move(trajectory(session.state.q_d, turned(0.1)))
            session.recover()
            self.assertEqual(session.state.robot_mode, "Idle")
            q = session.state.q_d
            result = session.control(law, check=False, **options)
            self.assertFalse(result.succeeded)
            self.assertEqual(result.end, "aborted")

    def test_the_user_stop(self):
        with pt.Session(IDEAL) as session:
            session.user_stop(True)
            self.assertEqual(session.state.robot_mode, "User stopped")
            with self.assertRaises(pt.RobotFault):
                session.move(trajectory(REST, turned(0.1)))
            session.user_stop(False)
            session.recover()
            self.assertTrue(session.move(trajectory(REST, turned(0.1))).succeeded)


class HandAndObjects(unittest.TestCase):
    def test_grasps_nothing_and_says_so(self):
        with pt.Session(TABLE) as session:
            self.assertTrue(session.hand.homing().succeeded)
            self.assertAlmostEqual(session.hand.state.max_width, 0.08, places=3)
            self.assertTrue(session.hand.move(0.06, speed=0.1).succeeded)
            grasp = session.hand.grasp(0.03, force=20)
            self.assertFalse(grasp.succeeded)
            self.assertEqual(grasp.result, "unsuccessful")
            session.hand.stop()
            with self.assertRaisesRegex(pt.RobotFault, "force"):
                session.hand.grasp(0.03, force=-1)

    def test_the_cobot_pump_holds_a_box_and_drops_it(self):
        on_cup = {"robot": {"hand": "cobot_pump", "q_start": {"unit": "rad", "values": REST}}, "objects": [
            {"name": "table", "shape": "box", "size": ["0.3 m", "0.3 m", "0.38 m"], "position": ["0.307 m", "0 m", "0.19 m"]},
            {"name": "box", "shape": "box", "size": ["0.1 m", "0.1 m", "0.1055 m"], "mass": "0.5 kg", "on": "table"}]}
        with pt.Session(on_cup) as session:
            self.assertEqual(session.hand.state.vacuum, 0)
            self.assertTrue(session.hand.vacuum(600, timeout=1).succeeded)
            self.assertTrue(session.move(trajectory(REST, turned(-0.2, joint=1))).succeeded)
            self.assertTrue(session.hand.state.is_grasped)
            self.assertGreater(session.objects["box"][2, 3], 0.47)
            dropped = session.hand.drop_off()
            self.assertTrue(dropped.succeeded)
            self.assertLess(dropped.vacuum, 50)
            session.wait(1)
            self.assertLess(session.objects["box"][2, 3], 0.45)
            with self.assertRaisesRegex(pt.RobotFault, "no fingers"):
                session.hand.grasp(0.03, force=20)

    def test_objects_are_seen_and_placed(self):
        with pt.Session(TABLE) as session:
            self.assertEqual(list(session.objects), ["box"])
            pose = session.objects["box"]
            self.assertEqual(pose.shape, (4, 4))
            np.testing.assert_allclose(pose[:3, 3], [0.5, 0, 0.325], atol=1e-9)
            pose[1, 3] += 0.1
            session.objects["box"] = pose
            session.wait(0.1)
            np.testing.assert_allclose(session.objects["box"][:3, 3], [0.5, 0.1, 0.325], atol=1e-3)
            pose[2, 3] -= 0.02
            with self.assertRaisesRegex(ValueError, "deep in table"):
                session.objects["box"] = pose
            with self.assertRaisesRegex(ValueError, "box"):
                session.objects["ball"] = np.eye(4)
            with self.assertRaises(KeyError):
                session.objects["ball"]
            with self.assertRaisesRegex(ValueError, r"\(4, 4\)"):
                session.objects["box"] = np.eye(3)


class States(unittest.TestCase):
    def test_every_read_is_a_copy(self):
        with pt.Session(IDEAL) as session:
            state = session.state
            state.q[0] = 1
            self.assertEqual(state.q[0], 0)
            self.assertEqual(state.O_T_EE.shape, (4, 4))
            np.testing.assert_allclose(state.O_T_EE[:3, :3] @ state.O_T_EE[:3, :3].T, np.eye(3),
                                       atol=1e-12)
            self.assertAlmostEqual(state.O_T_EE[0, 3], 0.307, places=2)
            self.assertEqual(state.I_ee.shape, (3, 3))
            self.assertEqual(state.errors, [])
            session.wait(0.1)
            self.assertEqual(state.message_id, 0)
            self.assertAlmostEqual(session.state.time, 0.1, places=6)

    def test_has_every_field_of_the_robots(self):
        header = pathlib.Path(__file__).parents[2] / "include/twin/core/robot_state.h"
        text = header.read_text().split("struct RobotState {")[1].split("\n};")[0]
        names = re.findall(r"^  [\w:]+ (\w+)\s*[={;]", text, re.MULTILINE)
        self.assertGreater(len(names), 40)
        with pt.Session(IDEAL) as session:
            for name in names:
                self.assertTrue(hasattr(session.state, name), name)


class Snapshots(unittest.TestCase):
    def test_a_restored_twin_repeats(self):
        with pt.Session(TABLE) as session:
            session.move(trajectory(REST, turned(0.1)))
            snapshot = session.snapshot()
            saved = session.time
            ends = []
            for _ in range(2):
                session.restore(snapshot)
                self.assertEqual(session.time, saved)
                session.move(trajectory(session.state.q_d, REST))
                state = session.state
                ends.append(np.concatenate([state.q, state.tau_J, state.O_T_EE.ravel()]).tobytes())
            self.assertEqual(ends[0], ends[1])
        with pt.Session(TABLE) as straight:
            straight.move(trajectory(REST, turned(0.1)))
            straight.move(trajectory(straight.state.q_d, REST))
        self.assertEqual(session.states_hash, straight.states_hash)

    def test_is_of_one_session(self):
        with pt.Session(IDEAL) as one, pt.Session(IDEAL) as other:
            with self.assertRaisesRegex(ValueError, "another session"):
                other.restore(one.snapshot())

    def test_reset_begins_anew(self):
        with pt.Session(TABLE) as session:
            session.move(trajectory(REST, turned(0.1)))
            session.reset()
            self.assertAlmostEqual(session.state.q_d[0], 0)
            session.reset(turned(0.3))
            self.assertAlmostEqual(session.state.q_d[0], 0.3)
            with self.assertRaisesRegex(ValueError, "joint 4"):
                session.reset(turned(3, joint=3))


class Openings(unittest.TestCase):
    def test_takes_a_file_a_text_or_an_object(self):
        class Scenario:
            def to_yaml(self):
                return IDEAL

        with pt.Session(Scenario()) as session:
            self.assertIn("ideal", repr(session))
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder, "s.yaml")
            file.write_text(IDEAL)
            with pt.Session(file), pt.Session(str(file)):
                pass
            with self.assertRaisesRegex(ValueError, "s.yaml:4: .*colour"):
                file.write_text(IDEAL + "colour: red\n")
                pt.Session(file)
            with self.assertRaises((OSError, ValueError)):
                pt.Session(file.with_name("none.yaml"))

    def test_takes_an_installed_scenario_and_keys(self):
        with pt.Session("scenarios/smoke.yaml") as session:
            self.assertTrue(session.move().succeeded)
        with pt.Session() as session:
            np.testing.assert_allclose(session.state.q, pt.model.Q_READY, atol=1e-6)
        with pt.Session({"robot": {"hand": "none"}, "seed": 3}) as session:
            np.testing.assert_allclose(session.state.q, pt.model.Q_READY, atol=1e-6)
            with self.assertRaisesRegex(ValueError, "hand"):
                session.hand.state
        with pt.Session({"name": "turned", "robot": {"q_start": {"unit": "rad", "values": turned(0.3)}}}) as session:
            self.assertIn("turned", repr(session))
            self.assertAlmostEqual(session.state.q[0], 0.3, places=6)

    def test_writes_a_log_with_scenes(self):
        with tempfile.TemporaryDirectory() as folder:
            log = pathlib.Path(folder, "session.mcap")
            with pt.Session(TABLE, log=log) as session:
                session.move(trajectory(REST, turned(0.1)), name="there")
                self.assertFalse(log.exists())
                session_length = session.time
            self.assertTrue(log.exists())
            subprocess.run([PANDA_TWIN, "export", log, "--out", folder], check=True,
                           capture_output=True)
            cycles = pathlib.Path(folder, "cycles.csv").read_text().splitlines()
            self.assertGreater(len(cycles), 1000 * session_length)
            with self.assertRaises(OSError):
                pt.Session(TABLE, log="/nowhere/session.mcap")

    def test_a_closed_session_says_so(self):
        session = pt.Session(IDEAL)
        with self.assertRaisesRegex(ValueError, "goes on"):
            session.result
        session.close()
        session.close()
        self.assertTrue(session.closed)
        for call in (lambda: session.state, lambda: session.wait(1), session.recover,
                     session.snapshot, lambda: session.hand.state, lambda: list(session.objects),
                     lambda: session.control(lambda state, dt: pt.Torques([0] * 7), 1.0)):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()

    def test_the_clock_does_not_go_back(self):
        with pt.Session(IDEAL + "drive: realtime\n") as session:
            session.wait(0.05)
            self.assertEqual(session.state.robot_mode, "Idle")
            for call in (session.snapshot, session.reset, lambda: list(session.objects),
                         lambda: session.control(lambda state, dt: pt.Torques([0] * 7), 1.0)):
                with self.assertRaisesRegex(ValueError, "drive: lockstep"):
                    call()


class Threads(unittest.TestCase):
    def test_two_threads_in_one_session_are_told(self):
        def use(call):
            try:
                call()
            except RuntimeError as error:
                errors.append(str(error))

        errors = []
        with pt.Session(IDEAL) as session:
            waiting = threading.Thread(target=use, args=(lambda: session.wait(60),))
            waiting.start()
            while waiting.is_alive() and not errors:
                use(lambda: session.time)  # either may be the one that comes second
            waiting.join()
        self.assertIn("in use", errors[0])

    def test_two_sessions_release_the_gil(self):
        def work():
            with pt.Session(IDEAL) as session:
                session.wait(20)
            hashes.append(session.states_hash)

        hashes = []
        threads = [threading.Thread(target=work) for _ in range(2)]
        for thread in threads:
            thread.start()
        turns = 0
        while any(thread.is_alive() for thread in threads):
            turns += 1
            time.sleep(0.001)
        self.assertEqual(len(set(hashes)), 1)
        self.assertEqual(len(hashes), 2)
        self.assertGreater(turns, 10)


class CtrlC(unittest.TestCase):
    def interrupted(self, call):
        """Seconds from the signal to the exception."""
        sent = []

        def send():
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(0.3, send)
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            call()
        timer.join()
        return time.monotonic() - sent[0]

    def test_ends_every_call_that_waits_and_leaves_nothing_behind(self):
        with pt.Session(IDEAL) as session:
            rest = trajectory(REST, turned(1e-5), duration=80_000)

            def law(state, dt):
                return pt.Torques([0.0] * 7)

            calls = {
                "wait": lambda: session.wait(80_000),
                "move": lambda: session.move(rest),
                "control": lambda: session.control(law, 80_000),
                "hand": lambda: [session.hand.move(w, speed=0.005) for w in [0, 0.08] * 10_000],
            }
            threads = threading.active_count()
            for name, call in calls.items():
                with self.subTest(name):
                    print(f"{name}: {self.interrupted(call):.3f} s after Ctrl-C")
                    session.reset()
                    session.wait(0.01)
            self.assertEqual(threading.active_count(), threads)
            self.assertTrue(session.move(trajectory(REST, turned(0.1))).succeeded)


class Leaks(unittest.TestCase):
    def test_sessions_leave_nothing_behind(self):
        count = int(os.environ.get("PANDA_TWIN_SESSIONS", "300"))

        def open_and_close(times, every):
            for i in range(times):
                with pt.Session(IDEAL if i % every else TABLE) as session:
                    session.wait(0.002)

        def use():
            status = pathlib.Path("/proc/self/status").read_text()
            memory = int(status.split("VmRSS:")[1].split()[0])
            tasks = int(status.split("Threads:")[1].split()[0])
            return memory, tasks, len(os.listdir("/proc/self/fd"))

        # The first fifty sessions that compile a model add 10 MB to what the C library keeps; later ones add nothing.
        open_and_close(min(60, count), 1)
        before = use()
        open_and_close(count, 100)
        after = use()
        print(f"{count} sessions: {before} -> {after} (KiB, threads, descriptors)")
        self.assertEqual(after[1:], before[1:])
        self.assertLess(after[0] - before[0], 4_000 + 0.5 * count)


if __name__ == "__main__":
    unittest.main()
