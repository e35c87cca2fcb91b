#include "report/plan_facts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "twin/core/time.h"

namespace twin::report {
namespace {

/// From here on the jerk of noise, 8 a / T^3, is above the robot's limits. rad or m.
constexpr double kLargeNoise = 1e-6;
/// Above what delays and the lag of a tracking arm make. rad.
constexpr double kLargeDeviation = 0.05;

struct KeptBack {
  std::uint64_t changed = 0;
  std::uint64_t commands = 0;  ///< that passed the filter

  [[nodiscard]] bool is_most() const { return 2 * changed > commands; }
};

KeptBack CountKeptBack(const RunEnd& end) {
  KeptBack count;
  for (const EndCycle& cycle : end.cycles) {
    if (!cycle.written() || !cycle.answer->margin) continue;
    ++count.commands;
    count.changed += cycle.answer->kept_back != 0 ? 1 : 0;
  }
  return count;
}

struct JointDeviation {
  std::size_t joint = 0;
  double value = 0;  ///< rad
};

/// The largest in the last cycle that has a target in joint space.
JointDeviation LastDeviation(const RunEnd& end) {
  JointDeviation largest;
  for (auto cycle = end.cycles.rbegin(); cycle != end.cycles.rend(); ++cycle) {
    if (!cycle->answer) continue;
    const JointVector& target = cycle->answer->q_ext;
    if (std::ranges::all_of(target, [](double q) { return q == 0; })) continue;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const double value = std::abs(target[i] - cycle->cycle.state.q[i]);
      if (value > largest.value) largest = {i, value};
    }
    break;
  }
  return largest;
}

bool IsNoisy(const std::optional<ScenarioFacts>& facts) {
  return facts && facts->target_noise > kLargeNoise;
}

std::string NoiseText(const ScenarioFacts& facts) {
  return fmt::format(
      "the scenario adds noise of up to {:.3g} to every target (controller.target_noise)",
      facts.target_noise);
}

std::string KeptBackText(std::uint64_t changed, std::string_view of) {
  return fmt::format(
      "the viability filter changed {} of {} commands: they kept the limits, and did not follow the "
      "targets.",
      changed, of);
}

/// Derivative of positions or torques that an error limits; 0: none.
int OrderOf(RobotError error) {
  switch (error) {
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation:
    case RobotError::kCartesianMotionGeneratorVelocityLimitsViolation:
    case RobotError::kControllerTorqueDiscontinuity: return 1;
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity:
    case RobotError::kCartesianMotionGeneratorVelocityDiscontinuity: return 2;
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity:
    case RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity: return 3;
    default: return 0;
  }
}

}  // namespace

std::string TellNoise(const RunEnd& end, const Violation& v, const ScenarioFacts& facts) {
  if (!(facts.target_noise > 0)) return "";
  const MotionGeneratorMode mode = end.before().state.motion_generator_mode;
  const bool by_velocity = mode == MotionGeneratorMode::kJointVelocity ||
                           mode == MotionGeneratorMode::kCartesianVelocity;
  const bool by_torque = v.error == RobotError::kControllerTorqueDiscontinuity;
  const int order = OrderOf(v.error) - (by_velocity && !by_torque ? 1 : 0);
  // A difference of two values is at most twice the largest.
  const double most = facts.target_noise * std::pow(2 / kCycleSeconds, order);
  const std::string noise = NoiseText(facts);
  if (!facts.has_generator && order > 0 && most > std::abs(v.limit)) {
    return fmt::format(
        "{}, and no reference generator smooths it: the noise alone makes up to {:.3g} {}. Take "
        "it out, or choose a generator (tick.generator).",
        noise, most, UnitOf(v));
  }
  return IsNoisy(facts) ? noise + "." : "";
}

std::string TellKeptBack(const RunEnd& end) {
  const KeptBack count = CountKeptBack(end);
  if (!count.is_most()) return "";
  return KeptBackText(count.changed, fmt::format("these {}", count.commands));
}

std::vector<Paragraph> TellHindrances(const RunEnd& end,
                                      const std::optional<ScenarioFacts>& facts) {
  std::vector<Paragraph> told;
  const KeptBack all{end.filter.kept_back, end.filter.commands};
  if (all.is_most()) {
    told.push_back({"kept back", {KeptBackText(all.changed, fmt::format("{}", all.commands))}});
  }
  if (IsNoisy(facts)) told.push_back({"injected", {NoiseText(*facts) + "."}});
  return told;
}

std::string TellDeviation(const RunEnd& end) {
  const JointDeviation largest = LastDeviation(end);
  if (!(largest.value > kLargeDeviation)) return "";
  return fmt::format(
      "joint {} was {:.3g} rad away from its target: this is not where the plan led.",
      largest.joint + 1, largest.value);
}

std::string RemedyOfDeviation(const RunEnd& end, const std::optional<ScenarioFacts>& facts) {
  if (!CountKeptBack(end).is_most() && !(LastDeviation(end).value > kLargeDeviation)) return "";
  std::vector<std::string_view> ways;
  if (IsNoisy(facts)) ways.emplace_back("take the noise out (controller.target_noise)");
  if (facts && !facts->has_default_generator) {
    ways.emplace_back("leave tick.generator out: its default resamples the targets");
  }
  if (ways.empty()) ways.emplace_back("move more gently");
  return fmt::format("first see that the arm follows its plan: {}. ", fmt::join(ways, "; "));
}

}  // namespace twin::report
