#include "plant/tyre.h"

#include <cmath>

#include <gtest/gtest.h>

#include "twin/core/time.h"

namespace twin::plant::plant_tyre_test {
namespace {

constexpr double kLoad = 200;  // N

WheelLoad OnFloor(double force = kLoad) {
  return {.force = force, .point = {0, 0, -0.165}, .normal = {0, 0, 1}};
}

double Size(const Vector3& v) {
  return std::hypot(v[0], v[1], v[2]);
}

TEST(TyreTest, TakesNothingWithoutALoad) {
  Tyre tyre;
  EXPECT_EQ(tyre.Step({}, {1, 1, 0}, 1), Vector3{});
}

TEST(TyreTest, SlidesAgainstTheSlipByTheFrictionOfItsLoad) {
  Tyre tyre;
  Vector3 f{};
  for (int k = 0; k < 100; ++k) f = tyre.Step(OnFloor(), {0.3, -0.4, 0}, 0);
  EXPECT_NEAR(f[0], -0.6 * Tyre::kFriction * kLoad, 1e-6);
  EXPECT_NEAR(f[1], 0.8 * Tyre::kFriction * kLoad, 1e-6);
}

TEST(TyreTest, NeverExceedsTheFrictionOfItsLoad) {
  Tyre tyre;
  for (int k = 0; k < 500; ++k) {
    const Vector3 slip{std::sin(0.02 * k), std::cos(0.05 * k), 0};
    EXPECT_LE(Size(tyre.Step(OnFloor(), slip, std::abs(slip[0]))),
              Tyre::kFriction * kLoad * (1 + 1e-12));
  }
}

TEST(TyreTest, HoldsAMassWithoutCreep) {
  // 20 kg pulled by 100 N, below 140 N: it comes to rest, bent by F / k, and stays.
  Tyre tyre;
  double x = 0;
  double v = 0;
  double after_one_second = 0;
  for (int k = 0; k < 10'000; ++k) {
    v += (100 + tyre.Step(OnFloor(), {v, 0, 0}, 0)[0]) / 20 * kCycleSeconds;
    x += v * kCycleSeconds;
    if (k == 999) after_one_second = x;
  }
  EXPECT_NEAR(x, 100 / Tyre::kStiffness, 1e-9);
  EXPECT_NEAR(x, after_one_second, 1e-9);
}

TEST(TyreTest, RollingForgetsWhatBentIt) {
  Tyre tyre;
  for (int k = 0; k < 50; ++k) (void)tyre.Step(OnFloor(), {0, 0.02, 0}, 0);
  const double bent = Size(tyre.Step(OnFloor(), {}, 0));
  ASSERT_GT(bent, 10);
  Vector3 f{};
  for (int k = 0; k < 1000; ++k) f = tyre.Step(OnFloor(), {}, 1.0);  // 1 m, ten times sigma
  EXPECT_NEAR(Size(f) / bent, std::exp(-10), 1e-5);
}

TEST(TyreTest, PushesAlongTheGroundOnly) {
  Tyre tyre;
  const WheelLoad slope{.force = kLoad, .point = {}, .normal = {0.6, 0, 0.8}};
  Vector3 f{};
  for (int k = 0; k < 50; ++k) f = tyre.Step(slope, {0.3, 0.1, -0.5}, 0.2);
  EXPECT_NEAR(0.6 * f[0] + 0.8 * f[2], 0, 1e-9);
}

}  // namespace
}  // namespace twin::plant::plant_tyre_test
