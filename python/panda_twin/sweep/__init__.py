"""Sweeps: a scenario at many points and with many seeds, on this machine or a Ray cluster, in a folder or an object store."""

from __future__ import annotations

import dataclasses
import json
import os
import pathlib
import re

from . import _ray
from ._program import Sweep
from ._store import Results, is_stored, opened

__all__ = ["Merged", "Plan", "merge", "plan", "run"]


@dataclasses.dataclass(frozen=True)
class Plan:
    """What a sweep asks for.

    Attributes
    ----------
    points, runs : int
        How many; fewer runs when points end early.
    text : str
        Axes and cost, as `panda-twin sweep plan` prints them.
    """

    points: int
    runs: int
    text: str


@dataclasses.dataclass(frozen=True)
class Merged:
    """What came of a sweep.

    Attributes
    ----------
    out : str
        Folder of runs.csv, points.csv, summary.json, report.html and, with pyarrow, runs.parquet; or its address in a store.
    runs, failures : int
    digest : str
        Of all results, 16 hexadecimal digits: the same for any number of shards, processes, machines and retries.
    """

    out: str
    runs: int
    failures: int
    digest: str


def plan(file: str | os.PathLike[str], *, data: str = "", meshes: str = "") -> Plan:
    """Read a sweep, and time its first run.

    Parameters
    ----------
    file : path
        Sweep file, or one of the installed models: "sweeps/losses.yaml".
    data, meshes : str
        Folders of models and meshes; empty: as the program finds them.

    Raises
    ------
    ValueError
        For a file, or a point, that is not acceptable.
    """
    text = Sweep(file, data, meshes).call("plan")
    points, runs = (int(number) for number in re.findall(r"^(?:points|runs) +(\d+)", text, re.MULTILINE))
    return Plan(points, runs, text)


def run(
    file: str | os.PathLike[str],
    out: str | os.PathLike[str] = "",
    *,
    shard: str = "",
    jobs: int | None = None,
    on: str = "",
    shards: int | None = None,
    yes: bool = False,
    data: str = "",
    meshes: str = "",
    shows: bool = False,
) -> None:
    """Carry out the runs whose results are not there yet. Broken off at any moment and begun again, it goes on.

    Parameters
    ----------
    file : path
        As `plan` has it. For a cluster: at the same place on each node.
    out : path or str
        Folder of results, or a folder of an object store, such as "s3://bucket/path"; empty: out/<name of the sweep>. The store's
        credentials are found by the rules of its own tools (for S3: ~/.aws, AWS_ACCESS_KEY_ID, AWS_ENDPOINT_URL, ...).
    shard : str
        "3/64": only the fourth of 64 shares.
    jobs : int, optional
        Processes on this machine; absent: one per processor.
    on : str
        "ray": tasks of a Ray cluster, that of RAY_ADDRESS or one begun on this machine; "ray://HOST:PORT": by Ray's client. Empty:
        this machine. The package must be installed on each node, with the same version.
    shards : int, optional
        Tasks, for `on`; absent: of at most 64 runs each, and several for each processor.
    yes : bool
        Carry out more than a million runs.
    data, meshes : str
        As `plan` has them.
    shows : bool
        Show progress on standard error.

    Raises
    ------
    ValueError
        For a file, a point or an argument that is not acceptable.
    OSError
        When results cannot be read or written, or nodes of the cluster have another version. What is done is kept.
    ImportError
        Without Ray or pyarrow, saying what to install.
    """
    if on and (shard or jobs is not None):
        raise ValueError("on shares the runs out itself: leave shard and jobs out")
    if shards is not None and (not on or shards < 1):
        raise ValueError("shards is for on, and at least 1")
    sweep = Sweep(file, data, meshes, yes=yes, shows=shows)
    if on:
        cluster = _ray.address_of(on)
        runs = sweep.list_runs()
        with opened(out or runs.usual_folder, runs.addresses) as results:
            _ray.run(sweep, runs, cluster, shards, results)
    elif is_stored(out):
        with opened(out, sweep.list_runs().of_shard(shard)) as results:
            sweep.run(results.folder, shard, jobs, results.send)
    else:
        sweep.run(out, shard, jobs)


def merge(
    file: str | os.PathLike[str], out: str | os.PathLike[str] = "", *, data: str = "", meshes: str = "", shows: bool = False
) -> Merged:
    """Check that all results are there; write tables and report beside them.

    Parameters
    ----------
    file, out, data, meshes, shows
        As `run` has them.

    Raises
    ------
    ValueError
        For a file that is not acceptable.
    RuntimeError
        When runs are missing, or fewer succeeded than the file demands; the report is there then.
    OSError
        When a file or the store fails.
    """
    sweep = Sweep(file, data, meshes, shows=shows)
    if not is_stored(out):
        return _merge_folder(sweep, out)
    with opened(out, sweep.list_runs().addresses) as results:
        try:
            return dataclasses.replace(_merge_folder(sweep, results.folder), out=os.fspath(out))
        except RuntimeError as error:
            raise RuntimeError(str(error).replace(str(results.folder), os.fspath(out))) from None
        finally:
            results.send_merged()


def _merge_folder(sweep: Sweep, out: str | os.PathLike[str]) -> Merged:
    text, failure = sweep.merge(out)
    folder = pathlib.Path(re.findall(r"^report  (.*)$", text, re.MULTILINE)[-1]).parent
    _write_parquet(folder)
    if failure:
        raise failure
    summary = json.loads((folder / "summary.json").read_text())
    return Merged(str(folder), summary["runs"], summary["failures"], summary["digest"])


def _write_parquet(folder: pathlib.Path) -> None:
    """Runs.csv as runs.parquet, where pyarrow is installed."""
    try:
        import pyarrow.csv  # type: ignore[import-untyped,unused-ignore]
        import pyarrow.parquet  # type: ignore[import-untyped,unused-ignore]
    except ImportError:
        return
    text, number = pyarrow.string(), pyarrow.float64()
    kinds = {"outcome": text, "error": text, "states_hash": text, "address": text, "final_error_rad": number, "deviation_rad": number,
             "deviation_m": number, "duration_s": number}  # fmt: skip
    options = pyarrow.csv.ConvertOptions(column_types=kinds, strings_can_be_null=False)
    lines = pyarrow.csv.ParseOptions(newlines_in_values=True)
    table = pyarrow.csv.read_csv(folder / "runs.csv", parse_options=lines, convert_options=options)
    whole = folder / "runs.parquet"
    partial = whole.with_suffix(".partial")
    pyarrow.parquet.write_table(table, partial, compression="zstd")
    partial.replace(whole)
