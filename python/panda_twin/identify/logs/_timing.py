"""What the times of a log say: period, lost and late cycles, runs of held cycles, share of commands that arrived."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]
Counts = npt.NDArray[np.int64]

_BINS = 100_000  # of 1 us
_LOST = 1.5  # periods from which on an interval has a row too few
_LATE = 1.25


@dataclasses.dataclass(frozen=True)
class Timing:
    """Times of a log's rows.

    Attributes
    ----------
    by : str
        "message_id": by the robot's own ms; "time": by the stamps of the program that wrote the log.
    median, mean, sd, longest : float
        Interval between rows, ms; `longest` is the longest.
    longest_at : float
        Where the longest interval begins, s from the log's begin.
    lost : int
        Cycles that are not in the log: by ids that are missing, or by intervals of at least 1.5 periods (the median).
    late : int
        Intervals of 1.25 periods and more in which no cycle is lost; by the stamps where the log has both.
    repeated : int
        Rows of the time of the row before, which are left out.
    sorted : bool
        False when messages were reordered by their stamps.
    intervals : (edges, counts)
        Of the intervals: edges in ms, one more than counts; the last bin has all that are longer.
    held : dict of int to int
        Cycles in a row that held the last command, and how often; empty where the log does not say (`fate`).
    success : (edges, counts) or None
        Of control_command_success_rate, in steps of 0.01.
    """

    by: str
    median: float
    mean: float
    sd: float
    longest: float
    longest_at: float
    lost: int
    late: int
    repeated: int
    sorted: bool
    intervals: tuple[Floats, Counts]
    held: dict[int, int]
    success: tuple[Floats, Counts] | None


class Intervals:
    """Counts intervals without keeping them."""

    def __init__(self) -> None:
        self.counts: Counts = np.zeros(_BINS + 1, np.int64)
        self._long: list[Floats] = []
        self._sums = np.zeros(3)
        self.longest = 0.0
        self.longest_at = 0.0

    def add(self, t: Floats, last: float | None) -> None:
        """Add rising times; `last` is the one before them."""
        dt = np.diff(t, prepend=[] if last is None else [last])
        if len(dt) == 0:
            return
        k = int(np.argmax(dt))
        if dt[k] > self.longest:
            self.longest, self.longest_at = float(dt[k]), float(t[k + len(t) - len(dt)] - dt[k])
        bins = np.minimum(np.rint(dt * 1e6), _BINS).astype(np.int64)
        self.counts += np.bincount(bins, minlength=_BINS + 1)
        self._long.append(dt[bins == _BINS])
        self._sums += len(dt), dt.sum(), (dt * dt).sum()

    @property
    def mean(self) -> float:
        return float(self._sums[1] / max(1, self._sums[0]))

    @property
    def sd(self) -> float:
        return float(np.sqrt(max(0.0, self._sums[2] / max(1, self._sums[0]) - self.mean**2)))

    def median(self) -> float:
        """Median, s: to 1 us, or exact where it is above 0.1 s."""
        half = (self.counts.sum() + 1) // 2
        place = int(np.searchsorted(np.cumsum(self.counts), half))
        return place * 1e-6 if place < _BINS else float(np.median(np.concatenate(self._long)))

    def lost(self, period: float) -> int:
        """Rows too few, by intervals of at least 1.5 periods."""
        dt = np.arange(_BINS) * 1e-6
        gaps = dt >= _LOST * period
        few = float((self.counts[:_BINS][gaps] * (np.rint(dt[gaps] / period) - 1)).sum())
        long = np.concatenate(self._long) if self._long else np.zeros(0)
        return int(few + (np.rint(long[long >= _LOST * period] / period) - 1).sum())

    def late(self, period: float) -> int:
        """Intervals of at least 1.25 and less than 1.5 periods."""
        dt = np.arange(_BINS) * 1e-6
        few = int(self.counts[:_BINS][(dt >= _LATE * period) & (dt < _LOST * period)].sum())
        long = np.concatenate(self._long) if self._long else np.zeros(0)
        return few + int(((long >= _LATE * period) & (long < _LOST * period)).sum())

    def histogram(self, period: float) -> tuple[Floats, Counts]:
        """In 40 bins up to two periods; the last has all that are longer. Edges in ms."""
        edges = np.linspace(0, 2 * period, 41)
        place = np.minimum(np.searchsorted(edges, np.arange(_BINS + 1) * 1e-6, side="right") - 1, 39)
        counts = np.bincount(place, weights=self.counts, minlength=40).astype(np.int64)
        if 2 * period > _BINS * 1e-6:
            counts = np.histogram(np.minimum(np.concatenate(self._long), edges[-1]), edges)[0] + np.append(counts[:-1], 0)
        return edges * 1e3, counts


class Runs:
    """Counts runs of held cycles."""

    def __init__(self) -> None:
        self.counts: dict[int, int] = {}
        self._run = 0

    def add(self, held: npt.NDArray[np.bool_]) -> None:
        edges = np.flatnonzero(np.diff(held, prepend=False, append=False))
        for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist()):
            if begin > 0:
                self.end()
            self._run += end - begin
        if len(held) and not held[-1]:
            self.end()

    def end(self) -> None:
        """The log ends, or a cycle was not held."""
        if self._run:
            self.counts[self._run] = self.counts.get(self._run, 0) + 1
        self._run = 0


class Success:
    """Counts success rates in steps of 0.01."""

    def __init__(self) -> None:
        self.counts: Counts = np.zeros(101, np.int64)

    def add(self, rate: npt.NDArray[Any]) -> None:
        rate = np.asarray(rate, np.float64)
        good = rate[np.isfinite(rate)]
        self.counts += np.bincount(np.clip(np.rint(good * 100), 0, 100).astype(np.int64), minlength=101)

    def histogram(self) -> tuple[Floats, Counts] | None:
        return (np.append(np.arange(101) - 0.5, 100.5) / 100, self.counts) if self.counts.any() else None
