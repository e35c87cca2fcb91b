#include "twin/model/lab_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/model_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::model::model_lab_limits_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using Parts = std::vector<LimitedPart>;
const Parts kEndEffectorOnly{LimitedPart::kEndEffector};
const Parts kElbowOnly{LimitedPart::kElbow};
const Parts kHandOnly{LimitedPart::kHand};
constexpr JointVector kReady{0, -0.785, 0, -2.356, 0, 1.571, 0.785};
const LimitedArm kArm{kHandPose, true};

LimitRegion Inside(const Parts& parts, const LimitBox& box) {
  return {"box", parts, true, box};
}

LimitRegion Behind(const Parts& parts, const Vector3& normal, double offset) {
  return {"plane", parts, true, HalfSpace{normal, offset}};
}

double MarginOf(const LimitRegion& region, const JointVector& q, const LimitedArm& arm = kArm) {
  return LeastMargin({.regions = {region}}, arm, q).value().margin;
}

std::string ErrorOf(const LabLimits& limits) {
  try {
    limits.Validate();
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(LabLimitsTest, AnEndEffectorInABoxHasTheDistanceFromTheClosestFace) {
  const Transform O_T_EE = ArmModel::Panda().Pose(Frame::kEndEffector, kReady, kHandPose);
  const double x = O_T_EE[12];
  const double z = O_T_EE[14];
  const auto room = [&](double low, double high) {
    return Inside(kEndEffectorOnly, {{x - 1, -1, z - low}, {x + high, 1, z + 1}});
  };
  EXPECT_NEAR(MarginOf(room(0.5, 0.03), kReady), 0.03, 1e-12);
  EXPECT_NEAR(MarginOf(room(0.02, 0.03), kReady), 0.02, 1e-12);
  EXPECT_NEAR(MarginOf(room(0.02, -0.04), kReady), -0.04, 1e-12);
}

TEST(LabLimitsTest, APointOutsideABoxHasTheDistanceFromItsNearestPoint) {
  const Transform O_T_EE = ArmModel::Panda().Pose(Frame::kEndEffector, kReady, kHandPose);
  const Vector3 p{O_T_EE[12], O_T_EE[13], O_T_EE[14]};
  const auto beside = [&](const Vector3& low, const Vector3& high) {
    LimitBox box;
    for (std::size_t i = 0; i < 3; ++i) {
      box.low[i] = p[i] + low[i];
      box.high[i] = p[i] + high[i];
    }
    LimitRegion region = Inside(kEndEffectorOnly, box);
    region.keep_inside = false;
    return region;
  };
  EXPECT_NEAR(MarginOf(beside({0.3, 0.4, -1}, {1, 1, 1}), kReady), 0.5, 1e-12);  // an edge
  EXPECT_NEAR(MarginOf(beside({-1, -1, -0.9}, {1, 1, -0.1}), kReady), 0.1, 1e-12);
  EXPECT_NEAR(MarginOf(beside({-1, -0.02, -1}, {1, 1, 1}), kReady), -0.02, 1e-12);
}

TEST(LabLimitsTest, AHalfSpaceEndsAtItsPlaneWhateverItsNormalsLength) {
  // Joint 4's origin at q = 0 is at x = 0.0825 m, z = 0.333 m + 0.316 m (the DH parameters).
  LimitRegion ceiling = Behind(kElbowOnly, {0, 0, 5}, 0.7);
  EXPECT_NEAR(MarginOf(ceiling, {}), 0.7 - 0.649, 1e-12);
  ceiling.keep_inside = false;
  EXPECT_NEAR(MarginOf(ceiling, {}), 0.649 - 0.7, 1e-12);
  const double diagonal = (0.0825 + 0.649) / std::sqrt(2.0);
  EXPECT_NEAR(MarginOf(Behind(kElbowOnly, {1, 0, 1}, 1), {}), 1 - diagonal, 1e-12);
}

TEST(LabLimitsTest, TheHandReachesAsFarAsItsSpheres) {
  const Transform O_T_F = ArmModel::Panda().Pose(Frame::kFlange, kReady);
  const Vector3 forward{O_T_F[8], O_T_F[9], O_T_F[10]};  // the flange's z axis
  const double flange = forward[0] * O_T_F[12] + forward[1] * O_T_F[13] + forward[2] * O_T_F[14];
  const LimitRegion region = Behind(kHandOnly, forward, flange + 0.2);
  EXPECT_NEAR(MarginOf(region, kReady), 0.2 - 0.095 - 0.027, 1e-12);
  EXPECT_NEAR(MarginOf(region, kReady, {kIdentityTransform, false}), 0.2 - 0.05, 1e-12);
}

/// Corners of the shapes of models/robots/hand (primitives.yaml, hand.urdf), in the hand's frame.
std::vector<Vector3> CornersOfTheHand() {
  std::vector<Vector3> corners;
  const auto add = [&corners](const Vector3& at, const Vector3& half) {
    for (int i = 0; i < 8; ++i) {
      corners.push_back({at[0] + (i % 2 == 0 ? half[0] : -half[0]),
                         at[1] + (i / 2 % 2 == 0 ? half[1] : -half[1]),
                         at[2] + (i / 4 == 0 ? half[2] : -half[2])});
    }
  };
  for (double y = -0.1; y <= 0.1; y += 0.002) add({0, y, 0.037}, {0.029, 0, 0.028});
  for (const double side : {-1.0, 1.0}) {
    for (double opening = 0; opening <= 0.04; opening += 0.001) {
      const double y = side * opening;
      add({0, y + side * 0.0155, 0.0584 + 0.014}, {0.01, 0.01, 0.014});
      add({0, y + side * 0.00775, 0.0584 + 0.0384}, {0.0087, 0.00675, 0.0154});
    }
  }
  return corners;
}

TEST(LabLimitsTest, TheSpheresCoverTheHandAtAnyOpening) {
  for (const Vector3& p : CornersOfTheHand()) {
    // The hand is turned by -45 degrees about the flange's z axis.
    const Vector3 in_flange{kCos45 * (p[0] + p[1]), kCos45 * (p[1] - p[0]), p[2]};
    const bool is_covered = std::ranges::any_of(HandSpheres(), [&](const FlangeSphere& sphere) {
      return std::hypot(in_flange[0] - sphere.centre[0], in_flange[1] - sphere.centre[1],
                        in_flange[2] - sphere.centre[2]) <= sphere.radius;
    });
    EXPECT_TRUE(is_covered) << p[0] << " " << p[1] << " " << p[2];
  }
}

TEST(LabLimitsTest, TheGradientIsThatOfDifferences) {
  constexpr double kStep = 1e-6;
  LimitRegion outside = Inside(kHandOnly, {{0.3, -0.1, 0.2}, {0.5, 0.1, 0.4}});
  outside.keep_inside = false;
  const std::vector<LimitRegion> regions{
      Inside(kEndEffectorOnly, {{-0.1, -0.2, -0.3}, {0.1, 0.2, 0.3}}),
      Behind(kElbowOnly, {1, -2, 3}, 0.1), Behind(kHandOnly, {0, 1, 0}, 0.1), outside};
  for (const LimitRegion& region : regions) {
    for (std::uint64_t i = 0; i < 50; ++i) {
      const JointVector q = SampleOf(i).q;
      const RegionMargin here = LeastMargin({.regions = {region}}, kArm, q).value();
      for (std::size_t joint = 0; joint < kJoints; ++joint) {
        JointVector there = q;
        there[joint] += kStep;
        const double forward = MarginOf(region, there);
        there[joint] = q[joint] - kStep;
        const double backward = MarginOf(region, there);
        EXPECT_NEAR(here.gradient[joint], (forward - backward) / (2 * kStep), 1e-4)
            << region.name << " sample " << i << " joint " << joint + 1;
      }
    }
  }
}

TEST(LabLimitsTest, GivesTheClosestPlanesWithinTheHorizon) {
  const LabLimits limits{.regions = {Inside(kHandOnly, {{-2, -2, 0}, {2, 2, 2}})}};
  std::vector<RegionMargin> all(6 * HandSpheres().size());
  const double infinity = std::numeric_limits<double>::infinity();
  ASSERT_EQ(MarginsWithin(infinity, limits, kArm, kReady, all), all.size());
  std::ranges::sort(all, {}, &RegionMargin::margin);
  std::vector<RegionMargin> near(5);
  ASSERT_EQ(MarginsWithin(infinity, limits, kArm, kReady, near), near.size());
  std::ranges::sort(near, {}, &RegionMargin::margin);
  for (std::size_t i = 0; i < near.size(); ++i) EXPECT_EQ(near[i].margin, all[i].margin);
  const double horizon = (all[3].margin + all[4].margin) / 2;
  EXPECT_EQ(MarginsWithin(horizon, limits, kArm, kReady, all),
            all[4].margin > all[3].margin ? 4 : 3);
}

TEST(LabLimitsTest, NothingIsKnownOfPositionsThatAreNoNumbers) {
  JointVector q = kReady;
  q[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(LeastMargin({.regions = {Behind(kHandOnly, {0, 0, 1}, 1)}}, kArm, q));
  EXPECT_FALSE(LeastMargin({}, kArm, kReady));
}

TEST(LabLimitsTest, IsForRealTime) {
  LabLimits limits{
      .regions = {Inside({LimitedPart::kEndEffector, LimitedPart::kElbow, LimitedPart::kHand},
                         {{-1, -1, 0}, {1, 1, 1}}),
                  Behind(kHandOnly, {0, 1, 0}, 0.3)}};
  limits.regions[1].keep_inside = false;
  std::array<RegionMargin, 8> near;
  const test::RealtimeGuard guard;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    (void)MarginsWithin(0.1, limits, kArm, SampleOf(i).q, near);
    (void)LeastMargin(limits, kArm, SampleOf(i).q);
  }
}

TEST(LabLimitsTest, SaysWhichLimitIsPassedAndByHowMuch) {
  const LabLimits limits{.regions = {Behind(kElbowOnly, {0, 0, 1}, 0.6)}};
  EXPECT_EQ(Describe(limits, LeastMargin(limits, kArm, JointVector{}).value()),
            "limit \"plane\": the elbow reaches z = 0.64900 m; it must be at most 0.60000 m");
}

TEST(LabLimitsTest, SaysALowerBoundInTheBasesCoordinate) {
  const LabLimits limits{.regions = {Inside(kElbowOnly, {{-1, -1, 0.7}, {1, 1, 2}})}};
  EXPECT_EQ(Describe(limits, LeastMargin(limits, kArm, JointVector{}).value()),
            "limit \"box\": the elbow reaches z = 0.64900 m; it must be at least 0.70000 m");
}

TEST(LabLimitsTest, DemandsNoCoordinateBesideABoxToStayOutOf) {
  LabLimits limits{.regions = {Inside(kElbowOnly, {{-1, -1, 0.6}, {1, 1, 9}})}};
  limits.regions[0].keep_inside = false;
  EXPECT_EQ(Describe(limits, LeastMargin(limits, kArm, JointVector{}).value()),
            "limit \"box\": the elbow reaches z = 0.64900 m; the bound is 0.60000 m");
}

TEST(LabLimitsTest, AddsRegionsAndTakesTheLowerCap) {
  JointVector slow;
  slow.fill(0.5);
  JointVector mixed = slow;
  mixed[0] = 0.2;
  mixed[1] = 2;
  JointVector lower = slow;
  lower[0] = 0.2;
  LabLimits here{.regions = {Behind(kHandOnly, {0, 0, 1}, 1)}, .dq_max = slow, .v_max = 0.3};
  const LabLimits lab{.regions = {Inside(kHandOnly, {{-1, -1, 0}, {1, 1, 1}})},
                      .dq_max = mixed,
                      .v_max = 0.5,
                      .force_max = 40};
  here.Add(lab);
  EXPECT_EQ(here.regions.size(), 2u);
  EXPECT_EQ(here.dq_max, lower);
  EXPECT_EQ(here.v_max, 0.3);
  EXPECT_EQ(here.force_max, 40);
  EXPECT_THROW(here.Add(lab), InputError);  // both have a region "box"
}

TEST(LabLimitsTest, RefusesWhatContradictsItself) {
  const auto of = [](const LimitRegion& one) { return ErrorOf({.regions = {one}}); };
  EXPECT_THAT(of(Inside(kHandOnly, {{0, 0.5, 0}, {1, 0.4, 1}})),
              AllOf(HasSubstr("\"box\""), HasSubstr("min 0.5 m, max 0.4 m along y")));
  EXPECT_THAT(of(Behind(kHandOnly, {0, 0, 0}, 1)), HasSubstr("length 0"));
  EXPECT_THAT(of(Inside({}, {{0, 0, 0}, {1, 1, 1}})), HasSubstr("limits nothing"));
  LimitRegion long_name = Behind(kHandOnly, {0, 0, 1}, 1);
  long_name.name = std::string(32, 'a');
  EXPECT_THAT(of(long_name), HasSubstr("the name has 32 bytes; give one of at most 31"));
  EXPECT_THAT(ErrorOf({.v_max = 0}), HasSubstr("speed.end_effector is 0"));

  const LimitRegion room = Inside(kHandOnly, {{0, 0, 0}, {1, 1, 1}});
  LimitRegion all = room;
  all.name = "all of it";
  EXPECT_EQ(ErrorOf({.regions = {room, all}}), "accepted");
  all.keep_inside = false;
  EXPECT_THAT(ErrorOf({.regions = {room, all}}), HasSubstr("\"all of it\": it leaves the hand no"));
  EXPECT_THAT(ErrorOf({.regions = {room, Behind(kHandOnly, {0, 0, 1}, -0.1)}}),
              HasSubstr("no place"));
  EXPECT_EQ(ErrorOf({.regions = {room, Behind(kElbowOnly, {0, 0, 1}, -0.1)}}), "accepted");
  LimitRegion apart = Inside(kHandOnly, {{2, 0, 0}, {3, 1, 1}});
  apart.name = "elsewhere";
  EXPECT_THAT(ErrorOf({.regions = {room, apart}}), HasSubstr("\"elsewhere\""));
  EXPECT_THAT(ErrorOf({.regions = {room, room}}), HasSubstr("another region has this name"));
}

}  // namespace
}  // namespace twin::model::model_lab_limits_test
