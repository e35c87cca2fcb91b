#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"

namespace twin::plant::plant_realtime_test {
namespace {

TEST(PlantRealtimeTest, StepsWithoutAllocationOrLock) {
  for (const auto friction :
       {FrictionProfile::kNone, FrictionProfile::kResidual, FrictionProfile::kBreakaway}) {
    MujocoPlantOptions options = DefaultOptions();
    options.friction = friction;
    options.noise = {.q_rad = 1e-5, .dq_rad_per_s = 1e-4, .tau_J_Nm = 0.01};
    const auto plant = MujocoPlant::Create(options);
    // Gravity is let loose half way, so that steps with contacts and joint limits are among them.
    JointDrive drive{.tau = plant->GravityTorque(kReady)};
    const test::RealtimeGuard guard;
    for (int k = 0; k < 3000; ++k) {
      if (k == 1000) drive = JointDrive{};
      plant->Step(drive);
    }
    const auto counts = guard.counts();
    EXPECT_EQ(counts.allocations, 0);
    EXPECT_EQ(counts.frees, 0);
    EXPECT_EQ(counts.locks, 0);
    EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
  }
}

}  // namespace
}  // namespace twin::plant::plant_realtime_test
