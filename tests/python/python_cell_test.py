"""Several robots in one scene: one time, functions together, and the bits of a run."""

import json
import math
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

import numpy as np

import panda_twin as pt
import process_counts

SOURCE = pathlib.Path(__file__).parents[2]
PANDA_TWIN = pathlib.Path(pt.__file__).parents[2] / "panda-twin"
TWO_ARMS = SOURCE / "models/cells/two_arms.yaml"
REST = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
BOX = {"name": "box", "shape": "box", "size": ["50 mm", "50 mm", "50 mm"], "mass": "0.1 kg", "on": "ground"}


def robot(y, **more):
    return {"robot": {"pose": {"position": ["0 m", f"{y} m", "0 m"]}, "q_start": {"unit": "rad", "values": REST}},
            "link": {"state_delay": "60 us", "command_delay": "60 us", "command_loss": "1 %"},
            "plant": {"noise": {"q": "0.001 deg"}}, **more}


def keys(gap=0.5, **more):
    """Two robots within reach of each other, unless the gap is large."""
    return {"robots": {"left": robot(gap), "right": robot(-gap)}, **more}


def turned(angle, joint=0):
    q = list(REST)
    q[joint] += angle
    return q


def path(angle, duration=None):
    return pt.Trajectory([REST, turned(angle)], duration=duration)


def hashes(cell):
    return {name: robot.states_hash for name, robot in cell.robots.items()}


def run(scenario, out):
    """Hashes of a run by the program."""
    subprocess.run([PANDA_TWIN, "run", scenario, "--no-video", "--out", out], check=True, capture_output=True)
    robots = json.loads(pathlib.Path(out, "summary.json").read_text())["robots"]
    return {name: end["states_hash"] for name, end in robots.items()}


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)


class OneTime(unittest.TestCase):
    def test_passes_for_all_while_one_moves(self):
        with pt.Cell(keys()) as cell:
            left, right = cell.robots.values()
            self.assertEqual((cell.time, left.state.message_id, right.state.message_id), (0, 0, 0))
            self.assertTrue(left.move(path(0.3)).succeeded)
            self.assertEqual(left.state.message_id, right.state.message_id)
            self.assertAlmostEqual(cell.time, left.state.time, places=9)
            self.assertAlmostEqual(left.state.q[0], 0.3, places=2)
            np.testing.assert_allclose(right.state.q, REST, atol=1e-3)
            self.assertEqual((right.state.robot_mode, right.state.message_id), ("Idle", left.state.message_id))
            right.hand.move(0.02)
            cell.wait(0.1)
            self.assertEqual(left.state.message_id, right.state.message_id)
            self.assertLess(right.hand.state.width, left.hand.state.width)

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        cls.addClassCleanup(folder.cleanup)
        cls.out = pathlib.Path(folder.name)
        cls.whole = run(TWO_ARMS, cls.out)

    def test_gives_the_bits_of_a_run_and_of_sessions(self):
        with pt.Cell(TWO_ARMS) as cell:
            ends = cell.together(right=pt.Robot.move, left=pt.Robot.move)
            cycles = cell.robots["right"].state.message_id
        self.assertGreater(ends["left"].ended, ends["right"].ended)
        self.assertEqual(cell.robots["left"].states_hash, self.whole["left"])  # the last to end
        with pt.Session(self.out / "right/scenario.yaml") as alone:
            alone.move()
            alone.wait(1e-3 * cycles - alone.time)
            self.assertEqual(alone.state.message_id, cycles)
        self.assertEqual(cell.robots["right"].states_hash, alone.states_hash)

    def test_one_after_the_other_gives_the_bits_of_sessions(self):
        with pt.Cell(TWO_ARMS) as cell:
            cell.robots["left"].move()
            begin = cell.robots["right"].state.message_id
            cell.robots["right"].move()
            end = cell.robots["left"].state.message_id
        with pt.Session(self.out / "left/scenario.yaml") as left:
            left.move()
            left.wait(1e-3 * end - left.time)
        with pt.Session(self.out / "right/scenario.yaml") as right:
            right.wait(1e-3 * begin)
            right.move()
        self.assertEqual(hashes(cell), {"left": left.states_hash, "right": right.states_hash})

    def test_a_robot_in_reflex_holds_nobody_up(self):
        with pt.Cell(keys()) as cell:
            left, right = cell.robots.values()
            with self.assertRaises(pt.MotionFault):
                left.control(lambda state, dt: pt.JointPositions(state.q_d + 0.1), tick={"generator": "none"})
            self.assertTrue(right.move(path(0.1)).succeeded)
            self.assertEqual(left.state.robot_mode, "Reflex")
            left.recover()
            self.assertTrue(left.move_to(turned(0.1)).succeeded)


class Together(Folder):
    def test_repeats_whatever_the_order_and_the_threads_speed(self):
        def bits(turn, pause):
            def left(robot):
                robot.move(path(0.2))
                time.sleep(pause)
                return robot.hand.move(0.02).width

            def right(robot):
                robot.wait(0.25)
                time.sleep(0.1 - pause)
                return robot.move(path(-0.2)).final_error

            functions = {"left": left, "right": right}
            with pt.Cell(keys(), seed=3) as cell:
                ends = cell.together(**dict(sorted(functions.items(), reverse=turn)))
                self.assertEqual(list(ends), ["left", "right"])
            return ends, hashes(cell)

        first = bits(False, 0)
        self.assertEqual(first, bits(True, 0.1))
        self.assertEqual(first, bits(False, 0.05))

    def test_within_reach_gives_the_bits_of_a_run(self):
        motion = {"motion": {"trajectory": {"unit": "rad", "duration": "2 s", "waypoints": [{"q": REST}, {"q": turned(0.3)}]}}}
        longer = {"motion": {"trajectory": {"unit": "rad", "duration": "3 s", "waypoints": [{"q": REST}, {"q": turned(-0.3)}]}}}
        far = {"motion": {"trajectory": {"unit": "rad", "duration": "1 s", "waypoints": [{"q": REST}, {"q": turned(0.1)}]}}}
        cell = {"name": "three", "robots": {"a": robot(6, **far), "left": robot(0.5, **motion), "right": robot(-0.5, **longer)}}
        (self.folder / "three.yaml").write_text(json.dumps(cell))
        whole = run(self.folder / "three.yaml", self.folder / "run")
        with pt.Cell(cell) as three:
            three.together(**{name: pt.Robot.move for name in three.robots})
            self.assertEqual(len({one.state.message_id for one in three.robots.values()}), 1)
        self.assertEqual(three.robots["right"].states_hash, whole["right"])
        with pt.Cell(self.folder / "three.yaml") as three:  # `a` has no function
            three.together(left=pt.Robot.move, right=pt.Robot.move)
        self.assertEqual(three.robots["right"].states_hash, whole["right"])
        with pt.Cell(self.folder / "three.yaml") as three:  # `left` holds, which `right` does not feel
            three.robots["right"].move()
            np.testing.assert_allclose(three.robots["left"].state.q, REST, atol=1e-3)

    def test_arms_that_collide_stop_both(self):
        with pt.Cell(SOURCE / "models/cells/collision.yaml") as cell:
            with self.assertRaises(pt.MotionFault) as caught:
                cell.together(left=pt.Robot.move, right=pt.Robot.move)
            self.assertRegex(caught.exception.errors[0], "reflex")
            self.assertEqual({one.state.robot_mode for one in cell.robots.values()}, {"Reflex"})

    def test_laws_may_share_what_they_know(self):
        known = {"left": np.array(REST), "right": np.array(REST)}

        def follow(other):
            def law(state, dt):
                """Mirrors the other arm's first joint, which the scenario pushes."""
                known[names[id(law)]] = state.q
                error = np.array(REST) - state.q
                error[0] = -known[other][0] - state.q[0]
                return pt.Torques(200 * error - 20 * state.dq)

            return law

        def bits():
            for name in known:
                known[name] = np.array(REST)
            with pt.Cell(pushed) as cell:
                cell.together(left=lambda robot: robot.control(laws["left"], until=0.8), right=lambda robot: robot.control(laws["right"], until=0.8))
                ends = [one.state.q[0] for one in cell.robots.values()]
            return ends, hashes(cell)

        push = {"push": {"body": "panda_hand", "begin": "0.1 s", "duration": "2 s", "force": ["0 N", "15 N", "0 N"]}}
        pushed = {"robots": {"left": robot(1.5, perturbations=[push]), "right": robot(-1.5)}}
        laws = {"left": follow("right"), "right": follow("left")}
        names = {id(law): name for name, law in laws.items()}
        (left, right), first = bits()
        self.assertGreater(left, 0.01)
        self.assertLess(right, -0.005)
        self.assertEqual(bits()[1], first)

    def test_an_error_ends_the_others_after_their_call(self):
        told = []

        def left(robot):
            robot.wait(0.2)
            raise ZeroDivisionError("of left")

        def right(robot):
            told.append(robot.move(path(0.3)).succeeded)
            try:
                robot.move(pt.Trajectory([robot.state.q_d, REST]))
            except Exception:
                told.append("taken for an error")
            finally:
                told.append("finally")

        with pt.Cell(keys()) as cell:
            before = threading.active_count()
            with self.assertRaises(ZeroDivisionError) as caught:
                cell.together(left=left, right=right)
            self.assertEqual(caught.exception.__notes__, ["in the function of robot left"])
            self.assertEqual(told, [True, "finally"])
            self.assertEqual(threading.active_count(), before)
            self.assertAlmostEqual(cell.robots["right"].state.q[0], 0.3, places=2)
            self.assertEqual(cell.together(left=lambda robot: robot.wait(0.1), right=lambda robot: 7), {"left": None, "right": 7})

    def test_every_error_is_told(self):
        def fail(robot):
            robot.wait(0.1)
            raise ValueError("of left")

        def law(state, dt):
            return pt.JointPositions(state.q_d + (0.1 if state.time > 0.3 else 0))

        with pt.Cell(keys()) as cell:
            with self.assertRaises(ValueError) as caught:
                cell.together(left=fail, right=lambda robot: robot.control(law, tick={"generator": "none"}))
            own, other = caught.exception.__notes__
            self.assertEqual(own, "in the function of robot left")
            self.assertRegex(other, "^robot right failed, too: MotionFault.*joint_motion_generator_velocity_discontinuity")

    def test_misuse_is_told(self):
        with pt.Cell(keys()) as cell:
            left, right = cell.robots.values()
            self.assertEqual(cell.together(), {})
            with self.assertRaisesRegex(KeyError, "unknown robot 'lft'; there are left, right"):
                cell.together(lft=pt.Robot.move)
            with self.assertRaisesRegex(TypeError, "left is of type float; a function of a Robot belongs here"):
                cell.together(left=1.0)
            for wrong in (lambda one: right.wait(1), lambda one: cell.together(left=pt.Robot.recover), lambda one: cell.close()):
                with self.assertRaisesRegex(RuntimeError, "another function of together|the cell is in use"):
                    cell.together(left=wrong, right=lambda one: one.wait(0.1))

            def law(state, dt):
                right.wait(1)

            with self.assertRaisesRegex(RuntimeError, "the cell is in use"):
                left.control(law)
            under_way, seen = threading.Event(), threading.Event()

            def wait(state, dt):
                under_way.set()
                seen.wait()
                return pt.Torques([0] * 7, finished=True) if dt else pt.Torques([0] * 7)

            other = threading.Thread(target=left.control, args=(wait,))
            other.start()
            under_way.wait()
            for call in (right.recover, lambda: cell.time, cell.close, lambda: cell.together(left=pt.Robot.recover)):
                with self.assertRaisesRegex(RuntimeError, "the cell is in use, by another thread"):
                    call()
            seen.set()
            other.join()
            self.assertEqual(left.state.message_id, right.state.message_id)

    def test_a_function_may_call_a_robot_without_one(self):
        with pt.Cell(keys()) as cell:
            cell.together(left=lambda left: [left.wait(0.1), cell.robots["right"].move(path(0.1)), left.wait(0.1)])
            self.assertAlmostEqual(cell.robots["right"].state.q[0], 0.1, places=2)


class CtrlC(unittest.TestCase):
    def test_stops_all_arms_and_the_cell_goes_on(self):
        ended = []

        def swing(robot):
            try:
                while True:
                    robot.move(path(1e-5, duration=40_000))
            finally:
                ended.append("ended")

        calls = {
            "together": lambda cell: cell.together(left=swing, right=swing),
            "beside one that waits": lambda cell: cell.together(left=lambda robot: [robot.wait(1) for _ in range(80_000)], right=swing),
            "one": lambda cell: swing(cell.robots["left"]),
        }
        for name, call in calls.items():
            with self.subTest(name), pt.Cell(keys()) as cell:
                ended.clear()
                timer = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
                timer.start()
                begin = time.monotonic()
                with self.assertRaises(KeyboardInterrupt):
                    call(cell)
                print(f"{name}: {time.monotonic() - begin - 0.3:.3f} s after Ctrl-C")
                timer.join()
                self.assertEqual(set(ended), {"ended"})
                self.assertEqual(threading.active_count(), 1)
                cell.wait(0.1)
                for one in cell.robots.values():
                    one.recover()
                    self.assertTrue(one.move_to(turned(0.1)).succeeded)


class ObjectsOfAll(Folder):
    def test_each_robot_sees_and_places_what_it_can_reach(self):
        boxes = [{**BOX, "name": "near", "position": ["0.5 m", "0.5 m", "0 m"]}, {**BOX, "name": "far", "position": ["0.5 m", "6 m", "0 m"]}]
        with pt.Cell({"objects": boxes, "robots": {"a": robot(6), "left": robot(0.5), "right": robot(-0.5)}}) as cell:
            a, left, right = cell.robots.values()
            self.assertEqual([list(one.objects) for one in (a, left, right)], [["far"], ["near"], ["near"]])
            for one in (left, right):
                np.testing.assert_allclose(one.objects["near"][:3, 3], [0.5, 0.5, 0.025], atol=1e-3)
            pose = left.objects["near"]
            pose[1, 3] = 0.2
            right.objects["near"] = pose
            left.wait(0.2)
            np.testing.assert_allclose(left.objects["near"][:3, 3], [0.5, 0.2, 0.025], atol=1e-3)

    def test_one_arm_hands_a_box_to_a_table_that_the_other_sees(self):
        table = {"name": "table", "shape": "box", "size": ["0.3 m", "0.3 m", "0.38 m"], "position": ["0.307 m", "0.5 m", "0.19 m"]}
        box = {"name": "box", "shape": "box", "size": ["0.1 m", "0.1 m", "0.1055 m"], "mass": "0.5 kg", "on": "table"}
        pump = robot(0.5)
        pump["robot"]["hand"] = "cobot_pump"
        with pt.Cell({"objects": [table, box], "robots": {"left": pump, "right": robot(-0.5)}}) as cell:
            left, right = cell.robots.values()
            self.assertTrue(left.hand.vacuum(600).succeeded)
            lifted = cell.together(left=lambda one: one.move(pt.Trajectory([REST, turned(-0.2, joint=1)])), right=lambda one: one.hand.move(0.02))
            self.assertTrue(lifted["left"].succeeded)
            self.assertGreater(right.objects["box"][2, 3], 0.47)
            left.hand.drop_off()
            cell.wait(1)
            self.assertLess(right.objects["box"][2, 3], 0.45)


class Plans(Folder):
    """The right arm holds its hand where the shortest way of the left one leads through."""

    BESIDE, BEYOND = turned(-math.pi / 2 - 0.8), turned(-math.pi / 2 + 0.8)

    def test_move_to_keeps_clear_of_where_the_others_are(self):
        with pt.Cell(keys(gap=0.3)) as cell:
            left, right = cell.robots["left"], cell.robots["right"]
            self.assertTrue(left.move_to(self.BESIDE).succeeded)
            self.assertTrue(right.move_to(turned(math.pi / 2)).succeeded)
            self.assertTrue(left.move_to(self.BEYOND).succeeded)
            np.testing.assert_allclose(left.state.q, self.BEYOND, atol=2e-3)
            np.testing.assert_allclose(right.state.q, turned(math.pi / 2), atol=2e-3)
            with self.assertRaisesRegex(ValueError, "the goal is in collision: .*left/panda_hand and right/panda_hand"):
                left.move_to(turned(-math.pi / 2))

    def test_a_planned_motion_keeps_clear_of_where_the_others_start(self):
        def motion(start, goal):
            return {"robot": {**robot(0)["robot"], "q_start": {"unit": "rad", "values": start}},
                    "motion": {"plan": {"goal": {"q": {"unit": "rad", "values": goal}}}}}
        left, right = motion(self.BESIDE, self.BEYOND), motion(turned(math.pi / 2), turned(math.pi / 2 + 0.01))
        for one, y in ((left, 0.3), (right, -0.3)):
            one["robot"]["pose"] = {"position": ["0 m", f"{y} m", "0 m"]}
        scenario = self.folder / "planned.yaml"
        scenario.write_text(json.dumps({"name": "planned", "robots": {"left": left, "right": right}}))
        run(scenario, self.folder / "out")
        summary = json.loads((self.folder / "out/summary.json").read_text())
        for one in summary["robots"].values():
            self.assertEqual((one["outcome"], one["contacts"]["cycles"]), ("success", 0), one)
        np.testing.assert_allclose(pt.Log(self.folder / "out/left").cycles["q"][-1], self.BEYOND, atol=2e-3)


class Openings(Folder):
    def test_takes_a_file_a_text_and_keys(self):
        with pt.Cell("cells/two_arms.yaml") as cell:
            self.assertEqual(repr(cell), "Cell('two_arms', ['left', 'right'])")
            self.assertEqual(repr(cell.robots["left"]), "Robot('left')")
        with pt.Cell(TWO_ARMS.read_text()) as cell:
            self.assertEqual(len(cell.robots), 2)
        poses = {"left": ["0 m", "1 m", "0 m"], "right": ["0 m", "-1 m", "0 m"]}
        with pt.Cell({"robots": {name: {"robot": {"pose": {"position": pose}}} for name, pose in poses.items()}}) as cell:
            np.testing.assert_allclose(cell.robots["right"].state.q, pt.model.Q_READY, atol=1e-6)
        self.assertTrue(cell.closed)
        cell.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            cell.robots["left"].wait(1)

    def test_the_seed_counts(self):
        def bits(seed):
            with pt.Cell(keys(), seed=seed) as cell:
                cell.wait(0.05)
            return hashes(cell)

        self.assertEqual(bits(1), bits(1))
        self.assertNotEqual(bits(2)["left"], bits(1)["left"])

    def test_what_is_wrong_is_told(self):
        for call, error, text in (
            (lambda: pt.Session(TWO_ARMS), ValueError, "two_arms.yaml:7: .*panda_twin.Cell"),
            (lambda: pt.Session(keys()), ValueError, "panda_twin.Cell"),
            (lambda: pt.run(TWO_ARMS), ValueError, "panda_twin.Cell"),
            (lambda: pt.Cell("scenarios/smoke.yaml"), ValueError, 'smoke.yaml:.*"robots" is missing: it describes one robot'),
            (lambda: pt.Cell({}), ValueError, '"robots" is missing'),
            (lambda: pt.Cell(5), TypeError, "scenario is of type int"),
            (lambda: pt.Cell("nowhere.yaml"), ValueError, "nowhere.yaml"),
            (lambda: pt.Cell(keys(drive="realtime")), ValueError, "say drive: lockstep"),
            (lambda: pt.Cell(keys(gap=0.05)), ValueError, "they overlap"),
        ):
            with self.subTest(text), self.assertRaisesRegex(error, text):
                call()

    def test_what_needs_one_robot_says_so(self):
        with pt.Cell(keys()) as cell:
            for name in ("move", "move_to", "control", "state", "hand", "objects", "recover", "snapshot"):
                with self.assertRaisesRegex(AttributeError, rf"a cell has no {name}; its robots have: cell.robots\['left'\].{name}"):
                    getattr(cell, name)
            with self.assertRaisesRegex(AttributeError, "no attribute 'colour'"):
                cell.colour
            with self.assertRaisesRegex(KeyError, "unknown robot 'middle'; there are left, right"):
                cell.robots["middle"]
            for call in (cell.robots["left"].snapshot, cell.robots["left"].reset):
                with self.assertRaisesRegex(ValueError, "open the cell anew"):
                    call()

    def test_leaves_the_logs_of_a_run(self):
        out = self.folder / "out"
        for seconds in (0.4, 0.2):  # the second replaces the first
            with pt.Cell(keys(name="logged"), log=out) as cell:
                cell.together(left=lambda one: one.move(path(0.05)), right=lambda one: one.wait(seconds))
                self.assertFalse((out / "left/run.mcap").exists())
            lengths = {name: len(pt.Log(out / name).cycles) for name in ("left", "right")}
            self.assertEqual(lengths["left"], lengths["right"])
        self.assertEqual(len(pt.Log(out / "left").motions), 1)
        self.assertEqual(pt.Log(out / "right").cycles["q"].shape, (lengths["right"], 7))
        with pt.Session(out / "left/scenario.yaml"), pt.Cell(out / "scenario.yaml") as again:
            self.assertEqual(list(again.robots), ["left", "right"])
        told = subprocess.run([PANDA_TWIN, "render", out, "--out", self.folder / "all.mp4"], capture_output=True, text=True)
        self.assertEqual(told.returncode, 0, told.stderr)
        with self.assertRaises(OSError):
            pt.Cell(keys(), log="/proc/nowhere")


class Leaks(unittest.TestCase):
    def test_cells_leave_nothing_behind(self):
        def use(times):
            for _ in range(times):
                with pt.Cell(keys()) as cell:
                    cell.together(left=lambda robot: robot.wait(0.002), right=lambda robot: robot.wait(0.001))
            return threading.active_count(), process_counts.descriptors()

        before = use(2)
        threads = process_counts.threads()
        self.assertEqual(use(10), before)
        self.assertLessEqual(process_counts.threads(at_most=threads), threads)

    def test_a_thread_that_cannot_be_started_ends_the_others(self):
        start = threading.Thread.start

        def fail(thread):
            if thread.name == "right":
                raise RuntimeError("can't start new thread")
            start(thread)

        with pt.Cell(keys()) as cell:
            with unittest.mock.patch.object(threading.Thread, "start", fail), self.assertRaisesRegex(RuntimeError, "can't start"):
                cell.together(left=lambda robot: [robot.wait(0.1) for _ in range(100_000)], right=pt.Robot.move)
            self.assertEqual(cell.together(left=lambda robot: 1, right=lambda robot: 2), {"left": 1, "right": 2})


class Example(Folder):
    def test_the_one_of_the_documents_runs(self):
        text = (SOURCE / "docs/tutorials/python.md").read_text()
        example = re.search(r'^```python title="two_arms.py"\n(.*?)^```', text, re.MULTILINE | re.DOTALL)[1]
        self.assertLessEqual(example.count("\n"), 20)
        told = subprocess.run([sys.executable, "-c", example], cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(told.returncode, 0, told.stderr)
        self.assertIn("right began after left: True", told.stdout)
        self.assertTrue((self.folder / "two_arms/right/run.mcap").exists())


if __name__ == "__main__":
    unittest.main()
