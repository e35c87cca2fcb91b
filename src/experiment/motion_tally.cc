#include "experiment/motion_tally.h"

#include <algorithm>

#include <fmt/format.h>

#include "twin/onboard/onboard_config.h"

namespace twin::experiment {

std::string TalliedMotion::HowItEnded() const {
  return errors.none() ? std::string() : fmt::format(", aborted by {}", FormatErrors(errors));
}

std::uint32_t MotionTally::EndsTheMotion() noexcept {
  return onboard::OnboardConfig().abort_after_lost;
}

MotionTally::MotionTally() {
  motions_.reserve(kMotions);
  lost_in_row_.reserve(kCycles);
}

void MotionTally::Put(const rt::CycleRecord& record) noexcept {
  if (record.fate == rt::CommandFate::kNone) {
    if (in_motion_ && record.state.robot_mode == RobotMode::kReflex) {
      motions_.back().errors = record.state.reflex_reason;
    }
    in_motion_ = false;
    return;
  }
  is_full_ =
      is_full_ || lost_in_row_.size() == kCycles || (!in_motion_ && motions_.size() == kMotions);
  if (is_full_) return;
  if (!in_motion_) motions_.push_back({.first_id = record.state.message_id});
  in_motion_ = true;
  TalliedMotion& motion = motions_.back();
  motion.last_id = record.state.message_id;
  motion.counts.Add(record);
  counts_.Add(record);
  lost_in_row_.push_back(
      static_cast<std::uint8_t>(std::min<std::uint32_t>(record.lost_in_row, 255)));
}

bool MotionTally::IsInMotion(std::uint64_t message_id) const noexcept {
  // A command answers the state of the cycle before.
  return std::ranges::any_of(motions_, [message_id](const TalliedMotion& motion) {
    return message_id + 1 >= motion.first_id && message_id + 1 <= motion.last_id;
  });
}

}  // namespace twin::experiment
