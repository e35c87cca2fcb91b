#include "twin/model/joint_friction.h"

#include <cmath>

namespace twin::model {
namespace {

constexpr JointVector kPhi1{0.54615, 0.87224, 0.64068, 1.2794, 0.83904, 0.30301, 0.56489};  // Nm
constexpr JointVector kPhi2{5.1181, 9.0657, 10.136, 5.5903, 8.3469, 17.133, 10.336};        // s/rad
constexpr JointVector kPhi3{0.039533, 0.025882,  -0.04607, 0.036194,
                            0.026226, -0.021047, 0.0035526};  // rad/s

}  // namespace

JointVector ResidualFriction(const JointVector& dq) noexcept {
  JointVector tau{};
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double at_dq = 1 / (1 + std::exp(-kPhi2[i] * (dq[i] + kPhi3[i])));
    const double at_rest = 1 / (1 + std::exp(-kPhi2[i] * kPhi3[i]));
    tau[i] = kPhi1[i] * (at_dq - at_rest);
  }
  return tau;
}

}  // namespace twin::model
