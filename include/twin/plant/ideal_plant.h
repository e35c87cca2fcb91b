#pragma once

#include "twin/plant/plant.h"

namespace twin::plant {

/// The plant that does exactly what is desired: q = q_d, dq = dq_d, tau_J = tau, theta = q. No
/// dynamics, no MuJoCo. For tests and studies in which only INT's checks matter.
class IdealPlant final : public Plant {
 public:
  void Reset(const JointVector& q) override;
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override;
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return sensors_; }

 private:
  JointSensors sensors_;
};

}  // namespace twin::plant
