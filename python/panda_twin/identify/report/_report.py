"""The report of `panda-twin compare`: a page for people, numbers for programs, a summary for the terminal."""

from __future__ import annotations

import json
import pathlib
from typing import TYPE_CHECKING

from ..._whole_files import write_whole
from ._summary import headline, in_detail, number, percent, summary, untold_of, values_after, values_before

if TYPE_CHECKING:
    from .._result import Comparison

_WIDTH = 240


def write_report(comparison: Comparison, folder: pathlib.Path) -> pathlib.Path:
    """Write report.html, which needs nothing beside it, and summary.json into a folder, which is made; each whole or not at all.

    Returns
    -------
    pathlib.Path
        Of report.html.

    Raises
    ------
    OSError
        If the folder cannot be written; what was there before is left as it was.
    """
    from ._page import page  # with matplotlib, which a comparison without a report needs not

    texts = {
        "summary.json": json.dumps(summary(comparison), indent=1, ensure_ascii=False, allow_nan=False) + "\n",
        "report.html": page(comparison),
    }
    write_whole(folder, texts)
    return folder / "report.html"


def tell(comparison: Comparison) -> str:
    """Return the summary for the terminal: at most 40 lines."""
    lines = [headline(comparison) + ".", in_detail(comparison)]
    lines += _some("Doubts:", [f"{log.name}: {text}" for log in comparison.logs for text in log.suspicions], 4)
    lines += _some("Not met:", [item.words for item in comparison.items if item.is_met is False], 9)
    for place, cause in enumerate(comparison.causes[:3], 1):
        lines += ["Largest causes of the torque residual:"] if place == 1 else []
        lines += [f"  {place}. {cause.name}, {percent(cause.share)}: {cause.words}", f"     {cause.remedy}"]
    lines += _residuals(comparison)
    if comparison.closed is not None:
        lines += _some("Under the same commands:", [*_difference(comparison), *comparison.closed.events], 4)
    lines += _some("The data cannot tell:", untold_of(comparison), 4)
    return "\n".join(_one_line(line) for line in lines if line.strip())


def _some(title: str, lines: list[str], most: int) -> list[str]:
    """A list under its title, of at most so many lines beside it."""
    if not lines:
        return []
    shown = lines if len(lines) <= most else [*lines[: most - 1], f"and {len(lines) - most + 1} more"]
    return [title, *(f"  {line}" for line in shown)]


def _residuals(comparison: Comparison) -> list[str]:
    held_out = comparison.identified.held_out if comparison.identified else None
    rows = [("twin as given", values_before(comparison).get("torque")), ("identified", values_after(comparison).get("torque"))]
    if held_out is not None:
        rows += [("on parts not fitted, as given", held_out[0]), ("on parts not fitted, identified", held_out[1])]
    told = [f"  {name:<31}" + "".join(f"{number(value):>9}" for value in values) for name, values in rows if values is not None]
    return ["Torque residual of joints 1 to 7, Nm:", *told] if told else []


def _difference(comparison: Comparison) -> list[str]:
    closed, after = comparison.closed, comparison.closed_after
    assert closed is not None
    lines = [
        f"{name}: positions differ by {', '.join(number(1e3 * x) for x in found.position_rms)} mrad (root of the mean square)"
        for name, found in (("twin as given", closed), ("identified", after))
        if found is not None
    ]
    return lines if closed.first_difference is not None else ["every cycle is equal to the last bit", *lines[1:]]


def _one_line(text: str) -> str:
    """A text without what would move a terminal's cursor."""
    line = "".join(c if c.isprintable() else " " for c in text).rstrip()
    return line if len(line) <= _WIDTH else line[: _WIDTH - 1] + "…"
