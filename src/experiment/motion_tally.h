#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "twin/core/robot_errors.h"
#include "twin/rt/cycle_record.h"
#include "twin/run/run.h"

namespace twin::experiment {

/// One motion, as the robot had it.
struct TalliedMotion {
  std::uint64_t first_id = 0;  ///< of the first cycle with a command
  std::uint64_t last_id = 0;   ///< of the last
  run::CycleCounts counts{};
  RobotErrors errors{};  ///< that ended it; none: it was ended in order, or by the client

  /// For people: ", aborted by ..."; empty for one in order.
  [[nodiscard]] std::string HowItEnded() const;
};

/// Keeps of every cycle of a robot's motions what became of its command.
///
/// Threads: cycles from one; the rest once the robot has ended. Real-time: Put() allocates nothing;
/// what no longer has room is not kept.
class MotionTally final : public rt::RecordSink {
 public:
  /// Cycles without a command in a row that end a motion.
  [[nodiscard]] static std::uint32_t EndsTheMotion() noexcept;

  MotionTally();

  void Put(const rt::CycleRecord& record) noexcept override;
  void Put(const rt::TickRecord& /*record*/) noexcept override {}

  /// In their order.
  [[nodiscard]] const std::vector<TalliedMotion>& motions() const noexcept { return motions_; }
  /// Cycles without a command in a row, up to and with each cycle of the motions, one after the
  /// other.
  [[nodiscard]] const std::vector<std::uint8_t>& lost_in_row() const noexcept {
    return lost_in_row_;
  }
  [[nodiscard]] bool IsInMotion(std::uint64_t message_id) const noexcept;
  /// Of all motions.
  [[nodiscard]] const run::CycleCounts& counts() const noexcept { return counts_; }
  /// Not all there was is kept.
  [[nodiscard]] bool is_full() const noexcept { return is_full_; }

 private:
  static constexpr std::size_t kMotions = 1000;
  static constexpr std::size_t kCycles = std::size_t{1} << 22;  ///< 70 minutes in motion

  std::vector<TalliedMotion> motions_;
  run::CycleCounts counts_;
  std::vector<std::uint8_t> lost_in_row_;
  bool in_motion_ = false;
  bool is_full_ = false;
};

}  // namespace twin::experiment
