#include "twin/plant/ideal_plant.h"

#include <algorithm>

#include "twin/core/hand_command.h"
#include "twin/core/time.h"
#include "twin/model/arm_model.h"

namespace twin::plant {

void IdealHand::Reset() noexcept {
  sensors_ = {.width = kHandStroke, .dwidth = 0, .force = 0};
  drive_ = {.force = 0, .width_d = kHandStroke};
}

void IdealHand::Step() noexcept {
  const double width = std::clamp(drive_.width_d, 0.0, kHandStroke);
  const bool at_stop =
      (width == 0 && drive_.force < 0) || (width == kHandStroke && drive_.force > 0);
  sensors_.dwidth = (width - sensors_.width) / kCycleSeconds;
  sensors_.width = width;
  sensors_.force = at_stop ? drive_.force : 0;
}

IdealPlant::IdealPlant(const model::Payload& payload, HandKind hand, const model::ArmModel& arm)
    : arm_(arm), payload_(payload) {
  if (hand == HandKind::kFrankaHand) hand_.emplace();
  if (hand == HandKind::kCobotPump) suction_.emplace();
}

void IdealPlant::Reset(const JointVector& q) {
  if (hand_) hand_->Reset();
  Sense(q, JointVector{}, JointVector{});
}

void IdealPlant::Step(const JointDrive& drive) noexcept {
  if (hand_) hand_->Step();
  if (drive.brakes) {
    Sense(sensors_.q, JointVector{}, JointVector{});
  } else {
    Sense(drive.q_d, drive.dq_d, drive.ddq_d);
  }
}

void IdealPlant::Sense(const JointVector& q, const JointVector& dq,
                       const JointVector& ddq) noexcept {
  sensors_.tau_J = arm_.InverseDynamics(q, dq, ddq, payload_);
  sensors_.q = q;
  sensors_.dq = dq;
  sensors_.theta = q;
  sensors_.dtheta = dq;
}

namespace {

/// The whole plant.
struct SavedIdealPlant final : Plant::State {
  explicit SavedIdealPlant(const IdealPlant& saved) : plant(saved) {}
  IdealPlant plant;
};

}  // namespace

std::unique_ptr<const Plant::State> IdealPlant::Save() const {
  return std::make_unique<SavedIdealPlant>(*this);
}

void IdealPlant::Restore(const State& state) {
  *this = static_cast<const SavedIdealPlant&>(state).plant;
}

}  // namespace twin::plant
