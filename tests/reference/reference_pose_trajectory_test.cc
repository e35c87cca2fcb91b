#include "twin/reference/pose_trajectory.h"

#include <chrono>
#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/panda_limits.h"
#include "support/pose_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::reference::reference_pose_trajectory_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 2s

const Transform kA = test::PoseOf({0.1, 0, 0}, {0.4, 0, 0.5});
const Transform kB = test::PoseOf({0.1, 0.3, -0.8}, {0.5, 0.2, 0.4});

PoseTrajectory Path(const std::vector<PoseWaypoint>& waypoints, const Timing& timing = {}) {
  return PoseTrajectory(waypoints, timing, test::PandaCartesianLimits());
}

std::string Complaint(const std::vector<PoseWaypoint>& waypoints, const Timing& timing = {}) {
  try {
    (void)Path(waypoints, timing);
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

TEST(PoseTrajectoryTest, GoesAlongALineAndAboutOneAxisByMinimumJerk) {
  const PoseTrajectory path = Path({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kB, .at = 2s}});
  const Eigen::Vector3d way = test::PositionOf(kB) - test::PositionOf(kA);
  const Eigen::Vector3d turn = test::RotationVector(kA, kB);
  for (Duration t = 0s; t <= 2s; t += 100ms) {
    const double x = ToSeconds(t) / 2;
    const double s = 10 * std::pow(x, 3) - 15 * std::pow(x, 4) + 6 * std::pow(x, 5);
    const PoseTarget target = path.Sample(t);
    EXPECT_LT((test::PositionOf(target.O_T_EE) - test::PositionOf(kA) - s * way).norm(), 1e-14);
    EXPECT_LT((test::RotationVector(kA, target.O_T_EE) - s * turn).norm(), 1e-12);
    EXPECT_LT(test::Obliqueness(target.O_T_EE), 1e-14);
  }
}

TEST(PoseTrajectoryTest, GivesTheTwistThatItsPosesHave) {
  const PoseTrajectory path =
      Path({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kB, .at = 1500ms}, {.O_T_EE = kA, .at = 4s}});
  for (Duration t = 50ms; t < 4s; t += 150ms) {
    const Transform before = path.Sample(t - 10us).O_T_EE;
    const Transform after = path.Sample(t + 10us).O_T_EE;
    const Vector6 twist = path.Sample(t).O_dP_EE;
    const Eigen::Vector3d v = (test::PositionOf(after) - test::PositionOf(before)) / 20e-6;
    const Eigen::Vector3d w = test::RotationVector(before, after) / 20e-6;
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(twist[i], v[static_cast<Eigen::Index>(i)], 1e-8);
      EXPECT_NEAR(twist[3 + i], w[static_cast<Eigen::Index>(i)], 1e-8);
    }
  }
}

TEST(PoseTrajectoryTest, RestsBitForBitAtBothEnds) {
  const PoseTrajectory path = Path({{.O_T_EE = kA}, {.O_T_EE = kB}});
  EXPECT_EQ(path.Sample(-1s).O_T_EE, kA);
  EXPECT_EQ(path.Sample(0s).O_T_EE, kA);
  EXPECT_EQ(path.Sample(path.duration()).O_T_EE, kB);
  EXPECT_EQ(path.Sample(path.duration() + 1s).O_T_EE, kB);
  EXPECT_EQ(path.Sample(path.duration()).O_dP_EE, Vector6{});
}

TEST(PoseTrajectoryTest, TakesTheTimeThatTheSharesAllow) {
  // 0.1 m alone: by velocity 1.875 d / (s v), acceleration sqrt(5.7735 d / (s a)), jerk cbrt(60 d /
  // (s j)).
  Transform near = kA;
  near[12] += 0.1;
  const auto duration = [&](double velocity, double acceleration, double jerk) {
    return ToSeconds(Path({{.O_T_EE = kA}, {.O_T_EE = near}}, {.duration = {},
                                                               .velocity_scale = velocity,
                                                               .acceleration_scale = acceleration,
                                                               .jerk_scale = jerk})
                         .duration());
  };
  EXPECT_NEAR(duration(0.01, 1, 1), 1.875 * 0.1 / (0.01 * 1.7), 1e-8);
  EXPECT_NEAR(duration(1, 0.01, 1), std::sqrt(10 / std::sqrt(3.0) * 0.1 / (0.01 * 13)), 1e-8);
  EXPECT_NEAR(duration(1, 1, 1e-4), std::cbrt(60 * 0.1 / (1e-4 * 6500)), 1e-8);
}

TEST(PoseTrajectoryTest, KeepsToTheLimitsSampledAtTheRobotsCycle) {
  const CartesianLimits limits = test::PandaCartesianLimits();
  const PoseTrajectory path = Path(
      {{.O_T_EE = kA}, {.O_T_EE = kB}},
      {.duration = {}, .velocity_scale = 0.999, .acceleration_scale = 0.999, .jerk_scale = 0.999});
  const auto p = [&](Duration t) { return test::PositionOf(path.Sample(t).O_T_EE); };
  double most = 0;
  for (Duration t = -5ms; t < path.duration() + 5ms; t += 1ms) {
    const Eigen::Vector3d v = (p(t) - p(t - 1ms)) / 1e-3;
    const Eigen::Vector3d a = (p(t) - 2 * p(t - 1ms) + p(t - 2ms)) / 1e-6;
    const Eigen::Vector3d j = (p(t) - 3 * p(t - 1ms) + 3 * p(t - 2ms) - p(t - 3ms)) / 1e-9;
    most = std::max({most, v.norm() / limits.translation.dp_max,
                     a.norm() / limits.translation.ddp_max, j.norm() / limits.translation.dddp_max,
                     Eigen::Map<const Eigen::Vector3d>(path.Sample(t).O_dP_EE.data() + 3).norm() /
                         limits.rotation.dp_max});
  }
  EXPECT_LE(most, 1);
  EXPECT_GT(most, 0.3) << "nowhere near";
}

TEST(PoseTrajectoryTest, IsStretchedToADuration) {
  const std::vector<PoseWaypoint> poses{{.O_T_EE = kA}, {.O_T_EE = kB}, {.O_T_EE = kA}};
  EXPECT_EQ(Path(poses, {.duration = 7s}).duration(), 7s);
  EXPECT_EQ(Path(poses, {.duration = 7s}).Sample(3500ms).O_T_EE, kB);
}

TEST(PoseTrajectoryTest, StandsBetweenEqualPosesWithTimes) {
  const PoseTrajectory path = Path({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kA, .at = 2s}});
  EXPECT_EQ(path.Sample(1s).O_T_EE, kA);
  EXPECT_EQ(path.Sample(1s).O_dP_EE, Vector6{});
}

TEST(PoseTrajectoryTest, RefusesWhatBreaksALimitNamingThePieceAndTheCure) {
  const std::string slow = Complaint({{.O_T_EE = kA, .at = 0s, .where = "a.yaml:3"},
                                      {.O_T_EE = kB, .at = 200ms, .where = "a.yaml:4"}});
  EXPECT_THAT(slow, AllOf(HasSubstr("a.yaml:3"), HasSubstr("a.yaml:4"), HasSubstr("velocity"),
                          HasSubstr("give this piece at least")));
  // The time it proposes is enough.
  const double cure = std::stod(slow.substr(slow.find("at least ") + 9));
  EXPECT_EQ(Complaint({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kB, .at = FromSeconds(cure + 1e-4)}}),
            "(accepted)");
}

TEST(PoseTrajectoryTest, RefusesWhatIsNoPath) {
  EXPECT_THAT(Complaint({{.O_T_EE = kA}}), HasSubstr("at least two"));
  Transform oblique = kB;
  oblique[0] += 1e-3;
  EXPECT_THAT(Complaint({{.O_T_EE = kA}, {.O_T_EE = oblique}}), HasSubstr("pose 2 is no pose"));
  Transform nan = kB;
  nan[13] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(Complaint({{.O_T_EE = kA}, {.O_T_EE = nan}}), HasSubstr("is no pose"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA}, {.O_T_EE = kA}}), HasSubstr("coincide"));
  EXPECT_THAT(Complaint({{.O_T_EE = test::PoseOf({0, 0, 0}, {0, 0, 1})},
                         {.O_T_EE = test::PoseOf({0, 3.1415, 0}, {0, 0, 1})}}),
              HasSubstr("half a revolution"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kB}}), HasSubstr("`at` to all"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA}, {.O_T_EE = kB, .at = 1s}}), HasSubstr("`at` to all"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA, .at = 1s}, {.O_T_EE = kB, .at = 2s}}),
              HasSubstr("must be 0 s"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA, .at = 0s}, {.O_T_EE = kB, .at = 0s}}),
              HasSubstr("must rise"));
  EXPECT_THAT(Complaint({{.O_T_EE = kA}, {.O_T_EE = kB}}, {.duration = {}, .jerk_scale = 0}),
              HasSubstr("jerk share"));
}

TEST(PoseTrajectoryTest, SamplesWithoutAllocating) {
  const PoseTrajectory path = Path({{.O_T_EE = kA}, {.O_T_EE = kB}, {.O_T_EE = kA}});
  const test::RealtimeGuard guard;
  double sum = 0;
  for (int i = -1; i < 1000; ++i) sum += path.Sample(i * 5ms).O_T_EE[12];
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(sum, 0);
}

}  // namespace
}  // namespace twin::reference::reference_pose_trajectory_test
