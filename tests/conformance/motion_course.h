#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "contract/backend_harness.h"
#include "twin/core/robot_state.h"

namespace twin::test {

/// Passes everything on to another harness, and notes every state that is read.
class NotingHarness final : public BackendHarness {
 public:
  /// @param states  must outlive this.
  NotingHarness(std::unique_ptr<BackendHarness> harness, std::vector<RobotState>& states)
      : harness_(std::move(harness)), states_(states) {}

  backend::Backend& backend() override { return harness_->backend(); }
  bool AwaitState(RobotState& state, backend::ReadRule rule) override {
    if (!harness_->AwaitState(state, rule)) return false;
    states_.push_back(state);
    return true;
  }
  bool AwaitArrivals(int count) override { return harness_->AwaitArrivals(count); }
  backend::Panel* panel() override { return harness_->panel(); }

 private:
  std::unique_ptr<BackendHarness> harness_;
  std::vector<RobotState>& states_;
};

/// The states of a robot's first motion, as a client read them.
struct MotionCourse {
  /// From the first that is not Idle to the first that does not show Move.
  std::vector<RobotState> states;
  /// The state before the first, or before the last, was not read: outside a motion's commands
  /// nobody waits for who reads.
  bool missed_begin = false;
  bool missed_end = false;
  bool is_over = false;  ///< the last state shows another mode than Move
};

/// @param all  every state that was read, from the robot's start on.
[[nodiscard]] MotionCourse CourseOf(const std::vector<RobotState>& all);

/// Of a motion's states, where a client has not commanded yet: those from the start to the first
/// that can have been answered. A served robot stands still there until the first command.
inline constexpr std::size_t kUncommanded = 2;

/// Compares what a motion showed in process and over the wire, bit for bit but for the ids, from
/// the first command on. @param there  over the wire.
/// @returns the first difference; nullopt: none.
[[nodiscard]] std::optional<std::string> FindDifference(const MotionCourse& here,
                                                        const MotionCourse& there);

}  // namespace twin::test
