#include "twin/reference/joint_reference_generator.h"

#include "reference/correction.h"
#include "twin/core/time.h"

namespace twin::reference {

JointReferenceGenerator::JointReferenceGenerator(double lambda)
    : lambda_(internal::CheckedLambda("joint reference generator", lambda)) {}

JointVector JointReferenceGenerator::Next(const JointVector& q_d,
                                          const JointTarget& target) const noexcept {
  JointVector q_s;
  for (std::size_t j = 0; j < kJoints; ++j) {
    q_s[j] = q_d[j] + kCycleSeconds * target.dq[j] + lambda_ * (target.q[j] - q_d[j]);
  }
  return q_s;
}

}  // namespace twin::reference
