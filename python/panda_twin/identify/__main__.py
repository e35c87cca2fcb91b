"""python3 -m panda_twin.identify is panda-twin compare."""

import sys

from ._program import main

sys.exit(main(sys.argv[1:]))
