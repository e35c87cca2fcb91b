"""Robot and twin under the same commands, and INT's estimates on the robot's own torques."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from ._result import Closed, External

if TYPE_CHECKING:
    from ..scenario import Scenario
    from ._recording import Recording

Array: TypeAlias = npt.NDArray[np.float64]


def closed_of(recording: Recording, scenario: Scenario) -> Closed | None:
    """Give the log's commands to the twin; None where the log has none."""
    return None


def external_of(recordings: Sequence[Recording], scenario: Scenario) -> External | None:
    """Give the robot's torques to INT's observer; None where the log lacks them or the robot's estimate."""
    return None
