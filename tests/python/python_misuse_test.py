"""What users get wrong: the class of the exception, and what its text must say."""

import contextlib
import gc
import math
import os
import pathlib
import tempfile
import unittest

import panda_twin as pt

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
]


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


if __name__ == "__main__":
    unittest.main()
