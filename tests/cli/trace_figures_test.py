#!/usr/bin/env python3
"""What scripts/trace makes of events: trace_figures_test.py SOURCE_TREE [unittest options]. Needs no LTTng."""

import json
import pathlib
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
SOURCE = pathlib.Path(sys.argv[1])
sys.path.insert(0, str(SOURCE / "scripts"))

from tracing import figures, report, session  # noqa: E402: found by the path above

LISTING = ('<command xmlns="https://lttng.org/xml/ns/lttng-mi"><channel><discarded_events>{}</discarded_events>'
           "<lost_packets>{}</lost_packets></channel></command>")


def cycle(message_id, read, d_EXT, thread=2):
    """The events of a state that is read at `read` us and answered d_EXT us later."""
    steps = (("read_begin", message_id - 1, read - 3), ("state_read", message_id, read),
             ("write_begin", message_id, read + d_EXT - 1), ("write_end", message_id, read + d_EXT))
    return [(at * 1000, event, 1, thread, number) for event, number, at in steps]


def motion_of(d_EXTs):
    """One of as many commands, 1 ms apart."""
    events = [event for i, d_EXT in enumerate(d_EXTs, 1) for event in cycle(i, 1000 * i, d_EXT)]
    [motion] = figures.motions_of(events)
    return motion


class MotionsTest(unittest.TestCase):
    def test_measures_from_the_end_of_the_read_to_the_end_of_the_write(self):
        told = figures.figures(motion_of(range(1, 101)))
        self.assertEqual(told["d_EXT"], {"median": 50_000, "p99": 99_000, "max": 100_000})
        self.assertEqual(told["write"], {"median": 1000, "p99": 1000, "max": 1000})
        self.assertEqual(told["read"], {"median": 3000, "p99": 3000, "max": 3000})
        self.assertEqual(told["read_to_read"], {"median": 1_000_000, "p99": 1_000_000, "max": 1_000_000})

    def test_counts_states_without_a_command_in_the_period_alone(self):
        [motion] = figures.motions_of([*cycle(1, 1000, 5), *cycle(2, 2000, 5)[:2], *cycle(3, 3100, 5)])
        self.assertEqual([command.message_id for command in motion.commands], [1, 3])
        self.assertEqual(motion.periods(), [1_000_000, 1_100_000])

    def test_begins_a_motion_where_ids_begin_anew_and_in_another_thread(self):
        events = [*cycle(7, 1000, 5), *cycle(8, 2000, 5), *cycle(1, 3000, 5), *cycle(2, 4000, 5, thread=3)]
        self.assertEqual([len(motion.commands) for motion in figures.motions_of(events)], [2, 1, 1])

    def test_leaves_out_a_write_that_never_ended(self):
        [motion] = figures.motions_of([*cycle(1, 1000, 5), *cycle(2, 2000, 5)[:3]])
        self.assertEqual(len(motion.commands), 1)

    def test_refuses_a_write_whose_read_is_missing(self):
        for missing in (1, 2):
            events = cycle(1, 1000, 5) + [event for i, event in enumerate(cycle(2, 2000, 5)) if i != missing]
            with self.assertRaisesRegex(figures.TraceFault, "message_id 2"):
                figures.motions_of(events)


class ComparisonTest(unittest.TestCase):
    def compare(self, log):
        motion = motion_of([20] * 200)
        return figures.compare(motion, log)

    def test_agrees_with_a_log_a_little_longer(self):
        compared = self.compare({i: 20_400 for i in range(1, 201)})
        self.assertEqual((compared.apart(), compared.commands_apart()), ([], []))

    def test_refuses_a_shifted_log(self):
        for shift in (5_001, -5_001):
            compared = self.compare({i: 20_000 + shift for i in range(1, 201)})
            self.assertEqual(compared.apart(), ["median", "p99", "max"])
            self.assertEqual(len(compared.commands_apart()), 200)

    def test_names_the_command_between_whose_readings_the_thread_was_interrupted(self):
        compared = self.compare({i: 20_000 if i != 17 else 60_000 for i in range(1, 201)})
        self.assertEqual((compared.apart(), compared.commands_apart()), (["max"], [17]))
        self.assertIn("message_id 17", "\n".join(compared.describe()))

    def test_refuses_other_commands(self):
        wanted = r"1 only in the trace \(message_id 200\), 1 only in the log \(message_id 0\)"
        with self.assertRaisesRegex(figures.TraceFault, wanted):
            self.compare({i: 20_000 for i in range(200)})

    def test_reads_of_a_log_the_commands_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            table = pathlib.Path(folder, "ticks.csv")
            table.write_text("read_ns,written_ns,message_id,action\n100,100,1,published\n1100,1150,2,written\n"
                             "2100,2100,3,skipped\n3100,3170,4,finished\n")
            self.assertEqual(figures.read_ticks(table, None), {2: 50, 4: 70})


class ReportTest(unittest.TestCase):
    """Two runs each of LF, RS and RA, in turn; the report tells the medians of the runs."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = pathlib.Path(folder.name)
        self.motions = [motion_of([d_EXT] * 100) for d_EXT in (10, 60, 12, 30, 70, 13)]

    def write(self, ours_us, seeds=2):
        rows = [{"quantity": f"{loop}, d_EXT, {what}", "ours": ours / 1000}
                for loop, ours in zip(("LF", "RS", "RA"), ours_us) for what in ("median", "p99", "max")]
        findings = {"seeds": seeds, "experiments": [{"id": "timings", "comparisons": rows}]}
        (self.out / "findings.json").write_text(json.dumps(findings))
        (self.out / "report.html").write_text('<h2 id="timings">T</h2><h3>first figure</h3><h3>second</h3>')

    def test_has_the_traces_figures_beside_its_own(self):
        self.write((10.4, 60.4, 12.4))
        self.assertEqual(report.add(self.out, self.motions), [])
        rows = json.loads((self.out / "findings.json").read_text())["experiments"][0]["comparisons"]
        self.assertEqual([row["lttng"] for row in rows], [0.010] * 3 + [0.060] * 3 + [0.012] * 3)
        page = (self.out / "report.html").read_text()
        self.assertIn("<td>RS, d_EXT, p99</td><td>60.4</td><td>60.0</td>", page)
        self.assertEqual(page.count("by LTTng"), 1)
        self.assertLess(page.index("by LTTng"), page.index("first figure"))

    def test_names_what_is_apart(self):
        self.write((10, 60, 17.1))
        apart = report.add(self.out, self.motions)
        self.assertEqual(apart, ["RA, d_EXT, median", "RA, d_EXT, p99", "RA, d_EXT, max"])

    def test_refuses_a_report_of_other_runs(self):
        self.write((10, 60, 12), seeds=3)
        with self.assertRaisesRegex(figures.TraceFault, "9 motions of its timings, and 6 were traced"):
            report.add(self.out, self.motions)

    def test_refuses_what_is_no_report_of_timings(self):
        with self.assertRaisesRegex(session.TraceError, "findings.json"):
            report.add(self.out, self.motions)


class ListingTest(unittest.TestCase):
    def test_counts_what_was_lost(self):
        self.assertEqual(session.lost_events(LISTING.format(0, 0)), 0)
        self.assertEqual(session.lost_events(LISTING.format(41, 1)), 42)

    def test_refuses_a_listing_that_does_not_tell(self):
        with self.assertRaises(session.TraceError):
            session.lost_events('<command xmlns="https://lttng.org/xml/ns/lttng-mi"/>')


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[2:]])
