#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string_view>
#include <utility>

#include "support/panda_limits.h"
#include "twin/core/time.h"
#include "twin/record/cycle_record.h"
#include "twin/record/recorder.h"

namespace twin::report {

/// A log made by hand: a motion of joint 2, q(k) = 0.2 (1 - cos(3 k T)), as the controller takes
/// and holds its commands, and the workstation's answers to its states. State ids are 1000 + k.
class SampleMotion {
 public:
  static constexpr std::size_t kJoint = 1;

  explicit SampleMotion(std::filesystem::path log) : log_(std::move(log)) {
    info_.scenario = "sample";
    info_.version = "0.1.0";
    info_.drive = "lockstep";
    info_.limits = record::RunLimits{test::PandaLimits(), test::PandaCartesianLimits()};
    recorder_.emplace(log_, info_, record::FullRing::kWait);
    state_.robot_mode = RobotMode::kMove;
    state_.motion_generator_mode = MotionGeneratorMode::kJointPosition;
    state_.controller_mode = ControllerMode::kJointImpedance;
    state_.message_id = 1000;
    state_.q = state_.q_d = {0, 0, 0, -2.3562, 0, 1.5708, 0.7854};
  }

  /// With another description of the run. To be called first.
  SampleMotion& Describe(const record::RunInfo& info) {
    recorder_.reset();
    info_ = info;
    recorder_.emplace(log_, info_, record::FullRing::kWait);
    return *this;
  }

  [[nodiscard]] static double Planned(std::uint64_t k) {
    return 0.2 * (1 - std::cos(3e-3 * static_cast<double>(k)));
  }

  /// `count` served cycles along the plan.
  SampleMotion& Serve(int count) {
    for (int i = 0; i < count; ++i) {
      ++k_;
      Answer(Planned(k_));
      Accept(Planned(k_));
      PutCycle(record::CommandFate::kServed);
    }
    return *this;
  }

  /// `count` cycles without a command; the workstation answered the state before them, or not.
  SampleMotion& Lose(int count, bool answered) {
    for (int i = 0; i < count; ++i) {
      ++k_;
      if (answered) Answer(Planned(k_));
      const double ddq = state_.ddq_d[kJoint];
      state_.dq_d[kJoint] += kCycleSeconds * ddq;
      state_.q_d[kJoint] += kCycleSeconds * state_.dq_d[kJoint];
      dddq_ = 0;
      ++lost_;
      PutCycle(record::CommandFate::kHeld);
    }
    return *this;
  }

  /// A cycle in which the robot moves by itself, as the state says.
  SampleMotion& PassBy() {
    ++k_;
    PutCycle(record::CommandFate::kNone);
    return *this;
  }

  /// The workstation answers the state of the last cycle so, whatever becomes of it.
  SampleMotion& AnswerWith(const record::TickRecord& tick) {
    record::TickRecord answer = tick;
    answer.message_id = state_.message_id;
    recorder_->Put(answer);
    return *this;
  }

  /// The state before the next cycle, for what a test wants to be in it.
  RobotState& state() { return state_; }
  void SetLost(std::uint32_t lost) { lost_ = lost; }

  /// A cycle that an error ends. @param told  with its violation; else the state's error alone.
  SampleMotion& Abort(const Violation& violation, record::CommandFate fate, bool told = true) {
    ++k_;
    state_.robot_mode = RobotMode::kReflex;
    state_.motion_generator_mode = MotionGeneratorMode::kIdle;
    state_.controller_mode = ControllerMode::kOther;
    state_.errors.set(static_cast<std::size_t>(violation.error));
    violation_ = violation;
    told_ = told;
    PutCycle(fate);
    told_ = false;
    return *this;
  }

  /// Cycles without error or motion.
  SampleMotion& Rest(int count) {
    state_.errors.reset();
    state_.robot_mode = RobotMode::kIdle;
    state_.motion_generator_mode = MotionGeneratorMode::kIdle;
    state_.controller_mode = ControllerMode::kOther;
    for (int i = 0; i < count; ++i) PassBy();
    return *this;
  }

  /// Recovery, and a motion anew.
  SampleMotion& Recover() {
    state_.errors.reset();
    state_.robot_mode = RobotMode::kMove;
    state_.motion_generator_mode = MotionGeneratorMode::kJointPosition;
    state_.controller_mode = ControllerMode::kJointImpedance;
    return *this;
  }

  SampleMotion& Event(std::string_view kind, std::string_view text) {
    recorder_->Event(Time(static_cast<std::int64_t>(k_) * kCycle), kind, text);
    return *this;
  }

  /// Writes the log. @returns its path.
  const std::filesystem::path& Finish() {
    recorder_->Finish();
    return log_;
  }

  [[nodiscard]] std::uint64_t k() const { return k_; }

 private:
  void Answer(double q_c) {
    record::TickRecord tick;
    tick.action = record::TickAction::kWritten;
    tick.read = Time(static_cast<std::int64_t>(k_ - 1) * kCycle + Duration(100'000));
    tick.written = tick.read + Duration(20'000);
    tick.deposit_time = tick.read;
    tick.q_ext = state_.q_d;
    tick.q_ext[kJoint] = q_c;
    tick.command.q_c = tick.q_ext;
    AnswerWith(tick);
  }

  void Accept(double q_c) {
    const double dq = (q_c - state_.q_d[kJoint]) / kCycleSeconds;
    const double ddq = (dq - state_.dq_d[kJoint]) / kCycleSeconds;
    dddq_ = (ddq - state_.ddq_d[kJoint]) / kCycleSeconds;
    state_.q_d[kJoint] = state_.q[kJoint] = q_c;
    state_.dq_d[kJoint] = state_.dq[kJoint] = dq;
    state_.ddq_d[kJoint] = ddq;
    lost_ = 0;
  }

  void PutCycle(record::CommandFate fate) {
    ++state_.message_id;
    record::CycleRecord cycle;
    cycle.at = Time(static_cast<std::int64_t>(k_) * kCycle);
    cycle.state = state_;
    cycle.dddq_d[kJoint] = dddq_;
    cycle.fate = fate;
    cycle.lost_in_row = fate == record::CommandFate::kServed ? 0 : lost_;
    cycle.violated = told_;
    if (told_) {
      cycle.violation = violation_;
      cycle.violation.message_id = state_.message_id;
    }
    recorder_->Put(cycle);
  }

  std::filesystem::path log_;
  record::RunInfo info_;
  std::optional<record::Recorder> recorder_;
  std::uint64_t k_ = 0;
  RobotState state_;
  double dddq_ = 0;
  std::uint32_t lost_ = 0;
  Violation violation_;
  bool told_ = false;
};

}  // namespace twin::report
