#include "twin/teleop/led_posture.h"

#include <algorithm>

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "twin/model/transform.h"

namespace twin::teleop {
namespace {

constexpr double kPostureDamping = 1e-4;  // d, m^2, rad^2
constexpr double kTracking = 5;           // k, 1/s
constexpr double kCentring = 1;           // 1/s
constexpr double kFade = 5;               // 1/s

}  // namespace

void LedPosture::Follow(const reference::PoseTarget& x_d, const Transform& F_T_EE, double T,
                        bool centres) noexcept {
  using Matrix6 = Eigen::Matrix<double, 6, 6>;
  const model::FrameMotion here = arm_.MotionOf(model::Frame::kEndEffector, now_.q, F_T_EE);
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(here.J.data());
  using ConstVector6 = Eigen::Map<const Eigen::Matrix<double, 6, 1>>;
  const Vector6 way = model::WayTo(here.O_T_frame, x_d.O_T_EE);
  const Eigen::Matrix<double, 6, 1> u =
      kTracking * ConstVector6(way.data()) + ConstVector6(x_d.O_dP_EE.data());
  centring_ = std::clamp(centring_ + (centres ? kFade : -kFade) * T, 0.0, 1.0);
  Eigen::Matrix<double, 7, 1> z;
  for (std::size_t i = 0; i < kJoints; ++i) {
    z[static_cast<Eigen::Index>(i)] = centring_ * kCentring *
                                      (std::max(0.0, kSoftMargin - (now_.q[i] - limits_.q_min[i])) -
                                       std::max(0.0, kSoftMargin - (limits_.q_max[i] - now_.q[i])));
  }
  const Matrix6 A = J * J.transpose() + kPostureDamping * Matrix6::Identity();
  const Eigen::Matrix<double, 7, 1> dq = z + J.transpose() * A.ldlt().solve(u - J * z);
  for (std::size_t i = 0; i < kJoints; ++i) {
    now_.dq[i] =
        std::clamp(dq[static_cast<Eigen::Index>(i)], -limits_.dq_max[i], limits_.dq_max[i]);
    now_.q[i] = std::clamp(now_.q[i] + T * now_.dq[i], limits_.q_min[i], limits_.q_max[i]);
  }
}

Vector6 LedPosture::PerTurn(std::size_t joint, const Transform& F_T_EE) const noexcept {
  const model::Jacobian J = arm_.ZeroJacobian(model::Frame::kEndEffector, now_.q, F_T_EE);
  Vector6 column;
  std::copy_n(J.begin() + static_cast<std::ptrdiff_t>(column.size() * joint), column.size(),
              column.begin());
  return column;
}

Vector6 LedPosture::Turn(std::size_t joint, double speed, const Transform& x_d,
                         const Transform& F_T_EE, double T) noexcept {
  const model::FrameMotion here = arm_.MotionOf(model::Frame::kEndEffector, now_.q, F_T_EE);
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(here.J.data());
  Vector6 twist = model::WayTo(x_d, here.O_T_frame);
  Eigen::Map<Eigen::Matrix<double, 6, 1>> u(twist.data());
  u = kTracking * u + speed * J.col(static_cast<Eigen::Index>(joint));
  now_.dq = {};
  now_.dq[joint] = speed;
  now_.q[joint] = std::clamp(now_.q[joint] + T * speed, limits_.q_min[joint], limits_.q_max[joint]);
  centring_ = 0;
  return twist;
}

}  // namespace twin::teleop
