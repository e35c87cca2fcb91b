"""What a comparison found: numbers for programs, and what the report is made of."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
import numpy.typing as npt

from ._causes import Cause
from ._demand import Item
from ._identify import Identified
from .logs._timing import Timing

if TYPE_CHECKING:
    from ..scenario import Scenario

Array: TypeAlias = npt.NDArray[np.float64]


def rms(values: Array) -> Array:
    """Root of the mean square of each column."""
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


@dataclasses.dataclass(frozen=True)
class LogFacts:
    """A log that was compared."""

    name: str
    kind: str
    sha256: str
    rows: int
    seconds: float
    timing: Timing
    missing: list[tuple[str, str]]
    """Columns that are not there, and what cannot be judged without them."""
    notes: list[str]
    suspicions: list[str]
    """What does not fit a Panda: units, swapped joints."""


@dataclasses.dataclass(frozen=True)
class Open:
    """Torques on the measured motion: measured against the twin's inverse dynamics, every 40 ms after a low-pass of 8 Hz."""

    t: Array
    q: Array
    dq: Array
    measured: Array
    """(n, 7), Nm."""
    before: Array
    """(n, 7): measured less the twin's, Nm."""
    after: Array | None
    """(n, 7): less the identified twin's; None without identification."""


@dataclasses.dataclass(frozen=True)
class Closed:
    """Robot and twin under the same commands."""

    t: Array
    """(m,), s: every tenth cycle."""
    position: Array
    """(m, 7): q of the robot less that of the twin, rad."""
    reference: Array
    """(m, 7): the same of q_d, rad."""
    position_rms: Array
    position_largest: Array
    torque_rms: Array
    """Of tau_J, Nm."""
    cycles: int
    events: list[str]
    """Errors: what robot and twin reported, at which cycle."""
    first_difference: int | None
    """Number of the first cycle, from 1, whose q, dq or tau_J differs in any bit; None: all are equal."""


@dataclasses.dataclass(frozen=True)
class External:
    """INT's estimates of external torque and wrench: the robot's less the twin's, on the robot's own torques."""

    torque_rms: Array
    """(7,), Nm."""
    wrench_rms: Array | None
    """(6,), N and Nm in the base's axes."""
    seconds: float


@dataclasses.dataclass(frozen=True)
class CommandDelay:
    """Cycles from a command in the log to the state that shows it."""

    cycles: Array
    """0, 1, 2, ..."""
    share: Array
    """Of the cycles in motion."""
    expected: int
    """What a link without delay gives."""


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Robot against twin.

    `passed` is the verdict: every demand that the logs can tell is met, and at least one can be told.
    """

    logs: list[LogFacts]
    scenario: Scenario
    """The twin."""
    open: Open | None
    causes: list[Cause]
    """What explains the open residual, the largest first; at most three."""
    identified: Identified | None
    closed: Closed | None
    closed_after: Closed | None
    """With the identified twin."""
    external: External | None
    command_delay: CommandDelay | None
    found: dict[str, Array]
    """What the demands are held against, SI."""
    items: list[Item]
    untold: list[str]
    """What the data cannot tell."""
    profile: dict[str, Any] | None
    """What `--write` writes; None without identification."""

    @property
    def passed(self) -> bool:
        """Whether the twin is the robot, as demanded."""
        return any(item.is_met for item in self.items) and not any(item.is_met is False for item in self.items)

    def __repr__(self) -> str:
        bad = sum(item.is_met is False for item in self.items)
        return f"<Comparison: {'passed' if self.passed else f'{bad} of {len(self.items)} demands not met'}; {self.causes[0].name if self.causes else 'no cause'}>"
