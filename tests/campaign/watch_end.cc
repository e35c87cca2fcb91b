// What the watch checks once a run has ended.

#include <cmath>
#include <cstdint>

#include <fmt/format.h>

#include "campaign/watch.h"
#include "twin/core/hand_command.h"
#include "twin/core/time.h"

namespace twin::campaign {
namespace {

constexpr double kGoalNear = 1e-4;  ///< rad: what is left of the speed at which motions end
constexpr Duration kHandLate = 12 * kCycle;  ///< from when a command is due to its beginning
constexpr double kHandNear = 1e-3;           ///< m

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

std::optional<Finding> Watch::End(const run::RunResult& result) {
  const run::CycleCounts& counts = result.counts;
  if (counts.served != counts_.served || counts.held != counts_.held ||
      counts.dropped != counts_.dropped || counts.longest_loss != counts_.longest_loss) {
    Note("account",
         fmt::format("the result tells of {} served, {} held ({} in a row), {} dropped; the cycles "
                     "of {}, {} ({}), {}",
                     counts.served, counts.held, counts.longest_loss, counts.dropped,
                     counts_.served, counts_.held, counts_.longest_loss, counts_.dropped));
  }
  if (counts_.served + counts_.dropped > 2 * written_) {
    Note("account", fmt::format("{} served and {} dropped of {} written", counts_.served,
                                counts_.dropped, written_));
  }
  const loop::LoopTimings& timings = result.report.timings;
  if (timings.written != written_ || timings.skipped_states != skipped_) {
    Note("account", fmt::format("the report tells of {} written and {} states skipped; the ticks "
                                "of {}, {}",
                                timings.written, timings.skipped_states, written_, skipped_));
  }
  messages_.End();
  CheckHand(result);
  CheckEnd(result);
  return finding_;
}

}  // namespace twin::campaign
