#include "campaign/source_watch.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "twin/core/time.h"

namespace twin::campaign {
namespace {

constexpr double kExact = 1e-9;  // rad
/// The play time differs from the robot's by less, and its rate changes.
constexpr double kPlayed = 0.02;
/// The curve's bends within a cycle, rad; the mean of the velocities at both ends of a span misses
/// what grows with the third power of its length.
constexpr double kBends = 1e-7;
/// Cycles that the resampler makes up for at once (loop::RejoiningFollower).
constexpr std::uint64_t kMostCycles = 64;

std::uint64_t WindowOf(const scenario::Scenario& world) {
  if (!world.tick.rate_matching) return 1;
  const double periods = 1 / (world.controller.rate_hz * kCycleSeconds);
  return static_cast<std::uint64_t>(std::ceil(periods - 1e-9));
}

}  // namespace

SourceWatch::SourceWatch(const scenario::Scenario& world, Note note)
    : world_(world),
      note_(std::move(note)),
      is_watched_(world.motion.interface == control::CommandInterface::kJointPosition),
      window_(WindowOf(world)) {}

void SourceWatch::OnTick(const record::TickRecord& tick) {
  if (!is_watched_ || !record::WroteCommand(tick)) return;
  const std::uint64_t cycles = last_ ? tick.message_id - last_->message_id : 1;
  if (!last_ || tick.deposit_time != last_->deposit_time) {
    since_deposit_ = 0;
  } else if (world_.tick.generator == loop::Generator::kRejoining) {
    CheckPlayed(tick, cycles);
  } else {
    CheckMatched(tick);
  }
  since_deposit_ += cycles;
  last_ = tick;
}

void SourceWatch::CheckPlayed(const record::TickRecord& tick, std::uint64_t cycles) {
  if (tick.stalled != last_->stalled || cycles > kMostCycles) return;
  const double seconds = static_cast<double>(cycles) * kCycleSeconds;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double moved = tick.q_ext[i] - last_->q_ext[i];
    const double mean = (tick.dq_ext[i] + last_->dq_ext[i]) / 2;
    const double change = std::abs(tick.dq_ext[i] - last_->dq_ext[i]);
    const double expected = tick.stalled ? 0 : seconds * mean;
    // Noise in two targets bends the curve between them.
    const double bends =
        kBends * std::pow(static_cast<double>(cycles), 3) + 2 * world_.controller.target_noise;
    const double most =
        tick.stalled ? 0 : 2 * seconds * change + kPlayed * std::abs(expected) + bends;
    if (std::abs(moved - expected) <= most) continue;
    note_("source", fmt::format("the tick of state {}: in {} cycles without a deposit joint {} of "
                                "the source moves by {:.9f} rad at {:.6f} rad/s{}",
                                tick.message_id, cycles, i + 1, moved, mean,
                                tick.stalled ? ", and it is stalled" : ""));
    return;
  }
}

void SourceWatch::CheckMatched(const record::TickRecord& tick) const {
  if (tick.stalled || since_deposit_ < window_) return;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double moved = tick.q_ext[i] - last_->q_ext[i];
    if (std::abs(moved) <= kExact) continue;
    note_("source",
          fmt::format("the tick of state {}: {} cycles after its deposit joint {} of the matched "
                      "source still moves, by {:.9f} rad, and {} cycles fill the mean",
                      tick.message_id, since_deposit_, i + 1, moved, window_));
    return;
  }
}

}  // namespace twin::campaign
