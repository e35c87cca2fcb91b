"""Logs of real robots against the twin: what differs, why, and a profile that removes it.

It needs scipy, and more for some logs and for the report: pip install 'panda-twin[identify]'.
"""

from ._compare import compare
from ._profile import write_profile
from ._result import Comparison
from .logs._recording import Block, Recording
from .logs._suspicions import suspicions
from .logs._timing import Timing

__all__ = ["Block", "Comparison", "Recording", "Timing", "compare", "suspicions", "write_profile"]
