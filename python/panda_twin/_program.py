"""The command panda-twin of an installed wheel: becomes the program that the package has with it."""

import os
import sys
from typing import NoReturn

from . import _host


def main() -> NoReturn:
    os.environ["PANDA_TWIN_MESHES"] = _host.meshes
    os.environ.setdefault("PANDA_TWIN_PYTHON", sys.executable)
    os.execv(_host.executable, sys.argv)
