"""LeRobot datasets: every item of format v3.0 that LeRobot reads, values out of the logs, same bytes for the same seeds, misuse."""

import contextlib
import io
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

import numpy as np
import pandas
import pyarrow
import pyarrow.parquet

import panda_twin as pt
from panda_twin import _lerobot_files, lerobot

READY = [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]
FPS = 10
SIZE = (64, 48)
CAMERAS = ("scenario", "gripper")
KEYS = ("observation.images.scenario", "observation.images.gripper")
FOLDER = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
HERE = pathlib.Path(FOLDER.name)
TASK = "The arm waves, and the hand closes."


def scenario(**changes):
    return pt.Scenario(
        name="wave",
        description=TASK,
        motion={
            "trajectory": {"unit": "rad", "acceleration_scale": 0.3, "waypoints": [{"q": READY}, {"q": [0.2, *READY[1:]]}]}
        },
        hand=[
            {"at": "0.1 s", "move": {"width": "70 mm", "speed": "0.1 m/s"}},
            {"at": "0.4 s", "move": {"width": "50 mm", "speed": "0.1 m/s"}},
        ],
        link={"command_loss": "8 %"},
        onboard={"abort_after_lost": 3},  # some seeds fail
    ).replace(changes)


FILMED = {"render": {"fps": f"{FPS} Hz", "overlays": []}}


def demonstrate(folder, **arguments):
    options = {"episodes": 3, "seed": 3, "fps": FPS, "cameras": CAMERAS, "size": SIZE, **arguments}
    return lerobot.demonstrate(scenario(), folder, **options)


def tearDownModule():
    FOLDER.cleanup()


def probe(path):
    shown = subprocess.run(
        ["ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json", path], check=True, capture_output=True
    )
    return json.loads(shown.stdout)["streams"]


def decoded(path):
    raw = subprocess.run(
        ["ffmpeg", "-v", "error", "-i", path, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], check=True, capture_output=True
    ).stdout
    return np.frombuffer(raw, dtype=np.uint8).reshape(-1, SIZE[1], SIZE[0], 3)


class DatasetTest(unittest.TestCase):
    """Of three episodes, by two cameras."""

    @classmethod
    def setUpClass(cls):
        cls.folder = HERE / "dataset"
        cls.told = []
        cls.done = demonstrate(cls.folder, progress=lambda seed, why: cls.told.append((seed, why)))
        cls.info = json.loads((cls.folder / "meta/info.json").read_text())
        cls.data = pyarrow.parquet.read_table(cls.folder / "data/chunk-000/file-000.parquet")
        cls.episodes = pyarrow.parquet.read_table(cls.folder / "meta/episodes/chunk-000/file-000.parquet")
        cls.logs = [pt.Log(HERE / f"run{seed}") for seed in cls.done.seeds if cls.run_of(seed)]

    @staticmethod
    def run_of(seed):
        return pt.run(scenario(**FILMED), seed=seed, out=HERE / f"run{seed}", video=False, plots=False)

    def column(self, name):
        return np.array(self.data[name].to_pylist())

    def test_only_runs_that_succeeded_are_episodes(self):
        seeds = range(3, 3 + len(self.told))
        outcomes = {seed: pt.run(scenario(**FILMED), seed=seed, check=False).succeeded for seed in seeds}
        self.assertEqual(self.done.seeds, tuple(seed for seed in seeds if outcomes[seed]))
        self.assertEqual(list(self.done.left_out), [seed for seed in seeds if not outcomes[seed]])
        self.assertGreater(len(self.done.left_out), 0)
        self.assertEqual(self.told, [(seed, self.done.left_out.get(seed, "")) for seed in seeds])
        text = str(self.done)
        self.assertIn(f"3 episodes, {self.done.frames} frames; {len(self.told)} runs", text)
        left_out = ", ".join(map(str, self.done.left_out))
        cause = 'motion aborted by reflex ["communication_constraints_violation"]'
        self.assertIn(f"left out {len(self.done.left_out)}, {cause}", text)
        self.assertIn(f"(seeds {left_out})", text)

    def test_there_are_these_files_and_no_others(self):
        files = {str(path.relative_to(self.folder)) for path in self.folder.rglob("*") if path.is_file()}
        self.assertEqual(
            files,
            {
                "meta/info.json", "meta/stats.json", "meta/tasks.parquet", "meta/episodes/chunk-000/file-000.parquet",
                "data/chunk-000/file-000.parquet", *(f"videos/{key}/chunk-000/file-000.mp4" for key in KEYS),
            },
        )
        self.assertEqual([path.name for path in HERE.iterdir() if path.name.startswith(".")], [])
        self.assertEqual(self.folder.stat().st_mode & 0o777, 0o755)

    def test_the_information_is_of_the_format(self):
        features = self.info.pop("features")
        frames = self.data.num_rows
        self.assertEqual(
            self.info,
            {
                "codebase_version": "v3.0", "robot_type": "panda", "total_episodes": 3, "total_frames": frames, "total_tasks": 1,
                "chunks_size": 1000, "data_files_size_in_mb": 100, "video_files_size_in_mb": 200, "fps": FPS,
                "splits": {"train": "0:3"},
                "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
                "video_path": "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
            },
        )
        q = [f"q[{i}]" for i in range(7)]
        q_d = [f"q_d[{i}]" for i in range(7)]
        self.assertEqual(features.pop("observation.state"), {"dtype": "float32", "shape": [8], "names": [*q, "gripper_width"]})
        self.assertEqual(features.pop("action"), {"dtype": "float32", "shape": [8], "names": [*q_d, "gripper_width"]})
        for key in KEYS:
            video = features.pop(key)
            self.assertEqual((video["dtype"], video["shape"]), ("video", [48, 64, 3]))
            self.assertEqual(video["names"], ["height", "width", "channels"])
            self.assertEqual((video["info"]["video.fps"], video["info"]["video.codec"]), (FPS, "h264"))
        self.assertEqual(features.pop("timestamp"), {"dtype": "float32", "shape": [1], "names": None})
        for name in ["frame_index", "episode_index", "index", "task_index"]:
            self.assertEqual(features.pop(name), {"dtype": "int64", "shape": [1], "names": None})
        self.assertEqual(features, {})
        self.info["features"] = json.loads((self.folder / "meta/info.json").read_text())["features"]

    def test_columns_have_their_types(self):
        vector = pyarrow.list_(pyarrow.float32(), 8)
        self.assertEqual(
            {field.name: field.type for field in self.data.schema},
            {
                "observation.state": vector, "action": vector, "timestamp": pyarrow.float32(), "frame_index": pyarrow.int64(),
                "episode_index": pyarrow.int64(), "index": pyarrow.int64(), "task_index": pyarrow.int64(),
            },
        )
        self.assertEqual(self.data.column_names[-5:], ["timestamp", "frame_index", "episode_index", "index", "task_index"])
        self.assertEqual([self.data[name].null_count for name in self.data.column_names], [0] * 7)

    def test_indices_count_frames_and_episodes(self):
        lengths = self.episodes["length"].to_pylist()
        self.assertEqual(len(lengths), 3)
        self.assertTrue(all(length >= 5 for length in lengths), lengths)
        frames = np.concatenate([np.arange(length) for length in lengths])
        self.assertEqual(self.column("frame_index").tolist(), frames.tolist())
        self.assertEqual(self.column("index").tolist(), list(range(sum(lengths))))
        self.assertEqual(self.column("episode_index").tolist(), np.repeat([0, 1, 2], lengths).tolist())
        self.assertEqual(set(self.column("task_index").tolist()), {0})
        self.assertEqual(self.data["timestamp"].to_pylist(), (frames / FPS).astype(np.float32).tolist())

    def test_episodes_say_where_they_are(self):
        lengths = self.episodes["length"].to_pylist()
        ends = np.cumsum(lengths)
        expected = {
            "episode_index": [0, 1, 2], "tasks": [[TASK]] * 3, "length": lengths,
            "dataset_from_index": [0, *ends[:-1]], "dataset_to_index": list(ends),
        }
        for where in ["data", *(f"videos/{key}" for key in KEYS), "meta/episodes"]:
            expected |= {f"{where}/chunk_index": [0] * 3, f"{where}/file_index": [0] * 3}
        for key in KEYS:
            expected[f"videos/{key}/from_timestamp"] = [begin / FPS for begin in [0, *ends[:-1]]]
            expected[f"videos/{key}/to_timestamp"] = [end / FPS for end in ends]
        places = [name for name in self.episodes.column_names if not name.startswith("stats/")]
        self.assertEqual(self.episodes.select(places).to_pydict(), expected)
        self.assertEqual(self.episodes.schema.field("tasks").type, pyarrow.list_(pyarrow.string()))

    def test_the_task_is_an_index_of_pandas(self):
        tasks = pandas.read_parquet(self.folder / "meta/tasks.parquet")
        self.assertEqual((tasks.index.name, tasks.index.tolist(), tasks.columns.tolist()), ("task", [TASK], ["task_index"]))
        self.assertEqual(tasks.loc[TASK].task_index, 0)

    def test_states_and_actions_are_those_of_the_logs(self):
        state, action, episode = self.column("observation.state"), self.column("action"), self.column("episode_index")
        for number, log in enumerate(self.logs):
            at, begin = log.cycles["at_ns"], int(log.table("scenes")["at_ns"][0])
            rows = np.flatnonzero(episode == number)
            end = min(int(at[-1]), int(log.table("scenes")["at_ns"][-1]))
            self.assertEqual(len(rows), (end - begin) * FPS // 10**9 + 1)
            for k, row in enumerate(rows):
                now, then = begin + k * 10**9 // FPS, begin + (k + 1) * 10**9 // FPS
                q = log.cycles["q"][[one <= now for one in at]][-1]
                q_d = log.cycles["q_d"][[one <= then for one in at]][-1]
                np.testing.assert_array_equal(state[row, :7], q.astype(np.float32), f"episode {number}, frame {k}")
                np.testing.assert_array_equal(action[row, :7], q_d.astype(np.float32), f"episode {number}, frame {k}")
        self.assertGreater(np.ptp(state[:, 0]), 0.15)

    def test_widths_are_measured_and_commanded(self):
        state, action = self.column("observation.state")[:, 7], self.column("action")[:, 7]
        episode, time = self.column("episode_index"), self.column("timestamp")
        for number in range(3):
            widths, commanded, at = state[episode == number], action[episode == number], time[episode == number]
            self.assertAlmostEqual(widths[0], 0.08, delta=1e-4)
            self.assertAlmostEqual(widths[np.searchsorted(at, 0.35)], 0.07, delta=5e-4)
            self.assertLess(widths[-1], 0.062)  # on the way to 50 mm
            # Frames end 0.1 s after their time, which counts from 1 ms: the one of 0.3 s ends with the second command.
            np.testing.assert_allclose(commanded[at < 0.25], 0.07, atol=5e-4)
            np.testing.assert_allclose(commanded[at > 0.25], widths[-1], atol=1e-3)

    def test_statistics_are_of_all_frames(self):
        stats = json.loads((self.folder / "meta/stats.json").read_text())
        self.assertEqual(set(stats), set(self.info["features"]))
        for name in self.data.column_names:
            values = self.column(name).astype(np.float64).reshape(self.data.num_rows, -1)
            for key, expected in {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}.items():
                np.testing.assert_allclose(stats[name][key], expected, rtol=1e-6, atol=1e-9, err_msg=f"{name} {key}")
            self.assertEqual(stats[name]["count"], [self.data.num_rows])
        pictures = self.pictures("gripper").astype(np.float64) / 255
        told = stats["observation.images.gripper"]
        self.assertEqual(told["count"], [len(pictures)])
        for key in ["min", "max", "mean", "std"]:
            self.assertEqual(np.shape(told[key]), (3, 1, 1))
            np.testing.assert_allclose(np.ravel(told[key]), getattr(np, key)(pictures, axis=(0, 1, 2)), rtol=1e-6, err_msg=key)

    def test_statistics_of_each_episode_are_of_its_frames(self):
        rows = self.episodes.to_pylist()
        index = self.column("episode_index")
        pictures, at = self.pictures("gripper") / 255, 0
        for episode, row in enumerate(rows):
            for name in self.data.column_names:
                values = self.column(name).astype(np.float64).reshape(self.data.num_rows, -1)[index == episode]
                for key, expected in {"min": values.min(0), "max": values.max(0), "mean": values.mean(0), "std": values.std(0)}.items():
                    np.testing.assert_allclose(row[f"stats/{name}/{key}"], expected, rtol=1e-6, atol=1e-9, err_msg=f"{name} {key}")
                self.assertEqual(row[f"stats/{name}/count"], [row["length"]])
            own = pictures[at : (at := at + row["length"])]
            for key in ["min", "max", "mean", "std"]:
                told = row[f"stats/observation.images.gripper/{key}"]
                self.assertEqual(np.shape(told), (3, 1, 1))
                np.testing.assert_allclose(np.ravel(told), getattr(np, key)(own, axis=(0, 1, 2)), rtol=1e-6, err_msg=key)

    def pictures(self, camera):
        """Those that the log's own call draws."""
        drawn = [list(log.frames(FPS, camera=None if camera == "scenario" else camera, size=SIZE)) for log in self.logs]
        lengths = self.episodes["length"].to_pylist()
        return np.concatenate([frames[:length] for frames, length in zip(drawn, lengths)])

    def test_videos_have_the_frames_of_the_episodes(self):
        for camera, key in zip(CAMERAS, KEYS):
            path = self.folder / f"videos/{key}/chunk-000/file-000.mp4"
            (stream,) = probe(path)
            self.assertEqual([stream[key] for key in ("codec_name", "pix_fmt", "width", "height")], ["h264", "yuv420p", 64, 48])
            self.assertEqual((stream["r_frame_rate"], int(stream["nb_read_frames"])), (f"{FPS}/1", self.data.num_rows))
            self.assertAlmostEqual(float(stream["start_time"]), 0, delta=1e-6)
            end = self.episodes[f"videos/{key}/to_timestamp"].to_pylist()[-1]
            self.assertAlmostEqual(float(stream["duration"]), end, delta=1e-4)
            drawn = self.pictures(camera).astype(np.int16)
            apart = np.array([[np.abs(one - other).mean() for other in drawn] for one in decoded(path).astype(np.int16)])
            self.assertLess(np.diag(apart).max(), 6)  # what the encoder and its halved colours lose
            self.assertGreater(apart[0, -1], 2 * apart[0, 0])

    def test_the_same_seeds_give_the_same_bytes(self):
        demonstrate(HERE / "again")
        demonstrate(HERE / "other", seed=8)
        for path in [*self.folder.rglob("*.parquet"), *self.folder.rglob("*.json")]:
            name = path.relative_to(self.folder)
            self.assertEqual(path.read_bytes(), (HERE / "again" / name).read_bytes(), name)
        data = "data/chunk-000/file-000.parquet"
        self.assertNotEqual((self.folder / data).read_bytes(), (HERE / "other" / data).read_bytes())


class WriteTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.results = HERE / "one_run"
        pt.run(scenario(**FILMED), seed=3, out=cls.results, video=False, plots=False)
        cls.log = pt.Log(cls.results)

    def setUp(self):
        folder = tempfile.TemporaryDirectory(dir=HERE)
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.out = self.folder / "out"

    def table(self):
        return pyarrow.parquet.read_table(self.out / "data/chunk-000/file-000.parquet")

    def test_chosen_columns_need_no_scenes_and_no_video(self):
        pt.run("scenarios/smoke.yaml", out=self.folder / "smoke", video=False, plots=False)
        log = pt.Log(self.folder / "smoke")
        self.assertEqual(len(log.table("scenes")), 0)
        logs = [log, *log.motions]
        lerobot.write(logs, self.out, fps=50, cameras=(), state=("q", "O_T_EE"), action=("q_ext", "O_T_EE_d"), task="wave")
        info = json.loads((self.out / "meta/info.json").read_text())
        self.assertIsNone(info["video_path"])
        self.assertEqual(info["total_episodes"], 1 + len(log.motions))
        self.assertFalse((self.out / "videos").exists())
        poses = [f"O_T_EE[{i}]" for i in (12, 13, 14, 0, 1, 2, 4, 5, 6)]
        self.assertEqual(info["features"]["observation.state"]["names"][7:], poses)
        self.assertEqual(info["features"]["action"]["shape"], [16])
        state, action = (np.array(self.table()[name].to_pylist()) for name in ("observation.state", "action"))
        first = log.cycles["O_T_EE"][0]
        np.testing.assert_array_equal(state[0, 7:10], first[12:15].astype(np.float32))
        np.testing.assert_array_equal(state[0, 10:], first[[0, 1, 2, 4, 5, 6]].astype(np.float32))
        # Where no tick has a target, the last one or the first one stands.
        np.testing.assert_allclose(action[:, 1:7], np.tile(READY[1:], (len(action), 1)), atol=1e-3)
        self.assertEqual(pandas.read_parquet(self.out / "meta/tasks.parquet").index.tolist(), ["wave"])

    def test_each_scenario_has_its_task(self):
        pt.run(scenario(description="Another one", **FILMED), seed=3, out=self.folder / "other", video=False, plots=False)
        lerobot.write([self.results, self.folder / "other", self.log], self.out, fps=FPS, cameras=())
        tasks = pandas.read_parquet(self.out / "meta/tasks.parquet")
        self.assertEqual(dict(zip(tasks.index, tasks.task_index)), {TASK: 0, "Another one": 1})
        of_episodes = dict(zip(self.table()["episode_index"].to_pylist(), self.table()["task_index"].to_pylist()))
        self.assertEqual(of_episodes, {0: 0, 1: 1, 2: 0})

    def test_files_divide_between_episodes(self):
        with unittest.mock.patch.multiple(_lerobot_files, _DATA_MB=0, _VIDEO_MB=0, _CHUNK=2):
            lerobot.write([self.log] * 3, self.out, fps=FPS, cameras=("scenario",), size=SIZE)
        episodes = pyarrow.parquet.read_table(self.out / "meta/episodes/chunk-000/file-000.parquet").to_pydict()
        for where, ending in (("data", "parquet"), (f"videos/{KEYS[0]}", "mp4")):
            pattern = f"{where}/chunk-{{:03d}}/file-{{:03d}}.{ending}"
            places = list(zip(episodes[f"{where}/chunk_index"], episodes[f"{where}/file_index"]))
            self.assertEqual(places, [(0, 0), (0, 1), (1, 0)])
            self.assertTrue(all((self.out / pattern.format(*place)).is_file() for place in places))
        self.assertEqual(episodes[f"videos/{KEYS[0]}/from_timestamp"], [0, 0, 0])
        last = pyarrow.parquet.read_table(self.out / "data/chunk-001/file-000.parquet")
        self.assertEqual(last["index"].to_pylist(), list(range(episodes["dataset_from_index"][2], episodes["dataset_to_index"][2])))
        (stream,) = probe(self.out / f"videos/{KEYS[0]}/chunk-001/file-000.mp4")
        self.assertEqual(int(stream["nb_read_frames"]), episodes["length"][2])

    def test_pictures_with_text_are_told(self):
        pt.run(scenario(render={"fps": f"{FPS} Hz"}), seed=3, out=self.folder / "text", video=False, plots=False)
        with self.assertLogs("panda_twin", "WARNING") as logged:
            lerobot.write([self.folder / "text"], self.out, fps=FPS, size=SIZE)
        self.assertIn("carry the texts of render.overlays", logged.output[0])

    def misuse(self):
        """What is called, what it raises, a fragment of its text."""
        foreign = pt.Log.from_panda_py({"time": [0.0, 1.0], "q": [READY, READY], "q_d": [READY, READY]})
        bare = scenario(robot={"hand": "none"}, hand=[], **FILMED)
        pt.run(bare, seed=3, out=self.folder / "bare", video=False, plots=False)
        pt.run("scenarios/smoke.yaml", out=self.folder / "ideal", video=False, plots=False)
        (self.folder / "taken").mkdir()
        out, log = self.out, self.log
        write = lerobot.write
        return [
            (lambda: write(log, out), TypeError, "logs is of type Log; a list of logs belongs here"),
            (lambda: write(str(self.results), out), TypeError, "logs is of type str"),
            (lambda: write([], out), ValueError, "there are no logs"),
            (lambda: write([5], out), TypeError, "int"),
            (lambda: write([log, self.folder / "nope"], out), ValueError, "nope"),
            (lambda: write([log], ""), ValueError, "the folder's name is empty"),
            (lambda: write([log], self.folder / "taken"), FileExistsError, "taken exists; name a new folder"),
            (lambda: write([log], "/proc/here/out"), OSError, "/proc/here"),
            (lambda: write([log], out, fps=0), ValueError, "fps is 0; it must be a whole number from 1 to 240"),
            (lambda: write([log], out, fps=241), ValueError, "fps is 241"),
            (lambda: write([log], out, fps=12.5), TypeError, "float"),
            (lambda: write([log], out, size=(63, 48)), ValueError, "size is (63, 48); it must be an even width"),
            (lambda: write([log], out, size=(64, 8)), ValueError, "size is (64, 8)"),
            (lambda: write([log], out, size=(64,)), ValueError, "size is (64,)"),
            (lambda: write([log], out, cameras="gripper"), TypeError, "cameras is of type str"),
            (lambda: write([log], out, cameras=("gripper", "gripper")), ValueError, "each must have a name of its own"),
            (lambda: write([log], out, cameras=("",)), ValueError, "each must have a name of its own"),
            (lambda: write([log], out, cameras=("no_such",)), ValueError, "no_such"),
            (lambda: write([log], out, state=()), ValueError, "state is (); a tuple of at least one column"),
            (lambda: write([log], out, state="q"), ValueError, "state is 'q'; a tuple of at least one column"),
            (lambda: write([log], out, state=("q", "q")), ValueError, "state names a column twice"),
            (lambda: write([log], out, state=("tau_j",)), ValueError, "tau_J"),
            (lambda: write([log], out, action=("fate",)), ValueError, "action names fate; a column of floating-point numbers"),
            (lambda: write([log], out, action=("qpos",)), ValueError, "action names qpos"),
            (lambda: write([foreign], out, cameras=(), state=("q",), action=("q_d",)), ValueError, "give the task"),
            (lambda: write([foreign], out, task="x", cameras=()), ValueError, "has no scenes: without them there are no pictures"),
            (lambda: write([foreign], out, task="x", cameras=(), state=("q",), action=("q_ext",)), ValueError, "no column q_ext"),
            (lambda: write([log.between(0, 0.002)], out, action=("q_ext",)), ValueError, "has no q_ext: no tick of the workstation"),
            (lambda: write([self.folder / "ideal"], out), ValueError, "leave out cameras and gripper_width"),
            (lambda: write([self.folder / "bare"], out, cameras=()), ValueError, "is of an arm without a hand; leave out gripper"),
            (lambda: write([log.between(50, 60)], out), ValueError, "has no cycles of the robot"),
            (lambda: demonstrate(out, episodes=0), ValueError, "episodes is 0; it must be at least 1"),
            (lambda: demonstrate(out, most_runs=2), ValueError, "most_runs is 2; it must be at least the 3 episodes"),
            (lambda: demonstrate(out, seed=-1), ValueError, "seed is -1"),
            (lambda: demonstrate(out, episodes=2, seed=5, most_runs=2), pt.RobotFault, "0 of the wanted 2 episodes: 2 runs\n"),
            (lambda: lerobot.demonstrate("no_such.yaml", out), ValueError, "no_such.yaml"),
        ]

    def test_each_misuse_is_told_and_leaves_nothing(self):
        table = self.misuse()
        before = sorted(path.name for path in self.folder.iterdir())
        for number, (call, kind, fragment) in enumerate(table):
            with self.subTest(number=number, fragment=fragment):
                with self.assertRaises(kind) as raised:
                    call()
                self.assertIn(fragment, str(raised.exception))
                self.assertEqual(sorted(path.name for path in self.folder.iterdir()), before)

    def test_what_is_missing_is_named_with_the_cure(self):
        for name in ("pyarrow", "pandas"):
            with unittest.mock.patch.dict(sys.modules, {name: None}):
                with self.assertRaisesRegex(ImportError, rf"needs {name}; pip install 'panda-twin\[log\]'"):
                    lerobot.write([self.log], self.out)
        with unittest.mock.patch.dict(os.environ, {"PATH": str(self.folder)}):
            with self.assertRaisesRegex(FileNotFoundError, "ffmpeg is not installed; apt-get install ffmpeg, or write without"):
                lerobot.write([self.log], self.out)
            lerobot.write([self.log], self.out, cameras=())

    def test_a_failing_ffmpeg_is_told_and_leaves_nothing(self):
        ffmpeg = self.folder / "ffmpeg"
        for reading in ("", "cat >/dev/null\n"):
            ffmpeg.write_text(f"#!/bin/sh\n{reading}echo no such encoder >&2\nexit 1\n")
            ffmpeg.chmod(0o755)
            with unittest.mock.patch.dict(os.environ, {"PATH": f"{self.folder}:{os.environ['PATH']}"}):
                with self.assertRaisesRegex(OSError, "ffmpeg cannot write file-000.mp4: no such encoder"):
                    lerobot.write([self.log], self.out, fps=FPS, size=SIZE)
            self.assertEqual([path.name for path in self.folder.iterdir()], ["ffmpeg"])

    def called(self, *arguments):
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            code = lerobot.main([str(one) for one in arguments])
        return code, out.getvalue(), err.getvalue()

    def test_the_commands_write_the_same(self):
        lerobot.write([self.log], self.folder / "library", fps=FPS, cameras=("gripper",), size=SIZE, action=("q_c",), task="wave")
        arguments = ["--fps", FPS, "--camera", "gripper", "--size", "64x48", "--action", "q_c", "--task", "wave"]
        self.assertEqual(self.called("write", self.results, "--out", self.out, *arguments), (0, f"{self.out}\n", ""))
        file = self.folder / "wave.yaml"
        file.write_text(scenario().to_yaml())
        demonstrate(self.folder / "demonstrated", cameras=())
        options = ["--episodes", 3, "--seed", 3, "--fps", FPS, "--no-video"]
        code, told, progress = self.called("demonstrate", file, "--out", self.folder / "command", *options)
        self.assertEqual(code, 0, progress)
        self.assertRegex(told, r"command: 3 episodes, \d+ frames; \d+ runs\n  left out \d+, motion aborted by reflex")
        self.assertRegex(progress, "(?m)^seed 3: an episode\n(.*\n)*seed 5: motion aborted by reflex")
        for left, right in (("library", "out"), ("demonstrated", "command")):
            for path in [one for one in (self.folder / left).rglob("*") if one.suffix in (".parquet", ".json")]:
                name = path.relative_to(self.folder / left)
                self.assertEqual(path.read_bytes(), (self.folder / right / name).read_bytes(), name)

    def test_the_commands_end_with_their_codes(self):
        file = self.folder / "wave.yaml"
        file.write_text(scenario().to_yaml())
        few = ["demonstrate", file, "--out", self.out, "--episodes", 1, "--most-runs", 1, "--seed", 5, "--no-video"]
        for arguments, code, fragment in (
            (["write", self.folder / "nope", "--out", self.out], 3, "nope"),
            (["write", self.results, "--out", self.out, "--size", "64"], 3, "--size is 64; write it as 320x240"),
            (["write", self.results, "--out", self.folder], 4, "exists; name a new folder"),
            (few, 1, "0 of the wanted 1 episodes: 1 runs"),
        ):
            with self.subTest(fragment):
                ended, _, told = self.called(*arguments)
                self.assertEqual(ended, code, told)
                self.assertIn(fragment, told)
        self.assertFalse(self.out.exists())


if __name__ == "__main__":
    unittest.main()
