"""Runs from Python: the same bytes as the program's, what they leave, how they fail, and how they are ended."""

import atexit
import json
import multiprocessing
import os
import pathlib
import pickle
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import panda_twin as pt
from panda_twin import _host

PROGRAM = _host._executable()
READY = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]


def motion_to(goal, duration="4 s"):
    return {"trajectory": {"unit": "rad", "duration": duration, "waypoints": [{"q": READY}, {"q": goal}]}}


LOSSY = {  # INT ends the motion after 20 lost commands in a row
    "name": "lossy",
    "plant": {"kind": "ideal"},
    "link": {"command_loss": {"scripted": [{"at": "500 ms", "count": 60}]}},
    "motion": motion_to([0.5, *READY[1:]]),
}
# Noise of 10 mrad that no generator smooths makes accelerations of up to 4 x 10 mrad / (1 ms)^2 = 40000 rad/s^2.
ROUGH = {
    "name": "rough",
    "plant": {"kind": "ideal"},
    "tick": {"generator": "none", "rate_matching": False},
    "controller": {"target_noise": "10 mrad"},
    "motion": motion_to([0.5, *READY[1:]]),
}
LONG = {"name": "long", "plant": {"kind": "ideal"}, "motion": motion_to([0.5, *READY[1:]], "30000 s")}
SEEN = {"name": "seen", "motion": motion_to([0.3, *READY[1:]], "2 s"), "render": {"fps": "5 Hz"}}


def hash_of(name):
    return pt.run(name, seed=5).states_hash


def refusal_of_video(out):
    """What a run that makes a video is refused for; empty: nothing."""
    try:
        pt.run(SEEN, out=out)
    except OSError as refused:
        return str(refused)
    return ""


class RunTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def of_program(self, name, *flags):
        """summary.json of a run by the program."""
        out = self.folder / "program"
        done = subprocess.run([PROGRAM, "run", name, "--no-video", "--out", out, "-q", *flags], capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads((out / "summary.json").read_text())

    def test_gives_the_bytes_of_the_program(self):
        for name in ("scenarios/canonical.yaml", "applications/plan_and_execute.yaml"):
            with self.subTest(name):
                result = pt.run(name, seed=5)
                self.assertEqual(result.summary, self.of_program(name, "--seed", "5"))
                self.assertEqual(result.states_hash, result.summary["states_hash"])
                self.assertRegex(result.states_hash, "^[0-9a-f]{16}$")
                self.assertNotEqual(result.states_hash, pt.run(name, seed=6).states_hash)
                self.assertEqual(result.log.read_bytes(), (self.folder / "program/run.mcap").read_bytes())

    def test_lays_a_lab_over_the_scenario(self):
        result = pt.run("scenarios/canonical.yaml", lab="a")
        self.assertEqual(result.summary, self.of_program("scenarios/canonical.yaml", "--lab", "a"))
        self.assertNotEqual(result.scenario, pt.Scenario.load("scenarios/canonical.yaml"))

    def test_writes_what_the_program_writes(self):
        result = pt.run("scenarios/smoke.yaml", out=self.folder / "python", seed=9)
        self.of_program("scenarios/smoke.yaml", "--seed", "9")
        files = [{str(path.relative_to(root)) for path in root.rglob("*")} for root in (result.folder, self.folder / "program")]
        self.assertEqual(*files)
        self.assertEqual((result.scenario.seed, result.folder), (9, self.folder / "python"))

    def test_makes_the_video_in_the_folder_that_is_given(self):
        self.assertGreater(pt.run(SEEN, out=self.folder / "a").video.stat().st_size, 1000)
        self.assertIsNone(pt.run(SEEN, out=self.folder / "b", video=False).video)

    def test_keeps_a_temporary_log_as_long_as_the_result(self):
        result = pt.run("scenarios/smoke.yaml")
        copy = pickle.loads(pickle.dumps(result))
        folder = result.folder
        self.assertEqual(sorted(path.name for path in folder.iterdir()), ["run.mcap", "scenario.yaml", "summary.json", "timing.json"])
        self.assertFalse(result.explain().aborted)
        del result
        self.assertFalse(folder.exists())
        self.assertIsNone(copy.log)
        self.assertTrue(copy.succeeded)

    def test_makes_no_log_of_a_scenario_without(self):
        scenario = pt.Scenario.load("scenarios/smoke.yaml")
        result = pt.run(scenario.replace({"record": False}))
        self.assertIsNone(result.log)
        self.assertEqual(result.states_hash, pt.run(scenario).states_hash)

    def test_runs_on_the_wall_clock(self):
        result = pt.run({"name": "short", "plant": {"kind": "ideal"}, "motion": motion_to([0.1, *READY[1:]], "1 s")}, drive="realtime", check=False)
        self.assertEqual(result.summary["drive"], "realtime")

    def test_tells_progress(self):
        told = []
        pt.run("scenarios/canonical.yaml", progress=lambda work, share: told.append((work, share)))
        self.assertTrue(told)
        self.assertTrue(all(work == "run" and 0 <= share for work, share in told), told)


class FaultTest(unittest.TestCase):
    def test_carries_error_joint_value_limit_and_cycle(self):
        with self.assertRaises(pt.RobotFault) as caught:
            pt.run(ROUGH)
        fault = caught.exception
        self.assertEqual(fault.error, "joint_motion_generator_velocity_discontinuity")
        self.assertIn(fault.joint, range(1, 8))
        self.assertGreater(abs(fault.value), abs(fault.limit))
        self.assertGreater(fault.cycle, 0)
        for part in (fault.error, f"joint {fault.joint}", f"{fault.value:.7g}", f"{fault.limit:.7g}", f"cycle of state {fault.cycle}"):
            self.assertIn(part, str(fault))
        self.assertFalse(fault.result.succeeded)
        self.assertEqual(fault.result.summary["outcome"], "aborted")

    def test_has_no_joint_of_an_error_of_none(self):
        with self.assertRaises(pt.RobotFault) as caught:
            pt.run(LOSSY)
        self.assertEqual((caught.exception.error, caught.exception.joint), ("communication_constraints_violation", None))
        told = caught.exception.explanation
        self.assertEqual((told.value, told.limit), (20, 20))
        for text in (str(caught.exception), json.dumps(caught.exception.result.summary)):
            self.assertIn("20 cycles in a row without a command; 20 end a motion", text)

    def test_is_not_raised_unless_checked(self):
        result = pt.run(LOSSY, check=False)
        self.assertFalse(result.succeeded)
        self.assertIn("communication_constraints_violation", result.failure)
        explanation = result.explain()
        self.assertTrue(explanation.aborted)
        self.assertTrue(explanation.page.lstrip().startswith("<!"), explanation.page[:40])

    def test_tells_the_failure_without_a_log(self):
        with self.assertRaises(pt.RobotFault) as caught:
            pt.run({**LOSSY, "record": False})
        self.assertIsNone(caught.exception.explanation)
        self.assertIn("communication_constraints_violation", str(caught.exception))

    def test_strict_judges_the_deviation(self):
        scenario = {"name": "off", "motion": motion_to([0.5, *READY[1:]]), "max_deviation": {"joints": "0.001 mrad"}}
        with self.assertLogs("panda_twin", "WARNING") as logged:
            self.assertTrue(pt.run(scenario).succeeded)
        self.assertIn("the arm was off its path", logged.output[-1])
        with self.assertRaisesRegex(pt.RobotFault, "the arm was off its path"):
            pt.run(scenario, strict=True)


class InterruptTest(unittest.TestCase):
    """Temporary folders go to a folder of the test's own, where what is left would show."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        usual = tempfile.tempdir
        tempfile.tempdir = folder.name
        self.addCleanup(setattr, tempfile, "tempdir", usual)

    def when_it_runs(self, act):
        """Calls `act` from another thread, while the log is written."""

        def wait():
            while not list(self.folder.rglob("run.mcap.partial")):
                time.sleep(0.01)
            act()

        thread = threading.Thread(target=wait)
        thread.start()
        self.addCleanup(thread.join)

    def test_control_c_ends_the_run_and_leaves_nothing(self):
        handler = signal.getsignal(signal.SIGINT)
        self.when_it_runs(lambda: os.kill(os.getpid(), signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt):
            pt.run(LONG)
        self.assertEqual(list(self.folder.iterdir()), [])
        self.assertIs(signal.getsignal(signal.SIGINT), handler)
        self.assertTrue(pt.run("scenarios/smoke.yaml").succeeded)

    def test_control_c_leaves_whole_results_in_the_folder_that_is_given(self):
        self.when_it_runs(lambda: os.kill(os.getpid(), signal.SIGINT))
        with self.assertRaises(KeyboardInterrupt):
            pt.run(LONG, out=self.folder / "out")
        self.assertEqual([path for path in self.folder.rglob("*.partial")], [])
        self.assertEqual(json.loads((self.folder / "out/summary.json").read_text())["outcome"], "interrupted")

    def test_a_handler_of_the_users_runs_meanwhile_and_the_run_goes_on(self):
        called = []
        usual = signal.signal(signal.SIGUSR1, lambda number, frame: called.append(number))
        self.addCleanup(signal.signal, signal.SIGUSR1, usual)
        self.when_it_runs(lambda: os.kill(os.getpid(), signal.SIGUSR1))
        self.assertTrue(pt.run("scenarios/canonical.yaml").succeeded)
        self.assertEqual(called, [signal.SIGUSR1])

    def test_what_progress_raises_ends_the_run(self):
        class Enough(Exception):
            pass

        def raise_it(work, share):
            raise Enough

        with self.assertRaises(Enough):
            pt.run(LONG, progress=raise_it)
        self.assertEqual(list(self.folder.iterdir()), [])


class ThreadsTest(unittest.TestCase):
    def test_runs_beside_each_other(self):
        expected = hash_of("scenarios/smoke.yaml")
        hashes = []
        threads = [threading.Thread(target=lambda: hashes.append(hash_of("scenarios/smoke.yaml"))) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(hashes, [expected] * 3)

    def test_a_fork_runs_too(self):
        expected = hash_of("scenarios/smoke.yaml")
        kept = pt.run("scenarios/smoke.yaml")
        with multiprocessing.get_context("fork").Pool(2) as pool:
            self.assertEqual(pool.map(hash_of, ["scenarios/smoke.yaml"] * 2, chunksize=1), [expected] * 2)
        child = os.fork()
        if child == 0:
            atexit._run_exitfuncs()  # as sys.exit would, which unittest catches
            os._exit(0)
        os.waitpid(child, 0)
        self.assertTrue(kept.log.is_file())

    def test_a_fork_of_a_process_that_has_drawn_is_told_to_start_anew(self):
        with tempfile.TemporaryDirectory() as folder:
            pt.run(SEEN, out=f"{folder}/a")
            for method, answer in (("fork", "forked from one that has drawn pictures"), ("spawn", "")):
                with self.subTest(method), multiprocessing.get_context(method).Pool(1) as pool:
                    self.assertIn(answer, pool.apply_async(refusal_of_video, [f"{folder}/{method}"]).get(300))
            self.assertEqual(*[pathlib.Path(folder, one, "contact_sheet.png").read_bytes() for one in ("a", "spawn")])


if __name__ == "__main__":
    unittest.main()
