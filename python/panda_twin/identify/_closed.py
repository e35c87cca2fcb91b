"""Robot and twin under the same commands, and INT's estimates on the robot's own torques."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._observer import ExternalTorque
from ._replay import can_replay, is_by_reference, replay
from ._result import Closed, External

if TYPE_CHECKING:
    from ..scenario import Scenario
    from .logs._recording import Block, Recording

Array: TypeAlias = npt.NDArray[np.float64]

_EVERY = 10  # cycles between curves' points
_COMPARED = ("q", "dq", "tau_J", "q_d")
_PERIOD = (0.9e-3, 1.1e-3)  # s, of rows that the observer takes
_FOLLOWED = 0.1  # rad
_SETTLED = 0.2  # s after which the observer has forgotten where it began


def closed_of(recording: Recording, scenario: Scenario) -> Closed | None:
    """Give the log's commands to the twin; None where the log has none, begins in a motion, or has only a q_d that the robot did not follow."""
    if not can_replay(recording):
        return None
    names = [name for name in (*_COMPARED, "errors") if name in recording.columns]
    is_reference = is_by_reference(recording)
    sums, largest = {name: np.zeros(7) for name in ("q", "tau_J")}, np.zeros(7)
    curves: list[tuple[Array, Array, Array]] = []
    events, rows, first = _Events(), 0, None
    for block, twin in _beside(recording, scenario, names):
        if is_reference and np.abs(block.columns["q"] - block.columns["q_d"]).max() > _FOLLOWED:
            return None  # a torque motion
        differences = {name: block.columns[name] - twin[name] for name in names if name != "errors"}
        for name in sums.keys() & differences.keys():
            sums[name] += np.sum(differences[name] ** 2, axis=0)
        largest = np.maximum(largest, np.abs(differences["q"]).max(axis=0))
        exact = [differences[name] for name in ("q", "dq", "tau_J") if name in differences]
        unequal = np.flatnonzero(np.any([np.any(difference != 0, axis=1) for difference in exact], axis=0))
        if first is None and len(unequal):
            first = rows + int(unequal[0]) + 1
        events.add("robot", block.columns.get("errors"), rows)
        events.add("twin", twin["errors"], rows)
        shown = slice(-rows % _EVERY, None, _EVERY)
        reference = differences.get("q_d", np.full_like(differences["q"], np.nan))
        curves.append((block.t[shown], differences["q"][shown], reference[shown]))
        rows += len(block.t)
    t, position, reference = (np.concatenate(parts) for parts in zip(*curves))
    torque_rms = np.sqrt(sums["tau_J"] / rows) if "tau_J" in names else np.full(7, np.nan)
    return Closed(t, position, reference, np.sqrt(sums["q"] / rows), largest, torque_rms, rows, events.texts, first)


class _Events:
    """Errors as they appear."""

    def __init__(self) -> None:
        self.texts: list[str] = []
        self._last = {"robot": "", "twin": ""}

    def add(self, who: str, errors: npt.NDArray[Any] | None, first_row: int) -> None:
        if errors is None:
            return
        before = np.concatenate([np.array([self._last[who]], object), errors[:-1]])
        for row in np.flatnonzero(errors != before):
            if errors[row]:
                self.texts.append(f"{who}: {errors[row].replace('|', ', ')} in cycle {first_row + row + 1}")
        self._last[who] = errors[-1]


def _beside(recording: Recording, scenario: Scenario, names: Sequence[str]) -> Iterator[tuple[Block, dict[str, npt.NDArray[Any]]]]:
    """Blocks of the log, each with the same rows of the twin."""
    twin = replay(recording, scenario)
    held: dict[str, npt.NDArray[Any]] = {}
    for block in recording.blocks(*names):
        parts = [held] if held else []
        count = sum(len(part["q"]) for part in parts)
        while count < len(block.t):
            parts.append(next(twin))
            count += len(parts[-1]["q"])
        whole = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
        held = {name: values[len(block.t):] for name, values in whole.items()}
        yield block, {name: values[: len(block.t)] for name, values in whole.items()}


def external_of(recordings: Sequence[Recording], scenario: Scenario) -> External | None:
    """Give the robot's torques to INT's observer; None where the log lacks them or the robot's estimate, or is no log of 1 kHz."""
    seconds, counts = 0.0, 0
    sums = {"tau_ext_hat_filtered": np.zeros(7), "O_F_ext_hat_K": np.zeros(6)}
    has_wrench = False
    for recording in recordings:
        if not {"q", "dq", "tau_J", "tau_ext_hat_filtered"} <= recording.columns or not _PERIOD[0] <= recording.timing.median * 1e-3 <= _PERIOD[1]:
            continue
        observer, began = ExternalTorque(scenario), -np.inf
        wrench = ["O_F_ext_hat_K"] if "O_F_ext_hat_K" in recording.columns else []
        has_wrench |= bool(wrench)
        last = -np.inf
        for block in recording.blocks("q", "dq", "tau_J", "tau_ext_hat_filtered", *wrench):
            estimates = dict(zip(sums, observer.advance(block.t, *(block.columns[name] for name in ("q", "dq", "tau_J")))))
            gaps = np.where(np.diff(block.t, prepend=last) > 1.5e-3, block.t, -np.inf)
            since = np.maximum.accumulate(np.maximum(gaps, began))
            began, last = float(since[-1]), float(block.t[-1])
            settled = block.t - since >= _SETTLED
            for name in ("tau_ext_hat_filtered", *wrench):
                sums[name] += np.sum((block.columns[name] - estimates[name])[settled] ** 2, axis=0)
            counts += int(settled.sum())
        seconds += recording.seconds
    if counts == 0:
        return None
    torque, force = (np.sqrt(total / counts) for total in sums.values())
    return External(torque, force if has_wrench else None, seconds)
