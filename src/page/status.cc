#include "page/status.h"

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "page/message.h"
#include "twin/core/error.h"
#include "twin/core/mobile_base.h"
#include "twin/core/modes.h"

namespace twin::page {
namespace {

/// JSON cannot represent numbers that are not finite.
template <typename Values>
std::string Numbers(const Values& values) {
  std::string text;
  for (const double value : values) {
    if (!text.empty()) text += ',';
    text += std::isfinite(value) ? fmt::format("{:.5g}", value) : "0";
  }
  return text;
}

std::string NamesOf(const RobotErrors& errors) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    if (errors[i]) names.push_back(Quoted(Name(static_cast<RobotError>(i))));
  }
  return fmt::format("{}", fmt::join(names, ","));
}

/// Reference minus measured; null under torque control.
std::string ErrorText(const ArmView& arm) {
  if (!arm.follows_reference) return "null";
  JointVector error{};
  for (std::size_t i = 0; i < kJoints; ++i) error[i] = arm.q_d[i] - arm.q[i];
  return fmt::format("[{}]", Numbers(error));
}

std::optional<reference::ViabilityFilter> FilterOf(const JointLimits& limits) {
  try {
    return reference::ViabilityFilter(limits);
  } catch (const InputError&) {
    return {};  // the limits permit no filter: the page shows no margin
  }
}

const char* NameOf(BaseMode mode) {
  switch (mode) {
    case BaseMode::kStanding: return "stands";
    case BaseMode::kDriving: return "drives";
    case BaseMode::kEmergencyStop: break;
  }
  return "emergency stop";
}

}  // namespace

Status::Status(const JointLimits& limits, const PageScene& scene, rt::LatestValue<ArmView>& arm)
    : filter_(FilterOf(limits)), hand_(scene.hand), arm_(arm) {}

Time Status::now() {
  static_cast<void>(arm_.Refresh());
  return arm_.value().at;
}

std::string Status::Text(std::size_t camera) {
  const double t = ToSeconds(now().time_since_epoch());
  return fmt::format(R"("t":{:.3f},"camera":{},"no_picture":{},"arm":{},"base":{},"hand":{})", t,
                     camera, Quoted(no_picture_), ArmText(), BaseText(), HandText());
}

std::string Status::ArmText() const {
  if (!arm_.has_value()) return "null";
  const ArmView& arm = arm_.value();
  const bool has_margin = filter_ && arm.follows_reference;
  const double margin = has_margin ? filter_->Margin(arm.q_d, arm.dq_d, arm.ddq_d) : NAN;
  return fmt::format(
      R"({{"t":{:.3f},"q":[{}],"dq":[{}],"F":[{}],"O_T_EE":[{}],"error":{},"mode":{},"errors":[{}],"reflex":[{}],"served":{},"held":{},"margin":{}}})",
      ToSeconds(arm.at.time_since_epoch()), Numbers(arm.q), Numbers(arm.dq),
      Numbers(arm.O_F_ext_hat_K), Numbers(arm.O_T_EE), ErrorText(arm), Quoted(Name(arm.mode)),
      NamesOf(arm.errors), NamesOf(arm.reflex_reason), arm.served, arm.held,
      std::isfinite(margin) ? fmt::format("{:.4f}", margin) : "null");
}

std::string Status::BaseText() const {
  if (!arm_.has_value() || !arm_.value().base) return "null";
  const BaseState& state = *arm_.value().base;
  return fmt::format(R"({{"x":{:.4f},"y":{:.4f},"yaw":{:.4f},"v":{:.4f},"w":{:.4f},"mode":"{}"}})",
                     state.odometry.x, state.odometry.y, state.odometry.yaw, state.twist.v,
                     state.twist.w, NameOf(state.mode));
}

std::string Status::HandText() {
  if (hand_ == nullptr) return "null";
  try {
    const HandState state = hand_->ReadState();
    return fmt::format(R"({{"width":{:.4f},"vacuum":{},"is_grasped":{}}})", state.width,
                       state.pump ? fmt::format("{}", state.pump->vacuum) : "null",
                       state.is_grasped);
  } catch (const RobotFault&) {
    hand_ = nullptr;  // the hand does not answer: stop asking
    return "null";
  }
}

}  // namespace twin::page
