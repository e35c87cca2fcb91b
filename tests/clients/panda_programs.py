"""Programs of a user of panda-python (libfranka 0.9.2): panda_programs.py NAME ADDRESS.

They know nothing of the twin. The last line they print is JSON: what the program saw. They take time from the robot
(states, controllers), as the wall clock does not tell it: a twin in lockstep is faster.
"""

import json
import sys

import panda_failures  # noqa: F401
import panda_interfaces  # noqa: F401
import panda_motions  # noqa: F401
import panda_vacuum  # noqa: F401
from panda_common import PROGRAMS

if __name__ == "__main__":
    name, address = sys.argv[1:]
    print(json.dumps(PROGRAMS[name](address)))
