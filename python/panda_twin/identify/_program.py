"""panda-twin compare: python3 -m panda_twin.identify LOG..."""

from __future__ import annotations

import argparse
import pathlib
import sys

import numpy as np

from .._command import exit_code_of


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="panda-twin compare", description="Compare a robot's log with the twin.")
    parser.add_argument("logs", nargs="+")
    parser.add_argument("--against", help="the twin: a scenario")
    parser.add_argument("--map", help="which columns of a table are which, with units (YAML)")
    parser.add_argument("--identify", default="", help="of friction, load, delay, elasticity, armature, inertia, with commas")
    parser.add_argument("--demand", help="what the twin must keep (YAML)")
    parser.add_argument("--write", help="profile of the identified robot")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/compare"), help="folder of the report")
    parser.add_argument("--quiet", action="store_true")
    return parser


def main(arguments: list[str]) -> int:
    """Run the command; returns its exit code."""
    options = _parser().parse_args(arguments)
    passed = False

    def work() -> None:
        nonlocal passed
        try:
            from ._compare import compare
            from ._profile import write_profile
            from .report._report import tell, write_report
        except ImportError as error:
            raise ImportError(f"{error}; compare needs numpy and scipy, matplotlib for its report, and PyYAML: pip install 'panda-twin[identify]'") from None
        if options.write and pathlib.Path(options.write).is_dir():
            raise ValueError(f"--write: {options.write} is a folder; name the file")
        kinds = [kind.strip() for kind in options.identify.split(",") if kind.strip()]
        if options.write and not kinds:
            raise ValueError("--write: a profile has what --identify finds; name it, as --identify friction,load,delay")
        try:
            found = compare(*options.logs, against=options.against, mapping=options.map, identify=kinds, demand=options.demand)
        except (ArithmeticError, LookupError, np.linalg.LinAlgError) as error:
            raise ValueError(f"{', '.join(options.logs)}: nothing can be computed from these numbers ({error}); look for absurd values in the log's columns") from None
        passed = found.passed
        report = write_report(found, options.out)
        if not options.quiet:
            print(tell(found))
            print(f"report   {report}")
        if options.write and found.profile is not None:
            written = write_profile(found.profile, options.write)
            if not options.quiet:
                print(f"profile  {written}")

    code = exit_code_of(work)
    if code == 1:  # which is the verdict's
        return 4
    return code if code else int(not passed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
