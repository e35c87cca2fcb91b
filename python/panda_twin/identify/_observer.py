"""What INT makes of a log's measurements: external torque and wrench."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import numpy.typing as npt

from .. import _core

if TYPE_CHECKING:
    from ..scenario import Scenario

Floats: TypeAlias = npt.NDArray[np.float64]

_T = 1e-3  # s, a cycle


class ExternalTorque:
    """INT's estimates of external torque and wrench from measured rows of 1 kHz, block after block.

    End effector, load and frames are those that the scenario gives INT. On a lockstep log of the twin they are the log's own to
    rounding, but for times of closed brakes.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._observer = _core.ExternalTorque(scenario._loaded)
        self._last: float | None = None

    def advance(self, t: Floats, q: Floats, dq: Floats, tau_J: Floats) -> tuple[Floats, Floats]:
        """Take rows that follow the last ones; where rows are missing, the estimate begins anew at zero.

        Parameters
        ----------
        t : ndarray, shape (n,)
            s, rising.
        q, dq, tau_J : ndarray, shape (n, 7)
            rad, rad/s, Nm.

        Returns
        -------
        tau_ext_hat_filtered : ndarray, shape (n, 7)
            Nm, positive when the robot pushes.
        O_F_ext_hat_K : ndarray, shape (n, 6)
            [N; Nm] about K in the base's axes; zero near a singularity.
        """
        anew = np.diff(t, prepend=t[0] - 1 if self._last is None else self._last) > 1.5 * _T
        out = np.empty((len(t), 13))
        self._observer.advance(np.ascontiguousarray(q, float), np.ascontiguousarray(dq, float), np.ascontiguousarray(tau_J, float), anew, out)
        if len(t):
            self._last = float(t[-1])
        return out[:, :7], out[:, 7:]


def external_torque(scenario: Scenario, q: Floats, dq: Floats, tau_J: Floats) -> tuple[Floats, Floats]:
    """Give rows of 1 kHz, without gaps, to INT's observer; as `ExternalTorque.advance`."""
    return ExternalTorque(scenario).advance(np.arange(len(q), dtype=float) * _T, q, dq, tau_J)
