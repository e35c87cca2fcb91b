#!/usr/bin/env python3
"""What a run leaves of its video when it is killed: killed_video_test.py PROGRAM SOURCE_TREE [unittest options]."""

import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

PROGRAM = ""
SOURCE = pathlib.Path()


def fragments(path):
    """How many fragments of two seconds, of 50 frames, are whole in the file: all but the last."""
    boxes, data = [], path.read_bytes() if path.exists() else b""
    at = 0
    while at + 8 <= len(data):
        size = int.from_bytes(data[at:at + 4], "big")
        if size < 8 or at + size > len(data):
            break
        boxes.append(data[at + 4:at + 8])
        at += size
    return sum(a == b"moof" and b == b"mdat" for a, b in zip(boxes, boxes[1:]))


def frames(path):
    """How many frames a player gets to see."""
    said = subprocess.run(["ffprobe", "-v", "quiet", "-count_frames", "-show_entries", "stream=nb_read_frames",
                           "-of", "csv=p=0", path], capture_output=True, text=True, timeout=60)
    return int(said.stdout or 0)


def children(process):
    """Ids of a process's children."""
    return [int(word) for task in pathlib.Path(f"/proc/{process}/task").iterdir()
            for word in (task / "children").read_text().split()]


def runs(process):
    """Whether a process is there and no zombie that nobody waits for."""
    try:
        return pathlib.Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


class KilledVideoTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="panda_twin_killed_"))
        self.addCleanup(shutil.rmtree, self.folder, ignore_errors=True)
        self.out = self.folder / "out"
        self.partial = self.out / "video.mp4.partial"

    def start(self):
        """Starts the canonical run in a process group of its own; waits for two whole fragments."""
        environment = dict(os.environ, XDG_CACHE_HOME=str(self.folder / "cache"))
        run = subprocess.Popen([PROGRAM, "run", SOURCE / "models/scenarios/canonical.yaml", "--out", self.out,
                                "--quiet"], env=environment, start_new_session=True)
        self.addCleanup(run.wait)
        self.addCleanup(run.kill)
        while fragments(self.partial) < 2:
            self.assertIsNone(run.poll(), "the run ended before it could be killed")
            time.sleep(0.01)
        return run

    def test_all_killed_at_once_leaves_what_plays_to_the_last_fragment(self):
        run = self.start()
        encoders = children(run.pid)
        self.assertEqual(len(encoders), 1)
        os.killpg(run.pid, signal.SIGKILL)
        os.killpg(encoders[0], signal.SIGKILL)  # ffmpeg has a group of its own
        run.wait(timeout=60)
        self.assertGreaterEqual(frames(self.partial), 50 * fragments(self.partial))
        self.assertGreaterEqual(frames(self.partial), 100)
        self.assertFalse((self.out / "video.mp4").exists())

    def test_killed_without_ffmpeg_leaves_every_frame_that_was_drawn(self):
        run = self.start()
        encoder = children(run.pid)[0]
        os.killpg(run.pid, signal.SIGKILL)
        run.wait(timeout=60)
        while runs(encoder):  # it ends when its input does
            time.sleep(0.01)
        self.assertGreater(frames(self.partial), 100)
        self.assertFalse((self.out / "video.mp4").exists())


if __name__ == "__main__":
    PROGRAM, SOURCE = sys.argv[1], pathlib.Path(sys.argv[2])
    unittest.main(argv=[sys.argv[0], *sys.argv[3:]])
