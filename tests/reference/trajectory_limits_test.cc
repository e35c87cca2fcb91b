// What INT will say of a trajectory: its checks are applied to positions sampled at 1 ms.

#include <algorithm>
#include <cmath>
#include <optional>

#include <gmock/gmock.h>

#include "reference/quintic_path.h"
#include "support/panda_limits.h"
#include "twin/core/random.h"
#include "twin/reference/trajectory.h"

namespace twin::reference::trajectory_limits_test {
namespace {

using test::PandaLimits;

/// Relative tolerance of INT's own checks.
constexpr double kTolerance = 1e-9;

std::vector<Waypoint> RandomPoints(std::uint64_t seed) {
  const Random random(seed, RandomStream::kTest);
  const JointLimits limits = PandaLimits();
  std::vector<Waypoint> waypoints(3 + random.Bits(0)[0] % 6);
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    for (std::size_t j = 0; j < kJoints; ++j) {
      // In the middle half of the range, so that most paths stay inside between points.
      const double share = 0.25 + 0.5 * random.Uniform(i + 1, static_cast<std::uint32_t>(j));
      waypoints[i].q[j] = limits.q_min[j] + share * (limits.q_max[j] - limits.q_min[j]);
    }
    waypoints[i].stop = random.Uniform(i + 1, 50) < 0.2;
  }
  return waypoints;
}

/// A trajectory at the edge of the limits, or none when its path leaves the position limits.
std::optional<Trajectory> RandomTrajectory(std::uint64_t seed) {
  try {
    return Trajectory(RandomPoints(seed),
                      {.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1},
                      PandaLimits());
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

/// Largest share of a limit that backward differences at 1 ms reach, as INT forms them.
struct DifferenceShares {
  double velocity = 0;
  double acceleration = 0;
  double jerk = 0;
};

DifferenceShares Differentiate(const Trajectory& trajectory, Duration phase) {
  const JointLimits limits = PandaLimits();
  DifferenceShares worst;
  JointVector q_d = trajectory.start();
  JointVector dq_d{};
  JointVector ddq_d{};
  for (Duration t = phase; t < trajectory.duration() + 5 * kCycle; t += kCycle) {
    const JointVector q = trajectory.Sample(t).q;
    for (std::size_t j = 0; j < kJoints; ++j) {
      const double dq = (q[j] - q_d[j]) / kCycleSeconds;
      const double ddq = (dq - dq_d[j]) / kCycleSeconds;
      const double dddq = (ddq - ddq_d[j]) / kCycleSeconds;
      worst.velocity = std::max(worst.velocity, std::abs(dq) / limits.dq_max[j]);
      worst.acceleration = std::max(worst.acceleration, std::abs(ddq) / limits.ddq_max[j]);
      worst.jerk = std::max(worst.jerk, std::abs(dddq) / limits.dddq_max[j]);
      q_d[j] = q[j];
      dq_d[j] = dq;
      ddq_d[j] = ddq;
    }
  }
  return worst;
}

TEST(TrajectoryLimitsTest, BackwardDifferencesStayInsideTheLimitsAtAnyPhase) {
  const Random random(99, RandomStream::kTest);
  int tried = 0;
  double closest = 0;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    const auto trajectory = RandomTrajectory(seed);
    if (!trajectory) continue;
    ++tried;
    const Duration phase(static_cast<std::int64_t>(1e6 * random.Uniform(seed)));
    for (const Duration p : {Duration::zero(), phase}) {
      const DifferenceShares worst = Differentiate(*trajectory, p);
      ASSERT_LE(worst.velocity, 1 + kTolerance) << "seed " << seed;
      ASSERT_LE(worst.acceleration, 1 + kTolerance) << "seed " << seed;
      ASSERT_LE(worst.jerk, 1 + kTolerance) << "seed " << seed;
      closest = std::max({closest, worst.velocity, worst.acceleration, worst.jerk});
    }
  }
  EXPECT_GT(tried, 100);
  EXPECT_GT(closest, 0.9999) << "no trajectory came near a limit: the test shows nothing";
}

TEST(TrajectoryLimitsTest, JerkAtItsLimitStaysInsideOverShortMoves) {
  // So small that the jerk alone decides (the other two would allow more pace).
  const JointLimits limits = PandaLimits();
  for (std::size_t j = 0; j < kJoints; ++j) {
    std::vector<Waypoint> waypoints(2);
    waypoints[0].q = waypoints[1].q = {0, 0, 0, -2, 0, 2, 0};
    waypoints[1].q[j] += 2e-4;
    const Trajectory trajectory(
        waypoints, {.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1}, limits);
    EXPECT_GT(trajectory.peaks().jerk[j], 0.99);
    double worst = 0;
    for (Duration phase{}; phase < kCycle; phase += std::chrono::microseconds(50)) {
      worst = std::max(worst, Differentiate(trajectory, phase).jerk);
    }
    EXPECT_LE(worst, 1 + kTolerance);
    EXPECT_GT(worst, 0.4);
  }
}

TEST(TrajectoryLimitsTest, TimeSinceTheStartEatsNoDigits) {
  // The same move at once and after an hour at rest: its samples are the same to the last bit.
  std::vector<Waypoint> waypoints(2);
  waypoints[0].q = waypoints[1].q = {2, 0.5, 2, -2, 2, 3, 2};
  waypoints[1].q[1] -= 1;
  waypoints[0].at = Duration::zero();
  waypoints[1].at = std::chrono::milliseconds(1500);
  const Trajectory at_once(waypoints, {}, PandaLimits());
  const Duration rest = std::chrono::hours(1);
  waypoints.insert(waypoints.begin(), waypoints[0]);
  waypoints[1].stop = true;
  waypoints[1].at = rest;
  waypoints[2].at = rest + std::chrono::milliseconds(1500);
  const Trajectory later(waypoints, {}, PandaLimits());
  for (int k = -10; k < 1600; ++k) {
    ASSERT_EQ(later.Sample(rest + k * kCycle).q, at_once.Sample(k * kCycle).q);
  }
}

TEST(FindExtremesTest, AgreesWithDenseSampling) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const auto waypoints = RandomPoints(seed);
    std::vector<Duration> knots;
    for (std::size_t i = 0; i < waypoints.size(); ++i) {
      knots.push_back(static_cast<std::int64_t>(i) * std::chrono::milliseconds(700));
    }
    const auto segments = internal::FitSpline(waypoints, knots);
    const auto extremes = internal::FindExtremes(segments);
    constexpr int kSteps = 2000;
    for (std::size_t j = 0; j < kJoints; ++j) {
      JointTarget most{};  // magnitudes of one joint in the first components
      double lowest = 1e9;
      double highest = -1e9;
      double dddq_most = 0;
      for (const QuinticSegment& segment : segments) {
        for (int k = 0; k <= kSteps; ++k) {
          const double x = segment.length_s * k / kSteps;
          const auto& c = segment.c[j];
          double q = 0, dq = 0, ddq = 0, dddq = 0;
          for (int i = 5; i >= 0; --i) {  // repeated synthetic division
            dddq = dddq * x + 3 * ddq;
            ddq = ddq * x + 2 * dq;
            dq = dq * x + q;
            q = q * x + c[static_cast<std::size_t>(i)];
          }
          lowest = std::min(lowest, q);
          highest = std::max(highest, q);
          most.dq[0] = std::max(most.dq[0], std::abs(dq));
          most.ddq[0] = std::max(most.ddq[0], std::abs(ddq));
          dddq_most = std::max(dddq_most, std::abs(dddq));
        }
      }
      // Never below what sampling sees, and above it by no more than sampling misses.
      const auto expect_peak = [&](double exact, double sampled) {
        EXPECT_GE(exact, sampled * (1 - 1e-12));
        EXPECT_LE(exact, sampled * (1 + 1e-4));
      };
      expect_peak(std::abs(extremes.dq[j].value), most.dq[0]);
      expect_peak(std::abs(extremes.ddq[j].value), most.ddq[0]);
      expect_peak(std::abs(extremes.dddq[j].value), dddq_most);
      EXPECT_NEAR(extremes.q_highest[j].value, highest, 1e-5);
      EXPECT_GE(extremes.q_highest[j].value, highest - 1e-14);
      EXPECT_NEAR(extremes.q_lowest[j].value, lowest, 1e-5);
      EXPECT_LE(extremes.q_lowest[j].value, lowest + 1e-14);
    }
  }
}

}  // namespace
}  // namespace twin::reference::trajectory_limits_test
