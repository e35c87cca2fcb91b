#include "campaign/client_world.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>

#include "campaign/goal_world.h"
#include "campaign/session_world.h"
#include "conformance/dice.h"
#include "conformance/motion_course.h"
#include "conformance/stream_runner.h"
#include "contract/served_harness.h"
#include "twin/core/error.h"
#include "twin/core/hash.h"

namespace twin::campaign {
namespace {

using test::Mischief;
using test::StreamPlan;

bool IsSessionWorld(std::uint64_t seed) {
  return seed % 32 == 21;
}

/// A robot in lockstep waits for the answer to each state, so that none can be left out or
/// replaced, and takes a datagram with NaN for none. States while it stops are not waited for, and
/// its buttons are out of a client's reach.
bool FitsTheWire(const test::Disturbance& disturbance) {
  switch (disturbance.mischief) {
    case Mischief::kLoss:
    case Mischief::kDouble:
    case Mischief::kWrongId:
    case Mischief::kNotANumber:
    case Mischief::kInfinite:
    case Mischief::kStop:
    case Mischief::kPanel: return false;
    case Mischief::kBadFrame: return disturbance.count % 5 != 4;
    default: return true;
  }
}

StreamPlan DrawWirePlan(std::uint64_t seed) {
  StreamPlan plan = test::DrawPlan(seed);
  std::erase_if(plan.disturbances, [](const auto& one) { return !FitsTheWire(one); });
  plan.waiting_cycles = 0;
  plan.idle_cycles = 0;
  plan.answers_idle = false;
  plan.goes_on = false;
  plan.end = test::StreamEnd::kFinish;
  return plan;
}

struct Course {
  test::StreamResult result;
  test::MotionCourse motion;
};

Course Run(const StreamPlan& plan, bool over_the_wire) {
  std::vector<RobotState> all;
  test::HarnessCase harness;
  harness.make = [&](const robot::RobotConfig& robot) {
    std::unique_ptr<test::BackendHarness> inner;
    if (over_the_wire) {
      inner = test::MakeServedHarness(robot, backend::RobotTime::kStates, true);
    } else {
      const auto cases = test::Harnesses();
      inner =
          std::ranges::find(cases, robot.plant_kind, &test::HarnessCase::plant_kind)->make(robot);
    }
    return std::make_unique<test::NotingHarness>(std::move(inner), all);
  };
  Course course;
  course.result = RunStream(plan, harness, !over_the_wire);
  course.motion = test::CourseOf(all);
  return course;
}

/// Of a plan with all that can only be done in process: lost and doubled commands, wrong ids,
/// values that are no numbers.
std::optional<Finding> RunInProcess(const StreamPlan& plan) {
  const Course here = Run(plan, false);
  if (!here.result.finding) return std::nullopt;
  return Finding{"specification", "of all disturbances: " + *here.result.finding};
}

std::uint64_t HashOf(const std::vector<RobotState>& states) {
  WordHash hash;
  for (const RobotState& state : states) {
    hash.AddNumbers(state.q_d.data(), kJoints);
  }
  return hash.value();
}

RobotErrors ErrorsOf(const Course& course) {
  const std::vector<RobotState>& states = course.motion.states;
  return states.empty() ? RobotErrors() : states.back().reflex_reason;
}

Outcome RunStreamWorld(const StreamPlan& plan) {
  Outcome outcome;
  try {
    const Course here = Run(plan, false);
    outcome.cycles = here.result.cycles;
    outcome.states_hash = HashOf(here.motion.states);
    outcome.end = here.result.aborted ? "stream: " + FormatErrors(here.result.errors) : "stream";
    if (here.result.finding) {
      outcome.finding = Finding{"specification", *here.result.finding};
      return outcome;
    }
    const Course there = Run(plan, true);
    if (here.result.started != there.result.started || ErrorsOf(here) != ErrorsOf(there)) {
      outcome.finding =
          Finding{"wire", fmt::format("in process {}, over the wire {}",
                                      FormatErrors(ErrorsOf(here)), FormatErrors(ErrorsOf(there)))};
    } else if (here.motion.is_over && here.motion.states.size() <= test::kUncommanded) {
      // Over before its first command: nobody waits for the client to read its first state.
    } else if (const auto difference = FindDifference(here.motion, there.motion)) {
      outcome.finding = Finding{"wire", *difference};
    }
  } catch (const std::exception& error) {
    outcome.finding = Finding{"errors", error.what()};
  }
  return outcome;
}

}  // namespace

bool IsClientWorld(std::uint64_t seed) {
  return seed % 16 == 5 || IsGoalWorld(seed);
}

Outcome RunClientWorld(std::uint64_t seed, const run::Catalogue& catalogue,
                       const run::RunFiles& files) {
  if (IsGoalWorld(seed)) return RunGoalWorld(seed, catalogue, files);
  if (IsSessionWorld(seed)) return RunSessionWorld(seed, files);
  Outcome outcome = RunStreamWorld(DrawWirePlan(seed));
  if (!outcome.finding) outcome.finding = RunInProcess(test::DrawPlan(seed));
  return outcome;
}

std::string DescribeClientWorld(std::uint64_t seed) {
  if (IsGoalWorld(seed)) return fmt::format("world {}: a client's goals, or stream\n", seed);
  if (IsSessionWorld(seed)) return fmt::format("world {}: sessions of clients\n", seed);
  return Describe(DrawWirePlan(seed));
}

std::string ShrinkClientWorld(std::uint64_t seed, std::string_view invariant) {
  if (IsSessionWorld(seed) || IsGoalWorld(seed)) return DescribeClientWorld(seed);
  const bool is_of_wire = RunStreamWorld(DrawWirePlan(seed)).finding.has_value();
  return Describe(test::Shrink(
      is_of_wire ? DrawWirePlan(seed) : test::DrawPlan(seed), [&](const StreamPlan& less) {
        const auto finding = is_of_wire ? RunStreamWorld(less).finding : RunInProcess(less);
        return finding && finding->invariant == invariant;
      }));
}

}  // namespace twin::campaign
