"""The program's command `sweep`, which does the work."""

from __future__ import annotations

import dataclasses
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable

from .. import _host

_POLLING = 2.0  # s
_ERRORS: dict[int, type[Exception]] = {2: ValueError, 3: ValueError, 4: OSError}


def failure_of(code: int, said: str) -> Exception:
    """What is raised for the program's exit code and its lines."""
    text = said.partition("error: ")[2] or said or f"the program ended with code {code}"
    return _ERRORS.get(code, RuntimeError)(text.strip())


@dataclasses.dataclass(frozen=True)
class Runs:
    """The runs of a sweep, in order. `units`: what is shared out, the run's number, or that of its point."""

    usual_folder: str
    units: list[int]
    addresses: list[str]

    def of_shard(self, shard: str) -> list[str]:
        """Addresses of the runs of a shard, such as "3/64"; all for an empty one. The program refuses what is none."""
        found = re.fullmatch(r"(\d{1,9})/([1-9]\d{0,8})", shard)
        if not found:
            return self.addresses
        index, count = int(found[1]), int(found[2])
        return [address for unit, address in zip(self.units, self.addresses) if unit % count == index]


class Sweep:
    """A sweep file with the flags of its commands."""

    def __init__(
        self, file: str | os.PathLike[str], data: str = "", meshes: str = "", *, yes: bool = False, shows: bool = False
    ) -> None:
        self.file = os.fspath(file)
        self._data = [f"--data={data}"] * bool(data) + [f"--meshes={meshes}"] * bool(meshes)
        self._yes = ["--yes"] * yes
        self.shows = shows

    def arguments(self, command: str, *more: str) -> list[str]:
        """Of the program."""
        return ["sweep", command, self.file, *self._data, *more]

    def words(self, command: str, *more: str) -> list[str]:
        """A command line."""
        return [os.fspath(_host.executable), *self.arguments(command, *more)]

    def call(self, command: str, *more: str, meanwhile: Callable[[], None] = lambda: None) -> str:
        """What it prints. `meanwhile` is called every other second; what it raises interrupts the program."""
        process = subprocess.Popen(
            self.words(command, *more), stdout=subprocess.PIPE, stderr=None if self.shows else subprocess.PIPE, text=True
        )
        try:
            while True:
                try:
                    printed, said = process.communicate(timeout=_POLLING)
                    break
                except subprocess.TimeoutExpired:
                    meanwhile()
        except BaseException:
            process.send_signal(signal.SIGINT)
            process.communicate()
            raise
        if process.returncode == 0:
            return printed
        if process.returncode in (130, -signal.SIGINT):
            raise KeyboardInterrupt
        if self.shows:  # it has said why
            sys.stdout.write(printed)
            raise SystemExit(process.returncode)
        raise failure_of(process.returncode, said)

    def list_runs(self) -> Runs:
        usual_folder, *lines = self.call("addresses", *self._yes).splitlines()
        pairs = [line.split() for line in lines]
        return Runs(usual_folder, [int(unit) for unit, _ in pairs], [address for _, address in pairs])

    def run(
        self,
        out: str | os.PathLike[str],
        shard: str,
        jobs: int | None,
        meanwhile: Callable[[], None] = lambda: None,
    ) -> None:
        more = [f"--out={os.fspath(out)}"] * bool(out) + [f"--shard={shard}"] * bool(shard)
        more += [f"--jobs={jobs}"] * (jobs is not None)
        self.call("run", *self._yes, *more, meanwhile=meanwhile)

    def merge(self, out: str | os.PathLike[str]) -> tuple[str, Exception | None]:
        """What it prints, and why the sweep is no success although the report is there."""
        process = subprocess.run(
            self.words("merge", *[f"--out={os.fspath(out)}"] * bool(out)), capture_output=True, text=True
        )
        failure = failure_of(process.returncode, process.stderr) if process.returncode else None
        if self.shows:  # notes; who calls this tells the failure
            sys.stderr.write("".join(line for line in process.stderr.splitlines(True) if "error: " not in line))
        if failure and "\nreport  " not in process.stdout:
            raise failure
        return process.stdout, failure
