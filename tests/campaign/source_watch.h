#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "conformance/state_checker.h"
#include "twin/record/cycle_record.h"
#include "twin/scenario/scenario.h"

namespace twin::campaign {

/// Watches how the workstation's tick reads a source of joint positions between two deposits: its
/// time goes on with the robot's cycles, answered or lost, and stands while it is stalled. Part of
/// Watch.
class SourceWatch {
 public:
  using Note = std::function<void(std::string_view invariant, const test::Finding& finding)>;

  /// @param world  must outlive this. @param note  is told of each violation.
  SourceWatch(const scenario::Scenario& world, Note note);

  void OnTick(const record::TickRecord& tick);

 private:
  /// The resampler's curve: q_ext differs by what dq_ext says.
  void CheckPlayed(const record::TickRecord& tick, std::uint64_t cycles);
  /// The rate matching's mean: once a deposit has filled its window, q_ext is that deposit.
  void CheckMatched(const record::TickRecord& tick) const;

  const scenario::Scenario& world_;
  const Note note_;
  const bool is_watched_;
  const std::uint64_t window_;              ///< cycles of the rate matching; 1: none
  std::optional<record::TickRecord> last_;  ///< that wrote a command
  std::uint64_t since_deposit_ = 0;         ///< cycles up to last_, with the first of the deposit
};

}  // namespace twin::campaign
