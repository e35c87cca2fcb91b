"""The page of a comparison, section by section."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from .._demand import KINDS
from .._yaml import yaml_text
from . import _plots
from ._estimates import estimates_section
from ._html import Cell, Cells, Html, bullets, document, escaped, folded, h2, h3, p, pre, table
from ._sections import closed, external, timing, torques
from ._summary import headline, in_detail, number, percent, plain, untold_of, values_after, values_before

if TYPE_CHECKING:
    from .._demand import Item
    from .._result import Comparison, LogFacts

_JOINTS = range(7)
_JOINT_HEADS: list[str | Cell] = [f"joint {i + 1}" for i in _JOINTS]


def page(comparison: Comparison) -> str:
    """Return the page, which needs nothing beside it."""
    with _plots.style():
        parts = [
            *_head(comparison),
            *_verdict(comparison),
            *_causes(comparison),
            *estimates_section(comparison.identified),
            *_held_out(comparison),
            *_profile(comparison),
            *torques(comparison),
            *closed(comparison),
            *external(comparison),
            *timing(comparison),
            *_untold(comparison),
            *_logs(comparison),
        ]
    return document(headline(comparison), parts)


def _head(comparison: Comparison) -> list[Html]:
    css = "met" if comparison.passed else "missed" if any(item.is_met is False for item in comparison.items) else ""
    heading = Html(f'<h1 class="{css}">{headline(comparison)}</h1>')
    logs = ", ".join(log.name for log in comparison.logs) or "no log"
    parts = [heading, p(f"{logs} against the scenario {comparison.scenario.name}", "soft")]
    detail = in_detail(comparison)
    if detail:
        parts.append(p(detail))
    doubts = [(log.name, text) for log in comparison.logs for text in log.suspicions]
    if doubts:
        parts += [
            Html('<div class="doubt">'),
            p("The data may not be what they seem. Look at this first:"),
            bullets([f"{name}: {text}" for name, text in doubts]),
            Html("</div>"),
        ]
    return parts


def _verdict(comparison: Comparison) -> list[Html]:
    parts = [h2("What is demanded, and what was found")]
    before, after = values_before(comparison), values_after(comparison)
    items = {(item.kind, item.joint): item for item in comparison.items}
    kinds = [name for name, kind in KINDS.items() if kind.per_joint and (name in before or (name, 0) in items)]
    if kinds:
        parts += [
            _joint_table(kinds, before, after, items),
            p(
                "Each number is the root of the mean square over the log. "
                + " ".join(
                    f"{name.replace('_', ' ').capitalize()}: {KINDS[name].meaning.partition(', root')[0]}." for name in kinds
                ),
                "soft",
            ),
        ]
    whole = [item for item in comparison.items if item.joint is None]
    if whole:
        parts.append(
            table(
                [[Cell("of the whole robot"), "found", "at most", Cell("verdict", "word")]], [_whole_row(item) for item in whole]
            )
        )
    if not kinds and not whole:
        parts.append(p("Nothing is demanded, and the logs hold nothing that a demand could be held against."))
    return parts


def _joint_table(
    kinds: Sequence[str],
    before: dict[str, _plots.Array],
    after: dict[str, _plots.Array],
    items: dict[tuple[str, int | None], Item],
) -> Html:
    over: list[str | Cell] = [""]
    heads: list[str | Cell] = ["joint"]
    rows: list[list[str | Cell]] = [[str(i + 1)] for i in _JOINTS]
    for name in kinds:
        factor = KINDS[name].factor
        columns = ["as given", *(["identified"] if name in after else []), *(["at most"] if (name, 0) in items else [])]
        over.append(Cell(f"{name.replace('_', ' ')}, {KINDS[name].unit}", "over first", len(columns)))
        heads += [Cell(columns[0], "first"), *columns[1:]]
        for i in _JOINTS:
            item = items.get((name, i))
            rows[i].append(_judged(before[name][i] if name in before else math.nan, factor, item, "first"))
            if name in after:
                rows[i].append(_judged(after[name][i], factor, item))
            if (name, 0) in items:
                rows[i].append(number(item.demanded / factor) if item else "–")
    return table([over, heads], rows)


def _judged(value: float, factor: float, item: Item | None, css: str = "") -> Cell:
    if not math.isfinite(value):
        return Cell("not told", f"untold {css}".strip())
    verdict = "" if item is None else "met" if abs(value) <= item.demanded else "missed"
    return Cell(number(abs(value) / factor), f"{verdict} {css}".strip())


def _whole_row(item: Item) -> Cells:
    kind = KINDS[item.kind]
    verdict = (
        Cell("not told", "word untold")
        if item.is_met is None
        else Cell("met", "word met") if item.is_met else Cell("not met", "word missed")
    )
    found = "–" if item.is_met is None else f"{number(item.found / kind.factor)} {kind.unit}"
    return [f"{item.kind}: {kind.meaning}", found, f"{number(item.demanded / kind.factor)} {kind.unit}", verdict]


def _causes(comparison: Comparison) -> list[Html]:
    parts = [h2("What explains the difference of the torques")]
    if not comparison.causes:
        why = "the torques were not compared" if comparison.open is None else "nothing explains a part worth naming"
        return [*parts, p(f"No cause is named: {why}.")]
    for cause in comparison.causes[:3]:
        parts += [
            Html(f'<div class="cause"><b>{escaped(percent(cause.share))}</b><div>'),
            p(f"{cause.name[:1].upper()}{cause.name[1:]}: {cause.words.replace('+-', '±')}."),
            pre(cause.remedy),
            Html("</div></div>"),
        ]
    parts.append(
        p(
            "The percentages are shares of the squared torque residual. Each cause was fitted to what the ones above it leave; "
            "± gives 95 % intervals. A click into a box selects what to put into the scenario.",
            "soft",
        )
    )
    return parts


def _held_out(comparison: Comparison) -> list[Html]:
    identified = comparison.identified
    if identified is None:
        return []
    parts = [h3("Judged on parts of the log that did not fit")]
    if identified.held_out is None:
        return [
            *parts,
            p("Nothing was: the log is too short to fit on one part and to judge on another, or its torques fitted nothing."),
        ]
    before, after = identified.held_out
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = before / after
    rows: list[Cells] = [
        ["twin as given, Nm", *map(number, before)],
        ["twin identified, Nm", *map(number, after)],
        ["smaller by the factor", *(number(x, 2) for x in ratio)],
    ]
    return [
        *parts,
        table([["torque residual, root of the mean square", *_JOINT_HEADS]], rows),
        p("Five seconds fit, the next five judge, and so on.", "soft"),
    ]


def _profile(comparison: Comparison) -> list[Html]:
    scenario = (comparison.profile or {}).get("scenario")
    if not scenario:
        return []
    text = yaml_text(plain(scenario))
    return [
        p("With --write profile.yaml all of this goes into a profile, which a scenario takes by the line:"),
        pre("robot: {profile: profile.yaml}"),
        folded("The same as keys of a scenario", [pre(text)]),
    ]


def _untold(comparison: Comparison) -> list[Html]:
    parts = [h2("What the data cannot tell")]
    many = len(comparison.logs) > 1
    heads = [*(["log"] if many else []), "column that is missing", "what cannot be judged without it"]
    missing = [[*([log.name] if many else []), column, lost] for log in comparison.logs for column, lost in log.missing]
    untold = untold_of(comparison)
    if untold:
        parts.append(bullets(untold))
    if missing:
        parts.append(table([[Cell(head, "word") for head in heads]], [[Cell(text, "word") for text in row] for row in missing]))
    if not untold and not missing:
        parts.append(p("Nothing that was asked for is left open."))
    return parts


def _logs(comparison: Comparison) -> list[Html]:
    parts = [h2("How this report was made")]
    for i, log in enumerate(comparison.logs):
        parts += [*([h3(f"Log {i + 1}")] if len(comparison.logs) > 1 else []), table([], _facts(log))]
        if log.notes:
            parts.append(bullets(log.notes))
    description = comparison.scenario.description
    return [
        *parts,
        table([], [["twin", Cell(f"scenario {comparison.scenario.name}{': ' if description else ''}{description}", "word")]]),
    ]


def _facts(log: LogFacts) -> list[Cells]:
    return [
        [name, Cell(text, "word")]
        for name, text in (
            ("file", log.name),
            ("kind", log.kind),
            ("sha256", log.sha256 or "not told"),
            ("rows", str(log.rows)),
            ("seconds", number(log.seconds, 6)),
            ("cycles lost, late", f"{log.timing.lost}, {log.timing.late}"),
        )
    ]
