"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

from ._core import RobotFault, __version__
from . import _host as _host  # tells the module where its files are
from ._log import Log, LogMeta, Table

__all__ = ["Log", "LogMeta", "RobotFault", "Table", "__version__"]
