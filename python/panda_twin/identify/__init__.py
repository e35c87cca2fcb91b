"""Logs of real robots against the twin."""

from ._recording import Block, Recording
from ._suspicions import suspicions
from ._timing import Timing

__all__ = ["Block", "Recording", "suspicions", "Timing"]
