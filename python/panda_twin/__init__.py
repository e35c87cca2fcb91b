"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

from . import _core
from . import _host as _host  # tells the module where its files are
from . import model
from ._errors import RobotFault
from ._results import Explanation, RunResult, explain
from ._run import run
from ._serve import ControlChannel, Event, ServedRobot, Status, control_channel, serve
from .scenario import Scenario, schema, validate

__version__ = _core.version()

__all__ = [
    "ControlChannel",
    "Event",
    "Explanation",
    "RobotFault",
    "RunResult",
    "Scenario",
    "ServedRobot",
    "Status",
    "__version__",
    "control_channel",
    "explain",
    "model",
    "run",
    "schema",
    "serve",
    "validate",
]
