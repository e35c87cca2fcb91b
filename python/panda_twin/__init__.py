"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

from . import _core
from . import _host as _host  # tells the module where its files are
from ._errors import RobotFault
from ._results import Explanation, RunResult, explain
from ._run import run
from .scenario import Scenario, schema, validate

__version__ = _core.version()

__all__ = ["Explanation", "RobotFault", "RunResult", "Scenario", "__version__", "explain", "run", "schema", "validate"]
