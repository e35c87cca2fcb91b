"""Where results are: a folder, or an object store by way of a folder."""

from __future__ import annotations

import concurrent.futures
import contextlib
import json
import os
import pathlib
import re
import tempfile
import typing
from collections.abc import Callable, Iterable, Iterator

_REQUESTS = 16  # to a store at a time
_KEPT = re.compile(r"runs/../[0-9a-f]{32}\.json|logs/../[0-9a-f]{32}/[^/]+")  # what is not whole has another name


def is_stored(out: str | os.PathLike[str]) -> bool:
    """Whether `out` is an address such as s3://bucket/path."""
    return "://" in os.fspath(out)


def _each(work: Callable[[str], None], names: Iterable[str]) -> None:
    with concurrent.futures.ThreadPoolExecutor(_REQUESTS) as pool:
        for _ in pool.map(work, names):
            pass


class Store:
    """A folder of an object store. A file in it is whole: it appears when all of it has been sent."""

    def __init__(self, uri: str) -> None:
        try:
            import pyarrow.fs  # type: ignore[import-untyped,unused-ignore]
        except ImportError as error:
            raise ImportError(f"{uri} needs pyarrow ({error}): pip install 'panda-twin[sweep]'") from None
        self.uri = uri.rstrip("/")
        self._fs: typing.Any = pyarrow.fs
        with self._errors():
            self._files, path = pyarrow.fs.FileSystem.from_uri(self.uri)
        self._path = path.rstrip("/")

    @contextlib.contextmanager
    def _errors(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            raise OSError(f"{self.uri}: {error}; results that are there stay: run the same command to go on") from None
        except Exception as error:  # pyarrow's own, of an address it does not read
            raise ValueError(f"{self.uri}: {error}") from None

    def names(self) -> list[str]:
        """Of all files of runs, relative to the folder."""
        there: list[typing.Any] = []
        with self._errors():
            for kind in ("runs", "logs"):
                there += self._files.get_file_info(self._fs.FileSelector(f"{self._path}/{kind}", recursive=True, allow_not_found=True))
        return [info.path.removeprefix(f"{self._path}/") for info in there if info.is_file]

    def get(self, name: str, folder: pathlib.Path) -> None:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        with self._errors(), self._files.open_input_stream(f"{self._path}/{name}") as stream:
            file.write_bytes(stream.readall())

    def put(self, name: str, folder: pathlib.Path) -> None:
        with self._errors(), self._files.open_output_stream(f"{self._path}/{name}") as stream:
            stream.write((folder / name).read_bytes())


class Results:
    """A folder of results on this machine; what is new in it is sent to the store, if there is one."""

    def __init__(self, folder: pathlib.Path, store: Store | None = None) -> None:
        self.folder = folder
        self._store = store
        self._sent: set[str] = set()

    def fetch(self, addresses: Iterable[str]) -> None:
        """Those that the store has. Of a log that is there its folder says so."""
        if self._store:
            names = self._store.names()
            wanted = set(map(name_of, addresses)).intersection(names)
            store, folder = self._store, self.folder
            _each(lambda name: store.get(name, folder), wanted)
            for name in names:
                if name.endswith("/run.mcap"):
                    (folder / name).parent.mkdir(parents=True, exist_ok=True)
            self._sent.update(names)

    def whole(self, address: str) -> bytes | None:
        """A result; None when there is none that is whole."""
        try:
            text = (self.folder / name_of(address)).read_bytes()
            return text if json.loads(text)["address"] == address else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def put(self, files: dict[str, bytes]) -> None:
        """Files by their names, each at once whole."""
        for name, content in files.items():
            file = self.folder / name
            file.parent.mkdir(parents=True, exist_ok=True)
            own = file.with_name(f"{file.name}.{os.getpid()}")
            own.write_bytes(content)
            own.replace(file)

    def names(self) -> list[str]:
        """Results, and files of logs, that are whole."""
        files = (str(file.relative_to(self.folder)) for kind in ("runs", "logs") for file in (self.folder / kind).rglob("*.*"))
        return [name for name in files if _KEPT.fullmatch(name)]

    def send(self) -> None:
        """What is new."""
        self._send(self.names())

    def send_merged(self) -> None:
        """Tables and report; the report's commands are for a copy of the store's folder."""
        report = self.folder / "report.html"
        if report.exists():
            report.write_text(report.read_text().replace(f"{self.folder}/", ""))
        self._send(str(file.relative_to(self.folder)) for pattern in ("*.*", "worst/*") for file in self.folder.glob(pattern))

    def _send(self, names: Iterable[str]) -> None:
        if self._store:
            new = [name for name in names if name not in self._sent]
            store, folder = self._store, self.folder
            _each(lambda name: store.put(name, folder), new)
            self._sent.update(new)


def name_of(address: str) -> str:
    """The result's file, as the program names it."""
    return f"runs/{address[:2]}/{address}.json"


@contextlib.contextmanager
def opened(out: str | os.PathLike[str], addresses: Iterable[str]) -> Iterator[Results]:
    """Results at `out`. Of a store those of the addresses are fetched, into a folder that is removed at the end; what is new is
    sent, also after an error."""
    if not is_stored(out):
        yield Results(pathlib.Path(out).absolute())
        return
    store = Store(os.fspath(out))
    with tempfile.TemporaryDirectory(prefix="panda_twin_sweep_") as folder:
        results = Results(pathlib.Path(folder), store)
        results.fetch(addresses)
        try:
            yield results
        except OSError:  # perhaps the store's: it is not tried again
            raise
        except BaseException:
            results.send()
            raise
        results.send()
