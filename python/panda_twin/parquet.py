"""Writes a log as Parquet, a file per table: python3 -m panda_twin.parquet run.mcap --out DIR."""

from __future__ import annotations

import os
import pathlib
import sys

from . import _core
from ._command import exit_code_of, log_parser, parse_log
from ._log import Log, _COLUMNS


def write(log: Log, folder: str | os.PathLike[str], columns: tuple[str, ...] = ()) -> list[pathlib.Path]:
    """Write the tables that have rows.

    Parameters
    ----------
    log
        What is written.
    folder
        Created if missing; files of the tables' names are replaced.
    columns
        Only these, of any table, with the table's time; all by default.

    Returns
    -------
    list of pathlib.Path
        The files, such as ``cycles.parquet``.

    Raises
    ------
    ImportError
        Without pyarrow: pip install 'panda-twin[log]'.
    ValueError
        For a column that no table has.
    """
    try:
        import pyarrow.parquet  # type: ignore[import-untyped]
    except ImportError as error:
        raise ImportError(f"Parquet needs pyarrow ({error}): pip install 'panda-twin[log]'") from None

    _core.check_log_columns(list(columns))
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    files = []
    for name in _COLUMNS:
        table = log.table(name)
        chosen = [column for column in table.names if column in columns]
        if (columns and not chosen) or len(table) == 0:
            continue
        names = list(dict.fromkeys([table.names[0], *chosen])) if columns else []
        file = folder / f"{name}.parquet"
        pyarrow.parquet.write_table(table.to_arrow(*names), file)
        files.append(file)
    return files


def main(arguments: list[str]) -> int:
    parser = log_parser("parquet", "Write a log as Parquet.")
    parser.add_argument("--columns", default="", help="only these, such as q,dq,q_c; each table keeps its time")
    options = parse_log(parser, "parquet", arguments)

    def work() -> None:
        for file in write(Log(options.log), options.out, tuple(filter(None, options.columns.split(",")))):
            print(file)

    return exit_code_of(work)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
