#pragma once

#include <optional>

#include "twin/model/payload.h"
#include "twin/plant/ideal_hand.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// The plant that does exactly what is desired, whatever torque is commanded; no MuJoCo.
///
///   q = theta = q_d,  dq = dtheta = dq_d,  tau_J = M(q) ddq_d + c(q, dq) + g(q)
///
/// by the robot's own model (model::ArmModel::Panda) with the payload: what the torque sensors of
/// an arm without friction show when it moves so and nothing touches it. Closed brakes hold it
/// where it is. For tests and studies in which only INT's checks matter.
class IdealPlant final : public Plant {
 public:
  /// @param payload  everything beyond the flange, for tau_J. @param hand  what moves there.
  explicit IdealPlant(const model::Payload& payload = {}, HandKind hand = HandKind::kNone);

  void Reset(const JointVector& q) override;
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override;
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return sensors_; }
  [[nodiscard]] HandBody* hand() noexcept override { return hand_ ? &*hand_ : nullptr; }

 private:
  /// The sensors of an arm that moves so.
  void Sense(const JointVector& q, const JointVector& dq,
             const JointVector& ddq) noexcept TWIN_REALTIME;

  model::Payload payload_;
  JointSensors sensors_;
  std::optional<IdealHand> hand_;
};

}  // namespace twin::plant
