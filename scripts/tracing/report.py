"""LTTng's d_EXT beside a report's own: of `panda-twin experiment timings --drive realtime`."""

import json

from tracing import figures
from tracing.session import TraceError

LOOPS = ("LF", "RS", "RA")  # each run drives them in this order
BEFORE = "<h3>"  # the report's first figure


def by_loop(motions, runs):
    """{quantity: ms}: the median of the runs, as the report has it.

    @throws TraceFault when there are fewer motions than the report's timings have.
    """
    wanted = len(LOOPS) * runs
    if len(motions) < wanted:
        raise figures.TraceFault(f"the report has {wanted} motions of its timings, and {len(motions)} were traced")
    told = [figures.figures(motion)["d_EXT"] for motion in motions[:wanted]]
    return {f"{loop}, d_EXT, {what}": figures.percentile([run[what] for run in told[i::len(LOOPS)]], 0.5) / 1e6
            for i, loop in enumerate(LOOPS) for what, _ in figures.PERCENTILES}


def table(rows):
    """HTML. @param rows  (quantity, ours in ms, the trace's in ms)."""
    cells = "".join(f"<tr><td>{name}</td><td>{1000 * ours:.1f}</td><td>{1000 * traced:.1f}</td></tr>\n"
                    for name, ours, traced in rows)
    return ("<h3>The same by LTTng's tracepoints</h3>\n<table>\n<tr><th>quantity</th><th>ours [us]</th><th>traced [us]</th>"
            f"</tr>\n{cells}</table>\n")


def add(out, motions):
    """Puts the trace's figures into findings.json and report.html. @returns what is apart by more than the tolerance.

    @throws TraceError when there is no such report; TraceFault when it is of other motions.
    """
    try:
        findings = json.loads((out / "findings.json").read_text())
        page = (out / "report.html").read_text()
        [timings] = (one for one in findings["experiments"] if one["id"] == "timings")
        head, rest = page.split('<h2 id="timings">')
    except (OSError, ValueError) as error:
        raise TraceError(f"{out} has no findings.json and report.html of loop timings: {error}") from error
    ours = {row["quantity"]: row for row in timings["comparisons"]}
    rows = [(name, ours[name]["ours"], traced) for name, traced in by_loop(motions, findings["seeds"]).items()]
    for name, _, traced in rows:
        ours[name]["lttng"] = traced
    (out / "findings.json").write_text(json.dumps(findings, indent=2) + "\n")
    (out / "report.html").write_text(head + '<h2 id="timings">' + rest.replace(BEFORE, table(rows) + BEFORE, 1))
    return [name for name, own, traced in rows if abs(own - traced) * 1e6 > figures.TOLERANCE_NS]
