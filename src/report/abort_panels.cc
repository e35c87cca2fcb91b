#include "report/abort_panels.h"

#include <functional>
#include <limits>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Core>

#include "report/script.h"
#include "twin/core/error_catalogue.h"
#include "twin/core/joint_vector.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"

namespace twin::report {
namespace {

constexpr double kNoLimit = std::numeric_limits<double>::quiet_NaN();
constexpr std::string_view kCommandColour = "#1b7f5c";  ///< green: the workstation's commands

using Value = std::function<double(const EndCycle&)>;

std::vector<double> Values(const RunEnd& end, const Value& value) {
  std::vector<double> values;
  for (const EndCycle& cycle : end.cycles) values.push_back(value(cycle));
  return values;
}

/// Backward differences over one cycle; none for the first cycle.
std::vector<double> Rates(std::vector<double> values) {
  for (std::size_t i = values.size(); i-- > 1;) {
    values[i] = (values[i] - values[i - 1]) / kCycleSeconds;
  }
  values.front() = kNoLimit;
  return values;
}

/// A component of the state, or of the cycle's record.
template <auto Member>
Value Of(std::size_t index) {
  return [index](const EndCycle& c) {
    if constexpr (requires { c.cycle.*Member; }) {
      return (c.cycle.*Member)[index];
    } else {
      return (c.cycle.state.*Member)[index];
    }
  };
}

/// A component of the written command.
template <auto Member>
Value Commanded(std::size_t index) {
  return [index](const EndCycle& c) {
    return c.written() ? (c.answer->command.*Member)[index] : kNoLimit;
  };
}

/// Collects panels; that of the error comes first.
class Panels {
 public:
  explicit Panels(const RunEnd& end) : end_(end) {
    // Some logs have no details of their violations.
    if (end.last().violated) violation_ = end.last().violation;
  }

  std::vector<EndPanel> Make();

 private:
  EndPanel& Add(std::string title, std::string unit) {
    panels_.push_back({.title = std::move(title), .unit = std::move(unit)});
    return panels_.back();
  }
  void AddCurve(std::string name, std::string_view colour, const Value& value) {
    panels_.back().curves.push_back({std::move(name), colour, Values(end_, value)});
  }
  void AddPoints(std::string name, const Value& value) {
    panels_.back().curves.push_back({std::move(name), kCommandColour, Values(end_, value), true});
  }
  void SetLimits(std::vector<double> limits) { panels_.back().limits = std::move(limits); }
  /// Marks the last panel as that of the error: moves it to the front, with the limit in view.
  void Offend(bool both_signs);
  void OffendIf(std::initializer_list<RobotError> errors, bool both_signs);

  void AddReference(std::size_t joint);
  void AddMeasuredJoint(std::size_t joint);
  void AddTorques(std::size_t joint);
  void AddExternal(std::size_t joint);
  void AddForce(std::size_t axis);
  void AddCartesian(std::size_t axis);
  void AddElbow();
  void AddMeasuredSpeed(std::size_t axis);
  void AddAllJoints();
  void AddPower();
  void AddSelfDistance();
  void AddTimes();

  const RunEnd& end_;
  std::optional<Violation> violation_;
  std::vector<EndPanel> panels_;
};

void Panels::Offend(bool both_signs) {
  EndPanel panel = std::move(panels_.back());
  panels_.pop_back();
  panel.limits = {violation_->limit};
  if (both_signs) panel.limits.push_back(-violation_->limit);
  panel.limits_in_view = true;
  panel.offender = violation_->value;
  panels_.insert(panels_.begin(), std::move(panel));
}

void Panels::OffendIf(std::initializer_list<RobotError> errors, bool both_signs) {
  if (!violation_) return;
  for (const RobotError error : errors) {
    if (error == violation_->error) return Offend(both_signs);
  }
}

void Panels::AddReference(std::size_t joint) {
  const auto& limits = end_.run.limits;
  const std::string name = fmt::format("joint {}: ", joint + 1);
  Add(name + "position", "rad");
  AddCurve("q, measured", kMeasuredColour, Of<&RobotState::q>(joint));
  AddCurve("q_d, desired", kReferenceColour, Of<&RobotState::q_d>(joint));
  const MotionGeneratorMode generator = end_.before().state.motion_generator_mode;
  if (generator == MotionGeneratorMode::kJointPosition) {
    AddPoints("q_c, sent", Commanded<&RobotCommand::q_c>(joint));
  }
  if (limits) SetLimits({limits->joints.q_min[joint], limits->joints.q_max[joint]});
  OffendIf({RobotError::kJointMotionGeneratorPositionLimitsViolation,
            RobotError::kJointPositionLimitsViolation,
            RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation},
           false);
  Add(name + "velocity", "rad/s");
  AddCurve("dq, measured", kMeasuredColour, Of<&RobotState::dq>(joint));
  AddCurve("dq_d, desired", kReferenceColour, Of<&RobotState::dq_d>(joint));
  if (generator == MotionGeneratorMode::kJointVelocity) {
    AddPoints("dq_c, sent", Commanded<&RobotCommand::dq_c>(joint));
  }
  if (limits) SetLimits({-limits->joints.dq_max[joint], limits->joints.dq_max[joint]});
  OffendIf({RobotError::kJointMotionGeneratorVelocityLimitsViolation,
            RobotError::kJointVelocityViolation,
            RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation},
           true);
  Add(name + "acceleration of the reference", "rad/s²");
  AddCurve("ddq_d", kReferenceColour, Of<&RobotState::ddq_d>(joint));
  if (limits) SetLimits({-limits->joints.ddq_max[joint], limits->joints.ddq_max[joint]});
  OffendIf({RobotError::kJointMotionGeneratorVelocityDiscontinuity,
            RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity},
           true);
  Add(name + "jerk of the reference", "rad/s³");
  AddCurve("dddq_d", kReferenceColour, Of<&record::CycleRecord::dddq_d>(joint));
  if (limits) SetLimits({-limits->joints.dddq_max[joint], limits->joints.dddq_max[joint]});
  OffendIf({RobotError::kJointMotionGeneratorAccelerationDiscontinuity,
            RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity},
           true);
}

void Panels::AddTorques(std::size_t joint) {
  const std::string name = fmt::format("joint {}: ", joint + 1);
  Add(name + "rate of the commanded torque", "Nm/s");
  panels_.back().curves.push_back(
      {"dtau_J_d", kReferenceColour, Rates(Values(end_, Of<&RobotState::tau_J_d>(joint)))});
  OffendIf({RobotError::kControllerTorqueDiscontinuity}, true);
  Add(name + "torque without gravity and friction", "Nm");
  AddCurve("tau_J_d, accepted", kReferenceColour, Of<&RobotState::tau_J_d>(joint));
  AddPoints("tau_J_d, sent", Commanded<&RobotCommand::tau_J_d>(joint));
  Add(name + "measured torque, gravity included", "Nm");
  AddCurve("tau_J", kMeasuredColour, Of<&RobotState::tau_J>(joint));
  OffendIf({RobotError::kTauJRangeViolation}, true);
}

void Panels::AddMeasuredJoint(std::size_t joint) {
  const std::string name = fmt::format("joint {}: ", joint + 1);
  Add(name + "position", "rad");
  AddCurve("q, measured", kMeasuredColour, Of<&RobotState::q>(joint));
  AddCurve("q_d, desired", kReferenceColour, Of<&RobotState::q_d>(joint));
  Add(name + "velocity", "rad/s");
  AddCurve("dq, measured", kMeasuredColour, Of<&RobotState::dq>(joint));
  AddCurve("dq_d, desired", kReferenceColour, Of<&RobotState::dq_d>(joint));
}

void Panels::AddExternal(std::size_t joint) {
  Add(fmt::format("joint {}: external torque", joint + 1), "Nm");
  AddCurve("tau_ext_hat_filtered", kMeasuredColour, Of<&RobotState::tau_ext_hat_filtered>(joint));
  OffendIf({RobotError::kJointReflex}, true);
  Add(fmt::format("joint {}: measured torque, gravity included", joint + 1), "Nm");
  AddCurve("tau_J", kMeasuredColour, Of<&RobotState::tau_J>(joint));
}

void Panels::AddForce(std::size_t axis) {
  const Violation& v = *violation_;
  Add(fmt::format("external {} on K, {}", axis < 3 ? "force" : "torque", AxisName(v)),
      axis < 3 ? "N" : "Nm");
  AddCurve("K_F_ext_hat_K", kMeasuredColour, Of<&RobotState::K_F_ext_hat_K>(axis));
  Offend(true);
  Add("size of the external force and torque on K", "N, Nm");
  AddCurve("force", kReferenceColour,
           [](const EndCycle& c) { return HalfNorm(c.cycle.state.K_F_ext_hat_K, 0); });
  AddCurve("torque", kMeasuredColour,
           [](const EndCycle& c) { return HalfNorm(c.cycle.state.K_F_ext_hat_K, 3); });
  AddMeasuredSpeed(axis < 3 ? 0 : 1);
}

void Panels::AddMeasuredSpeed(std::size_t axis) {
  const bool turns = axis == 1;
  const std::size_t first = turns ? 3 : 0;
  Add(turns ? "turning of the end effector" : "speed of the end effector", turns ? "rad/s" : "m/s");
  AddCurve("measured", kMeasuredColour, [first](const EndCycle& c) {
    const RobotState& s = c.cycle.state;
    return HalfNorm(model::ArmModel::Panda().Twist(model::Frame::kEndEffector,
                                                   model::Configuration(s.q), s.dq, s.F_T_EE),
                    first);
  });
  AddCurve("O_dP_EE_d, desired", kReferenceColour,
           [first](const EndCycle& c) { return HalfNorm(c.cycle.state.O_dP_EE_d, first); });
  OffendIf({RobotError::kCartesianVelocityViolation}, false);
}

void Panels::AddCartesian(std::size_t axis) {
  const bool turns = axis == 1;
  const std::size_t first = turns ? 3 : 0;
  const std::string_view length = turns ? "rad" : "m";
  const std::string what = turns ? "end effector, rotation: " : "end effector: ";
  const Transform from = end_.cycles.front().cycle.state.O_T_EE_c;
  Add(what + "way since the first of these cycles", std::string(length));
  AddCurve("O_T_EE_c, commanded", kReferenceColour, [turns, from](const EndCycle& c) {
    const Transform& X = c.cycle.state.O_T_EE_c;
    return turns ? model::TurnBetween(from, X).norm()
                 : (model::Position(X) - model::Position(from)).norm();
  });
  Add(what + "velocity", fmt::format("{}/s", length));
  AddCurve("|O_dP_EE_c|", kReferenceColour,
           [first](const EndCycle& c) { return HalfNorm(c.cycle.state.O_dP_EE_c, first); });
  OffendIf({RobotError::kCartesianMotionGeneratorVelocityLimitsViolation}, false);
  Add(what + "acceleration", fmt::format("{}/s²", length));
  AddCurve("|O_ddP_EE_c|", kReferenceColour,
           [first](const EndCycle& c) { return HalfNorm(c.cycle.state.O_ddP_EE_c, first); });
  OffendIf({RobotError::kCartesianMotionGeneratorVelocityDiscontinuity}, false);
  Add(what + "jerk", fmt::format("{}/s³", length));
  std::vector<double> jerk;
  for (std::size_t i = 0; i < end_.cycles.size(); ++i) {
    Vector6 step = end_.cycles[i].cycle.state.O_ddP_EE_c;
    if (i > 0) {
      for (std::size_t k = 0; k < step.size(); ++k) {
        step[k] -= end_.cycles[i - 1].cycle.state.O_ddP_EE_c[k];
      }
    }
    jerk.push_back(i > 0 ? HalfNorm(step, first) / kCycleSeconds : kNoLimit);
  }
  panels_.back().curves.push_back({"|difference of O_ddP_EE_c| / T", kReferenceColour, jerk});
  OffendIf({RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity}, false);
}

void Panels::AddElbow() {
  Add("elbow: angle of joint 3", "rad");
  AddCurve("elbow, measured", kMeasuredColour, Of<&RobotState::elbow>(0));
  AddCurve("elbow_c, commanded", kReferenceColour, Of<&RobotState::elbow_c>(0));
  OffendIf({RobotError::kCartesianMotionGeneratorElbowLimitViolation}, false);
  Add("elbow: velocity", "rad/s");
  AddCurve("delbow_c", kReferenceColour, Of<&RobotState::delbow_c>(0));
  OffendIf({RobotError::kCartesianMotionGeneratorVelocityLimitsViolation}, true);
  Add("elbow: acceleration", "rad/s²");
  AddCurve("ddelbow_c", kReferenceColour, Of<&RobotState::ddelbow_c>(0));
  OffendIf({RobotError::kCartesianMotionGeneratorVelocityDiscontinuity}, true);
  Add("elbow: jerk", "rad/s³");
  panels_.back().curves.push_back(
      {"dddelbow", kReferenceColour, Rates(Values(end_, Of<&RobotState::ddelbow_c>(0)))});
  OffendIf({RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity}, true);
}

void Panels::AddAllJoints() {
  // Seven distinguishable colours, dark to light.
  constexpr std::string_view kColours[] = {"#0b3c6f", "#1b7f5c", "#7a2a90", "#c0272d",
                                           "#f0a030", "#5b8fd0", "#888888"};
  Add("velocities of the joints, measured", "rad/s");
  for (std::size_t i = 0; i < kJoints; ++i) {
    AddCurve(fmt::format("joint {}", i + 1), kColours[i], Of<&RobotState::dq>(i));
  }
  Add("torques of the joints, measured", "Nm");
  for (std::size_t i = 0; i < kJoints; ++i) {
    AddCurve(fmt::format("joint {}", i + 1), kColours[i], Of<&RobotState::tau_J>(i));
  }
}

void Panels::AddPower() {
  Add("power of the joints together, by the torques measured", "W");
  AddCurve("sum of tau_J dq", kMeasuredColour, [](const EndCycle& c) {
    double power = 0;
    for (std::size_t i = 0; i < kJoints; ++i) power += c.cycle.state.tau_J[i] * c.cycle.state.dq[i];
    return power;
  });
  OffendIf({RobotError::kPowerLimitViolation}, false);
}

void Panels::AddSelfDistance() {
  Add("least distance of the arm's parts", "m");
  AddCurve("at the measured q", kMeasuredColour, [](const EndCycle& c) {
    const bool with_hand = c.cycle.state.m_ee > 0;
    return model::SelfDistance(model::Configuration(c.cycle.state.q), with_hand);
  });
  OffendIf({RobotError::kSelfCollisionAvoidanceViolation}, false);
}

void Panels::AddTimes() {
  Add("cycles in a row without a command", "cycles");
  AddCurve("lost in a row", kHeldColour,
           [](const EndCycle& c) { return static_cast<double>(c.cycle.lost_in_row); });
  // Before a motion's first command, losses are not counted.
  if (violation_ && violation_->axis < 0) Offend(false);
  Add("when the workstation was done, after the cycle whose state it answers", "µs");
  const auto after = [](Time record::TickRecord::*when) {
    return [when](const EndCycle& c) {
      if (!c.answer || (when == &record::TickRecord::written && !c.written())) return kNoLimit;
      // The state was sent one cycle before this one.
      return ToSeconds((*c.answer).*when - (c.cycle.at - kCycle)) * 1e6;
    };
  };
  AddCurve("state read", kMeasuredColour, after(&record::TickRecord::read));
  AddPoints("command written", after(&record::TickRecord::written));
  SetLimits({1000});
  panels_.back().limits_in_view = true;
}

std::vector<EndPanel> Panels::Make() {
  if (!violation_) {
    AddAllJoints();
    return std::move(panels_);
  }
  const AxisKind kind = EntryOf(*violation_).axis;
  const bool has_axis = !AxisName(*violation_).empty();
  const auto axis = has_axis ? static_cast<std::size_t>(violation_->axis) : 0;
  switch (violation_->error) {
    case RobotError::kCommunicationConstraintsViolation: AddTimes(); break;
    case RobotError::kJointReflex:
      AddExternal(axis);
      AddMeasuredJoint(axis);
      break;
    case RobotError::kControllerTorqueDiscontinuity:
    case RobotError::kTauJRangeViolation:
      AddTorques(axis);
      AddMeasuredJoint(axis);
      break;
    case RobotError::kPowerLimitViolation:
      AddPower();
      AddAllJoints();
      break;
    case RobotError::kSelfCollisionAvoidanceViolation:
      AddSelfDistance();
      AddAllJoints();
      break;
    case RobotError::kCartesianVelocityViolation:
      if (axis < 2) AddMeasuredSpeed(axis);
      AddAllJoints();
      break;
    default:
      if (kind == AxisKind::kJoint) {
        AddReference(axis);
      } else if (kind == AxisKind::kWrench && has_axis) {
        AddForce(axis);
      } else if (kind == AxisKind::kMotion) {
        axis == 2 ? AddElbow() : AddCartesian(axis);
      } else {
        AddAllJoints();
      }
  }
  return std::move(panels_);
}

}  // namespace

std::vector<EndPanel> EndPanels(const RunEnd& end) {
  return Panels(end).Make();
}

}  // namespace twin::report
