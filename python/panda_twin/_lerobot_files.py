"""Files of a LeRobot dataset, format v3.0, by pyarrow, pandas and ffmpeg."""

from __future__ import annotations

import contextlib
import dataclasses
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import types
import typing
from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import numpy.typing as npt

if typing.TYPE_CHECKING:
    import pyarrow  # type: ignore[import-untyped]

Floats = npt.NDArray[np.float32]
Picture = npt.NDArray[np.uint8]

_CHUNK = 1000  # files in a folder
_DATA_MB = 100
_VIDEO_MB = 200
_BYTES_PER_PIXEL = 1 / 16  # at most, of such pictures as H.264: decides when another file begins, on any host alike
_OWN = {"timestamp": "float32", "frame_index": "int64", "episode_index": "int64", "index": "int64", "task_index": "int64"}
_DATA = "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"
_VIDEO = "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4"
_EPISODES = "meta/episodes/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"


@dataclasses.dataclass(frozen=True)
class Shape:
    """What every episode of a dataset has."""

    fps: int
    vectors: Mapping[str, Sequence[str]]
    """Names of the elements of each feature."""
    videos: Sequence[str]
    """Keys of the videos."""
    size: tuple[int, int]
    """Of pictures: width and height."""


def _place(file: int) -> dict[str, int]:
    return {"chunk_index": file // _CHUNK, "file_index": file % _CHUNK}


def _made(path: pathlib.Path) -> pathlib.Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    return path


class _Video:
    """A running ffmpeg that encodes pictures."""

    def __init__(self, path: pathlib.Path, fps: int, size: tuple[int, int]) -> None:
        self._path = path
        self._messages = tempfile.TemporaryFile()
        # A key frame every other picture: training reads pictures in any order.
        arguments = (
            f"ffmpeg -v error -f rawvideo -pix_fmt rgb24 -s {size[0]}x{size[1]} -r {fps} -i - -an -c:v libx264 -preset medium"
            " -crf 23 -g 2 -bf 0 -pix_fmt yuv420p -threads 2 -fflags +bitexact -flags:v +bitexact -movflags +faststart -f mp4"
        )
        self._process = subprocess.Popen([*arguments.split(), os.fspath(path)], stdin=subprocess.PIPE, stderr=self._messages)

    def add(self, picture: Picture) -> None:
        assert self._process.stdin
        try:
            self._process.stdin.write(picture.tobytes())
        except BrokenPipeError:
            self._end()

    def close(self) -> None:
        assert self._process.stdin
        with contextlib.suppress(BrokenPipeError):  # its code tells
            self._process.stdin.close()
        if self._process.wait() != 0:
            self._end()
        self._messages.close()

    def kill(self) -> None:
        assert self._process.stdin
        self._process.kill()
        with contextlib.suppress(BrokenPipeError):
            self._process.stdin.close()
        self._process.wait()
        self._messages.close()

    def _end(self) -> typing.NoReturn:
        self._process.wait()
        self._messages.seek(0)
        told = self._messages.read().decode(errors="replace").strip()
        raise OSError(f"ffmpeg cannot write {self._path.name}: {told or f'it ended with code {self._process.returncode}'}")


class _PictureStats:
    """Statistics of a video's pictures, exact, by channel."""

    def __init__(self) -> None:
        self._low = np.full(3, 255)
        self._high = np.zeros(3, dtype=np.int64)
        self._sum = [0, 0, 0]
        self._squares = [0, 0, 0]
        self._pixels = 0
        self._pictures = 0

    def add(self, picture: Picture) -> None:
        for channel in range(3):
            counts = np.bincount(picture[:, :, channel].ravel(), minlength=256)
            present = np.flatnonzero(counts)
            self._low[channel] = min(self._low[channel], present[0])
            self._high[channel] = max(self._high[channel], present[-1])
            self._sum[channel] += int(counts @ np.arange(256))
            self._squares[channel] += int(counts @ np.arange(256) ** 2)
        self._pixels += picture.shape[0] * picture.shape[1]
        self._pictures += 1

    def join(self, other: _PictureStats) -> None:
        self._low = np.minimum(self._low, other._low)
        self._high = np.maximum(self._high, other._high)
        self._sum = [a + b for a, b in zip(self._sum, other._sum)]
        self._squares = [a + b for a, b in zip(self._squares, other._squares)]
        self._pixels += other._pixels
        self._pictures += other._pictures

    def to_json(self) -> dict[str, typing.Any]:
        mean = [one / self._pixels for one in self._sum]
        std = [max(0.0, square / self._pixels - m * m) ** 0.5 for square, m in zip(self._squares, mean)]
        numbers = {"min": self._low.tolist(), "max": self._high.tolist(), "mean": mean, "std": std}
        shaped = {name: [[[value / 255]] for value in values] for name, values in numbers.items()}
        return {**shaped, "count": [self._pictures]}


def _stats(values: npt.NDArray[typing.Any]) -> dict[str, typing.Any]:
    """Of rows (n, width) or numbers (n,)."""
    wide = values.astype(np.float64).reshape(len(values), -1)
    numbers = {"min": wide.min(0), "max": wide.max(0), "mean": wide.mean(0), "std": wide.std(0)}
    return {**{name: value.tolist() for name, value in numbers.items()}, "count": [len(values)]}


class Writer:
    """Writes a dataset beside its folder, and renames it at the end: the folder is there whole, or not at all.

    A context manager: what leaves it before `finish` removes everything.
    """

    def __init__(self, folder: pathlib.Path, shape: Shape) -> None:
        try:
            import pandas  # type: ignore[import-untyped]  # noqa: F401
            import pyarrow.parquet  # type: ignore[import-untyped]  # noqa: F401
        except ImportError as error:
            raise ImportError(f"a LeRobot dataset needs {error.name}; pip install 'panda-twin[log]'", name=error.name) from error
        if shape.videos and shutil.which("ffmpeg") is None:
            raise FileNotFoundError("ffmpeg is not installed; apt-get install ffmpeg, or write without cameras")
        if folder.exists() or folder.is_symlink():
            raise FileExistsError(f"{folder} exists; name a new folder, or remove it")
        folder.parent.mkdir(parents=True, exist_ok=True)
        self._folder = folder
        self._shape = shape
        self._made = pathlib.Path(tempfile.mkdtemp(prefix=f".{folder.name}.", dir=folder.parent))
        self._tasks: dict[str, int] = {}
        self._episodes: list[dict[str, typing.Any]] = []
        self._all: dict[str, list[npt.NDArray[typing.Any]]] = {name: [] for name in [*shape.vectors, *_OWN]}
        self._frames = 0
        self._tables: list[pyarrow.Table] = []  # of the present file of data
        self._data_bytes = 0
        self._data_file = 0
        self._videos: dict[str, _Video] = {}  # of the present file of each
        self._video_file = 0
        self._video_frames = 0  # in the present file
        self._pictures = {key: _PictureStats() for key in shape.videos}

    def __enter__(self) -> Writer:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: types.TracebackType | None
    ) -> None:
        for video in self._videos.values():
            video.kill()
        shutil.rmtree(self._made, ignore_errors=True)  # renamed, if it is finished

    @property
    def frames(self) -> int:
        """Written so far."""
        return self._frames

    @property
    def episodes(self) -> int:
        """Written so far."""
        return len(self._episodes)

    def add(self, task: str, vectors: Mapping[str, Floats], pictures: Mapping[str, Iterator[Picture]]) -> None:
        """Add an episode: rows of each feature, and as many pictures of each video."""
        length = len(next(iter(vectors.values())))
        seen = {key: _PictureStats() for key in pictures}
        file, before = self._add_pictures(pictures, seen)
        self._add_rows(self._tasks.setdefault(task, len(self._tasks)), length, vectors)
        episode: dict[str, typing.Any] = {
            "episode_index": len(self._episodes),
            "tasks": [task],
            "length": length,
            **{f"data/{name}": number for name, number in _place(self._data_file).items()},
            "dataset_from_index": self._frames,
            "dataset_to_index": self._frames + length,
        }
        for key in self._shape.videos:
            episode |= {f"videos/{key}/{name}": number for name, number in _place(file).items()}
            episode[f"videos/{key}/from_timestamp"] = before / self._shape.fps
            episode[f"videos/{key}/to_timestamp"] = (before + length) / self._shape.fps
        stats = {name: _stats(values[-1]) for name, values in self._all.items()}
        stats |= {key: numbers.to_json() for key, numbers in seen.items()}
        episode |= {f"stats/{name}/{kind}": value for name, of in stats.items() for kind, value in of.items()}
        self._episodes.append({**episode, **{f"meta/episodes/{name}": 0 for name in _place(0)}})
        self._frames += length
        self._video_frames += length

    def finish(self) -> None:
        """Write what is left, and give the folder its name."""
        self._close_data()
        self._close_videos()
        self._write_meta()
        os.chmod(self._made, 0o755)
        os.rename(self._made, self._folder)

    def _add_pictures(self, pictures: Mapping[str, Iterator[Picture]], seen: dict[str, _PictureStats]) -> tuple[int, int]:
        """Returns the number of the video's file, and the frames in it before."""
        width, height = self._shape.size
        if self._video_frames * width * height * _BYTES_PER_PIXEL > _VIDEO_MB << 20:
            self._close_videos()
            self._video_file += 1
            self._video_frames = 0
        for key in self._shape.videos:
            if key not in self._videos:
                path = _made(self._made / _VIDEO.format(video_key=key, **_place(self._video_file)))
                self._videos[key] = _Video(path, self._shape.fps, self._shape.size)
            for picture in pictures[key]:
                self._videos[key].add(picture)
                seen[key].add(picture)
            self._pictures[key].join(seen[key])
        return self._video_file, self._video_frames

    def _close_videos(self) -> None:
        for key in list(self._videos):
            self._videos[key].close()
            del self._videos[key]

    def _add_rows(self, task: int, length: int, vectors: Mapping[str, Floats]) -> None:
        import pyarrow

        if self._data_bytes > _DATA_MB << 20:
            self._close_data()
            self._data_file += 1
        frame = np.arange(length, dtype=np.int64)
        own: dict[str, npt.NDArray[typing.Any]] = {
            "timestamp": (frame / self._shape.fps).astype(np.float32),
            "frame_index": frame,
            "episode_index": np.full(length, len(self._episodes), dtype=np.int64),
            "index": self._frames + frame,
            "task_index": np.full(length, task, dtype=np.int64),
        }
        columns: dict[str, pyarrow.Array] = {}
        for name, names in self._shape.vectors.items():
            flat = pyarrow.array(np.ascontiguousarray(vectors[name], dtype=np.float32).ravel())
            columns[name] = pyarrow.FixedSizeListArray.from_arrays(flat, len(names))
            self._all[name].append(vectors[name])
        for name, values in own.items():
            columns[name] = pyarrow.array(values)
            self._all[name].append(values)
        table = pyarrow.table(columns)
        self._tables.append(table)
        self._data_bytes += table.nbytes

    def _close_data(self) -> None:
        import pyarrow.parquet

        if not self._tables:
            return
        path = _made(self._made / _DATA.format(**_place(self._data_file)))
        pyarrow.parquet.write_table(pyarrow.concat_tables(self._tables).combine_chunks(), path)
        self._tables = []
        self._data_bytes = 0

    def _write_meta(self) -> None:
        import pandas
        import pyarrow.parquet

        columns = {name: [episode[name] for episode in self._episodes] for name in self._episodes[0]}
        pyarrow.parquet.write_table(pyarrow.table(columns), _made(self._made / _EPISODES.format(**_place(0))))
        tasks = pandas.DataFrame({"task_index": range(len(self._tasks))}, index=pandas.Index(list(self._tasks), name="task"))
        tasks.to_parquet(self._made / "meta/tasks.parquet")
        stats = {name: _stats(np.concatenate(values)) for name, values in self._all.items()}
        stats |= {key: numbers.to_json() for key, numbers in self._pictures.items()}
        self._write_json("stats", stats)
        self._write_json("info", self._info())

    def _info(self) -> dict[str, typing.Any]:
        width, height = self._shape.size
        features: dict[str, typing.Any] = {
            name: {"dtype": "float32", "shape": [len(names)], "names": list(names)} for name, names in self._shape.vectors.items()
        }
        for key in self._shape.videos:
            features[key] = {
                "dtype": "video",
                "shape": [height, width, 3],
                "names": ["height", "width", "channels"],
                "info": {
                    "video.height": height,
                    "video.width": width,
                    "video.codec": "h264",
                    "video.pix_fmt": "yuv420p",
                    "video.is_depth_map": False,
                    "video.fps": self._shape.fps,
                    "video.channels": 3,
                    "has_audio": False,
                },
            }
        features |= {name: {"dtype": kind, "shape": [1], "names": None} for name, kind in _OWN.items()}
        return {
            "codebase_version": "v3.0",
            "robot_type": "panda",
            "total_episodes": len(self._episodes),
            "total_frames": self._frames,
            "total_tasks": len(self._tasks),
            "chunks_size": _CHUNK,
            "data_files_size_in_mb": _DATA_MB,
            "video_files_size_in_mb": _VIDEO_MB,
            "fps": self._shape.fps,
            "splits": {"train": f"0:{len(self._episodes)}"},
            "data_path": _DATA,
            "video_path": _VIDEO if self._shape.videos else None,
            "features": features,
        }

    def _write_json(self, name: str, value: dict[str, typing.Any]) -> None:
        (self._made / f"meta/{name}.json").write_text(json.dumps(value, indent=4, ensure_ascii=False) + "\n", encoding="utf-8")
