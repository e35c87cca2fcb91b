#pragma once

#include <memory>
#include <optional>
#include <string>

#include "conformance/state_checker.h"
#include "contract/backend_harness.h"
#include "twin/core/modes.h"
#include "twin/core/setting.h"
#include "twin/robot/robot_config.h"

namespace twin::test {

/// What a checker must be told of this robot.
[[nodiscard]] CheckedRobot ToCheck(const robot::RobotConfig& robot);

/// A robot behind its backend, advanced one cycle at a time by hand, watched by a StateChecker
/// where asked for. Requests come between two cycles; what is refused is told by the return value.
///
/// Threads: one.
class Rig {
 public:
  /// Connects, and reads the first state.
  Rig(std::unique_ptr<BackendHarness> harness, const robot::RobotConfig& robot, bool checked);

  [[nodiscard]] const RobotState& state() const { return state_; }
  [[nodiscard]] backend::Description Describe() const { return harness_->backend().Describe(); }

  /// @returns whether it was accepted; why not is then in refusal().
  bool Start(const MotionModes& modes);
  bool Recover();
  bool Configure(const Setting& setting);
  bool Operate(PanelAction action);
  void Stop();
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

  /// Puts a command on the way, as it is.
  void Write(const RobotCommand& command);
  /// Lets a cycle pass and reads its state.
  const RobotState& Cycle();
  /// Answers the last state with the command, and lets a cycle pass.
  const RobotState& Answer(RobotCommand command);
  /// Starts a motion and lets it show two states, as a client does.
  bool StartMotion(const MotionModes& modes);
  /// Lets cycles pass until the reference rests, at most `cycles`. @returns whether it does.
  bool ComeToRest(int cycles = 1000);
  /// Comes to rest, recovers and becomes Idle. @returns whether it did.
  bool RecoverToIdle();

  /// A command that asks for nothing to change: the last reference once more.
  [[nodiscard]] RobotCommand Same() const;

  [[nodiscard]] Finding finding() const;

 private:
  template <typename Request>
  bool Try(Request request);

  std::unique_ptr<BackendHarness> harness_;
  std::optional<StateChecker> checker_;
  RobotState state_;
  std::string refusal_;
};

}  // namespace twin::test
