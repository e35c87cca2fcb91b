"""Shards as tasks of Ray: a task that a node takes with it is begun anew on another one."""

from __future__ import annotations

import math
import os
import pathlib
import socket
import subprocess
import sys
import tempfile
import typing

from .. import _host
from ._program import Runs, Sweep, failure_of
from ._store import Results, name_of

_RUNS = 64  # of a task, at most
_AHEAD = 4  # tasks for each processor that wait for it
_RETRIES = 5  # of a task whose node or process died
_MEMORY = 256 * 2**20  # of a task, bytes


def address_of(on: str) -> str | None:
    """What ray.init takes: None for "ray". Raises ValueError for another engine."""
    if on == "ray":
        return None
    if on.startswith("ray://") and ":" in on[len("ray://") :]:
        return on
    raise ValueError(f'--on "{on}": must be ray, or ray://HOST:PORT of a cluster')


def carry_out(arguments: list[str], there: dict[str, bytes]) -> tuple[str, dict[str, bytes]]:
    """A task: the shard of a command line of this node's program, of which some results are there. Returns the node's name and the new ones."""
    with tempfile.TemporaryDirectory(prefix="panda_twin_sweep_") as temporary:
        results = Results(pathlib.Path(temporary))
        results.put(there)
        with tempfile.TemporaryFile() as said:
            # It writes a byte for each run to descriptor 3, and ends when nobody reads: not even kill -9 of this process leaves it over.
            program = ["sh", "-c", 'exec "$0" "$@" 3>&1 >/dev/null', os.fspath(_host.executable)]
            command = [*program, *arguments, f"--out={temporary}", "-q"]
            with subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=said) as process:
                assert process.stdout
                while os.read(process.stdout.fileno(), 4096):
                    pass
            if process.returncode != 0:
                said.seek(0)
                raise failure_of(process.returncode, said.read().decode(errors="replace"))
        new = {name: (results.folder / name).read_bytes() for name in results.names() if name not in there}
        return socket.gethostname(), new


def run(sweep: Sweep, runs: Runs, cluster: str | None, shards: int | None, results: Results) -> None:
    """Carry out the shards of which results are missing."""
    try:
        import ray  # type: ignore[import-not-found,import-untyped,unused-ignore]
    except ImportError as error:
        raise ImportError(f"--on ray needs Ray ({error}): pip install 'panda-twin[ray]'") from None
    began = not ray.is_initialized()
    if began:
        try:
            ray.init(cluster, log_to_driver=False, logging_level="error")
        except (ConnectionError, RuntimeError, ValueError) as error:
            raise OSError(f"Ray's cluster cannot be reached: {error}") from None
    try:
        _Driver(ray, sweep, runs, results).run(shards)
    finally:
        if began:
            ray.shutdown()


class _Driver:
    def __init__(self, ray: typing.Any, sweep: Sweep, runs: Runs, results: Results) -> None:
        self._ray, self._sweep, self._runs, self._results = ray, sweep, runs, results
        self._processors = max(1, int(ray.cluster_resources().get("CPU", 1)))
        self._task = ray.remote(
            num_cpus=1, memory=_MEMORY, max_retries=_RETRIES, scheduling_strategy="SPREAD"
        )(carry_out)  # fmt: skip
        self._parts: list[list[str]] = []
        self._running: dict[typing.Any, int] = {}

    def run(self, shards: int | None) -> None:
        units = len(set(self._runs.units))
        usual = max(math.ceil(len(self._runs.addresses) / _RUNS), _AHEAD * self._processors)
        self._parts = [[] for _ in range(min(units, shards or usual))]
        for unit, address in zip(self._runs.units, self._runs.addresses):
            self._parts[unit % len(self._parts)].append(address)
        waiting = [i for i, part in enumerate(self._parts) if any(self._results.whole(address) is None for address in part)]
        done, all_of_them = 0, len(waiting)
        try:
            while waiting or self._running:
                while waiting and len(self._running) < _AHEAD * self._processors:
                    self._submit(waiting.pop(0))
                ended, _ = self._ray.wait(list(self._running))
                for task in ended:
                    self._take(task)
                    done += 1
                self._results.send()
                if self._sweep.shows and 10 * done // all_of_them > 10 * (done - len(ended)) // all_of_them:
                    print(f"panda-twin: sweep: {done} of {all_of_them} shards", file=sys.stderr)
        finally:
            for task in self._running:
                self._ray.cancel(task, force=True)

    def _submit(self, shard: int) -> None:
        there = {name_of(address): text for address in self._parts[shard] if (text := self._results.whole(address))}
        arguments = self._sweep.arguments("work", f"--shard={shard}/{len(self._parts)}")
        self._running[self._task.remote(arguments, there)] = shard

    def _take(self, task: typing.Any) -> None:
        shard = self._running.pop(task)
        try:
            node, files = self._ray.get(task)
        except self._ray.exceptions.RayTaskError as error:
            if "failed to import" in str(error.cause):
                raise OSError("a node of the cluster lacks the Python package panda_twin: install it there, in this version") from None
            raise error.cause from None
        except self._ray.exceptions.RayError as error:
            raise OSError(f"shard {shard}/{len(self._parts)} failed {_RETRIES + 1} times: {error}; what is done is kept") from None
        if not {name for name in files if name.startswith("runs/")} <= {name_of(address) for address in self._parts[shard]}:
            raise OSError(
                f"node {node} has another version of the program or the models, or of the C library's mathematics: "
                "its results have other addresses, and are not taken"
            )
        self._results.put(files)
