"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

from . import _core
from ._core import (
    CartesianPose,
    CartesianVelocities,
    HandOutcome,
    HandState,
    JointPositions,
    JointVelocities,
    MotionResult,
    RobotFault,
    RobotState,
    SessionResult,
    Snapshot,
    Torques,
    Violation,
)
from . import _host as _host  # tells the module where its files are
from ._session import Hand, MotionFault, Objects, Session
from ._trajectory import Trajectory

__version__ = _core.version()

__all__ = [
    "CartesianPose",
    "CartesianVelocities",
    "Hand",
    "HandOutcome",
    "HandState",
    "JointPositions",
    "JointVelocities",
    "MotionFault",
    "MotionResult",
    "Objects",
    "RobotFault",
    "RobotState",
    "Session",
    "SessionResult",
    "Snapshot",
    "Torques",
    "Trajectory",
    "Violation",
    "__version__",
]
