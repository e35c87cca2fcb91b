"""The program's commands `sweep run` and `sweep merge` where they need Python: engines, object stores, Parquet."""

from __future__ import annotations

import argparse
import importlib.util
import sys

from .._command import exit_code_of
from . import merge, run


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python3 -m panda_twin.sweep", description="Sweeps; panda-twin sweep --help explains them.")
    commands = parser.add_subparsers(dest="command", required=True)
    for name, text in (("run", "carry out the runs whose results are not there yet"), ("merge", "write the tables and the report")):
        command = commands.add_parser(name, help=text)
        command.add_argument("file", help="sweep file")
        command.add_argument("--out", default="", help="folder of results, or s3://BUCKET/PATH")
        command.add_argument("--data", default="", help="folder of models")
        command.add_argument("--meshes", default="", help="folder panda_description")
        command.add_argument("-q", "--quiet", action="store_true", help="no progress and no summary")
    running = commands.choices["run"]
    running.add_argument("--on", default="", help="ray, or ray://HOST:PORT")
    running.add_argument("--shard", default="", help="this share of the runs only, such as 3/64")
    running.add_argument("--shards", type=int, help="tasks of --on")
    running.add_argument("--jobs", type=int, help="processes")
    running.add_argument("--yes", action="store_true", help="carry out more than a million runs")
    return parser


def main(arguments: list[str]) -> int:
    """Carries out a command; returns the exit code, which is as the program's."""
    options = vars(_parser().parse_args(arguments))
    command, quiet = options.pop("command"), options.pop("quiet")

    def work() -> None:
        if command == "run":
            return run(shows=not quiet, **options)
        if importlib.util.find_spec("pyarrow") is None:
            raise ImportError("runs.parquet needs pyarrow: pip install 'panda-twin[sweep]'")
        merged = merge(shows=not quiet, **options)
        if not quiet:
            print(f"runs    {merged.runs}, {merged.failures} failed\nreport  {merged.out}/report.html")
        print(f"digest  {merged.digest}")

    return exit_code_of(work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
