#include "twin/teleop/teleoperator_config.h"

#include <string>
#include <string_view>

#include <fmt/format.h>

#include "twin/core/error.h"

namespace twin::teleop {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr double kSmallest = 1e-4;
constexpr double kFar = 2;  // m: beyond any reach

/// Largest values, in m or rad.
constexpr MotionBounds kMostAlong{.speed = 1.7, .acceleration = 13, .jerk = 6500};
constexpr MotionBounds kMostAbout{.speed = 2.5, .acceleration = 25, .jerk = 12500};
constexpr MotionBounds kMostOfJoint{.speed = 1, .acceleration = 7, .jerk = 3500};
constexpr MotionBounds kMostOfBase{.speed = 3, .acceleration = 5, .jerk = 500};

void Require(std::string_view what, const MotionBounds& bounds, const MotionBounds& most) {
  const auto field = [what](std::string_view name) {
    return fmt::format("operator: {}.{}", what, name);
  };
  RequireInRange(field("speed"), bounds.speed, kSmallest, most.speed);
  RequireInRange(field("acceleration"), bounds.acceleration, kSmallest, most.acceleration);
  RequireInRange(field("jerk"), bounds.jerk, kSmallest, most.jerk);
}

void Read(control::ParameterReader& p, const std::string& key, bool turns, const MotionBounds& most,
          MotionBounds& bounds) {
  bounds.speed =
      p.Quantity(key + ".speed", turns ? Dimension::kAngularVelocity : Dimension::kVelocity,
                 bounds.speed, kSmallest, most.speed);
  bounds.acceleration = p.Quantity(
      key + ".acceleration", turns ? Dimension::kAngularAcceleration : Dimension::kAcceleration,
      bounds.acceleration, kSmallest, most.acceleration);
  bounds.jerk = p.Quantity(key + ".jerk", turns ? Dimension::kAngularJerk : Dimension::kJerk,
                           bounds.jerk, kSmallest, most.jerk);
}

void Read(control::ParameterReader& p, MappingConfig& m) {
  m.dead_zone = p.Number("mapping.dead_zone", m.dead_zone, 0, 0.5);
  m.fine = p.Number("mapping.fine", m.fine, 0.01, 1);
  m.pose_scale = p.Number("mapping.pose_scale", m.pose_scale, 0.01, 10);
  m.full_way = p.Quantity("mapping.full_way", Dimension::kLength, m.full_way, 1e-3, 1);
  m.full_turn = p.Quantity("mapping.full_turn", Dimension::kAngle, m.full_turn, 1e-2, 3);
}

void Read(control::ParameterReader& p, Workspace& w) {
  w.low = p.Vector("workspace.low", Dimension::kLength, w.low, -kFar, kFar);
  w.high = p.Vector("workspace.high", Dimension::kLength, w.high, -kFar, kFar);
  w.nearest = p.Quantity("workspace.nearest", Dimension::kLength, w.nearest, 0, kFar);
  w.farthest = p.Quantity("workspace.farthest", Dimension::kLength, w.farthest, 0, kFar);
  w.press = p.Quantity("workspace.press", Dimension::kLength, w.press, 1e-3, 0.2);
  w.wring = p.Quantity("workspace.wring", Dimension::kAngle, w.wring, 1e-2, 1);
  w.touch = p.Bool("workspace.touch", w.touch);
}

void Read(control::ParameterReader& p, FeedbackConfig& f) {
  f.scale = p.Number("feedback.scale", f.scale, 0, 10);
  f.cutoff_hz = p.Quantity("feedback.cutoff", Dimension::kFrequency, f.cutoff_hz, 0.1, 500);
  f.dead_force = p.Quantity("feedback.dead_force", Dimension::kForce, f.dead_force, 0, 100);
  f.dead_torque = p.Quantity("feedback.dead_torque", Dimension::kTorque, f.dead_torque, 0, 100);
  f.most_force = p.Quantity("feedback.most_force", Dimension::kForce, f.most_force, 0.01, 100);
  f.most_torque = p.Quantity("feedback.most_torque", Dimension::kTorque, f.most_torque, 1e-3, 10);
  f.passive = p.Bool("feedback.passive", f.passive);
  f.reserve = p.Number("feedback.reserve", f.reserve, 1e-6, 1);
  f.damping = p.Quantity("feedback.damping", Dimension::kLinearDamping, f.damping, 0.1, 1000);
  f.turn_damping =
      p.Quantity("feedback.turn_damping", Dimension::kAngularDamping, f.turn_damping, 1e-3, 100);
  f.stick_way = p.Quantity("feedback.stick_way", Dimension::kLength, f.stick_way, 1e-4, 1);
  f.stick_turn = p.Quantity("feedback.stick_turn", Dimension::kAngle, f.stick_turn, 1e-3, 3);
}

}  // namespace

void TeleoperatorConfig::Validate() const {
  RequireInRange("operator: stale_after", ToSeconds(stale_after), 0.01, 10);
  Require("arm.along", along, kMostAlong);
  Require("arm.about", about, kMostAbout);
  Require("arm.joint", joint, kMostOfJoint);
  Require("base.ahead", ahead, kMostOfBase);
  Require("base.turning", turning, kMostOfBase);
  for (std::size_t i = 0; i < 3; ++i) {
    if (workspace.low[i] < workspace.high[i]) continue;
    throw InputError(
        fmt::format("operator: workspace.low is {} m and workspace.high {} m along {}; the low end "
                    "must be below the high one",
                    workspace.low[i], workspace.high[i], "xyz"[i]));
  }
  if (!(workspace.nearest < workspace.farthest)) {
    throw InputError(
        fmt::format("operator: workspace.nearest is {} m and workspace.farthest {} m; the first "
                    "must be less",
                    workspace.nearest, workspace.farthest));
  }
  RequireInRange("operator: mapping.dead_zone", mapping.dead_zone, 0, 0.5);
  RequireInRange("operator: mapping.fine", mapping.fine, 0.01, 1);
  RequireInRange("operator: feedback.reserve", feedback.reserve, 1e-6, 1);
  RequireInRange("operator: feedback.cutoff", feedback.cutoff_hz, 0.1, 500);
}

TeleoperatorConfig ReadTeleoperatorConfig(control::ParameterReader& p) {
  TeleoperatorConfig c;
  c.stale_after = p.Time("stale_after", c.stale_after, milliseconds(10), seconds(10));
  Read(p, "arm.along", false, kMostAlong, c.along);
  Read(p, "arm.about", true, kMostAbout, c.about);
  Read(p, "arm.joint", true, kMostOfJoint, c.joint);
  Read(p, "base.ahead", false, kMostOfBase, c.ahead);
  Read(p, "base.turning", true, kMostOfBase, c.turning);
  Read(p, c.mapping);
  Read(p, c.workspace);
  Read(p, c.feedback);
  c.Validate();
  return c;
}

}  // namespace twin::teleop
