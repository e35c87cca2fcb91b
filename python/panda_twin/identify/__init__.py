"""Logs of real robots against the twin: what differs, why, and a profile that removes it."""

from ._recording import Block, Recording
from ._timing import Timing

__all__ = ["Block", "Recording", "Timing"]
