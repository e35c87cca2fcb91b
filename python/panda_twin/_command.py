"""What commands of modules, python3 -m panda_twin.X, have in common: messages and exit codes are the program's."""

from __future__ import annotations

import argparse
import pathlib
import sys
from collections.abc import Callable


def exit_code_of(work: Callable[[], None], interrupted: str = "interrupted") -> int:
    """Do it; tell what it raises in one line. `interrupted`: what Ctrl-C says."""
    try:
        work()
        return 0
    except KeyboardInterrupt:
        code, text = 130, interrupted
    except (ValueError, TypeError) as error:
        code, text = 3, str(error)
    except (OSError, ImportError) as error:
        code, text = 4, str(error)
    except RuntimeError as error:
        code, text = 1, str(error)
    print(f"panda-twin: error: {text}", file=sys.stderr)
    return code


def log_parser(module: str, description: str) -> argparse.ArgumentParser:
    """Of a command that writes a log in another form, into a folder that is named like the module unless --out says another."""
    parser = argparse.ArgumentParser(prog=f"python3 -m panda_twin.{module}", description=description)
    parser.add_argument("log", type=pathlib.Path, help="log of a run (run.mcap), or its folder of results")
    parser.add_argument("--out", type=pathlib.Path, help=f"folder (default: {module} beside the log)")
    return parser


def parse_log(parser: argparse.ArgumentParser, module: str, arguments: list[str]) -> argparse.Namespace:
    """With `out` as given, else beside the log."""
    options = parser.parse_args(arguments)
    options.out = options.out or (options.log if options.log.is_dir() else options.log.parent) / module
    return options
