#pragma once

#include <cstdint>
#include <vector>

#include "twin/backend/backend.h"
#include "twin/backend/registry.h"
#include "twin/rt/signal.h"

namespace twin::test {

/// A robot whose time is its states: in a motion, from the third state on, the next is there only
/// when the last has been answered. Its reference becomes what it is commanded.
class AnswerPacedBackend final : public backend::Backend, private rt::Arrival {
 public:
  /// @param first_id  of its first state: what its earlier life was.
  explicit AnswerPacedBackend(std::uint64_t first_id) { state_.message_id = first_id - 1; }

  [[nodiscard]] backend::Connection Connect() {
    backend::Connection connection;
    connection.arrival = this;
    return connection;
  }

  [[nodiscard]] backend::Description Describe() const override {
    backend::Description description;
    description.last_end = end_;
    return description;
  }
  void Configure(const Setting& /*setting*/) override {}
  void Start(const MotionModes& modes) override {
    end_ = backend::MotionEnd::kNone;
    unanswered_ = 0;
    state_.robot_mode = RobotMode::kMove;
    state_.motion_generator_mode = modes.generator;
    state_.controller_mode = modes.controller;
  }
  backend::ReadResult Read(backend::ReadRule /*rule*/, RobotState& state,
                           Time& arrival) noexcept override {
    if (state_.message_id >= gone_from) return backend::ReadResult::kLost;
    if (IsMoving() && unanswered_ >= 2) return backend::ReadResult::kPending;
    state_.message_id += state_.message_id == leaps_at ? 4 : 1;
    unanswered_ += IsMoving() ? 1 : 0;
    state = state_;
    arrival = Time(std::chrono::hours(1));  // by a wall clock, which is of no meaning here
    return backend::ReadResult::kState;
  }
  void Write(const RobotCommand& command) noexcept override {
    if (!IsMoving() || command.message_id != state_.message_id) return;
    commands.push_back(command);
    state_.q_d = command.q_c;
    state_.ddq_d[6] += 1;
    unanswered_ = 1;
    if (command.motion_generation_finished) End(backend::MotionEnd::kSuccess);
  }
  void Stop() override { End(backend::MotionEnd::kPreempted); }
  void Recover() override {}

  std::vector<RobotCommand> commands;
  std::uint64_t leaps_at = 0;  ///< after the state with this id, three are lost
  std::uint64_t gone_from = UINT64_MAX;

 private:
  bool AwaitUntil(Time /*deadline*/) noexcept override { return true; }
  [[nodiscard]] bool IsMoving() const noexcept { return state_.robot_mode == RobotMode::kMove; }
  void End(backend::MotionEnd end) noexcept {
    if (!IsMoving()) return;
    end_ = end;
    state_.robot_mode = RobotMode::kIdle;
    state_.motion_generator_mode = MotionGeneratorMode::kIdle;
    state_.controller_mode = ControllerMode::kOther;
  }

  RobotState state_ = [] {
    RobotState state;
    state.robot_mode = RobotMode::kIdle;
    return state;
  }();
  int unanswered_ = 0;  ///< states of the motion since the last answer
  backend::MotionEnd end_ = backend::MotionEnd::kNone;
};

}  // namespace twin::test
