"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

import importlib.util

from ._core import RobotFault, __version__
from . import _host as _host  # tells the module where its files are

if importlib.util.find_spec("gymnasium") is not None:
    from . import envs as envs  # registers the environments

__all__ = ["RobotFault", "__version__"]
