#include "twin/model/mass_properties.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model_samples.h"

namespace twin::model::payload_test {
namespace {

using testing::DoubleNear;
using testing::Pointwise;

void ExpectNear(const Payload& actual, const Payload& expected, double tolerance = 1e-15) {
  EXPECT_NEAR(actual.m, expected.m, tolerance);
  EXPECT_THAT(actual.F_x_C, Pointwise(DoubleNear(tolerance), expected.F_x_C));
  EXPECT_THAT(actual.I, Pointwise(DoubleNear(tolerance), expected.I));
}

// By hand: two point masses 0.3 m apart turn as their reduced mass 2/3 kg at that distance.
TEST(CombineTest, TwoPointMassesTurnAsTheirReducedMass) {
  const Payload a{2, {0.3, 0, 0}, {}};
  const Payload b{1, {0, 0, 0}, {}};
  ExpectNear(Combine(a, b), {3, {0.2, 0, 0}, {0, 0, 0, 0, 0.06, 0, 0, 0, 0.06}});
}

// By hand: 1 kg at (1, 1, 0) and 1 kg at (-1, -1, 0) have Ixy = -sum m x y = -2.
TEST(CombineTest, ProductsOfInertiaHaveTheirSign) {
  const Payload a{1, {1, 1, 0}, {}};
  const Payload b{1, {-1, -1, 0}, {}};
  ExpectNear(Combine(a, b), {2, {}, {2, -2, 0, -2, 2, 0, 0, 0, 4}});
}

TEST(CombineTest, OwnInertiasAddAboutACommonCentre) {
  const Payload a{1, {0.1, 0.2, 0.3}, {1, 2, 3, 4, 5, 6, 7, 8, 9}};
  const Payload b{3, {0.1, 0.2, 0.3}, {9, 8, 7, 6, 5, 4, 3, 2, 1}};
  ExpectNear(Combine(a, b), {4, {0.1, 0.2, 0.3}, {10, 10, 10, 10, 10, 10, 10, 10, 10}}, 1e-14);
}

TEST(CombineTest, DoesNotDependOnTheOrder) {
  ExpectNear(Combine(kHand, kLump), Combine(kLump, kHand));
}

TEST(CombineTest, NothingChangesNothing) {
  ExpectNear(Combine(kHand, {}), kHand);
  ExpectNear(Combine({}, kHand), kHand);
}

TEST(CombineTest, ABodyWithoutMassContributesNoInertia) {
  const Payload massless{0, {0.5, 0.5, 0.5}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  ExpectNear(Combine(kHand, massless), kHand);
}

TEST(CombineTest, WithoutAnyMassAllIsZero) {
  const Payload massless{0, {0.5, 0.5, 0.5}, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
  ExpectNear(Combine(massless, massless), {}, 0);
}

}  // namespace
}  // namespace twin::model::payload_test
