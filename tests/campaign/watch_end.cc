// What the watch checks once a run has ended.

#include <cmath>
#include <cstdint>
#include <string>

#include <fmt/format.h>

#include "campaign/watch.h"
#include "twin/core/hand_command.h"
#include "twin/core/time.h"

namespace twin::campaign {
namespace {

constexpr double kGoalNear = 1e-4;  ///< rad: what is left of the speed at which motions end
constexpr Duration kHandLate = 12 * kCycle;  ///< from when a command is due to its beginning
constexpr double kHandNear = 1e-3;           ///< m

/// By INT's joint impedance, of an arm that INT knows, at a rate whose matching lags by 1 mrad or
/// two, by a controller that never pauses, since the arm lags by the pause.
bool MustFollow(const scenario::Scenario& world) {
  const scenario::PlantSection usual;
  const bool is_silent = std::holds_alternative<faults::EmpiricalDelay>(world.controller.cost.law);
  return world.motion.controller == ControllerMode::kJointImpedance && !is_silent &&
         world.controller.rate_hz >= 500 && world.plant.mass_scale == 1 &&
         world.plant.base_tilt == usual.base_tilt && world.plant.arm == usual.arm;
}

}  // namespace

void Watch::CheckHand(const run::RunResult& result) {
  if (!result.hand) return;
  const Time end(result.report.simulated);
  for (std::size_t i = 0; i < world_.hand.size(); ++i) {
    const run::HandOutcome& outcome = result.hand->commands[i];
    const Time due(world_.hand[i].at);
    const bool is_last = i + 1 == world_.hand.size();
    const bool was_followed = !is_last && result.hand->commands[i + 1].begun.has_value();
    if (!outcome.begun) {
      if (due + kHandLate < end) {
        Note("hand", fmt::format("command {} did not begin, and the run went on", i + 1));
      }
    } else if (*outcome.begun < due || *outcome.begun > due + kHandLate) {
      Note("hand", fmt::format("command {} began {} ns after it was due", i + 1,
                               (*outcome.begun - due).count()));
    } else if (was_followed && !outcome.result) {
      Note("hand", fmt::format("command {} has no result, and another followed", i + 1));
    }
    const auto* move = std::get_if<hand::Move>(&world_.hand[i].command);
    if (move == nullptr || outcome.result != HandResult::kSuccess) continue;
    if (std::abs(outcome.width - move->width) > kHandNear) {
      Note("hand", fmt::format("command {}: the hand is {} m open and should be {} m", i + 1,
                               outcome.width, move->width));
    }
  }
}

void Watch::CheckEngine() {
  if (path_.empty()) return;  // the start itself was refused
  const std::string warnings = engine_warnings_ ? engine_warnings_() : "";
  if (!warnings.empty()) Note("energy", "the simulation became unsound: " + warnings);
}

void Watch::CheckUndisturbed(const run::RunResult& result) {
  constexpr auto kItself = static_cast<std::size_t>(RobotError::kSelfCollisionAvoidanceViolation);
  const bool is_disturbed = pushed_from_ || !world_.panel.empty() || !world_.limits.empty() ||
                            world_.base || counts_.held > 0 || counts_.served == 0 || has_stalled_;
  const bool keeps_limits =
      world_.tick.generator == loop::Generator::kRejoining && world_.tick.viability;
  if (is_disturbed || !keeps_limits || world_.robot.load != world_.onboard.load) return;
  // Of poses, the controller gives up where they are too fast for a joint.
  if (!world_.motion.poses.empty()) return;
  const loop::RunReport& report = result.report;
  const bool succeeded = report.end == backend::MotionEnd::kSuccess && report.failure.empty();
  const bool may_abort = world_.plant.kind == robot::PlantKind::kMujoco;
  if (!succeeded && !report.errors.test(kItself) && !(may_abort && report.errors.any())) {
    Note("finish", fmt::format("nothing disturbs the motion, and it ends with {} ({})",
                               NameOf(report.end), report.failure));
  }
  // Before a limit of the end effector the filter brakes.
  const bool is_led = world_.motion.interface == control::CommandInterface::kCartesianPose &&
                      result.viability && result.viability->kept_back > 0;
  if (result.followed.exceeds() && !is_led && MustFollow(world_)) {
    Note("path", fmt::format("nothing disturbs the motion: {}", result.followed.Excess()));
  }
}

void Watch::CheckEnd(const run::RunResult& result) {
  if (result.report.end == backend::MotionEnd::kSuccess && !finish_served_) {
    Note("finish", "the motion succeeded without a finished command");
  }
  const bool is_told = result.report.end == backend::MotionEnd::kSuccess ||
                       result.report.errors.any() || !result.report.failure.empty() ||
                       result.report.end == backend::MotionEnd::kPreempted ||
                       result.report.end == backend::MotionEnd::kUserStopped;
  if (!is_told) Note("finish", "the motion ended and nobody says why");
  if (result.report.end != backend::MotionEnd::kSuccess ||
      world_.motion.interface != control::CommandInterface::kJointPosition ||
      !world_.motion.poses.empty()) {  // whose goal is no waypoint
    return;
  }
  const double allowed = world_.tick.finish_tolerance + world_.controller.target_noise + kGoalNear;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double off = q_d_at_end_[i] - result.goal[i];
    if (std::abs(off) <= allowed) continue;
    Note("finish",
         fmt::format("the motion succeeded {} rad from the goal of joint {}", off, i + 1));
  }
}

void Watch::End(const run::RunResult& result) {
  const run::CycleCounts& counts = result.counts;
  if (counts.served != counts_.served || counts.held != counts_.held ||
      counts.dropped != counts_.dropped || counts.longest_loss != counts_.longest_loss) {
    Note("account",
         fmt::format("the result tells of {} served, {} held ({} in a row), {} dropped; the cycles "
                     "of {}, {} ({}), {}",
                     counts.served, counts.held, counts.longest_loss, counts.dropped,
                     counts_.served, counts_.held, counts_.longest_loss, counts_.dropped));
  }
  const loop::LoopTimings& timings = result.report.timings;
  if (timings.written != written_ || timings.skipped_states != skipped_) {
    Note("account", fmt::format("the report tells of {} written and {} states skipped; the ticks "
                                "of {}, {}",
                                timings.written, timings.skipped_states, written_, skipped_));
  }
  messages_.End(written_, counts_.served + counts_.dropped);
  CheckHand(result);
  CheckEnd(result);
  CheckUndisturbed(result);
}

}  // namespace twin::campaign
