// The figures that are promised of models/scenarios/trajectories/.

#include <algorithm>
#include <cstdio>

#include <gmock/gmock.h>
#include <yaml-cpp/yaml.h>

#include "support/panda_limits.h"
#include "twin/reference/trajectory.h"

namespace twin::reference::standard_trajectories_test {
namespace {

using test::PandaLimits;
using testing::AllOf;
using testing::Each;
using testing::Ge;
using testing::Le;
using namespace std::chrono_literals;

constexpr JointVector kReady{
    0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483};

/// The number before " s".
Duration Seconds(const YAML::Node& node) {
  const auto text = node.as<std::string>();
  EXPECT_EQ(text.substr(text.size() - 2), " s");
  return FromSeconds(std::stod(text));
}

Trajectory Load(const std::string& name) {
  const YAML::Node file =
      YAML::LoadFile(std::string(TWIN_SOURCE_DIR "/models/scenarios/trajectories/") + name);
  EXPECT_EQ(file["unit"].as<std::string>(), "rad");
  std::vector<Waypoint> waypoints;
  for (const YAML::Node& point : file["waypoints"]) {
    waypoints.push_back({.q = point["q"].as<JointVector>(), .at = Seconds(point["at"])});
  }
  return Trajectory(waypoints, {.duration = Seconds(file["duration"])}, PandaLimits());
}

std::size_t CountWithin(const JointVector& values, double low, double high) {
  return static_cast<std::size_t>(
      std::count_if(values.begin(), values.end(), [&](double x) { return x >= low && x <= high; }));
}

void PrintPeaks(const Trajectory& trajectory) {
  for (std::size_t j = 0; j < kJoints; ++j) {
    std::printf("joint %zu: velocity %.4f, acceleration %.4f, jerk %.5f of the limits\n", j + 1,
                trajectory.peaks().velocity[j], trajectory.peaks().acceleration[j],
                trajectory.peaks().jerk[j]);
  }
}

/// Least distance to a position limit, rad.
double LeastDistance(const Trajectory& trajectory) {
  const JointLimits limits = PandaLimits();
  double least = 10;
  for (Duration t{}; t < trajectory.duration(); t += kCycle) {
    const JointVector q = trajectory.Sample(t).q;
    for (std::size_t j = 0; j < kJoints; ++j) {
      least = std::min({least, q[j] - limits.q_min[j], limits.q_max[j] - q[j]});
    }
  }
  return least;
}

TEST(CanonicalTrajectoryTest, LastsEighteenAndAThirdSecondsFromReadyToReady) {
  const Trajectory trajectory = Load("canonical.yaml");
  EXPECT_EQ(trajectory.duration(), 18'320ms);
  EXPECT_EQ(trajectory.start(), kReady);
  EXPECT_EQ(trajectory.goal(), kReady);
}

TEST(CanonicalTrajectoryTest, MovesAllJointsBrisklyButGently) {
  const Trajectory trajectory = Load("canonical.yaml");
  PrintPeaks(trajectory);
  EXPECT_THAT(trajectory.peaks().velocity, Each(AllOf(Ge(0.4), Le(0.6))));
  EXPECT_THAT(trajectory.peaks().acceleration, Each(Le(0.2)));
  EXPECT_THAT(trajectory.peaks().jerk, Each(Le(0.004)));
  EXPECT_GE(LeastDistance(trajectory), 0.1);
}

TEST(BriskTrajectoryTest, ComesCloseToSixTenthsOfTheAccelerationLimits) {
  const Trajectory trajectory = Load("brisk.yaml");
  PrintPeaks(trajectory);
  EXPECT_EQ(trajectory.start(), kReady);
  EXPECT_EQ(trajectory.goal(), kReady);
  EXPECT_LT(trajectory.duration(), 10s);
  EXPECT_THAT(trajectory.peaks().velocity, Each(Le(0.8)));
  EXPECT_THAT(trajectory.peaks().acceleration, Each(Le(0.6)));
  EXPECT_GE(CountWithin(trajectory.peaks().acceleration, 0.55, 0.6), 5u);
  EXPECT_THAT(trajectory.peaks().jerk, Each(Le(0.1)));
  EXPECT_GE(LeastDistance(trajectory), 0.1);
}

}  // namespace
}  // namespace twin::reference::standard_trajectories_test
