"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

import contextlib
import importlib.util

from . import _core
from . import _host as _host  # tells the module where its files are
from . import model as model
from ._cell import Cell, Robots
from ._core import (
    Cancelled,
    CartesianPose,
    CartesianVelocities,
    HandOutcome,
    HandState,
    JointPositions,
    JointVelocities,
    MotionResult,
    RobotState,
    SessionResult,
    Snapshot,
    Torques,
    Violation,
)
from ._errors import RobotFault
from ._log import Log, LogMeta, Table
from ._results import Explanation, RunResult, explain
from ._robot import Hand, MotionFault, Objects, Robot
from ._run import run
from ._serve import ControlChannel, Event, ServedRobot, Status, control_channel, serve
from ._session import Session
from ._trajectory import Trajectory
from .scenario import Scenario, schema, validate

if importlib.util.find_spec("gymnasium") is not None:
    with contextlib.suppress(Exception):  # of a broken Gymnasium; importing panda_twin.envs says it
        from . import envs as envs  # registers the environments

__version__ = _core.version()

__all__ = [
    "__version__",
    "Cancelled",
    "CartesianPose",
    "CartesianVelocities",
    "Cell",
    "control_channel",
    "ControlChannel",
    "Event",
    "explain",
    "Explanation",
    "Hand",
    "HandOutcome",
    "HandState",
    "JointPositions",
    "JointVelocities",
    "model",
    "Log",
    "LogMeta",
    "MotionFault",
    "MotionResult",
    "Objects",
    "Robot",
    "RobotFault",
    "Robots",
    "RobotState",
    "run",
    "RunResult",
    "Scenario",
    "schema",
    "serve",
    "ServedRobot",
    "Session",
    "SessionResult",
    "Snapshot",
    "Status",
    "Table",
    "Torques",
    "Trajectory",
    "validate",
    "Violation",
]
