#include "twin/core/setting.h"

#include <cmath>

#include <fmt/format.h>

namespace twin {
namespace {

using setting::CollisionBehavior;
using Finding = std::optional<BadValue>;

/// Range of one kind of value.
struct Range {
  double least;
  double most;
  std::string_view text;
};
constexpr Range kJointStiffness{0, 14250, "in [0, 14250] Nm/rad"};
constexpr Range kTranslationalStiffness{10, 3000, "in [10, 3000] N/m"};
constexpr Range kRotationalStiffness{1, 300, "in [1, 300] Nm/rad"};
constexpr Range kThreshold{0, 1e6, "finite and not negative"};
constexpr Range kMass{0, 100, "in [0, 100] kg"};
constexpr double kFar = 10;  // m
constexpr Range kLength{-kFar, kFar, "in [-10, 10] m"};
constexpr Range kInertia{-100, 100, "in [-100, 100] kg m^2"};
constexpr Range kCutoff{1, 1000, "in [1, 1000] Hz"};

Finding Check(std::string_view field, double value, const Range& range,
              std::optional<int> index = {}) noexcept {
  if (value >= range.least && value <= range.most) return {};
  return BadValue{field, index, value, range.text};
}

template <std::size_t N>
Finding Check(std::string_view field, const std::array<double, N>& values,
              const Range& range) noexcept {
  for (std::size_t i = 0; i < N; ++i) {
    if (const Finding found = Check(field, values[i], range, static_cast<int>(i))) return found;
  }
  return {};
}

/// The first finding, if any.
template <typename... Rest>
Finding First(const Finding& finding, const Rest&... rest) noexcept {
  if constexpr (sizeof...(rest) == 0) {
    return finding;
  } else {
    return finding ? finding : First(rest...);
  }
}

template <std::size_t N>
Finding CheckPair(std::string_view lower_name, const std::array<double, N>& lower,
                  std::string_view upper_name, const std::array<double, N>& upper) noexcept {
  const Finding found =
      First(Check(lower_name, lower, kThreshold), Check(upper_name, upper, kThreshold));
  if (found) return found;
  for (std::size_t i = 0; i < N; ++i) {
    if (lower[i] <= upper[i]) continue;
    return BadValue{lower_name, static_cast<int>(i), lower[i], "at most its upper threshold"};
  }
  return {};
}

Finding CheckFrame(std::string_view field, const Transform& X) noexcept {
  const bool is_near =
      std::abs(X[12]) <= kFar && std::abs(X[13]) <= kFar && std::abs(X[14]) <= kFar;
  if (is_near && IsRigid(X)) return {};
  return BadValue{field, {}, {}, "a rigid transform, 4 x 4 column-major, within 10 m"};
}

Finding Find(const setting::JointImpedance& impedance) noexcept {
  return Check("K_theta", impedance.K_theta, kJointStiffness);
}

Finding Find(const setting::CartesianImpedance& impedance) noexcept {
  for (int i = 0; i < 6; ++i) {
    const Range& range = i < 3 ? kTranslationalStiffness : kRotationalStiffness;
    const double K = impedance.K_x[static_cast<std::size_t>(i)];
    if (const Finding found = Check("K_x", K, range, i)) return found;
  }
  return {};
}

Finding Find(const CollisionBehavior& b) noexcept {
  return First(CheckPair("lower_torque_thresholds_acceleration", b.lower_torque_acc,
                         "upper_torque_thresholds_acceleration", b.upper_torque_acc),
               CheckPair("lower_torque_thresholds_nominal", b.lower_torque_nominal,
                         "upper_torque_thresholds_nominal", b.upper_torque_nominal),
               CheckPair("lower_force_thresholds_acceleration", b.lower_force_acc,
                         "upper_force_thresholds_acceleration", b.upper_force_acc),
               CheckPair("lower_force_thresholds_nominal", b.lower_force_nominal,
                         "upper_force_thresholds_nominal", b.upper_force_nominal));
}

Finding Find(const setting::GuidingMode& /*mode*/) noexcept {
  return {};
}
Finding Find(const setting::StiffnessFrame& frame) noexcept {
  return CheckFrame("EE_T_K", frame.EE_T_K);
}
Finding Find(const setting::EndEffectorFrame& frame) noexcept {
  return CheckFrame("NE_T_EE", frame.NE_T_EE);
}

Finding Find(const setting::Load& load) noexcept {
  const Finding found =
      First(Check("load_mass", load.m_load, kMass), Check("F_x_Cload", load.F_x_Cload, kLength),
            Check("load_inertia", load.I_load, kInertia));
  if (found) return found;
  const bool is_body = load.m_load == 0 ? load.I_load == Matrix3{} : IsInertiaOfBody(load.I_load);
  if (is_body) return {};
  return BadValue{"load_inertia",
                  {},
                  {},
                  "that of a body (symmetric, no principal moment negative or above the other two "
                  "together; 0 without a mass)"};
}

Finding Find(const setting::Filters& f) noexcept {
  return First(Check("joint_position_filter_frequency", f.joint_position_hz, kCutoff),
               Check("joint_velocity_filter_frequency", f.joint_velocity_hz, kCutoff),
               Check("cartesian_position_filter_frequency", f.cartesian_position_hz, kCutoff),
               Check("cartesian_velocity_filter_frequency", f.cartesian_velocity_hz, kCutoff),
               Check("controller_filter_frequency", f.controller_hz, kCutoff));
}

}  // namespace

std::optional<BadValue> FindBadValue(const Setting& setting) noexcept {
  return std::visit([](const auto& one) { return Find(one); }, setting);
}

std::string Describe(const BadValue& bad) {
  const std::string where =
      bad.index ? fmt::format("{}[{}]", bad.field, *bad.index) : std::string(bad.field);
  if (!bad.value) return fmt::format("{} must be {}", where, bad.allowed);
  return fmt::format("{} is {}; it must be {}", where, *bad.value, bad.allowed);
}

std::string_view Name(const Setting& setting) noexcept {
  return std::visit([](const auto& one) { return one.kName; }, setting);
}

bool IsRigid(const Transform& X) noexcept {
  constexpr double kTolerance = 1e-5;
  const auto column = [&](std::size_t c, std::size_t r) { return X[4 * c + r]; };
  const bool last_row = X[3] == 0 && X[7] == 0 && X[11] == 0 && X[15] == 1;
  if (!last_row) return false;
  for (const double x : X) {
    if (!std::isfinite(x)) return false;
  }
  for (std::size_t a = 0; a < 3; ++a) {
    for (std::size_t b = a; b < 3; ++b) {
      double dot = 0;
      for (std::size_t r = 0; r < 3; ++r) dot += column(a, r) * column(b, r);
      if (!(std::abs(dot - (a == b ? 1 : 0)) <= kTolerance)) return false;
    }
  }
  const double handed = column(0, 0) * (column(1, 1) * column(2, 2) - column(1, 2) * column(2, 1)) +
                        column(0, 1) * (column(1, 2) * column(2, 0) - column(1, 0) * column(2, 2)) +
                        column(0, 2) * (column(1, 0) * column(2, 1) - column(1, 1) * column(2, 0));
  return handed > 0;
}

bool IsInertiaOfBody(const Matrix3& I) noexcept {
  constexpr double kTolerance = 1e-6;  // of the trace
  if (I == Matrix3{}) return true;
  const double trace = I[0] + I[4] + I[8];
  const double tolerance = kTolerance * trace;
  for (const double skew : {I[1] - I[3], I[2] - I[6], I[5] - I[7]}) {
    if (!(std::abs(skew) <= tolerance)) return false;
  }
  // Sylvester's criterion for Sigma + tolerance 1. NaN fails every comparison.
  const double xx = trace / 2 - I[0] + tolerance;
  const double yy = trace / 2 - I[4] + tolerance;
  const double zz = trace / 2 - I[8] + tolerance;
  const double xy = -I[1];
  const double xz = -I[2];
  const double yz = -I[5];
  const double minor = xx * yy - xy * xy;
  const double determinant = zz * minor - xx * yz * yz - yy * xz * xz + 2 * xy * xz * yz;
  return xx > 0 && minor > 0 && determinant > 0;
}

}  // namespace twin
