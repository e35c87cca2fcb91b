#pragma once

#include <memory>
#include <optional>

#include "twin/model/arm_model.h"
#include "twin/model/mass_properties.h"
#include "twin/plant/plant.h"

namespace twin::plant {

/// A hand that follows the desired motion exactly within its range: width = width_d, cut to [0,
/// 0.08] m. It only touches its two stops, where the fingers press with the drive's force.
class IdealHand final : public HandBody {
 public:
  IdealHand() noexcept { Reset(); }

  void Reset() noexcept;
  /// Advances by 1 ms, like its plant.
  void Step() noexcept TWIN_REALTIME;

  void Drive(const HandDrive& drive) noexcept TWIN_REALTIME override { drive_ = drive; }
  [[nodiscard]] const HandSensors& sensors() const noexcept override { return sensors_; }

 private:
  HandDrive drive_;
  HandSensors sensors_;
};

/// A vacuum gripper that touches nothing, and so never has a vacuum.
class IdealSuction final : public SuctionBody {
 public:
  void Drive(const PumpDrive& /*drive*/) noexcept TWIN_REALTIME override {}
  [[nodiscard]] const PumpSensors& sensors() const noexcept override { return sensors_; }

 private:
  PumpSensors sensors_;
};

/// A plant that follows the desired motion exactly and ignores the torque; without MuJoCo.
///
///   q = theta = q_d,  dq = dtheta = dq_d,  tau_J = M(q) ddq_d + c(q, dq) + g(q)
///
/// by the robot's own model with the payload: the torque sensors of an arm
/// in that motion without friction and contact. Closed brakes hold it in place. For tests and
/// studies of INT's checks alone.
class IdealPlant final : public Plant {
 public:
  /// @param payload  all bodies beyond the flange, for tau_J. @param hand  its hand.
  /// @param arm  the model.
  explicit IdealPlant(const model::Payload& payload = {}, HandKind hand = HandKind::kNone,
                      const model::ArmModel& arm = model::ArmModel::Panda());

  void Reset(const JointVector& q) override;
  void Step(const JointDrive& drive) noexcept TWIN_REALTIME override;
  [[nodiscard]] std::unique_ptr<const State> Save() const override;
  void Restore(const State& state) override;
  [[nodiscard]] const JointSensors& sensors() const noexcept override { return sensors_; }
  [[nodiscard]] HandBody* hand() noexcept override { return hand_ ? &*hand_ : nullptr; }
  [[nodiscard]] SuctionBody* suction() noexcept override { return suction_ ? &*suction_ : nullptr; }

 private:
  /// Sets the sensors for this motion.
  void Sense(const JointVector& q, const JointVector& dq,
             const JointVector& ddq) noexcept TWIN_REALTIME;

  model::ArmModel arm_;
  model::Payload payload_;
  JointSensors sensors_;
  std::optional<IdealHand> hand_;
  std::optional<IdealSuction> suction_;
};

}  // namespace twin::plant
