#!/usr/bin/env python3
"""Mutants of the viability filter, and of the tool that finds its set a second time, and the tests that must catch them.

    check_mutants.py --source ROOT --build DIR [--quick] [--only NAME] [--all]

How: tests/support/mutants.py.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))

import mutants  # noqa: E402

# Program and arguments, cheapest first.
CATCHERS = [
    ("reference_tests", ["reference_viability_in_flight_test"]),
    ("reference_tests", ["reference_viable_twist_test"]),
    ("reference_tests", ["reference_viable_axis_test"]),
    ("reference_tests", ["polytope_test"]),
    ("reference_tests", ["fixed_point_test"]),
]

AXIS = "src/reference/viable_axis.cc"
FILTER = "src/reference/viability_filter.cc"
LATE = "src/reference/viability_in_flight.cc"
TWIST = "src/reference/viable_twist.cc"
POLYTOPE = "tests/reference/fixed_point/polytope.cc"
FIXED_POINT = "tests/reference/fixed_point/fixed_point.cc"

# name, file, text, its replacement
MUTANTS = [
    ("n one too small", AXIS, "const double n = lost_;", "const double n = std::max(lost_ - 1, 0);"),
    ("no look at the highest point within held cycles", AXIS,
     "if (ddq < 0 && dq > 0) {  // the", "if (false) {  // the"),
    ("that point taken a cycle late", AXIS, "std::floor(-dq / (kT * ddq))", "1 + std::floor(-dq / (kT * ddq))"),
    ("halving ends on the wrong side of the border", AXIS, "  return keeps;\n", "  return breaks;\n"),
    ("no condition on the speed", AXIS, "kept_.q_max && reach.dq <= kept_.dq_max;", "kept_.q_max;"),
    ("braking of 2 J on the worst way", AXIS, "std::max(ddq - kT * kept_.dddq_max,",
     "std::max(ddq - 2 * kT * kept_.dddq_max,"),
    ("acceleration not mirrored for the lower bounds", AXIS, ".dq = -x.dq, .ddq = -x.ddq}", ".dq = -x.dq, .ddq = x.ddq}"),
    ("limits kept a little outside, not inside", AXIS, "kInside = 1e-6;", "kInside = -1e-6;"),
    ("a range a tenth too small admitted", AXIS, "least_range_ = from_rest.q", "least_range_ = 0.9 * from_rest.q"),
    ("a range a tenth larger asked for", AXIS, "least_range_ = from_rest.q", "least_range_ = 1.1 * from_rest.q"),
    ("a speed admitted that losses gather", AXIS, "if (kept_.dq_max < gathered) {", "if (false) {"),
    ("by position: no look at held steps", AXIS, "    if (shrinks) reach.q = std::max(reach.q, q + NeedOfHeld(dq, ddq));\n", ""),
    ("by position: no look at commanded steps", AXIS, "    if (shrinks) reach.q = std::max(reach.q, q + NeedOfStep(dq));\n", ""),
    ("by position: no look within held steps", AXIS, "if (share <= -1) return most;", "return most;"),
    ("by position: the limit at a step's end", AXIS, "return kT * (i - 1) * (dq + step * i / 2)",
     "return kT * i * (dq + step * (i + 1) / 2)"),
    ("by position: a range admitted that is not enough", AXIS, "least_range_ = std::max(least_range_, still) + std::max(",
     "least_range_ = 0 * std::max("),
    ("what is admissible changed by rounding", FILTER, "if (jerk == wish) return {};", ""),
    ("late: a command need do in one of the states only", AXIS, "std::all_of", "std::any_of"),
    ("late: jerk and acceleration looked at in the first state only", AXIS, ": states.subspan(1)) {", ": states.first(0)) {"),
    ("late: the same jerk taken for all states", AXIS, "jerk + state.extra", "jerk"),
    ("late: the extra jerk of the wrong sign", LATE, ".extra = Command::Jerk(", ".extra = -Command::Jerk("),
    ("late: upper bounds not looked at again", AXIS, "if (!KeepsAll(Side::kUpper, states, jerk)) return {};", ""),
    ("late: what is in flight taken for arrived", LATE, "states_[count_++].x = held;", ""),
    ("late: what is in flight taken newest first", LATE, "for (const InFlight& cycle : since) {",
     "for (std::size_t c = since.size(); c-- > 0;) {\n      const InFlight& cycle = since[c];"),
    ("late: silent cycles not counted", LATE, "          state = held;\n        }", "        }"),
    ("late: the wish is sent where no command is admissible", LATE, "if (!c) return {};", "if (!c) continue;"),
    ("late: more in flight than told of is not noticed", LATE,
     "if (since.size() > static_cast<std::size_t>(in_flight_)) return {};", ""),
    ("late: silent cycles before a run forgotten", LATE, "(filter_.axis(0).lost() - in_flight_) /", "filter_.axis(0).lost() /"),
    ("poses: n one too small", TWIST, "velocity += lost_ * kT", "velocity += (lost_ - 1) * kT"),
    ("poses: no look at what braking gathers", TWIST, "return (v + a * (Gathered(acceleration) / acceleration)).norm() <= kept_.dp_max;",
     "return true;"),
    ("poses: no bound on the jerk", TWIST, "(a_c - a).norm() <= kT * kept_.dddp_max &&", ""),
    ("poses: the largest component for the speed's norm", TWIST, "&& v.norm() <= kept_.dp_max", "&& v.cwiseAbs().maxCoeff() <= kept_.dp_max"),
    ("poses: braking by half a step too little", TWIST, "(1 - step / acceleration)", "(1 - step / acceleration / 2)"),
    ("poses: halving ends on the wrong side", TWIST, "return braked + keeps * way;", "return braked + breaks * way;"),
    ("polytope: pairs of rows not combined", POLYTOPE, "if (from_above * from_below >= 0) continue;", "continue;"),
    ("polytope: a pair combined the wrong way round", POLYTOPE, "share * g + (1 - share) * h", "(1 - share) * g + share * h"),
    ("fixed point: a held cycle too few", FIXED_POINT, "i < lost; ++i) rows.", "i + 1 < lost; ++i) rows."),
]

QUICK = ["late: silent cycles not counted"]

if __name__ == "__main__":
    mutants.main(__doc__, "tests/reference", CATCHERS, MUTANTS, QUICK)
