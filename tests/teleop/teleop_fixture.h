#pragma once

#include <cmath>
#include <memory>
#include <optional>
#include <string>

#include "support/panda_limits.h"
#include "twin/backend/mobile_base.h"
#include "twin/core/limits.h"
#include "twin/model/arm_model.h"
#include "twin/teleop/teleoperator.h"

namespace twin::teleop::test {

/// A posture from which every way is free, rad.
inline constexpr JointVector kReady{0, -0.785, 0, -2.356, 0, 1.571, 0.785};

/// Gives the sample it is told to, one per look.
class FakeDevice final : public Device {
 public:
  OperatorSample now;
  bool silent = false;
  bool is_lost = false;
  OperatorFeedback felt;

  [[nodiscard]] std::optional<OperatorSample> Read(Time at) noexcept override {
    if (silent) return std::nullopt;
    ++now.sequence;
    now.at = at;
    return now;
  }
  void Feel(const OperatorFeedback& feedback) noexcept override { felt = feedback; }
  [[nodiscard]] bool lost() const noexcept override { return is_lost; }
  [[nodiscard]] std::string Describe() const override { return "a fake"; }
};

/// Does at once what it is told.
class FakeBase final : public backend::MobileBase {
 public:
  BaseState state;
  int drives = 0;
  int stops = 0;
  int releases = 0;

  void Drive(const BaseTwist& twist) noexcept override {
    ++drives;
    state.twist = twist;
  }
  void EmergencyStop() noexcept override {
    ++stops;
    state.twist = {};
  }
  void Release() noexcept override { ++releases; }
  [[nodiscard]] BaseState ReadState() const noexcept override { return state; }
};

/// A teleoperator at 1 kHz whose arm is where its reference was a millisecond ago.
class Rig {
 public:
  explicit Rig(const TeleoperatorConfig& config = {}, const WireConfig& wire = {},
               bool has_base = true)
      : teleoperator({.device = device,
                      .base = has_base ? &base : nullptr,
                      .limits = twin::test::PandaLimits()},
                     config, wire, 1) {
    state.q = kReady;
    state.F_T_EE = kIdentityTransform;
    state.O_T_EE = model::ArmModel::Panda().Pose(model::Frame::kEndEffector, kReady);
    start = state.O_T_EE;
    target.O_T_EE = start;
    teleoperator.Begin(start, now);
  }

  /// One millisecond on.
  void Step() {
    now += kCycle;
    state.O_T_EE = target.O_T_EE;
    target = teleoperator.Next(state, now);
  }
  void Run(int milliseconds) {
    for (int i = 0; i < milliseconds; ++i) Step();
  }
  /// How far the reference is from where it began, m.
  [[nodiscard]] double Way() const {
    return std::hypot(target.O_T_EE[12] - start[12], target.O_T_EE[13] - start[13],
                      target.O_T_EE[14] - start[14]);
  }
  [[nodiscard]] double Speed() const {
    return std::hypot(target.O_dP_EE[0], target.O_dP_EE[1], target.O_dP_EE[2]);
  }

  FakeDevice device;
  FakeBase base;
  RobotState state;
  Transform start = kIdentityTransform;
  reference::PoseTarget target;
  Time now{};
  Teleoperator teleoperator;
};

}  // namespace twin::teleop::test
