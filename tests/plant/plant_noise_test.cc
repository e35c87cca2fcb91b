#include <cmath>

#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "support/bits.h"

namespace twin::plant::plant_noise_test {
namespace {

constexpr int kSteps = 2000;

/// Root mean square of noisy minus exact over a held pose: all joints, all steps.
struct Deviations {
  double q = 0;
  double dq = 0;
  double tau_J = 0;
};

double SquaredDistance(const JointVector& a, const JointVector& b) {
  double sum = 0;
  for (std::size_t i = 0; i < kJoints; ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
  return sum;
}

Deviations Measure(MujocoPlant& noisy, MujocoPlant& exact) {
  Deviations d;
  const JointDrive drive{.tau = exact.GravityTorque(kReady)};
  noisy.Reset(kReady);
  exact.Reset(kReady);
  for (int k = 0; k < kSteps; ++k) {
    noisy.Step(drive);
    exact.Step(drive);
    d.q += SquaredDistance(noisy.sensors().q, exact.sensors().q);
    d.dq += SquaredDistance(noisy.sensors().dq, exact.sensors().dq);
    d.tau_J += SquaredDistance(noisy.sensors().tau_J, exact.sensors().tau_J);
  }
  for (double* value : {&d.q, &d.dq, &d.tau_J}) {
    *value = std::sqrt(*value / (kSteps * static_cast<double>(kJoints)));
  }
  return d;
}

// 14 000 draws: the estimate of a standard deviation has itself one of 0.6 %.
TEST(SensorNoiseTest, HasTheDeviationsAskedFor) {
  MujocoPlantOptions options = DefaultOptions();
  const auto exact = MujocoPlant::Create(options);
  options.noise = {.q_rad = 1e-4, .dq_rad_per_s = 2e-3, .tau_J_Nm = 0.05};
  options.seed = 7;
  const auto noisy = MujocoPlant::Create(options);
  const Deviations d = Measure(*noisy, *exact);
  EXPECT_NEAR(d.q, 1e-4, 0.03 * 1e-4);
  EXPECT_NEAR(d.dq, 2e-3, 0.03 * 2e-3);
  EXPECT_NEAR(d.tau_J, 0.05, 0.03 * 0.05);
}

TEST(SensorNoiseTest, RepeatsWithItsSeedAndDiffersWithAnother) {
  MujocoPlantOptions options = DefaultOptions();
  options.noise.q_rad = 1e-4;
  const auto sensed = [&options](std::uint64_t seed) {
    options.seed = seed;
    const auto plant = MujocoPlant::Create(options);
    plant->Step({.tau = plant->GravityTorque(kReady)});
    return plant->sensors().q;
  };
  EXPECT_EQ(sensed(1), sensed(1));
  EXPECT_NE(sensed(1), sensed(2));
}

TEST(SensorNoiseTest, RestartsWithReset) {
  MujocoPlantOptions options = DefaultOptions();
  options.noise = {.q_rad = 1e-4, .dq_rad_per_s = 2e-3, .tau_J_Nm = 0.05};
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  const JointSensors first = plant->sensors();
  plant->Step({});
  EXPECT_NE(plant->sensors().q, first.q);
  plant->Reset(kReady);
  EXPECT_EQ(test::Bits(plant->sensors()), test::Bits(first));
}

// One quantity's noise does not change another's value.
TEST(SensorNoiseTest, OnlyTouchesWhatItIsOf) {
  MujocoPlantOptions options = DefaultOptions();
  const auto exact = MujocoPlant::Create(options);
  options.noise.tau_J_Nm = 0.05;
  const auto noisy = MujocoPlant::Create(options);
  const Deviations d = Measure(*noisy, *exact);
  EXPECT_EQ(d.q, 0);
  EXPECT_EQ(d.dq, 0);
  EXPECT_GT(d.tau_J, 0);
}

}  // namespace
}  // namespace twin::plant::plant_noise_test
