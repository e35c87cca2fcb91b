"""Messages of ROS 2 in CDR, many at once: where each number is in one message is where it is in all that are built alike."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

_NUMBERS = {
    "bool": "u1", "byte": "u1", "char": "u1", "octet": "u1", "uint8": "u1", "int8": "i1", "uint16": "u2", "int16": "i2",
    "uint32": "u4", "int32": "i4", "uint64": "u8", "int64": "i8", "float32": "f4", "float64": "f8",
}  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Layout:
    """Where the fields of a message are.

    `numbers`: of each field of numbers, such as "header.stamp.sec", its offset, numpy type and how many. `texts`: of each field
    of texts, those of the message from which the layout was made. `fixed`: the places of counts and texts, which must be the
    same in another message for this to be its layout.
    """

    size: int
    numbers: dict[str, tuple[int, str, int]]
    texts: dict[str, tuple[str, ...]]
    fixed: npt.NDArray[np.intp]
    fixed_bytes: npt.NDArray[np.uint8]

    def read(self, rows: npt.NDArray[np.uint8], field: str) -> npt.NDArray[Any] | None:
        """Values (n, count) of messages (n, size); None for a field that is not there, or is empty."""
        if field not in self.numbers:
            return None
        offset, kind, count = self.numbers[field]
        width = count * int(kind[2])
        return np.ascontiguousarray(rows[:, offset : offset + width]).view(kind) if count else None


class _Walk:
    """Goes through one message by its definition."""

    def __init__(self, data: bytes, types: Any) -> None:
        if len(data) < 4 or data[0] != 0 or data[1] > 1:
            raise ValueError("a message is not in the CDR of ROS 2")
        self._data = data
        self._types = types  # of a name, (constants, [(field, (kind, detail))]), as rosbags has them
        self._order = "<" if data[1] else ">"
        self._at = 4
        self.numbers: dict[str, tuple[int, str, int]] = {}
        self.texts: dict[str, tuple[str, ...]] = {}
        self.fixed = list(range(4))

    def message(self, name: str, path: str) -> None:
        if name not in self._types:
            raise ValueError(f"the bag does not say what {name} is")
        for field, description in self._types[name][1]:
            self._field(description, f"{path}.{field}" if path else field)

    def _field(self, description: Any, path: str) -> None:
        kind, detail = int(description[0]), description[1]
        if kind == 1:
            self._base(detail[0], path, 1)
        elif kind == 2:
            self.message(detail, path)
        else:
            inner, count = detail
            if kind == 4:
                count = self._count()
            if int(inner[0]) == 1:
                self._base(inner[1][0], path, count)
            else:
                for i in range(count):
                    self._field(inner, f"{path}[{i}]")

    def _base(self, name: str, path: str, count: int) -> None:
        if name in ("string", "wstring"):
            self.texts[path] = tuple(self._text(1 if name == "string" else 2) for _ in range(count))
            return
        if name not in _NUMBERS:
            raise ValueError(f"{path} is of type {name}, which cannot be read")
        size = int(_NUMBERS[name][1])
        if count:
            self._align(size)
        self.numbers[path] = (self._at, f"{self._order}{_NUMBERS[name]}", count)
        self._skip(size * count)

    def _align(self, size: int) -> None:
        self._at += -(self._at - 4) % size

    def _skip(self, size: int) -> int:
        self._at += size
        if self._at > len(self._data):
            raise ValueError("a message ends before its last field")
        return self._at - size

    def _count(self) -> int:
        self._align(4)
        begin = self._skip(4)
        self.fixed += range(begin, begin + 4)
        count = int.from_bytes(self._data[begin : begin + 4], "little" if self._order == "<" else "big")
        if count > len(self._data):
            raise ValueError("a message has a count beyond its size")
        return count

    def _text(self, width: int) -> str:
        begin = self._skip(self._count() * width)
        self.fixed += range(begin, self._at)
        return self._data[begin : self._at].rstrip(b"\0").decode("utf-8", "replace")


def layout(data: bytes, name: str, types: Any) -> Layout:
    """The layout of a message. Raises ValueError where it does not fit its definition."""
    walk = _Walk(data, types)
    walk.message(name, "")
    fixed = np.array(walk.fixed, np.intp)
    return Layout(len(data), walk.numbers, walk.texts, fixed, np.frombuffer(data, np.uint8)[fixed])


class Messages:
    """Reads messages of one type."""

    def __init__(self, name: str, types: Any) -> None:
        self._name = name
        self._types = types
        self._layouts: dict[int, list[Layout]] = {}

    def alike(self, messages: Sequence[bytes]) -> Iterator[tuple[Layout, npt.NDArray[np.intp], npt.NDArray[np.uint8]]]:
        """Yield each layout that occurs, the places of its messages, and their bytes (n, size)."""
        sizes = np.fromiter(map(len, messages), np.intp, len(messages))
        for size in np.unique(sizes).tolist():
            places = np.flatnonzero(sizes == size)
            rows = np.frombuffer(b"".join([messages[place] for place in places.tolist()]), np.uint8).reshape(len(places), size)
            known = self._layouts.setdefault(size, [])
            tried = 0
            while len(places):
                if tried == len(known):
                    known.append(layout(rows[0].tobytes(), self._name, self._types))
                one = known[tried]
                same = (rows[:, one.fixed] == one.fixed_bytes).all(axis=1)
                if same.any():
                    yield one, places[same], rows[same] if not same.all() else rows
                    places, rows = places[~same], rows[~same]
                tried += 1
            del known[:-16]
