"""panda_twin.serve and control_channel: programs made for the real robot, unmodified, against robots of this process."""

import os
import pathlib
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import panda_twin
import process_counts

try:
    import franka
    import panda_py
except ImportError as missing:
    print(f"missing: {missing.name} is not installed: scripts/setup")
    sys.exit(77)  # ctest's word for skipped

READY = np.array([0, -np.pi / 4, 0, -3 * np.pi / 4, 0, np.pi / 2, np.pi / 4])
BOX = """
name: box
description: A box on the floor.
objects: [{name: box, shape: box, size: [0.05 m, 0.05 m, 0.05 m], mass: 0.1 kg, on: ground, position: [0.6 m, 0.3 m, 0 m]}]
motion:
  trajectory: {unit: rad, waypoints: [{q: [0, -0.785, 0, -2.356, 0, 1.571, 0.785]}, {q: [0.1, -0.785, 0, -2.356, 0, 1.571, 0.785]}]}
"""
PROGRAM = """
import sys
import panda_py
panda = panda_py.Panda(sys.argv[1])
panda.move_to_joint_position({goal})
print(list(panda.get_state().q))
"""


def goal_of(step):
    return READY + step * np.array([1, 0, 1, 0, 1, 0, 1])


class Case(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def serve(self, *arguments, **options):
        robot = panda_twin.serve(*arguments, **options)
        self.addCleanup(robot.close)
        return robot

    def assert_near(self, q, goal, tolerance=5e-3):
        self.assertLess(np.abs(np.asarray(q) - goal).max(), tolerance)


class Programs(Case):
    def test_panda_python_moves_in_this_process(self):
        with panda_twin.serve() as robot:
            panda = panda_py.Panda(robot.hostname)
            self.assertTrue(panda.move_to_joint_position(goal_of(0.2)))
            self.assert_near(robot.status.q, goal_of(0.2))
            del panda
        kinds = [event.kind for event in robot.events]
        self.assertIn("client", kinds)
        motions = [event.text for event in robot.events if event.kind == "motion"]
        self.assertEqual(len(motions), 2, robot.events)
        self.assertRegex(motions[0], "^started: joint_velocity")
        self.assertEqual(motions[1], "finished")

    def test_panda_python_moves_in_another_process_and_two_robots_do_not_see_each_other(self):
        robots = self.serve(), self.serve()
        self.assertNotEqual(robots[0].hostname, robots[1].hostname)
        programs = [subprocess.Popen([sys.executable, "-c", PROGRAM.format(goal=goal_of(step).tolist()), robot.hostname],
                                     stdout=subprocess.PIPE, text=True) for robot, step in zip(robots, (0.1, -0.2))]
        for program, robot, step in zip(programs, robots, (0.1, -0.2)):
            self.assert_near(eval(program.communicate(timeout=120)[0]), goal_of(step))
            self.assertEqual(program.returncode, 0)
            self.assert_near(robot.status.q, goal_of(step))

    def test_two_robots_in_one_program(self):
        robots = self.serve(), self.serve()
        pandas = [panda_py.Panda(robot.hostname) for robot in robots]
        moves = [threading.Thread(target=panda.move_to_joint_position, args=(goal_of(step),))
                 for panda, step in zip(pandas, (0.1, -0.1))]
        for move in moves:
            move.start()
        for move in moves:
            move.join()
        self.assert_near(robots[0].status.q, goal_of(0.1))
        self.assert_near(robots[1].status.q, goal_of(-0.1))

    def test_franka_rs_moves(self):
        robot = self.serve()
        arm = franka.Robot(robot.hostname, realtime="ignore")
        self.assertEqual(arm.fci_version, 5)
        start = np.array(arm.read_once().O_T_EE)[:3, 3]
        np.testing.assert_allclose(start, panda_twin.model.fk(robot.status.q)[:3, 3], atol=1e-4)
        for backend, goal in (("robot", start + (0.05, 0.05, -0.05)), ("impedance", start)):  # poses, torques
            with arm.cartesian_targets(backend=backend) as targets:
                targets.move_to(goal)
                limit = time.monotonic() + 60
                while np.abs(np.array(targets.state().O_T_EE)[:3, 3] - goal).max() > 2e-3:
                    self.assertLess(time.monotonic(), limit, robot.events)
                    time.sleep(0.01)
            self.assert_near(panda_twin.model.fk(robot.status.q)[:3, 3], goal)

    def test_an_fr3_speaks_protocol_10(self):
        with panda_twin.serve(model="fr3") as robot, socket.create_connection((robot.hostname, 1337), timeout=10) as client:
            client.sendall(struct.pack("<IIIHH", 0, 7, 16, 10, 40000))
            self.assertEqual(struct.unpack("<IIIBH", client.recv(15, socket.MSG_WAITALL)), (0, 7, 15, 0, 10))

    def test_a_refusal_says_why(self):
        robot = self.serve()
        panda = panda_py.Panda(robot.hostname)
        robot.user_stop(True)
        self.assertFalse(panda.move_to_joint_position(goal_of(0.1)))
        self.assert_near(robot.status.q, READY)
        self.assertIn("refused", " ".join(event.text for event in robot.events))


class Control(Case):
    def test_time_stands_still_and_goes_on_by_steps(self):
        robot = self.serve()
        at = robot.pause()
        self.assertTrue(at.paused and at.lockstep)
        self.assertEqual(robot.status.cycle, at.cycle)
        self.assertEqual(robot.step(10).cycle, at.cycle + 10)
        self.assertAlmostEqual(robot.status.time_s, (at.cycle + 10) / 1000)
        robot.resume()
        with self.assertRaisesRegex(ValueError, "pause first"):
            robot.step()

    def test_a_snapshot_is_gone_back_to(self):
        robot = self.serve()
        robot.pause()
        robot.step(100)
        before = robot.snapshot("here")
        robot.step(50)
        robot.reset(goal_of(0.3))
        self.assert_near(robot.step().q, goal_of(0.3))
        robot.restore("here")
        after = robot.status
        self.assertEqual(after.cycle, before.cycle)
        np.testing.assert_array_equal(after.q, before.q)
        with self.assertRaisesRegex(ValueError, "nowhere"):
            robot.restore("nowhere")

    def test_objects_are_placed(self):
        class Scenario:
            def to_yaml(self):
                return BOX

        robot = self.serve(Scenario(), lab=None, seed=3)
        robot.place("box", (0.5, 0.2, 0.5))
        with self.assertRaisesRegex(ValueError, "box"):
            robot.place("no_such", (0.5, 0.2, 0.5))

    def test_keys_describe_the_robot(self):
        robot = self.serve({"objects": [{"name": "box", "shape": "box", "size": ["0.05 m"] * 3, "mass": "0.1 kg", "on": "ground",
                                         "position": ["0.6 m", "0.3 m", "0 m"]}]})
        self.assert_near(robot.status.q, READY)
        robot.place("box", (0.5, 0.2, 0.5))

    def test_switches(self):
        robot = self.serve()
        self.assertEqual(robot.user_stop(True).mode, "User stopped")
        self.assertEqual(robot.user_stop(False).mode, "Idle")
        self.assertEqual(robot.guiding(True).mode, "Guiding")
        robot.guiding(False)
        robot.recover()

    def test_the_wall_clock_never_stands_still(self):
        robot = self.serve(drive="realtime")
        self.assertEqual(robot.drive, "realtime")
        with self.assertRaisesRegex(ValueError, "runs on the wall clock"):
            robot.pause()

    def test_another_process_controls(self):
        path = self.folder / "control"
        robot = self.serve(control=path)
        channel = panda_twin.control_channel(path)
        self.assertTrue(channel.pause().paused)
        self.assertTrue(robot.status.paused)
        at = channel.step(5)
        self.assertEqual(at.cycle, robot.status.cycle)
        np.testing.assert_array_equal(at.q, robot.status.q)
        with self.assertRaisesRegex(ValueError, "reset"):
            channel.reset()  # reset="never" is about others
        self.assertEqual([event.text for event in robot.events if event.kind == "control"][-1], '{"cycles":5,"do":"step"}')
        robot.close()
        with self.assertRaisesRegex(OSError, "no served robot"):
            channel.pause()
        with self.assertRaisesRegex(OSError, "no served robot"):
            panda_twin.control_channel(self.folder / "other")


class Ends(Case):
    def test_a_port_in_use_is_named(self):
        robot = self.serve()
        with self.assertRaisesRegex(OSError, rf"{robot.hostname}:1337 .*in use"):
            panda_twin.serve(hostname=robot.hostname)

    def test_wrong_values_are_named(self):
        for options, says in (({"drive": "remote"}, "realtime or lockstep"), ({"pace": 1, "drive": "realtime"}, "pace goes with"),
                              ({"hostname": "192.0.2.1"}, "other machines"), ({"guard": True}, "nothing to guard"),
                              ({"viability": 101}, "viability"), ({"reset": "always"}, "none of never"),
                              ({"lab": "no_such"}, "no_such"), ({"seed": 1, "idle": "no"}, "neither run nor freeze")):
            with self.assertRaisesRegex(ValueError, says):
                panda_twin.serve(**options)
        with self.assertRaisesRegex(ValueError, "no_such.yaml"):
            panda_twin.serve("no_such.yaml")

    def test_a_closed_robot_says_so(self):
        robot = panda_twin.serve()
        robot.close()
        robot.close()
        self.assertTrue(robot.closed)
        for call in (robot.pause, robot.step, lambda: robot.status, robot.recover):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()
        self.assertIn("closed", repr(robot))

    def test_a_close_ends_the_wait_of_a_step(self):
        robot = self.serve()
        robot.pause()
        closing = threading.Timer(0.2, robot.close)
        closing.start()
        with self.assertRaisesRegex(ValueError, "closed"):
            robot.step(10_000_000)
        closing.join()

    def test_ctrl_c_ends_waits_within_half_a_second(self):
        path = self.folder / "control"
        robot = self.serve(control=path)
        for waits in (robot, panda_twin.control_channel(path)):
            took = []
            for _ in range(5):  # this machine may be late once
                robot.pause()
                sent = []

                def interrupt():
                    sent.append(time.monotonic())
                    os.kill(os.getpid(), signal.SIGINT)

                timer = threading.Timer(0.1, interrupt)
                timer.start()
                with self.assertRaises(KeyboardInterrupt):
                    waits.step(10_000_000)
                took.append(time.monotonic() - sent[0])
                timer.join()
                if took[-1] < 0.5:
                    break
            self.assertLess(took[-1], 0.5, took)

    def test_robots_served_at_the_same_time_get_addresses_of_their_own(self):
        code = "import panda_twin\nwith panda_twin.serve() as robot: print(robot.hostname, flush=True), input()"
        programs = [subprocess.Popen([sys.executable, "-c", code], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
                    for _ in range(4)]
        addresses = {program.stdout.readline() for program in programs}
        for program in programs:
            program.communicate("\n", timeout=60)
        self.assertEqual([program.returncode for program in programs], [0] * 4)
        self.assertEqual(len(addresses), 4, addresses)

    def test_a_program_may_end_without_closing(self):
        done = subprocess.run([sys.executable, "-c", "import panda_twin; robot = panda_twin.serve(); robot.pause()"],
                              capture_output=True, text=True, timeout=120)
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_results(self):
        out = self.folder / "out"
        with panda_twin.serve(out=out, video=False) as robot:
            panda = panda_py.Panda(robot.hostname)
            panda.move_to_joint_position(goal_of(0.05))
            del panda
        for name in ("run.mcap", "report.html", "summary.json", "motions/1/plots/joints.svg"):
            self.assertTrue((out / name).is_file(), name)

    def test_a_log_is_split_and_old_parts_go(self):
        log = self.folder / "day.mcap"
        with panda_twin.serve(log=log, log_split="0.1 s", log_keep=2):
            time.sleep(1.5)
        parts = sorted(path.name for path in self.folder.glob("day_*.mcap"))
        self.assertEqual(len(parts), 2)
        self.assertNotIn("day_0001.mcap", parts)

    def test_two_hundred_leave_nothing(self):
        def memory():
            return int(pathlib.Path("/proc/self/status").read_text().split("VmRSS:")[1].split()[0]) // 1024

        # The C library may keep a robot's 15 MB while 30 more come and go, so the least of 80 in a row counts.
        counts, least = [], [[], []]
        for number in range(200):
            with panda_twin.serve() as robot:
                robot.pause()
            if number % 100 >= 20:
                least[number // 100].append(memory())
            if number in (49, 199):
                counts.append((process_counts.threads(at_most=counts[0][0] if counts else 0), process_counts.descriptors()))
        print("threads, descriptors after 50 and 200, MB up to 100 and to 200:", *counts, *map(min, least))
        self.assertLessEqual(counts[1][0], counts[0][0])
        self.assertEqual(counts[0][1], counts[1][1])
        self.assertLess(min(least[1]) - min(least[0]), 7)


if __name__ == "__main__":
    unittest.main()
