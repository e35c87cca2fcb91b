"""Which reader a log takes, by what its file begins with."""

from __future__ import annotations

import pathlib
from collections.abc import Mapping
from typing import Any

from ... import _core
from ._mapping import ColumnMap, automatic, shortened
from ._readers import OwnLog, Source, is_libfranka, is_panda_py, libfranka, mapped, panda_py
from ._tables import ArraysTable, CsvTable, NpzTable, ParquetTable, Table

_OTHERS = (  # begin of a file: what it is, what to do
    (b"\x89PNG", "a picture"), (b"\xff\xd8\xff", "a picture"), (b"GIF8", "a picture"), (b"%PDF", "a PDF document"),
    (b"\x7fELF", "a program"),
    (b"\x89HDF", "an HDF5 file; save its arrays by "
                 "numpy.savez"), (b"#ROSBAG V1", "a bag of ROS 1; convert it by rosbags-convert"),
    (b"#ROSBAG V2", "a bag of ROS 1; convert it by rosbags-convert"), (b"\x1f\x8b", "compressed (gzip); unpack it"),
    (b"\x28\xb5\x2f\xfd", "compressed (zstd); unpack it"), (b"BZh", "compressed (bzip2); unpack it"),
    (b"\xfd7zXZ", "compressed (xz); unpack it"),
    (b"\x93NUMPY", "one array; save all arrays in one file by "
                   "numpy.savez"), (b"MATLAB", "a file of MATLAB; save its arrays by numpy.savez"),
)  # fmt: skip
_PICKLES = (".pkl", ".pickle", ".joblib", ".pt")


def of_arrays(arrays: Mapping[str, Any], mapping: ColumnMap | None) -> Source:
    """Open a dict of arrays: what panda_py's get_log() returns, or another by a mapping."""
    return _of_table(ArraysTable(arrays), mapping)


def _of_table(table: Table, mapping: ColumnMap | None) -> Source:
    if mapping:
        return mapped(table, mapping)
    return panda_py(table) if is_panda_py(table) and not isinstance(table, (CsvTable, ParquetTable)) else _by_own_names(table)


def _by_own_names(table: Table) -> Source:
    """A table whose columns are called as ours. Raises ValueError saying how to map others."""
    names = automatic(table.names, table.vectors)
    if names is None:
        raise ValueError(f"{table.file} does not have the twin's names for its columns ({shortened(table.names)}); give a "
                         f"column mapping, such as "
                         "columns: {time: {from: t, unit: s}, q: {from: q_, unit: rad}, tau_J: tau_}")  # fmt: skip
    return mapped(table, names)


def of_file(path: pathlib.Path, mapping: ColumnMap | None) -> Source:
    """Open a file or a folder. Raises ValueError for what is no log."""
    if path.is_dir():
        return _of_folder(path, mapping)
    with open(path, "rb") as file:
        begin = file.read(64)
    if path.suffix.lower() in _PICKLES or begin[:1] == b"\x80" and begin[1:2] in (b"\2", b"\3", b"\4", b"\5"):
        raise ValueError(
            f"{path} is a pickle, and reading one runs whatever code it holds; save the log by numpy.savez('log.npz', "
            f"**panda.get_log())"
        )
    if not begin:
        raise ValueError(f"{path} is empty")
    if begin.startswith(b"\x89MCAP0\r\n"):
        if b"ros2" in begin[8:40]:
            return _bag(path, mapping)
        return _own(path, mapping)
    if begin.startswith(b"SQLite format 3\0"):
        return _bag(path, mapping)
    if begin.startswith(b"PAR1"):
        return _of_table(ParquetTable(path), mapping)
    if begin.startswith(b"PK\3\4"):
        return _of_table(NpzTable(path), mapping)
    for magic, what in _OTHERS:
        if begin.startswith(magic):
            raise ValueError(f"{path} is no log but {what}")
    table = CsvTable(path, mapping.separator, mapping.decimal) if mapping else CsvTable(path)
    return libfranka(table) if is_libfranka(table) and not mapping else _of_table(table, mapping)


def _of_folder(path: pathlib.Path, mapping: ColumnMap | None) -> Source:
    if (path / "metadata.yaml").exists():
        return _bag(path, mapping)
    if len(files := list(path.glob("*.db3"))) == 1:  # a bag whose recording was cut before it wrote metadata.yaml
        return _bag(files[0], mapping)
    try:
        return _own(_core.find_log(path), mapping)
    except ValueError as error:
        raise ValueError(f"{path} has neither a log of the twin (run.mcap) nor a bag of ROS 2 (metadata.yaml): {error}") from None


def _own(path: pathlib.Path, mapping: ColumnMap | None) -> Source:
    if mapping:
        raise ValueError(f"{path} is a log of the twin, whose columns are known; leave the column mapping out")
    return OwnLog(path)


def _bag(path: pathlib.Path, mapping: ColumnMap | None) -> Source:
    from ._bags import Bag

    if mapping:
        raise ValueError(f"{path} is a bag of ROS 2, whose columns are known; leave the column mapping out")
    return Bag(path)
