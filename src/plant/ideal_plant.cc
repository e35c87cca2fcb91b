#include "twin/plant/ideal_plant.h"

namespace twin::plant {

void IdealPlant::Reset(const JointVector& q) {
  sensors_ = JointSensors{};
  sensors_.q = q;
  sensors_.theta = q;
}

void IdealPlant::Step(const JointDrive& drive) noexcept {
  sensors_.q = drive.q_d;
  sensors_.dq = drive.dq_d;
  sensors_.tau_J = drive.tau;
  sensors_.theta = drive.q_d;
  sensors_.dtheta = drive.dq_d;
}

}  // namespace twin::plant
