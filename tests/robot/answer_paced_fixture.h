#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <initializer_list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "robot/robot_fixture.h"
#include "twin/fci/datagrams.h"
#include "twin/robot/robot_config.h"

// A robot in lockstep with a workstation beyond a port. Nothing here depends on how fast the
// threads run; where a test waits, it waits for what must come.
namespace twin::robot::answer_paced {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// A wire that loses nothing, between the robot's thread and the test's.
class Wire final : public WorkstationPort, public rt::Arrival {
 public:
  // The robot's end.
  bool Receive(ReceivedCommand& received) noexcept override {
    const std::scoped_lock lock(mutex_);
    if (commands_.empty()) return false;
    received.command = commands_.front();
    commands_.pop_front();
    return true;
  }
  void Deliver(const RobotState& state) noexcept override {
    const std::scoped_lock lock(mutex_);
    states_.push_back(state);
    changed_.notify_all();
  }
  bool AwaitUntil(Time) noexcept override {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, milliseconds(1), [this] { return !commands_.empty(); });
  }

  // The workstation's end.
  void Answer(const RobotCommand& command) { Answer({command}); }
  /// All at once.
  void Answer(std::initializer_list<RobotCommand> commands) {
    const std::scoped_lock lock(mutex_);
    commands_.insert(commands_.end(), commands);
    changed_.notify_all();
  }
  /// The next state, in order. Waits for it.
  RobotState Next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !states_.empty(); });
    const RobotState state = states_.front();
    states_.pop_front();
    return state;
  }
  [[nodiscard]] std::size_t waiting() {
    const std::scoped_lock lock(mutex_);
    return states_.size();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RobotCommand> commands_;
  std::deque<RobotState> states_;
};

/// A fingerprint (FNV-1a) of a state's bytes, but for its id.
inline std::uint64_t Content(const RobotState& state) {
  fci::StateBytes bytes;
  fci::Encode(state, bytes);
  std::uint64_t hash = 14695981039346656037u;
  for (std::size_t i = 8; i < bytes.size(); ++i) {
    hash = (hash ^ std::to_integer<std::uint64_t>(bytes[i])) * 1099511628211u;
  }
  return hash;
}

inline std::vector<std::uint64_t> Contents(const std::vector<RobotState>& states) {
  std::vector<std::uint64_t> contents;
  contents.reserve(states.size());
  for (const RobotState& state : states) contents.push_back(Content(state));
  return contents;
}

inline constexpr int kMotionCycles = 300;

/// Time stands still until the first command, so that it cannot come too late.
inline constexpr LockstepOptions kFreeze{.freeze_when_idle = true};

class AnswerPacedRobotTest : public ::testing::Test {
 protected:
  ~AnswerPacedRobotTest() override { robot_.reset(); }

  void Make(const RobotConfig& config, const LockstepOptions& options = {}) {
    robot_.reset();
    wire_.emplace();
    robot_.emplace(config, MakePlant(config).plant, *wire_, *wire_, clock_,
                   rt::ThreadSettings{.name = "robot", .lock_memory = false}, nullptr, options);
    robot_->Begin();
  }
  static RobotConfig Ideal() {
    RobotConfig config = test::PandaRobot();
    config.link = {};
    config.plant_kind = PlantKind::kIdeal;
    return config;
  }

  /// Asks for a motion and reads on until two states show it; the second is to be answered first.
  RobotState Start() {
    EXPECT_EQ(robot_->Move({}), MoveStatus::kMotionStarted);
    RobotState state = wire_->Next();
    while (state.motion_generator_mode == MotionGeneratorMode::kIdle) state = wire_->Next();
    return wire_->Next();
  }
  /// The newest state that waits; waits for one when none does.
  RobotState Newest(RobotState state) {
    while (wire_->waiting() > 0) state = wire_->Next();
    return state;
  }

  /// Starts a motion and answers it once, with its own reference. @returns the state answered.
  RobotState Stand() {
    const RobotState state = Newest(Start());
    RobotCommand command;
    command.message_id = state.message_id;
    command.q_c = state.q_d;
    wire_->Answer(command);
    return state;
  }

  /// Answers states with a gentle motion of joint 1 and 4 until it is over.
  /// @param pause  before answer k. @returns the states after the first answer, to the idle one.
  std::vector<RobotState> Drive(
      RobotState state, const std::function<void(int)>& pause = [](int) {}) {
    state = Newest(state);
    const JointVector start = state.q_d;
    const std::uint64_t first = state.message_id;
    std::vector<RobotState> states;
    while (state.motion_generator_mode != MotionGeneratorMode::kIdle) {
      const auto k = static_cast<int>(state.message_id - first);
      pause(k);
      RobotCommand command;
      command.message_id = state.message_id;
      command.q_c = start;
      const double share = std::min(1.0, static_cast<double>(k) / kMotionCycles);
      const double moved = 0.02 * (1 - std::cos(share * 2 * 3.14159265358979));
      command.q_c[0] += moved;
      command.q_c[3] += moved;
      command.motion_generation_finished = k >= kMotionCycles;
      wire_->Answer(command);
      state = After(command.message_id);
      states.push_back(state);
    }
    return states;
  }
  /// The next state that is newer.
  RobotState After(std::uint64_t id) {
    RobotState state = wire_->Next();
    while (state.message_id <= id) state = wire_->Next();
    return state;
  }

  const MonotonicClock clock_;
  std::optional<Wire> wire_;
  std::optional<AnswerPacedRobot> robot_;
};

}  // namespace twin::robot::answer_paced
