"""A digital twin of the Franka Emika Panda and of its 1 kHz control stack."""

from ._core import RobotFault, __version__
from . import _host as _host  # tells the module where its files are
from . import model
from ._serve import ControlChannel, Event, ServedRobot, Status, control_channel, serve

__all__ = ["ControlChannel", "Event", "RobotFault", "ServedRobot", "Status", "__version__", "control_channel", "model", "serve"]
