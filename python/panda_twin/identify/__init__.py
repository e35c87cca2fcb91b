"""Logs of real robots against the twin: what differs, why, and a profile that removes it.

`compare` needs scipy, and PyYAML for files: pip install 'panda-twin[identify]'.
"""

from ._compare import compare
from ._profile import write_profile
from ._recording import Block, Recording
from ._result import Comparison
from ._suspicions import suspicions
from ._timing import Timing

__all__ = ["Block", "Comparison", "Recording", "Timing", "compare", "suspicions", "write_profile"]
