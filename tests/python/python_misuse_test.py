"""What users get wrong: the class of the exception, and what its text must say."""

import contextlib
import gc
import math
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import threading
import unittest

import numpy as np

import panda_twin as pt
from panda_twin.envs import PandaEnv, PandaVectorEnv

READY = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
MOTION = {"trajectory": {"unit": "rad", "waypoints": [{"q": READY}, {"q": [0.5, *READY[1:]]}]}}
SMOKE = "scenarios/smoke.yaml"
FOLDER = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
HERE = pathlib.Path(FOLDER.name)
TEMPORARY = HERE / "temporary"  # of runs without `out`
TEMPORARY.mkdir()
tempfile.tempdir = str(TEMPORARY)


def scenario(**keys):
    return pt.Scenario(**{"name": "here", "motion": MOTION, **keys})


def through(q):
    return {"trajectory": {"unit": "rad", "waypoints": [{"q": READY}, {"q": q}]}}


def file(name, text):
    (HERE / name).write_text(text)
    return HERE / name


# What is called, the class of what it raises, and fragments of the text.
TABLE = [
    # What stands for a scenario
    (lambda: pt.run(5), TypeError, "scenario is of type int; a Scenario, a dict of its keys or a file's name belongs here"),
    (lambda: pt.run(None), TypeError, "of type NoneType"),
    (lambda: pt.run(["a.yaml"]), TypeError, "of type list"),
    (lambda: pt.run(b"scenarios/smoke.yaml"), TypeError, "of type bytes"),
    (lambda: pt.run(), TypeError, "scenario"),
    (lambda: pt.run("smoke.yaml"), ValueError, "name one of the installed with its folder: scenarios/smoke.yaml"),
    (lambda: pt.Session("smoke.yaml"), ValueError, "name one of the installed with its folder: scenarios/smoke.yaml"),
    (lambda: pt.serve("smoke.yaml"), ValueError, "name one of the installed with its folder: scenarios/smoke.yaml"),
    (lambda: pt.run(SMOKE, 7), TypeError, "positional"),
    (lambda: pt.Session(5), TypeError, "scenario is of type int"),
    (lambda: pt.Session("nowhere/smoke.yaml"), ValueError, "nowhere/smoke.yaml"),
    (lambda: pt.Session({"seeds": 3}), ValueError, 'unknown key "seeds"'),
    (lambda: pt.Session({"plant": {"kind": "ideal"}}).move([READY, READY]), TypeError, "trajectory is of type list; a panda_twin.Trajectory"),
    (lambda: pt.serve(5), TypeError, "scenario is of type int"),
    (lambda: pt.envs.PandaEnv("Reech"), ValueError, "give a class derived from panda_twin.envs.Task"),
    (lambda: pt.envs.PandaEnv(int), ValueError, "give a class derived from panda_twin.envs.Task"),
    (lambda: pt.run(SMOKE, sed=7), TypeError, "sed"),
    (lambda: pt.run("no_such.yaml"), ValueError, "no_such.yaml: No such file or directory"),
    (lambda: pt.run(""), ValueError, "give an existing YAML file"),
    (lambda: pt.run(HERE), ValueError, "not a file"),
    (lambda: pt.Scenario.load(7), TypeError, "int"),
    (lambda: pt.Scenario.load(file("empty.yaml", "")), ValueError, "empty.yaml:1: "),
    (lambda: pt.Scenario.load(file("list.yaml", "- 1")), ValueError, "list.yaml:1: "),
    (lambda: pt.Scenario.load(file("open.yaml", "name: [a\n")), ValueError, "not valid YAML"),
    (lambda: pt.Scenario.from_yaml(5), TypeError, "parse"),
    # Times
    (lambda: pt.Trajectory([READY, READY], times=[0, math.nan]), ValueError, "waypoint 2: time, s, is nan; it must lie in [0, 86400]"),
    (lambda: pt.Trajectory([READY, READY], times=[0, math.inf]), ValueError, "waypoint 2: time, s, is inf"),
    (lambda: pt.Trajectory([READY, READY], duration=1e300), ValueError, "duration, s, is 1e+300; it must lie in [0, 86400]"),
    (lambda: pt.Trajectory([READY, [0.1, *READY[1:]]]).sample(math.nan), ValueError, "time, s, is nan"),
    (lambda: pt.Session().control(lambda state, dt: None, until=1e-12), ValueError, "until, s, is 1e-12; it must lie in [0.001, 86400]"),
    (lambda: PandaEnv("Reach", viability=2.7), TypeError, "float"),
    # Keys and values
    (lambda: pt.Scenario(), ValueError, 'Scenario():1: '),
    (lambda: pt.Scenario(name="here"), ValueError, "motion"),
    (lambda: scenario(nam="x"), ValueError, 'unknown key "nam"; did you mean "name"?'),
    (lambda: scenario(link={"command_los": "1 %"}), ValueError, 'link: unknown key "command_los"; did you mean "command_loss"?'),
    (lambda: scenario(link={"command_loss": "101 %"}), ValueError, "link.command_loss: "),
    (lambda: scenario(link={"command_loss": 1}), ValueError, "link.command_loss: "),
    (lambda: scenario(link=[1]), ValueError, "link: is a list; a map"),
    (lambda: scenario(seed=-1), ValueError, "seed: "),
    (lambda: scenario(seed=2**64), ValueError, "seed: "),
    (lambda: scenario(seed=1.5), ValueError, "seed: "),
    (lambda: scenario(name="a/b"), ValueError, "name: "),
    (lambda: scenario(drive="fast"), ValueError, "drive: "),
    (lambda: scenario(record="maybe"), ValueError, "record: "),
    (lambda: scenario(tick={"lambda": math.nan}), ValueError, "tick.lambda: "),
    (lambda: scenario(tick={"lambda": math.inf}), ValueError, "tick.lambda: "),
    (lambda: scenario(motion=through([math.nan, *READY[1:]])), ValueError, "waypoints[2].q"),
    (lambda: scenario(motion=through(READY[1:])), ValueError, "waypoints[2].q"),
    (lambda: scenario(motion=through(["a", *READY[1:]])), ValueError, "waypoints[2].q"),
    (lambda: scenario(description={1, 2}), TypeError, "of type set"),
    (lambda: scenario(description=object()), TypeError, "of type object"),
    (lambda: scenario(scene=b"x"), TypeError, "of type bytes"),
    (lambda: scenario().replace("link"), TypeError, "changes is of type str"),
    (lambda: scenario().replace({"link": {"d_INT": "-1 us"}}), ValueError, "(replaced)"),
    (lambda: scenario().replace({"motion": None}), ValueError, "motion"),
    (lambda: scenario().replace({}, remove=["name"]), ValueError, "name"),
    (lambda: scenario() < scenario(), TypeError, "'<' not supported"),
    # What only a run can know
    (lambda: pt.run(scenario(motion=through([9, *READY[1:]]))), ValueError, "joint 1"),
    (lambda: pt.run(scenario(scene="scenes/none.xml")), ValueError, "none.xml"),
    (lambda: pt.run(scenario(controller={"type": "none_such"})), ValueError, "none_such"),
    (lambda: pt.run(scenario(backend="fci")), ValueError, "backend is fci"),
    (lambda: pt.run(scenario(backend="no_such")), ValueError, "no_such"),
    (lambda: pt.validate(scenario(robot={"model": "ur5"})), ValueError, "ur5"),
    (lambda: pt.validate(SMOKE, load="yes"), TypeError, "validate"),
    # Arguments of a run
    (lambda: pt.run(SMOKE, seed=-1), ValueError, "seed is -1; it must be a whole number from 0 to 18446744073709551615"),
    (lambda: pt.run(SMOKE, seed=2**64), ValueError, "seed is 18446744073709551616; it must be"),
    (lambda: pt.run(SMOKE, seed=1.0), TypeError, "float"),
    (lambda: pt.run(SMOKE, seed="1"), TypeError, "str"),
    (lambda: pt.run(SMOKE, drive="fast"), ValueError, "fast"),
    (lambda: pt.run(SMOKE, drive=1), TypeError, "drive"),
    (lambda: pt.run(SMOKE, lab="z"), ValueError, "z"),
    (lambda: pt.run(SMOKE, lab=1), TypeError, "int"),
    (lambda: pt.run(SMOKE, quality="best"), ValueError, 'quality is "best"; accepted: draft, fine'),
    (lambda: pt.run(SMOKE, strict="no"), TypeError, "strict"),
    (lambda: pt.run(SMOKE, progress=3), TypeError, "progress is of type int; a callable"),
    # Folders of results
    (lambda: pt.run(SMOKE, out=5), TypeError, "int"),
    (lambda: pt.run(SMOKE, out=""), ValueError, "out is empty"),
    (lambda: pt.run(SMOKE, out=file("a_file", "")), OSError, "a_file"),
    (lambda: pt.run(SMOKE, out=HERE / "a_file" / "below"), OSError, "a_file"),
    (lambda: pt.run(SMOKE, out="/proc/here"), OSError, "/proc/here"),
    # Explanations
    (lambda: pt.explain(HERE / "nothing"), ValueError, "nothing"),
    (lambda: pt.explain(HERE), ValueError, "run.mcap"),
    (lambda: pt.explain(file("a.mcap", "no log")), ValueError, "a.mcap"),
    (lambda: pt.explain(5), TypeError, "int"),
    (lambda: pt.explain(HERE, motion=0), ValueError, "motions are counted from 1"),
    (lambda: pt.explain(HERE, motion=1.0), TypeError, "a whole number belongs here"),
    (lambda: pt.run(SMOKE).explain(motion=1), ValueError, "no error ended motion 1"),
    (lambda: pt.run(scenario(record=False, plant={"kind": "ideal"})).explain(), ValueError, "holds no run.mcap"),
    (lambda: setattr(scenario(), "seed", 3), AttributeError, "seed"),
    # Sessions, served robots, the model
    (lambda: pt.Session(SMOKE, seed=-1), ValueError, "seed is -1; it must be a whole number from 0 to 18446744073709551615"),
    (lambda: pt.Session(SMOKE, seed=1.5), TypeError, "float"),
    (lambda: pt.serve(seed=2**64), ValueError, "seed is 18446744073709551616; it must be"),
    (lambda: pt.model.fk(READY, F_T_EE=2 * np.eye(4)), ValueError, "F_T_EE: it must be finite, with a rotation"),
    (lambda: pt.model.jacobian(READY, F_T_EE=np.full((4, 4), np.nan)), ValueError, "F_T_EE: it must be finite"),
    # Environments
    (lambda: PandaVectorEnv(num_envs=0), ValueError, "num_envs: 0 is no whole number from 1 to 10000"),
    (lambda: PandaVectorEnv(num_envs=1.5), TypeError, "float"),
    (lambda: PandaVectorEnv(num_envs=10**9), ValueError, "num_envs: 1000000000 is no whole number"),
    (lambda: PandaVectorEnv(num_envs=2).reset(options={"reset_mask": [True]}), ValueError, "reset_mask: its shape is (1,)"),
    (lambda: PandaVectorEnv(num_envs=2).reset(options={"reset_mask": [True, False]}), ValueError, "begins episodes of all robots"),
    (lambda: PandaEnv(randomize={"loss": 5}), ValueError, "randomize: loss is 5; give (low, high)"),
    (lambda: PandaEnv(randomize={"loss": ("foo", 0, 1)}), ValueError, "randomize: loss is ('foo', 0, 1)"),
    (lambda: PandaEnv(randomize={"loss": (math.nan, 1)}), ValueError, "randomize: loss is (nan, 1)"),
    (lambda: PandaEnv(randomize={"delay": (1, 0)}), ValueError, "it must rise"),
    (lambda: PandaEnv(randomize={"delay": ("log_uniform", 0, 1)}), ValueError, "log_uniform from above 0"),
    (lambda: PandaEnv(randomize={"q_start": (5, 6)}).reset(), ValueError, "q_start gives"),
]


def alone(code):
    """Exit status and output of a Python process with this code."""
    lines = "import os, sys, threading, time\nimport numpy as np\nimport panda_twin as pt\nfrom panda_twin.envs import *\n" + code
    done = subprocess.run([sys.executable, "-c", lines], capture_output=True, text=True, timeout=60)
    return done.returncode, done.stdout + done.stderr


def answers(path, line):
    """A socket at a path where the one client is told a line."""
    listening = socket.socket(socket.AF_UNIX)
    listening.bind(str(path))
    listening.listen()

    def answer():
        client, _ = listening.accept()
        client.recv(1000)
        client.sendall(line)
        client.close()
        listening.close()

    threading.Thread(target=answer).start()


class MisuseTest(unittest.TestCase):
    @classmethod
    def tearDownClass(cls):
        FOLDER.cleanup()

    def test_each_misuse_is_told_in_its_words(self):
        for number, (call, kind, fragment) in enumerate(TABLE):
            with self.subTest(number=number, fragment=fragment):
                with self.assertRaises(kind) as raised:
                    call()
                self.assertIn(fragment, str(raised.exception))
        gc.collect()
        self.assertEqual([path.name for path in TEMPORARY.iterdir()], [])

    def test_a_run_cannot_replace_its_own_scenario(self):
        out = HERE / "again"
        pt.run(SMOKE, out=out, plots=False)
        with self.assertRaisesRegex(ValueError, "is a result of an earlier run"):
            pt.run(out / "scenario.yaml", out=out)

    def test_misuse_leaves_no_folder_that_was_named(self):
        for call in (lambda: pt.run(SMOKE, out=HERE / "new", seed=-1), lambda: pt.run(scenario(backend="no_such"), out=HERE / "new")):
            with contextlib.suppress(ValueError):
                call()
            self.assertFalse((HERE / "new").exists())

    def test_missing_programs_are_named_with_the_cure(self):
        host = {"executable": pt._host._executable(), "models": "", "meshes": "", "cache": "", "state": ""}
        self.addCleanup(pt._core.set_host, **host, path=os.environ["PATH"])
        pt._core.set_host(**host, path="/nowhere")
        moved = scenario(render={"fps": "5 Hz"})
        with self.assertRaisesRegex(OSError, "ffmpeg is not installed; apt-get install ffmpeg, or run with video=False"):
            pt.run(moved, out=HERE / "missing")
        with self.assertRaisesRegex(OSError, "gnuplot is not installed; apt-get install gnuplot-nox, or run with plots=False"):
            pt.run(moved, out=HERE / "missing", video=False)

    def test_a_session_finds_the_installed_scenarios_as_a_run_does(self):
        with pt.Session(SMOKE) as session:
            self.assertEqual(repr(session), "Session('smoke')")

    def test_foreign_answers_at_a_control_channel_are_told(self):
        for number, line in enumerate((b"garbage\n", b"[]\n", b"{}\n", b'{"ok":true}\n', b'{"ok":false}\n', b"\xff\n")):
            answers(HERE / f"foreign{number}", line)
            with self.subTest(line=line), self.assertRaisesRegex(OSError, "no answer of a control channel"):
                pt.control_channel(HERE / f"foreign{number}")

    def test_a_full_control_channel_says_so_each_time(self):
        path = HERE / "full"
        with contextlib.ExitStack() as stack:
            stack.enter_context(pt.serve(drive="lockstep", control=path))
            channel = pt.control_channel(path)
            for _ in range(22):
                stack.enter_context(socket.socket(socket.AF_UNIX)).connect(str(path))
            for _ in range(3000):  # a refusal may come before the request, or after
                with self.assertRaisesRegex(ValueError, "^8 programs are connected already; end one of them$"):
                    channel.status  # noqa: B018

    def test_numbers_of_a_request_are_finite(self):
        with pt.serve(drive="lockstep") as robot, self.assertRaisesRegex(ValueError, "reset: every number must be finite"):
            robot.reset([math.nan] * 7)

    def test_two_threads_on_an_environment_are_refused_or_take_turns(self):
        told = set()

        def use(call):
            for _ in range(50):
                try:
                    call()
                except RuntimeError as error:
                    told.add(str(error))

        for env, action in ((PandaEnv("Reach", render_mode="rgb_array"), (3,)), (PandaVectorEnv("Reach", 2, threads=2), (2, 3))):
            env.reset(seed=0)
            calls = [lambda: env.step(np.zeros(action))] * 3 + [env.reset, env.render, env.render]
            threads = [threading.Thread(target=use, args=(call,)) for call in calls]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
        self.assertEqual(told, {"the environment is in use by another thread; take one environment for each thread"})

    def test_threads_in_calls_do_not_disturb_the_end_of_the_interpreter(self):
        calls = {
            "wait": "with pt.Session() as session: session.wait(80000)",
            "control": "with pt.Session() as session: session.control(lambda state, dt: pt.Torques([0.0] * 7))",
            "run": "pt.run(LONG)",
            "serve": "with pt.serve(drive='realtime') as robot: time.sleep(100)",
        }
        program = """
import threading, time, panda_twin as pt
Q = list(pt.model.Q_READY)
LONG = {"name": "long", "plant": {"kind": "ideal"},
        "motion": {"trajectory": {"unit": "rad", "duration": "30000 s", "waypoints": [{"q": Q}, {"q": [0.5, *Q[1:]]}]}}}
def call():
    %s
for _ in range(2):
    threading.Thread(target=call, daemon=True).start()
time.sleep(1)
print("end", flush=True)
raise SystemExit(7)
"""
        for name, call in calls.items():
            with self.subTest(name):
                done = subprocess.run([sys.executable, "-c", program % call], capture_output=True, text=True, timeout=60)
                self.assertEqual((done.stdout, done.stderr, done.returncode), ("end\n", "", 7))

    def test_a_fork_has_no_threads_of_what_it_inherits(self):
        fork = "\nif child := os.fork():\n    print(os.waitpid(child, 0)[1])\n"
        told = alone(f"env = PandaVectorEnv('Reach', 2, threads=2); env.reset(seed=0){fork}print(env.step(np.zeros((2, 3)))[1])")
        self.assertEqual(told, (0, "[-1. -1.]\n0\n[-1. -1.]\n"))
        told = alone(f"s = pt.Session('{SMOKE}', log='{HERE}/f.mcap')\ntry:{fork.replace(chr(10), chr(10) + '    ')}\n"
                     "    s.wait(0.1); s.close(); print('closed')\nexcept RuntimeError as error:\n    print(error)")
        self.assertEqual(told[0], 0, told)
        self.assertRegex(told[1], "^a session with a log is process [0-9]+'s, and .* make one here\n0\nclosed\n$")
        told = alone(f"robot = pt.serve(drive='lockstep'){fork}try:\n    print(robot.status.mode)\n"
                     "except RuntimeError as error:\n    print(error)\nrobot.close()")
        self.assertRegex(told[1], "^a served robot is process [0-9]+'s, and .* make one here\n0\nIdle\n$")
        told = alone(f"env = PandaEnv(render_mode='rgb_array'); env.reset(); env.render(){fork}try:\n    env.render()\n"
                     "except OSError as error:\n    print(error, flush=True)\n    os._exit(0)")
        self.assertRegex(told[1], "^this process was forked from one that has drawn pictures, .*\n0\n$")


if __name__ == "__main__":
    unittest.main()
