"""The report of a comparison: it renders whatever is absent, shows no NaN, escapes names, and its numbers are strict JSON."""

import dataclasses
import html.parser
import itertools
import json
import pathlib
import re
import sys
import tempfile
import time
import unittest

import numpy as np
from made_comparison import (
    made_closed,
    made_comparison,
    made_estimate,
    made_identified,
    made_log,
    made_open,
    made_timing,
    with_nan,
)

from panda_twin.identify.report import _plots, _summary
from panda_twin.identify._causes import Cause
from panda_twin.identify._demand import judge, read_demand
from panda_twin.identify._identify import Identified
from panda_twin.identify.report._report import tell, write_report
from panda_twin.identify._result import CommandDelay, External, Open
from panda_twin.identify._terms import Parameter

HOSTILE = "<script>alert('$x$')</script>&\x1b[31m\udcff.csv"


class Page(html.parser.HTMLParser):
    """The text that a reader sees, and the elements."""

    def __init__(self, text):
        super().__init__()
        self.text, self.elements, self.open, self.ids, self.links = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.elements.append(tag)
        self.ids += [value for name, value in attributes if name == "id"]
        self.links += [value for name, value in attributes if name in ("href", "src", "xlink:href")]
        if tag not in ("meta", "br"):
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        if tag != "meta":
            assert self.open.pop() == tag, tag

    def handle_data(self, text):
        if "style" not in self.open:
            self.text.append(text)


class ReportTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="panda_twin_test_")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name) / "deep/out"

    def report(self, comparison):
        """Write the report, check what holds for every one, and return the page and the summary."""
        path = write_report(comparison, self.folder)
        self.assertEqual(sorted(one.name for one in self.folder.iterdir()), ["report.html", "summary.json"])
        text = path.read_text(encoding="utf-8")
        page = Page(text)
        self.assertEqual(page.open, [])
        self.assertEqual(len(page.ids), len(set(page.ids)))
        self.assertNotIn("script", page.elements)
        self.assertEqual([link for link in page.links if not link.startswith(("#", "data:image/png;base64,"))], [])
        self.assertTrue({link[1:] for link in page.links if link.startswith("#")} <= set(page.ids))
        told = tell(comparison)
        self.assertLessEqual(len(told.splitlines()), 40)
        for shown in (" ".join(page.text), told):
            self.assertIsNone(
                re.search(
                    r"\b(nan|none|inf)\b|\[\]|\{\}|Infinity", re.sub(r"misses none|: none of \d", "", shown), re.IGNORECASE
                ),
                shown,
            )

        def refuse(constant):
            raise AssertionError(constant)

        return text, page, json.loads((self.folder / "summary.json").read_text(encoding="utf-8"), parse_constant=refuse), told

    def test_whole(self):
        comparison = made_comparison()
        begin = time.process_time()
        text, page, numbers, told = self.report(comparison)
        self.assertLess(len(text), 1_500_000)
        self.assertLess(time.process_time() - begin, 12)  # 1.5 s on a quiet host
        self.assertEqual(page.elements.count("svg"), 6)
        bad = sum(item.is_met is False for item in comparison.items)
        verdict = f"The twin is not the robot: {bad} of {len(comparison.items)} demands are not met"
        self.assertIn(verdict, text)
        self.assertTrue(told.startswith(verdict))
        self.assertEqual((numbers["verdict"], numbers["passed"]), (verdict, False))
        for cause in comparison.causes:
            self.assertIn(cause.remedy, told)
        self.assertEqual([item["found"] for item in numbers["items"] if item["kind"] == "lost"], [None])
        coulomb = next(one for one in numbers["estimates"] if one["key"] == "plant.friction.coulomb[2]")
        self.assertEqual(coulomb["group"], "friction")
        np.testing.assert_allclose(coulomb["interval"], [0.62 - 1.959964 * 0.004, 0.62 + 1.959964 * 0.004])
        self.assertIn("0.620 ± 0.008", text)
        self.assertNotIn("mathdefault", text)
        self.assertIn(">0.003<", text)  # a tick of the spectra
        self.assertLess(numbers["residual"]["after"][2], numbers["residual"]["before"][2])
        self.assertEqual(numbers["logs"][0]["timing"]["held_runs"], {"1": 90, "2": 40, "3": 11, "5": 2})

    def test_is_the_same_again(self):
        self.assertEqual(self.report(made_comparison())[0], self.report(made_comparison())[0])

    def test_parts_may_be_absent(self):
        """All combinations of parts that are there, absent, or without a joint."""
        absent = {
            "open": (made_open(200), None),
            "identified": (made_identified(), None),
            "closed": (made_closed(1), None),
            "rest": (
                {},
                {
                    "external": None,
                    "command_delay": None,
                    "causes": [],
                    "untold": [],
                    "profile": None,
                    "closed_after": None,
                    "logs": [],
                    "items": [],
                },
            ),
        }
        for values in itertools.product(*absent.values()):
            changes = dict(zip(absent, values))
            changes |= changes.pop("rest")
            with self.subTest({name: value is not None for name, value in changes.items()}):
                comparison = made_comparison(**changes, found={})
                page = self.report(comparison)[1]
                text = " ".join(page.text)
                for part, sentence in (
                    ("open", "The torques were not compared"),
                    ("identified", "no --identify was given"),
                    ("closed", "The logs were not replayed"),
                ):
                    self.assertEqual(sentence in text, changes[part] is None)

    def test_parts_may_be_empty_or_not_told(self):
        empty = np.zeros((0, 7))
        nothing = Open(np.zeros(0), empty, empty, empty, empty, empty)
        few = dataclasses.replace(
            made_closed(1), t=np.zeros(0), position=empty, reference=empty, events=[], first_difference=None
        )
        untimed = made_timing(
            intervals=(np.linspace(0, 2, 41), np.zeros(40, np.int64)),
            held={},
            success=None,
            sorted=False,
            sd=np.nan,
            longest=np.nan,
            by="time",
        )
        log = made_log(timing=untimed, missing=[], notes=[], suspicions=[], rows=0, seconds=np.nan, sha256="")
        no_estimate = Identified([], None, None, None, None, np.full(7, np.inf), None, None, [])
        for changes in (
            {"open": nothing, "closed": few},
            {"open": dataclasses.replace(made_open(3), after=None)},
            {"open": with_nan(made_open()), "closed": with_nan(made_closed(1))},
            {"logs": [log], "command_delay": None, "identified": no_estimate},
            {"command_delay": CommandDelay(np.zeros(0), np.zeros(0), 1)},
            {"external": External(np.full(7, np.nan), None, 0.0)},
            {"open": dataclasses.replace(made_open(), before=np.full((3000, 7), np.nan))},
            {"open": dataclasses.replace(made_open(), before=np.zeros((3000, 7)), after=None)},
            {"logs": [made_log(), log, *[made_log()] * 6]},
        ):
            with self.subTest(str(changes)[:300]):
                self.report(made_comparison(**changes))

    def test_verdicts(self):
        demand = read_demand(None)
        good = {name: np.zeros_like(most) for name, most in demand.items()}
        part = {**good, "delay": np.array([np.nan])}
        bad = {**good, "delay": np.array([-0.004])}
        for found, verdict, css in (
            (good, "The twin is the robot, as demanded", "met"),
            (part, "The twin is the robot, as demanded", "met"),
            (bad, "The twin is not the robot: 1 of 15 demands is not met", "missed"),
            ({}, "The data cannot tell whether the twin is the robot: none of 15 demands can be judged", ""),
        ):
            comparison = made_comparison(items=judge(demand, found))
            with self.subTest(verdict):
                self.assertIn(f'<h1 class="{css}">{verdict}</h1>', self.report(comparison)[0])
        self.assertIn("1 cannot be judged", _summary.in_detail(made_comparison(items=judge(demand, part))))

    def test_numbers(self):
        for value, sd, text in (
            (0.5461, 0.0063, "0.546 ± 0.012"),
            (0.5461, 0.002, "0.546 ± 0.004"),
            (-1e-5, 0.002, "0.000 ± 0.004"),
            (14250.0, 300.0, "14250 ± 588"),
            (0.5, 0.0, "0.5"),
            (np.nan, 0.1, "not told"),
        ):
            self.assertEqual(_summary.interval(value, sd), text)
        self.assertEqual([_summary.number(x) for x in (14285.7, 0.04, np.inf, None)], ["14300", "0.04", "–", "–"])
        self.assertEqual([_summary.percent(x) for x in (0.001, 0.41, 1.0)], ["<1 %", "41 %", "100 %"])

    def test_names_are_escaped(self):
        log = made_log(
            name=HOSTILE, kind=HOSTILE, sha256=HOSTILE, missing=[(HOSTILE, HOSTILE)], notes=[HOSTILE], suspicions=[HOSTILE]
        )
        closed = dataclasses.replace(made_closed(1), events=[HOSTILE])
        estimate = made_estimate([Parameter("other", HOSTILE, HOSTILE, 1.0)], [1.0], [0.1])
        identified = dataclasses.replace(made_identified(), estimates=[estimate], untold=[HOSTILE])
        comparison = made_comparison(
            logs=[log, log],
            closed=closed,
            identified=identified,
            causes=[Cause(HOSTILE, HOSTILE, HOSTILE, 1.0)],
            untold=[HOSTILE],
            profile={"scenario": {HOSTILE: HOSTILE}},
        )
        text, page, numbers, told = self.report(comparison)
        self.assertNotIn("<script", text)
        self.assertIn("&lt;script&gt;", text)
        self.assertTrue("".join(told.split("\n")).isprintable())
        self.assertIn("<script>", numbers["logs"][0]["name"])

    def test_long_lists_are_cut_for_the_terminal(self):
        demand = {**read_demand(None), **read_demand({"torque": "0.01 Nm", "external_torque": "0.01 Nm"})}
        items = judge(demand, {name: most * 2 for name, most in demand.items()})
        log = made_log(suspicions=["line\nof two" + "x" * 500] * 20)
        closed = dataclasses.replace(made_closed(1), events=["robot: reflex"] * 50)
        told = self.report(made_comparison(items=items, logs=[log] * 3, closed=closed, untold=[f"thing {i}" for i in range(60)]))[
            3
        ]
        self.assertIn("more", told)
        self.assertLessEqual(max(map(len, told.splitlines())), 240)

    def test_files_come_whole_or_not_at_all(self):
        self.report(made_comparison())
        before = {one.name: one.read_bytes() for one in self.folder.iterdir()}
        with self.assertRaises(TypeError):
            write_report(made_comparison(open=dataclasses.replace(made_open(), q=None)), self.folder)
        self.assertEqual({one.name: one.read_bytes() for one in self.folder.iterdir()}, before)
        (self.folder / "report.html").unlink()
        (self.folder / "report.html").mkdir()
        with self.assertRaises(OSError):
            write_report(made_comparison(), self.folder)
        self.assertEqual(sorted(one.name for one in self.folder.iterdir()), ["report.html", "summary.json"])

    def test_an_hour_is_drawn_in_time(self):
        found = made_open(180_000)
        begin = time.process_time()
        with _plots.style():
            sizes = [
                len(draw(found)) for draw in (_plots.against_velocity, _plots.against_position, _plots.over_time, _plots.spectrum)
            ]
        self.assertLess(time.process_time() - begin, 12)
        self.assertLess(sum(sizes), 1_200_000)


if __name__ == "__main__":
    if len(sys.argv) == 3 and sys.argv[1] == "--write":  # to look at
        print(tell(made_comparison()))
        print(write_report(made_comparison(), pathlib.Path(sys.argv[2])))
    else:
        unittest.main()
