"""Logs of real robots against the twin."""

from ._recording import Block, Recording
from ._timing import Timing

__all__ = ["Block", "Recording", "Timing"]
