"""Files of columns, read block by block: CSV, Parquet, NPZ, and a dict of arrays."""

from __future__ import annotations

import codecs
import contextlib
import csv
import io
import os
import pathlib
import re
import zipfile
import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from ._mapping import shortened

Values = npt.NDArray[Any]

_BLOCK_BYTES = 4 << 20
_ROWS = 16384
_LARGEST = 64 << 20  # bytes of an array that may be read whole when it cannot be read by blocks
_LONGEST_LINE = 1 << 20


class Table(Protocol):
    """Columns of a file, numbered from 0."""

    file: str
    names: list[str]
    vectors: dict[str, int]  # columns of more than one number in a row, with how many
    notes: list[str]

    def blocks(self, places: Sequence[int]) -> Iterator[dict[int, Values]]:
        """Yield these columns, some rows at a time, (n,) or (n, width). Raises ValueError where the file is damaged."""
        ...


def import_pyarrow() -> Any:
    """The package pyarrow with what is needed of it. Raises ImportError saying what to install."""
    try:
        import pyarrow  # type: ignore[import-untyped]
        import pyarrow.csv  # type: ignore[import-untyped]
        import pyarrow.parquet  # type: ignore[import-untyped]
    except ImportError as error:
        raise ImportError(f"CSV and Parquet need pyarrow ({error}): pip install 'panda-twin[identify]'") from None
    pyarrow.set_cpu_count(pyarrow.cpu_count())
    return pyarrow


class CsvTable:
    """A CSV file of any separator, in UTF-8, UTF-16 or Latin-1, with a heading or without."""

    def __init__(self, path: pathlib.Path, separator: str | None = None, decimal: str | None = None) -> None:
        self.file = str(path)
        self.notes: list[str] = []
        self.vectors: dict[str, int] = {}
        self._path = path
        self._arrow = import_pyarrow()
        head, self._encoding = _decoded_head(path)
        lines = head.splitlines()
        self._skipped = next((i for i, line in enumerate(lines) if line.strip()), len(lines))
        if self._skipped == len(lines):
            raise ValueError(f"{path} is empty; a heading and rows belong there")
        heading, first = lines[self._skipped], next((line for line in lines[self._skipped + 1 :] if line.strip()), "")
        self._separator = separator or _separator(heading, first)
        self.names = _cells(heading.lstrip("# "), self._separator)
        if all(map(_is_number, self.names)):  # no heading
            self._first = self.names
            self.names = [str(place) for place in range(len(self.names))]
        else:
            self._skipped += 1
            self._first = _cells(first, self._separator)
        if not self._first:
            raise ValueError(f"{path} has a heading only, of {len(self.names)} columns, and no row")
        self._decimal = decimal or (
            "," if self._separator != "," and any(re.fullmatch(r"-?\d+,\d+(e[-+]?\d+)?", cell) for cell in self._first) else "."
        )
        self._tail = _last_line(path)

    def blocks(self, places: Sequence[int]) -> Iterator[dict[int, Values]]:
        arrow = self._arrow
        self._cut: str | None = None
        keys = [str(place) for place in range(len(self.names))]
        kinds = {str(place): arrow.int64() if self._is_large(place) else arrow.float64() for place in places}
        read = arrow.csv.ReadOptions(
            use_threads=False, block_size=_BLOCK_BYTES, skip_rows=self._skipped, column_names=keys, encoding=self._encoding
        )
        parse = arrow.csv.ParseOptions(delimiter=self._separator, invalid_row_handler=self._of_wrong_length)
        convert = arrow.csv.ConvertOptions(
            column_types=kinds, include_columns=list(kinds), decimal_point=self._decimal, strings_can_be_null=False,
            null_values=["", "nan", "NaN", "NAN", "-nan", "null", "NULL", "None", "NA", "N/A", "n/a"],
        )  # fmt: skip
        rows = 0
        try:
            with arrow.csv.open_csv(self.file, read_options=read, parse_options=parse, convert_options=convert) as reader:
                for batch in reader:
                    if batch.num_rows:
                        yield {place: batch.column(str(place)).to_numpy(zero_copy_only=False) for place in places}
                        rows += batch.num_rows
        except (arrow.ArrowInvalid, arrow.ArrowKeyError, arrow.ArrowNotImplementedError, UnicodeError) as error:
            raise ValueError(self._said(str(error), rows)) from None
        if (
            self._cut is not None
            and (note := "the last row is not whole, so it is left out: the program that wrote the log was stopped")
            not in self.notes
        ):
            self.notes.append(note)

    def _is_large(self, place: int) -> bool:
        """Whether a column holds integers beyond what float64 has exactly: stamps in ns."""
        cell = self._first[place] if place < len(self._first) else ""
        return re.fullmatch(r"-?\d{16,19}", cell) is not None

    def _of_wrong_length(self, row: Any) -> str:
        if self._cut is None and row.text.strip() == self._tail:
            self._cut = row.text
            return "skip"
        return "error"

    def _said(self, error: str, rows: int) -> str:
        if match := re.search(r"(?:Row #(\d+): )?Expected (\d+) columns, got (\d+)", error):
            where = f"row {int(match[1]) - self._skipped}" if match[1] else f"a row after row {rows}"
            return f"{self.file}: {where} has {match[3]} values and the heading {match[2]}; remove the row, or write the log anew"
        if match := re.search(r"In CSV column #(\d+): (?:Row #(\d+): )?.*invalid value '(.*)'", error, re.DOTALL):
            name = self.names[int(match[1])] if int(match[1]) < len(self.names) else match[1]
            where = f"in row {int(match[2]) - self._skipped}" if match[2] else f"after row {rows}"
            return f"{self.file}: column {name} has {match[3][:40]!r}, which is no number, {where}; remove the row"
        return f"{self.file} is no CSV that can be read: {' '.join(error.split())[:300]}"


def _decoded_head(path: pathlib.Path) -> tuple[str, str]:
    """The begin of a text and its encoding as pyarrow needs it. Raises ValueError for what is no text."""
    with open(path, "rb") as file:
        data = file.read(256 << 10)
    if not data:
        raise ValueError(f"{path} is empty")
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        encoding = "utf-16"
    elif b"\0" in data:
        raise ValueError(f"{path} is no log: it holds bytes that no text has, and is of no format that is known here")
    else:
        encoding = "utf-8"
    try:
        text = codecs.getincrementaldecoder("utf-8-sig" if encoding == "utf-8" else encoding)().decode(data)
    except UnicodeDecodeError:
        encoding = "latin-1"
        text = data.decode(encoding)
    if (
        sum(not (c.isprintable() or c in "\t\r\n") for c in text[:4096]) > 8
        or max(map(len, text.splitlines() or [""])) >= len(text) > _LONGEST_LINE // 8
    ):
        raise ValueError(f"{path} is no log: it is no text in lines, and of no format that is known here")
    return text, encoding


def _separator(heading: str, first: str) -> str:
    """The character between values: that which the heading and the first row have equally often, most often."""
    counts = {one: (len(_cells(heading, one)), len(_cells(first or heading, one))) for one in ",;\t| "}
    return max(counts, key=lambda one: (counts[one][0] == counts[one][1] > 1, counts[one][0]))


def _cells(line: str, separator: str) -> list[str]:
    with contextlib.suppress(csv.Error):
        return [cell.strip() for cell in next(csv.reader(io.StringIO(line), delimiter=separator), [])]
    return [cell.strip() for cell in line.split(separator)]


def _is_number(cell: str) -> bool:
    return re.fullmatch(r"[-+]?(\d+[.,]?\d*|[.,]\d+)([eE][-+]?\d+)?|[-+]?nan|[-+]?inf", cell.strip(), re.IGNORECASE) is not None


def _last_line(path: pathlib.Path) -> str:
    """The last line unless it ends with a newline: only then a program may have been stopped while it wrote it."""
    with open(path, "rb") as file:
        file.seek(max(0, os.path.getsize(path) - 65536))
        tail = file.read()
    return "" if tail.endswith((b"\n", b"\n\0")) else tail.rpartition(b"\n")[2].decode("utf-8", "replace").strip()


class ParquetTable:
    """A Parquet file, by row groups."""

    def __init__(self, path: pathlib.Path) -> None:
        self.file = str(path)
        self.notes: list[str] = []
        arrow = self._arrow = import_pyarrow()
        try:
            self._parquet = arrow.parquet.ParquetFile(path, memory_map=False, pre_buffer=False)
            schema = self._parquet.schema_arrow
        except (arrow.ArrowException, ValueError) as error:
            raise ValueError(f"{path} is a damaged Parquet file, such as one that was cut: {_short(error)}") from None
        if self._parquet.metadata.num_rows == 0:
            raise ValueError(f"{path} has columns ({shortened(list(schema.names))}) and no row")
        self.names = list(schema.names)
        self.vectors = {field.name: field.type.list_size for field in schema if arrow.types.is_fixed_size_list(field.type)}
        self._lists = {field.name for field in schema if arrow.types.is_list(field.type) or arrow.types.is_large_list(field.type)}
        if self._lists:
            first = next(self._batches(sorted(self._lists), 1))
            for name in self._lists:
                self.vectors[name] = len(first.column(name)[0].as_py() or ())

    def _batches(self, names: list[str], rows: int) -> Iterator[Any]:
        arrow = self._arrow
        try:
            yield from self._parquet.iter_batches(batch_size=rows, columns=names, use_threads=False)
        except (arrow.ArrowException, ValueError, OSError) as error:
            raise ValueError(f"{self.file} is a damaged Parquet file: {_short(error)}") from None

    def blocks(self, places: Sequence[int]) -> Iterator[dict[int, Values]]:
        row = 0
        for batch in self._batches([self.names[place] for place in places], _ROWS):
            yield {
                place: self._numbers(batch.column(batch.schema.get_field_index(self.names[place])), self.names[place], row)
                for place in places
            }
            row += batch.num_rows

    def _numbers(self, column: Any, name: str, row: int) -> Values:
        types = self._arrow.types
        if name in self.vectors:
            width = self.vectors[name]
            values = column.flatten()
            if len(values) != width * len(column):
                raise ValueError(f"{self.file}: {name} does not have {width} numbers in every row after row {row}")
            return self._numbers(values, "", row).reshape(-1, width)
        if types.is_dictionary(column.type):
            column = column.dictionary_decode()
        if types.is_timestamp(column.type):
            column = column.cast(self._arrow.timestamp("ns")).cast(self._arrow.int64())
        if not (types.is_integer(column.type) or types.is_floating(column.type) or types.is_boolean(column.type)):
            raise ValueError(f"{self.file}: {name} is of type {column.type}; numbers are needed")
        values = column.to_numpy(zero_copy_only=False)
        return np.asarray(values, np.float64) if values.dtype.kind not in "iuf" else values


class NpzTable:
    """Arrays of a .npz file, which are streamed out of it and never unpickled."""

    def __init__(self, path: pathlib.Path) -> None:
        self.file = str(path)
        self.notes: list[str] = []
        self._path = path
        self._members: list[tuple[str, tuple[int, ...], bool, np.dtype[Any]]] = []
        try:
            with zipfile.ZipFile(path) as archive:
                for member in archive.namelist():
                    if member.endswith(".npy"):
                        with archive.open(member) as file:
                            self._members.append((member, *_npy_header(file, f"{path}: {member[:-4]}")))
        except _ZIP_ERRORS as error:
            raise ValueError(f"{path} is a damaged .npz file, such as one that was cut: {_short(error)}") from None
        if not self._members:
            raise ValueError(f"{path} is a zip file without arrays; numpy.savez writes .npz files")
        self._members = [(member, shape or (1,), fortran, dtype) for member, shape, fortran, dtype in self._members]
        self.names = [member[:-4] for member, _, _, _ in self._members]
        self.vectors = {
            m[:-4]: int(np.prod(shape[1:])) for m, shape, _, _ in self._members if len(shape) > 1 and np.prod(shape[1:]) != 1
        }
        self.lengths = {member[:-4]: shape[0] for member, shape, _, _ in self._members}

    def blocks(self, places: Sequence[int]) -> Iterator[dict[int, Values]]:
        rows = _same_length(self.file, {self.names[place]: self.lengths[self.names[place]] for place in places})
        try:
            with zipfile.ZipFile(self._path) as archive, contextlib.ExitStack() as stack:
                readers = {place: self._reader(stack, archive, place) for place in places}
                for row in range(0, rows, _ROWS):
                    yield {place: reader(min(_ROWS, rows - row)) for place, reader in readers.items()}
        except _ZIP_ERRORS as error:
            raise ValueError(f"{self.file} is damaged: {_short(error)}") from None

    def _reader(self, stack: contextlib.ExitStack, archive: zipfile.ZipFile, place: int) -> Any:
        member, shape, fortran, dtype = self._members[place]
        name = f"{self.file}: {self.names[place]}"
        if dtype.hasobject:
            raise ValueError(
                f"{name} holds Python objects, whose reading would run code of the file; save it as an array of numbers: "
                f"numpy.asarray(..., float)"
            )
        if dtype.kind not in "iufb":
            raise ValueError(f"{name} is of type {dtype}; numbers are needed")
        file = stack.enter_context(archive.open(member))
        _npy_header(file, name)
        width = int(np.prod(shape[1:]))
        if fortran and width > 1:
            if (size := shape[0] * width * dtype.itemsize) > _LARGEST:
                raise ValueError(
                    f"{name} is stored column by column and too large ({size >> 20} MB) to be turned; save "
                    f"numpy.ascontiguousarray of it"
                )
            whole = _read(file, size, name).view(dtype).reshape(width, shape[0]).T
            return _Slices(whole)
        return lambda rows: _shaped(_read(file, rows * width * dtype.itemsize, name).view(dtype), width)


_ZIP_ERRORS = (
    zipfile.BadZipFile,
    zlib.error,
    EOFError,
    NotImplementedError,
    RuntimeError,
    KeyError,
    OSError,
    UnicodeError,
    OverflowError,
)


class _Slices:
    """The rows of an array one block after another."""

    def __init__(self, whole: Values) -> None:
        self._whole = whole
        self._at = 0

    def __call__(self, rows: int) -> Values:
        self._at += rows
        return self._whole[self._at - rows : self._at]


def _shaped(values: Values, width: int) -> Values:
    values = values.astype(values.dtype.newbyteorder("="), copy=False)
    return values.reshape(-1, width) if width > 1 else values


def _read(file: Any, size: int, name: str) -> Values:
    data = bytearray()
    while len(data) < size:
        if not (part := file.read(min(size - len(data), 8 << 20))):
            raise EOFError(f"{name} ends before its last row")
        data += part
    return np.frombuffer(data, np.uint8)


def _npy_header(file: Any, name: str) -> tuple[tuple[int, ...], bool, np.dtype[Any]]:
    try:
        version = np.lib.format.read_magic(file)
        read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, fortran, dtype = read(file)
    except (ValueError, TypeError, SyntaxError, RecursionError, MemoryError) as error:
        raise ValueError(f"{name} is no array of numpy: {_short(error)}") from None
    if any(not 0 <= size < 2**40 for size in shape) or len(shape) > 8:
        raise ValueError(f"{name} is no array of numpy: its shape is {shape}")
    return shape, fortran, dtype


class ArraysTable:
    """A dict of arrays, or of lists of rows."""

    def __init__(self, arrays: Mapping[str, Any], name: str = "the dict") -> None:
        self.file = name
        self.notes: list[str] = []
        self._arrays: dict[str, Values] = {}
        for key, values in arrays.items():
            try:
                array = np.asarray(values)
                array = array if array.dtype.kind in "iu" else np.asarray(array, np.float64)
                self._arrays[str(key)] = array.reshape(len(array), -1 if array.size else 1)
                if not array.size:
                    raise ValueError("it has no row")
            except (TypeError, ValueError) as error:
                raise ValueError(f"{name}: {key} is no array of numbers with equally long rows ({_short(error)})") from None
        self.names = list(self._arrays)
        self.vectors = {key: array.shape[1] for key, array in self._arrays.items() if array.shape[1] != 1}

    def blocks(self, places: Sequence[int]) -> Iterator[dict[int, Values]]:
        chosen = {place: self._arrays[self.names[place]] for place in places}
        rows = _same_length(self.file, {self.names[place]: len(array) for place, array in chosen.items()})
        for row in range(0, rows, _ROWS):
            yield {place: (array if array.shape[1] != 1 else array[:, 0])[row : row + _ROWS] for place, array in chosen.items()}


def _same_length(file: str, lengths: Mapping[str, int]) -> int:
    if len(set(lengths.values())) > 1:
        raise ValueError(
            f"{file}: its columns have different lengths: "
            f"{', '.join(f'{name} {rows} rows' for name, rows in lengths.items())}; cut them to the same rows"
        )
    return next(iter(lengths.values()), 0)


def _short(error: BaseException) -> str:
    return " ".join(str(error).split())[:200] or type(error).__name__
