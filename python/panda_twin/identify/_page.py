"""The page of a comparison, section by section."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import yaml

from . import _plots
from ._demand import KINDS
from ._estimates import estimates_section
from ._html import Cell, Cells, Html, bullets, document, figure, folded, h2, h3, p, pre, table
from ._summary import headline, in_detail, interval, number, plain, untold_of, values_after, values_before

if TYPE_CHECKING:
    from ._demand import Item
    from ._result import Closed, Comparison, LogFacts

_JOINTS = range(7)
_JOINT_HEADS: list[str | Cell] = [f"joint {i + 1}" for i in _JOINTS]


def page(comparison: Comparison) -> str:
    """Return the page, which needs nothing beside it."""
    with _plots.style():
        parts = [*_head(comparison), *_verdict(comparison), *_causes(comparison), *estimates_section(comparison.identified), *_held_out(comparison),
                 *_profile(comparison), *_torques(comparison), *_closed(comparison), *_external(comparison), *_timing(comparison), *_untold(comparison),
                 *_logs(comparison)]
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
        parts += [Html('<div class="doubt">'), p("The data may not be what they seem. Look at this first:"),
                  bullets([f"{name}: {text}" for name, text in doubts]), Html("</div>")]
    return parts


def _verdict(comparison: Comparison) -> list[Html]:
    parts = [h2("What is demanded, and what was found")]
    before, after = values_before(comparison), values_after(comparison)
    items = {(item.kind, item.joint): item for item in comparison.items}
    kinds = [name for name, kind in KINDS.items() if kind.per_joint and (name in before or (name, 0) in items)]
    if kinds:
        parts += [_joint_table(kinds, before, after, items),
                  p("Each number is the root of the mean square over the log. " + " ".join(f"{name.replace('_', ' ').capitalize()}: {KINDS[name].meaning.partition(', root')[0]}."
                    for name in kinds), "soft")]
    whole = [item for item in comparison.items if item.joint is None]
    if whole:
        parts.append(table([[Cell("of the whole robot"), "found", "at most", Cell("verdict", "word")]], [_whole_row(item) for item in whole]))
    if not kinds and not whole:
        parts.append(p("Nothing is demanded, and the logs hold nothing that a demand could be held against."))
    return parts


def _joint_table(kinds: Sequence[str], before: dict[str, _plots.Array], after: dict[str, _plots.Array], items: dict[tuple[str, int | None], Item]) -> Html:
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
    verdict = Cell("not told", "word untold") if item.is_met is None else Cell("met", "word met") if item.is_met else Cell("not met", "word missed")
    found = "–" if item.is_met is None else f"{number(item.found / kind.factor)} {kind.unit}"
    return [f"{item.kind}: {kind.meaning}", found, f"{number(item.demanded / kind.factor)} {kind.unit}", verdict]


def _causes(comparison: Comparison) -> list[Html]:
    parts = [h2("What explains the difference of the torques")]
    if not comparison.causes:
        why = "the torques were not compared" if comparison.open is None else "nothing explains a part worth naming"
        return [*parts, p(f"No cause is named: {why}.")]
    for cause in comparison.causes[:3]:
        parts += [Html(f'<div class="cause"><b>{100 * cause.share:.0f} %</b><div>'), p(f"{cause.name[:1].upper()}{cause.name[1:]}: {cause.words.replace('+-', '±')}."),
                  pre(cause.remedy), Html("</div></div>")]
    parts.append(p("The percentages are shares of the squared torque residual. Each cause was fitted to what the ones above it leave; ± gives 95 % intervals. "
                   "A click into a box selects what to put into the scenario.", "soft"))
    return parts


def _held_out(comparison: Comparison) -> list[Html]:
    identified = comparison.identified
    if identified is None:
        return []
    parts = [h3("Judged on parts of the log that did not fit")]
    if identified.held_out is None:
        return [*parts, p("The log is too short to fit on one part and to judge on another.")]
    before, after = identified.held_out
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = before / after
    rows: list[Cells] = [["twin as given, Nm", *map(number, before)], ["twin identified, Nm", *map(number, after)],
                         ["smaller by the factor", *(number(x, 2) for x in ratio)]]
    return [*parts, table([["torque residual, root of the mean square", *_JOINT_HEADS]], rows),
            p("Five seconds fit, the next five judge, and so on.", "soft")]


def _profile(comparison: Comparison) -> list[Html]:
    scenario = (comparison.profile or {}).get("scenario")
    if not scenario:
        return []
    text = yaml.safe_dump(plain(scenario), sort_keys=False, default_flow_style=None, width=120, allow_unicode=True)
    return [p("With --write profile.yaml all of this goes into a profile, which a scenario takes by the line:"), pre("robot: {profile: profile.yaml}"),
            folded("The same as keys of a scenario", [pre(text)])]


def _torques(comparison: Comparison) -> list[Html]:
    parts = [h2("Torques on the measured motion")]
    found = comparison.open
    if found is None:
        return [*parts, p("The torques were not compared: the logs do not hold what that needs (positions and joint torques).")]
    if len(found.t) < 2 or not np.any(np.isfinite(found.before)):
        return [*parts, p("The logs hold too little motion to show anything of the torques.")]
    parts.append(p("Measured torque less the twin's inverse dynamics on the measured motion, after a low-pass of 20 Hz."
                   + ("" if found.after is not None else " Nothing was identified: there is no “after”.")))
    parts.append(figure(_plots.against_velocity(found), "Residual against velocity, Nm over rad/s. A step at zero is Coulomb friction, a slope viscous friction, "
                        "a shift an offset of the sensor. Lines are medians."))
    parts.append(figure(_plots.against_position(found), "Residual against position, Nm over rad. What varies with the position is gravity: masses, the load, a tilted base."))
    parts.append(figure(_plots.over_time(found), "Residual over time. Each curve shows the extremes of every part of the time."))
    spectrum = _plots.spectrum(found)
    parts.append(figure(spectrum, "Spectrum of the residual (Welch). Below some 5 Hz it is the model; what is flat above is noise of the sensors.") if spectrum
                 else p("No part of the log without a gap is long enough for a spectrum."))
    return parts


def _closed(comparison: Comparison) -> list[Html]:
    parts = [h2("Robot and twin under the same commands")]
    closed, after = comparison.closed, comparison.closed_after
    if closed is None:
        return [*parts, p("The logs were not replayed: they hold no commands that the twin could be given.")]
    rows = [row for name, one in (("twin as given", closed), ("twin identified", after)) if one is not None for row in _closed_rows(name, one)]
    same = "Every cycle is equal to the last bit." if closed.first_difference is None else f"The first cycle that differs in any bit is number {closed.first_difference}."
    parts += [p(f"{closed.cycles} cycles were replayed through the twin's robot control and plant. {same}"), table([["", *_JOINT_HEADS]], rows)]
    if len(closed.t) > 1 and np.any(np.isfinite(closed.position)):
        parts.append(figure(_plots.closed_over_time(closed, after), "Position of the robot less that of the twin, mrad over s. The grey curve is the same of q_d: it is the link's and "
                            "the controller's part, the rest is the body's."))
    else:
        parts.append(p("The replay is too short to be drawn."))
    parts.append(h3("Events"))
    parts.append(bullets(closed.events) if closed.events else p("Neither the robot nor the twin reported an error."))
    if after is not None and after.events != closed.events:
        parts += [p("With the identified twin:"), bullets(after.events) if after.events else p("No errors.")]
    return parts


def _closed_rows(name: str, closed: Closed) -> list[Cells]:
    return [[f"{name}: position, mrad (root of the mean square)", *(number(1e3 * x) for x in closed.position_rms)],
            [f"{name}: position, mrad (largest)", *(number(1e3 * x) for x in closed.position_largest)],
            [f"{name}: tau_J, Nm (root of the mean square)", *map(number, closed.torque_rms)]]


def _external(comparison: Comparison) -> list[Html]:
    parts = [h2("Estimates of external torque and wrench")]
    external = comparison.external
    if external is None:
        return [*parts, p("The robot's own estimates were not compared: the logs do not hold them.")]
    parts += [p(f"The robot's estimates less the twin's, both from the robot's torques, over {number(external.seconds)} s; root of the mean square."),
              table([["", *_JOINT_HEADS]], [["tau_ext_hat_filtered, Nm", *map(number, external.torque_rms)]])]
    if external.wrench_rms is None:
        return [*parts, p("The logs hold no wrench.")]
    wrench: list[str | Cell] = ["Fx, N", "Fy, N", "Fz, N", "Mx, Nm", "My, Nm", "Mz, Nm"]
    return [*parts, table([["in the base's axes", *wrench]], [["O_F_ext_hat_K", *map(number, external.wrench_rms)]])]


def _timing(comparison: Comparison) -> list[Html]:
    parts = [h2("Timing")]
    if not comparison.logs:
        return [*parts, p("No log, no times.")]
    rows: list[Cells] = []
    for i, log in enumerate(comparison.logs):
        t = log.timing
        held = sum(length * count for length, count in t.held.items())
        rows.append([f"log {i + 1}", Cell("the robot's message_id" if t.by == "message_id" else "stamps", "word"), number(t.median, 4), number(t.mean, 4), number(t.sd), number(t.longest, 4),
                     number(t.longest_at, 4), str(t.lost), str(t.late), str(t.repeated), number(100 * held / log.rows) if t.held and log.rows else "–"])
    heads: Cells = ["", Cell("times by", "word"), "median, ms", "mean, ms", "sd, ms", "longest, ms", "at, s", "lost", "late", "repeated", "held, %"]
    parts += [table([heads], rows), p("Lost: cycles that are not in the log. Late: intervals of a quarter of a period too much. Held: cycles without a command in time.", "soft")]
    unsorted = [f"log {i + 1}" for i, log in enumerate(comparison.logs) if not log.timing.sorted]
    if unsorted:
        parts.append(p(f"Rows were sorted by their stamps: {', '.join(unsorted)}."))
    drawn = _plots.timing([log.timing for log in comparison.logs], comparison.command_delay)
    parts.append(figure(drawn, "As far as the logs tell: cycles from a command to the state that shows it, intervals between rows, how many cycles in a row had no command "
                        "in time, and the robot's own success rate.") if drawn else p("The logs hold too few rows for distributions."))
    if comparison.command_delay is None:
        parts.append(p("The delay of commands cannot be told: the logs do not hold commands beside the states that show them."))
    if not any(log.timing.held for log in comparison.logs):
        parts.append(p("No cycle without a command is in the logs, or the logs do not say which those are."))
    return parts


def _untold(comparison: Comparison) -> list[Html]:
    parts = [h2("What the data cannot tell")]
    missing = [[log.name if len(comparison.logs) > 1 else "", column, Cell(lost, "word")] for log in comparison.logs for column, lost in log.missing]
    untold = untold_of(comparison)
    if untold:
        parts.append(bullets(untold))
    if missing:
        skip = 0 if len(comparison.logs) > 1 else 1
        heads: list[str | Cell] = ["log", Cell("column that is missing", "word"), Cell("what cannot be judged without it", "word")]
        parts.append(table([heads[skip:]], [[Cell(row[1], "word") if place == 1 else row[place] for place in range(skip, 3)] for row in missing]))
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
    return [*parts, table([], [["twin", Cell(f"scenario {comparison.scenario.name}{': ' if description else ''}{description}", "word")]])]


def _facts(log: LogFacts) -> list[Cells]:
    return [[name, Cell(text, "word")] for name, text in (
        ("file", log.name), ("kind", log.kind), ("sha256", log.sha256 or "not told"), ("rows", str(log.rows)), ("seconds", number(log.seconds, 6)),
        ("cycles lost, late", f"{log.timing.lost}, {log.timing.late}"))]
