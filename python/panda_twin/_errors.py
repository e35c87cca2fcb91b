"""The package's own exception. It imports nothing of the package: the extension module raises it."""

from __future__ import annotations

import typing

if typing.TYPE_CHECKING:
    from ._results import Explanation, RunResult


class RobotFault(RuntimeError):
    """The robot refused a request, or a run failed.

    Attributes
    ----------
    explanation : Explanation or None
        Why a motion was aborted, out of the log; None when no error of the robot ended a motion, or there is no log.
    result : RunResult or None
        What the run left; None when no run failed.
    """

    explanation: Explanation | None = None
    result: RunResult | None = None

    @property
    def error(self) -> str | None:
        """Name of the robot's error as libfranka prints it; None without an explanation."""
        return self.explanation.error if self.explanation else None

    @property
    def joint(self) -> int | None:
        """Joint that broke a limit, 1 to 7; None when the error is of no joint, or not known."""
        return self.explanation.joint if self.explanation else None

    @property
    def value(self) -> float | None:
        """Value that broke the limit, in `explanation.unit`; None when not known."""
        return self.explanation.value if self.explanation else None

    @property
    def limit(self) -> float | None:
        """Limit that was broken, in `explanation.unit`; None when not known."""
        return self.explanation.limit if self.explanation else None

    @property
    def cycle(self) -> int | None:
        """Message id of the robot state of the cycle that raised the error; None when not known."""
        return self.explanation.cycle if self.explanation else None
