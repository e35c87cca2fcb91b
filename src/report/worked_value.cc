#include "report/worked_value.h"

#include <cmath>
#include <optional>

#include <fmt/format.h>
#include <Eigen/Core>

#include "twin/core/time.h"
#include "twin/model/transform.h"

namespace twin::report {
namespace {

using Eigen::Vector3d;

/// Steps and result of a calculation.
struct Working {
  std::vector<std::string> lines;
  double value = 0;
};

/// Largest relative difference of a calculation: permits rounding, but no filter.
constexpr double kSame = 1e-6;

/// Data of the last cycle.
struct Inputs {
  RobotState before;                    ///< the state that the command answers
  std::optional<RobotCommand> command;  ///< absent: the cycle held
  Violation violation;

  [[nodiscard]] std::size_t axis() const { return static_cast<std::size_t>(violation.axis); }
};

void Add(Working& working, std::string_view name, std::string_view formula,
         const std::string& numbers, double value, std::string_view unit) {
  working.lines.push_back(
      fmt::format("{} = {} = {} = {:.7g} {}", name, formula, numbers, value, unit));
  working.value = value;
}

/// (now - before) / T with the numbers inserted.
std::string Quotient(double now, double before) {
  return fmt::format("({:.10g} - {:.10g}) / 0.001", now, before);
}

/// Position of a joint, or its derivatives up to that of the error.
class JointChain {
 public:
  explicit JointChain(const Inputs& in) : in_(in), joint_(in.axis()) {}

  /// @param order  0 position, 1 velocity, 2 acceleration, 3 jerk.
  Working Run(int order) {
    AddVelocity();
    if (order == 0) AddPosition();
    if (order >= 2) AddAcceleration();
    if (order >= 3) {
      const double ddq_d = in_.before.ddq_d[joint_];
      Add(working_, "dddq", "(ddq - ddq_d) / T", Quotient(ddq_, ddq_d),
          (ddq_ - ddq_d) / kCycleSeconds, "rad/s^3");
    }
    return working_;
  }

 private:
  [[nodiscard]] bool by_position() const {
    return in_.before.motion_generator_mode == MotionGeneratorMode::kJointPosition;
  }

  void AddVelocity() {
    const double q_d = in_.before.q_d[joint_];
    const double dq_d = in_.before.dq_d[joint_];
    const double ddq_d = in_.before.ddq_d[joint_];
    if (!in_.command) {
      dq_ = dq_d + kCycleSeconds * ddq_d;
      Add(working_, "dq", "dq_d + T ddq_d, held",
          fmt::format("{:.10g} + 0.001 * {:.10g}", dq_d, ddq_d), dq_, "rad/s");
    } else if (by_position()) {
      const double q_c = in_.command->q_c[joint_];
      dq_ = (q_c - q_d) / kCycleSeconds;
      Add(working_, "dq", "(q_c - q_d) / T", Quotient(q_c, q_d), dq_, "rad/s");
    } else {
      dq_ = in_.command->dq_c[joint_];
      Add(working_, "dq", "dq_c", "commanded", dq_, "rad/s");
    }
  }

  void AddPosition() {
    const double q_d = in_.before.q_d[joint_];
    if (in_.command && by_position()) {
      Add(working_, "q", "q_c", "commanded", in_.command->q_c[joint_], "rad");
    } else {
      Add(working_, "q", "q_d + T dq", fmt::format("{:.10g} + 0.001 * {:.10g}", q_d, dq_),
          q_d + kCycleSeconds * dq_, "rad");
    }
  }

  void AddAcceleration() {
    const double dq_d = in_.before.dq_d[joint_];
    if (in_.command) {
      ddq_ = (dq_ - dq_d) / kCycleSeconds;
      Add(working_, "ddq", "(dq - dq_d) / T", Quotient(dq_, dq_d), ddq_, "rad/s^2");
    } else {
      ddq_ = in_.before.ddq_d[joint_];
      Add(working_, "ddq", "ddq_d", "held", ddq_, "rad/s^2");
    }
  }

  const Inputs& in_;
  const std::size_t joint_;
  Working working_;
  double dq_ = 0;
  double ddq_ = 0;
};

std::string Text(const Vector3d& v) {
  return fmt::format("({:.7g}, {:.7g}, {:.7g})", v.x(), v.y(), v.z());
}

Vector3d Part(const Vector6& v, std::size_t first) {
  return {v[first], v[first + 1], v[first + 2]};
}

void AddNorm(Working& working, std::string_view name, std::string_view formula, const Vector3d& v,
             std::string_view unit) {
  working.value = v.norm();
  working.lines.push_back(fmt::format("{0} = {1} = {2} {4}, |{0}| = {3:.7g} {4}", name, formula,
                                      Text(v), working.value, unit));
}

/// Derivatives of the end effector's position or rotation.
Working CartesianChain(const Inputs& in, int order) {
  const RobotState& s = in.before;
  const bool turns = in.axis() == 1;
  const std::size_t first = turns ? 3 : 0;
  const std::string_view length = turns ? "rad" : "m";
  const Vector3d last_dp = Part(s.O_dP_EE_c, first);
  const Vector3d last_ddp = Part(s.O_ddP_EE_c, first);
  Working working;
  Vector3d dp;
  if (!in.command) {
    dp = last_dp + kCycleSeconds * last_ddp;
    AddNorm(working, "dp", "O_dP_EE_c + T O_ddP_EE_c, held", dp, fmt::format("{}/s", length));
    return working;
  }
  if (s.motion_generator_mode == MotionGeneratorMode::kCartesianVelocity) {
    dp = Part(in.command->O_dP_EE_c, first);
    AddNorm(working, "dp", "commanded", dp, fmt::format("{}/s", length));
  } else {
    const Transform& to = in.command->O_T_EE_c;
    dp = turns ? model::TurnBetween(s.O_T_EE_c, to)
               : Vector3d(model::Position(to) - model::Position(s.O_T_EE_c));
    dp /= kCycleSeconds;
    AddNorm(working, "dp", turns ? "log(R_c R^T) / T" : "(p_c - p) / T", dp,
            fmt::format("{}/s", length));
  }
  if (order < 2) return working;
  const Vector3d ddp = (dp - last_dp) / kCycleSeconds;
  AddNorm(working, "ddp", "(dp - O_dP_EE_c) / T", ddp, fmt::format("{}/s^2", length));
  if (order < 3) return working;
  const Vector3d dddp = (ddp - last_ddp) / kCycleSeconds;
  AddNorm(working, "dddp", "(ddp - O_ddP_EE_c) / T", dddp, fmt::format("{}/s^3", length));
  return working;
}

/// Derivatives of the commanded elbow.
std::optional<Working> ElbowChain(const Inputs& in, int order) {
  if (!in.command || !in.command->valid_elbow) return std::nullopt;
  const RobotState& s = in.before;
  Working working;
  const double angle = in.command->elbow_c[0];
  const double d = (angle - s.elbow_c[0]) / kCycleSeconds;
  Add(working, "delbow", "(elbow - elbow_c) / T", Quotient(angle, s.elbow_c[0]), d, "rad/s");
  if (order < 2) return working;
  const double dd = (d - s.delbow_c[0]) / kCycleSeconds;
  Add(working, "ddelbow", "(delbow - delbow_c) / T", Quotient(d, s.delbow_c[0]), dd, "rad/s^2");
  if (order < 3) return working;
  Add(working, "dddelbow", "(ddelbow - ddelbow_c) / T", Quotient(dd, s.ddelbow_c[0]),
      (dd - s.ddelbow_c[0]) / kCycleSeconds, "rad/s^3");
  return working;
}

std::optional<Working> CartesianOrElbow(const Inputs& in, int order) {
  if (in.violation.axis < 0 || in.violation.axis > 2) return std::nullopt;
  return in.violation.axis == 2 ? ElbowChain(in, order) : std::optional(CartesianChain(in, order));
}

std::optional<Working> StartDistance(const Inputs& in) {
  if (!in.command) return std::nullopt;
  const double q_c = in.command->q_c[in.axis()];
  const double q_d = in.before.q_d[in.axis()];
  Working working;
  Add(working, "distance", "|q_c - q_d|", fmt::format("|{:.10g} - {:.10g}|", q_c, q_d),
      std::abs(q_c - q_d), "rad");
  return working;
}

std::optional<Working> TorqueRate(const Inputs& in) {
  if (!in.command) return std::nullopt;
  const double now = in.command->tau_J_d[in.axis()];
  const double before = in.before.tau_J_d[in.axis()];
  Working working;
  Add(working, "rate", "(tau_d - tau_J_d) / T", Quotient(now, before),
      (now - before) / kCycleSeconds, "Nm/s");
  return working;
}

std::optional<Working> Work(const Inputs& in) {
  const bool has_joint = in.violation.axis >= 0 && in.axis() < kJoints;
  switch (in.violation.error) {
    case RobotError::kCartesianMotionGeneratorVelocityLimitsViolation:
      return CartesianOrElbow(in, 1);
    case RobotError::kCartesianMotionGeneratorVelocityDiscontinuity: return CartesianOrElbow(in, 2);
    case RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity:
      return CartesianOrElbow(in, 3);
    default: break;
  }
  if (!has_joint) return std::nullopt;
  switch (in.violation.error) {
    case RobotError::kJointPositionMotionGeneratorStartPoseInvalid: return StartDistance(in);
    case RobotError::kJointMotionGeneratorPositionLimitsViolation: return JointChain(in).Run(0);
    case RobotError::kJointMotionGeneratorVelocityLimitsViolation: return JointChain(in).Run(1);
    case RobotError::kJointMotionGeneratorVelocityDiscontinuity: return JointChain(in).Run(2);
    case RobotError::kJointMotionGeneratorAccelerationDiscontinuity: return JointChain(in).Run(3);
    case RobotError::kControllerTorqueDiscontinuity: return TorqueRate(in);
    default: return std::nullopt;
  }
}

}  // namespace

std::vector<std::string> WorkOut(const RunEnd& end) {
  const EndCycle& last = end.cycles.back();
  if (end.cycles.size() < 2) return {};
  Inputs in{end.before().state, std::nullopt, last.cycle.violation};
  if (last.cycle.fate != record::CommandFate::kHeld) {
    if (!last.written()) return {};
    in.command = last.answer->command;
  }
  const std::optional<Working> working = Work(in);
  if (!working) return {};
  if (std::abs(working->value - in.violation.value) <= kSame * std::abs(in.violation.value)) {
    return working->lines;
  }
  if (!in.command || !in.command->motion_generation_finished) return {};
  return {
      "the command asks to end the motion, and keeps every limit itself; what breaks this one is "
      "coming to rest right after it. A motion may end only when it all but stands still"};
}

}  // namespace twin::report
