#!/usr/bin/env python3
"""Draws recorded runs by the command line: render_test.py PROGRAM SOURCE_TREE [unittest options]."""

import fcntl
import pathlib
import signal
import struct
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()


def size_of_png(path):
    data = path.read_bytes()
    assert data[:8] == b"\x89PNG\r\n\x1a\n", path
    return struct.unpack(">II", data[16:24])


def frames_of(path):
    """A hash of each frame of a video, as ffmpeg decodes it."""
    done = subprocess.run(["ffmpeg", "-v", "error", "-i", path, "-pix_fmt", "rgb24", "-f", "framemd5", "-"], capture_output=True, text=True,
                          check=True, timeout=60)
    return [line.split(",")[-1].strip() for line in done.stdout.splitlines() if not line.startswith("#")]


class RenderTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_render_")
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.task = cls.write("task.yaml", (SOURCE / "models/applications/plan_and_execute.yaml").read_text().replace(
            "render:", "render:\n  width: 160\n  height: 120\n  fps: 10 Hz\n  overlays: [text, goal, forces]"))
        cls.smoke = SOURCE / "models/scenarios/smoke.yaml"
        cls.run_in(cls.task, "task")
        cls.run_in(cls.task, "other", "--seed", "3", "--no-video")
        cls.run_in(cls.smoke, "smoke", "--no-video")

    @classmethod
    def write(cls, name, text):
        (cls.folder / name).write_text(text)
        return cls.folder / name

    @classmethod
    def run_in(cls, scenario, out, *flags):
        subprocess.run([PROGRAM, "run", scenario, "--out", cls.folder / out, "--data", SOURCE / "models", "--quiet",
                        *flags], check=True, timeout=120)

    def render(self, *flags):
        return subprocess.run([PROGRAM, "render", *flags, "--data", SOURCE / "models"], capture_output=True, text=True,
                              timeout=120, cwd=self.folder)

    def rendered(self, out, *flags):
        done = self.render(*flags, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(list(self.folder.glob("*.partial")), [])
        return self.folder / out

    def refused(self, says, *flags, code=3):
        before = sorted(self.folder.rglob("*"))
        done = self.render(*flags)
        self.assertEqual(done.returncode, code, done.stderr)
        self.assertIn(says, done.stderr)
        self.assertEqual(len([line for line in done.stderr.splitlines() if "error:" in line]), 1, done.stderr)
        self.assertEqual(sorted(self.folder.rglob("*")), before)

    def test_a_log_gives_the_frames_of_the_runs_own_video(self):
        video = frames_of(self.folder / "task/video.mp4")
        self.assertGreater(len(video), 20)
        self.assertEqual(frames_of(self.rendered("again.mp4", "task")), video)

    def test_without_loss_it_is_the_same_frames_in_a_file_and_in_a_folder(self):
        flags = ["task", "--from", "1", "--to", "1.5"]
        file = frames_of(self.rendered("lossless.mkv", *flags))
        folder = self.rendered("pictures/", *flags)
        self.assertEqual(len(file), 6)
        self.assertEqual(frames_of(folder / "frame_%06d.png"), file)

    def test_half_the_speed_takes_twice_as_many_frames(self):
        whole = len(frames_of(self.rendered("whole.mp4", "smoke", "--from", "0.5", "--to", "1.5", "--size", "64x48")))
        slow = len(frames_of(self.rendered("slow.mp4", "smoke", "--from", "0.5", "--to", "1.5", "--size", "64x48",
                                           "--speed", "0.5")))
        self.assertEqual((whole, slow), (26, 51))

    def test_a_log_without_scenes_is_drawn_by_its_arm_and_says_so(self):
        done = self.render("smoke/run.mcap", "--out", "smoke.png", "--at", "1", "--size", "64x48")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("it holds no scenes", done.stderr)
        self.assertEqual(size_of_png(self.folder / "smoke.png"), (64, 48))

    def test_the_log_of_a_served_robot_is_drawn(self):
        subprocess.run([PROGRAM, "serve", "--drive", "lockstep", "--for", "0.5", "--port", "0", "--hand-port", "0",
                        "--log", "serve.mcap", "--data", SOURCE / "models"], check=True, timeout=60, cwd=self.folder,
                       stdout=subprocess.DEVNULL)
        done = self.render("serve.mcap", "--out", "served.png", "--at", "0.1", "--size", "64x48")
        self.assertEqual((done.returncode, done.stderr), (0, ""), "its scenes are in the log")
        self.assertEqual(size_of_png(self.folder / "served.png"), (64, 48))

    def test_several_robots_are_drawn_together_from_their_logs(self):
        text = (SOURCE / "models/cells/two_arms.yaml").read_text().replace("render:", "render:\n  width: 160\n  height: 120\n  fps: 10 Hz")
        self.run_in(self.write("two_arms.yaml", text), "two_arms")
        video = frames_of(self.folder / "two_arms/video.mp4")
        self.assertGreater(len(video), 15)
        self.assertEqual(frames_of(self.rendered("two_arms_again.mp4", "two_arms")), video)
        # One of them alone is in its own log; more is seen where both are.
        one = self.rendered("one.png", "two_arms/left", "--at", "1", "--size", "160x120").read_bytes()
        both = self.rendered("both.png", "two_arms", "--at", "1", "--size", "160x120").read_bytes()
        self.assertNotEqual(one, both)
        self.refused("several robots", "two_arms", "task", "--out", "no.mp4")

    def test_a_log_that_was_cut_off_is_drawn_as_far_as_it_goes(self):
        whole = (self.folder / "task/run.mcap").read_bytes()
        (self.folder / "cut.mcap").write_bytes(whole[:len(whole) // 2])
        done = self.render("cut.mcap", "--out", "cut.png", "--at", "0.5")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("the run was killed", done.stderr)

    def test_cameras_insets_and_overlays_change_the_picture(self):
        plain = self.rendered("plain.png", "task", "--at", "1").read_bytes()
        for i, flags in enumerate((["--camera", "track:panda_hand"], ["--camera", "gripper"], ["--camera", "close"],
                                   ["--camera", "orbit", "--azimuth", "90"], ["--inset", "gripper@top_left"],
                                   ["--overlays", "limits,trace"], ["--overlays", "none"])):
            other = self.rendered(f"view{i}.png", "task", "--at", "1", *flags)
            self.assertNotEqual(other.read_bytes(), plain, flags)

    def test_fine_pictures_are_larger_and_smoother(self):
        def size(png):
            return struct.unpack(">II", png.read_bytes()[16:24])

        fine = self.rendered("fine.png", "task", "--at", "1", "--quality", "fine")
        self.assertEqual(size(fine), (1280, 720))
        # At the same size, samples and a larger shadow map change the picture alone.
        same = size(self.rendered("draft.png", "task", "--at", "1", "--quality", "draft"))
        smooth = self.rendered("smooth.png", "task", "--at", "1", "--quality", "fine", "--size", "{}x{}".format(*same))
        self.assertEqual(size(smooth), same)
        self.assertNotEqual(smooth.read_bytes(), (self.folder / "draft.png").read_bytes())

    def test_a_still_is_the_films_frame_of_its_instant_with_the_trace_before_it(self):
        flags = ["task", "--overlays", "text,trace"]
        film = frames_of(self.rendered("trace.mkv", *flags, "--to", "1.55"))
        self.assertEqual(frames_of(self.rendered("trace.png", *flags, "--at", "1.45")), film[-1:])
        self.assertEqual(frames_of(self.rendered("late.mkv", *flags, "--from", "1.45", "--to", "1.5")), film[-1:])
        both = [self.rendered(f"{name}.png", "task", "other", "--at", "1.5", "--overlays", name).read_bytes()
                for name in ("trace", "none")]
        self.assertNotEqual(*both)

    def test_two_do_not_write_into_one_name(self):
        for name, *flags in (["held.mp4"], ["held.mkv"], ["held.png", "--at", "1"]):
            with open(self.folder / f"{name}.partial", "w") as partial:
                fcntl.flock(partial, fcntl.LOCK_EX)
                self.refused("another run writes", "task", "--out", name, *flags, code=4)
            self.rendered(name, "task", *flags)  # it is free again, and what was left is taken away

    def test_an_interrupt_leaves_nothing(self):
        for name in ("stopped.mp4", "stopped/"):
            partial = self.folder / f"{name.rstrip('/')}.partial"
            render = subprocess.Popen([PROGRAM, "render", "task", "--out", name, "--speed", "0.01", "--quiet", "--data",
                                       SOURCE / "models"], cwd=self.folder, stderr=subprocess.PIPE, text=True)
            while not partial.exists() and render.poll() is None:
                time.sleep(0.01)
            render.send_signal(signal.SIGINT)
            self.assertIn("interrupted", render.communicate(timeout=120)[1])
            self.assertEqual(render.returncode, 130)
            self.assertEqual(list(self.folder.glob("stopped*")), [])

    def test_two_runs_share_a_picture(self):
        self.assertEqual(size_of_png(self.rendered("split.png", "task", "other", "--at", "1")), (320, 120))
        for how in ("ghost", "difference"):
            picture = self.rendered(f"{how}.png", "task", "other", "--at", "1", "--compare", how)
            self.assertEqual(size_of_png(picture), (160, 120))
        video = self.rendered("both.mp4", "task", "other", "--from", "2.5", "--compare", "difference")
        self.assertGreater(len(frames_of(video)), 5)

    def test_a_layout_is_one_picture(self):
        # Three pictures of 160 pixels, four borders of 4.
        self.assertEqual(size_of_png(self.rendered("triple.png", "task", "--layout", "triple")), (496, 128))

    def test_what_cannot_be_is_refused_by_name_and_leaves_nothing(self):
        self.refused("cannot read nothing", "nothing", "--out", "a.mp4")
        self.refused("no run.mcap", ".", "--out", "a.mp4")
        self.refused("cameras it has: overview, close. Besides those there are orbit, gripper, and track:BODY", "task", "--out",
                     "a.png", "--at", "1", "--camera", "nowhere")
        self.refused("bodies it has: ", "task", "--out", "a.png", "--at", "1", "--camera", "track:nobody")
        self.refused("the log holds 0", "task", "--out", "a.png", "--at", "60")
        self.refused("say which with --at", "task", "--out", "a.png")
        self.refused("name a .png", "task", "--out", "a.mp4", "--at", "1")
        self.refused("it takes six plans; the log of plan_and_execute has only goal_1", "task", "--out", "a.png",
                     "--layout", "strip")
        self.refused("leave the second log out", "task", "other", "--out", "a.png", "--layout", "triple")
        self.refused("leave --fps and --speed out", "task", "--out", "a.png", "--at", "1", "--fps", "5")
        self.refused("leave --fps and --speed out", "task", "--out", "a.png", "--layout", "triple", "--speed", "2")
        self.refused("--tolerance is for --compare difference", "task", "other", "--out", "a.mp4", "--tolerance", "5")

    def test_values_that_are_none_are_refused_as_usage(self):
        self.refused("--compare requires second", "task", "--out", "a.mp4", "--compare", "ghost", code=2)
        for flag, value, says in (("--speed", "0", "[0.01 - 100]"), ("--speed", "nan", "[0.01 - 100]"),
                                  ("--at", "nan", "nan"), ("--from", "nan", "nan"), ("--to", "inf", "inf"),
                                  ("--from", "-1", "-1"), ("--size", "big", "WIDTHxHEIGHT"), ("--size", "1x1", "width"),
                                  ("--overlays", "text,heat", "there is no heat"), ("--layout", "row", "there is no row"),
                                  ("--inset", "gripper@middle", "there is no corner middle"), ("--quality", "best", "best")):
            self.refused(says, "task", "--out", "a.mp4", flag, value, code=2)
        self.refused("there is no blink", "task", "other", "--out", "a.mp4", "--compare", "blink", code=2)

    def test_a_place_where_nothing_can_be_written_is_refused_before_the_log_is_read(self):
        for out in (".", "./", "..", "task/.."):
            self.refused("folder that is there already", "no.log", "--out", out)
        for out, *flags in (["nowhere/a.png", "--at", "1"], ["nowhere/a.mp4"], ["nowhere/frames/"]):
            self.refused("nowhere: cannot be written (No such file", "no.log", "--out", out, *flags, code=4)
        (self.folder / "folder.png").mkdir(exist_ok=True)
        self.refused("folder.png is a folder", "no.log", "--out", "folder.png", "--at", "1")
        (self.folder / "folder.png").rmdir()


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
