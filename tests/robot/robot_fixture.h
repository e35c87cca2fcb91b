#pragma once

#include <chrono>
#include <memory>

#include "support/panda_limits.h"
#include "twin/plant/ideal_plant.h"
#include "twin/plant/mujoco_plant.h"
#include "twin/robot/robot.h"
#include "twin/rt/event_queue.h"

namespace twin::test {

inline constexpr JointVector kReady{
    0, -0.785398163397, 0, -2.356194490192, 0, 1.570796326795, 0.785398163397};

/// A Panda without a hand at the ready pose, on a link that delays by 80 us each way.
inline robot::RobotConfig PandaRobot() {
  robot::RobotConfig config;
  config.onboard.limits = PandaLimits();
  config.onboard.cartesian = PandaCartesianLimits();
  config.onboard.rotor_inertia = {0.605721456, 0.605721456, 0.462474144, 0.462474144,
                                  0.205544064, 0.205544064, 0.205544064};
  config.plant.urdf = TWIN_SOURCE_DIR "/models/robots/panda/panda.urdf";
  config.plant.hand = plant::HandKind::kNone;
  config.link.state.delay =
      faults::DelayModel(faults::ConstantDelay{std::chrono::microseconds(80)});
  config.link.command.delay =
      faults::DelayModel(faults::ConstantDelay{std::chrono::microseconds(80)});
  config.q_start = kReady;
  return config;
}

/// Ignores what it is told.
class Deaf final : public rt::EventHandler {
 public:
  void OnEvent(Time, std::uint64_t) noexcept override {}
};

}  // namespace twin::test
