#include "twin/reference/trajectory.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <gmock/gmock.h>

#include "support/fr3_limits.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::reference::trajectory_test {
namespace {

using test::PandaLimits;
using testing::AllOf;
using testing::Each;
using testing::HasSubstr;
using testing::Le;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

constexpr JointVector kReady{
    0, -0.7853981633974483, 0, -2.356194490192345, 0, 1.5707963267948966, 0.7853981633974483};

/// The ready pose with one joint moved.
JointVector Moved(std::size_t joint, double by) {
  JointVector q = kReady;
  q[joint] += by;
  return q;
}

/// Joint 1 through these offsets.
std::vector<Waypoint> Through(const std::vector<double>& offsets) {
  std::vector<Waypoint> waypoints;
  waypoints.reserve(offsets.size());
  for (const double offset : offsets) waypoints.push_back({.q = Moved(0, offset)});
  return waypoints;
}

std::vector<Waypoint> Timed(std::vector<Waypoint> waypoints, const std::vector<Duration>& times) {
  for (std::size_t i = 0; i < waypoints.size(); ++i) waypoints[i].at = times[i];
  return waypoints;
}

void ExpectRefused(const std::vector<Waypoint>& waypoints, const Timing& timing,
                   const testing::Matcher<const std::string&>& text) {
  EXPECT_THAT([&] { Trajectory trajectory(waypoints, timing, PandaLimits()); },
              ThrowsMessage<InputError>(text));
}

TEST(TrajectoryTest, StandsAtTheFirstPointBeforeAndAtTheLastAfter) {
  const Trajectory trajectory(Through({0, 0.4, 1}), {.duration = 3s}, PandaLimits());
  EXPECT_EQ(trajectory.duration(), 3s);
  EXPECT_EQ(trajectory.start(), kReady);
  EXPECT_EQ(trajectory.goal(), Moved(0, 1));
  for (const Duration t : {-1s, 0s}) {
    EXPECT_EQ(trajectory.Sample(t).q, kReady);
    EXPECT_EQ(trajectory.Sample(t).dq, JointVector{});
  }
  for (const Duration t : {3s, 100s}) {
    EXPECT_EQ(trajectory.Sample(t).q, Moved(0, 1));
    EXPECT_EQ(trajectory.Sample(t).dq, JointVector{});
    EXPECT_EQ(trajectory.Sample(t).ddq, JointVector{});
  }
}

TEST(TrajectoryTest, PassesTimedPointsAtTheirTimes) {
  const std::vector<Duration> times{0s, 700ms, 2100ms, 3s};
  const auto waypoints = Timed(Through({0, 0.3, -0.2, 0.5}), times);
  const Trajectory trajectory(waypoints, {}, PandaLimits());
  for (std::size_t i = 0; i < times.size(); ++i) {
    EXPECT_NEAR(trajectory.Sample(times[i]).q[0], waypoints[i].q[0], 1e-15);
    EXPECT_EQ(trajectory.Sample(times[i]).q[1], waypoints[i].q[1]);
  }
  EXPECT_EQ(trajectory.duration(), 3s);
}

TEST(TrajectoryTest, RestsAtStops) {
  auto waypoints = Timed(Through({0, 0.5, 0.5, 0}), {0s, 2s, 3s, 5s});
  waypoints[1].stop = waypoints[2].stop = true;
  const Trajectory trajectory(waypoints, {}, PandaLimits());
  for (const Duration t : std::initializer_list<Duration>{2s, 2500ms, 3s}) {
    const JointTarget target = trajectory.Sample(t);
    EXPECT_NEAR(target.q[0], 0.5, 1e-15);
    EXPECT_NEAR(target.dq[0], 0, 1e-14);
    EXPECT_NEAR(target.ddq[0], 0, 1e-13);
  }
}

TEST(TrajectoryTest, VelocityAndAccelerationAreTheDerivativesOfPosition) {
  const Trajectory trajectory(Through({0, 0.9, -0.4, 0.2}), {.duration = 6s}, PandaLimits());
  constexpr double kStep = 1e-4;
  for (Duration t = 10ms; t < 6s; t += 137ms) {
    const JointTarget before = trajectory.Sample(t - 100us);
    const JointTarget here = trajectory.Sample(t);
    const JointTarget after = trajectory.Sample(t + 100us);
    EXPECT_NEAR(here.dq[0], (after.q[0] - before.q[0]) / (2 * kStep), 1e-6);
    EXPECT_NEAR(here.ddq[0], (after.dq[0] - before.dq[0]) / (2 * kStep), 1e-6);
  }
}

TEST(TrajectoryTest, PeaksOfOneMinimumJerkMoveAreTheKnownOnes) {
  const Trajectory trajectory(Through({0, 1.2}), {.duration = 2s}, PandaLimits());
  // d = 1.2 rad in T = 2 s: 15/8 d/T, 10/sqrt(3) d/T^2, 60 d/T^3.
  EXPECT_NEAR(trajectory.peaks().velocity[0], 1.875 * 1.2 / 2 / 2.175, 1e-14);
  EXPECT_NEAR(trajectory.peaks().acceleration[0], 10 / std::sqrt(3) * 1.2 / 4 / 15, 1e-14);
  EXPECT_NEAR(trajectory.peaks().jerk[0], 60 * 1.2 / 8 / 7500, 1e-14);
  EXPECT_EQ(trajectory.peaks().velocity[1], 0);
}

TEST(TrajectoryTest, PacesUntimedPointsAsFastAsTheSharesAllow) {
  const std::vector<Timing> timings{
      {.velocity_scale = 0.5, .acceleration_scale = 1, .jerk_scale = 1},
      {.velocity_scale = 1, .acceleration_scale = 0.05, .jerk_scale = 1},
      {.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1e-3},
      {.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1}};
  for (const Timing& timing : timings) {
    const Trajectory trajectory(Through({0, 0.9, -1.4, 0.2, 2}), timing, PandaLimits());
    const PeakShares& peaks = trajectory.peaks();
    EXPECT_THAT(peaks.velocity, Each(Le(timing.velocity_scale)));
    EXPECT_THAT(peaks.acceleration, Each(Le(timing.acceleration_scale)));
    EXPECT_THAT(peaks.jerk, Each(Le(timing.jerk_scale)));
    const double tightest = std::max({peaks.velocity[0] / timing.velocity_scale,
                                      peaks.acceleration[0] / timing.acceleration_scale,
                                      peaks.jerk[0] / timing.jerk_scale});
    EXPECT_NEAR(tightest, 1, 1e-5);
  }
}

TEST(TrajectoryTest, SpacesUntimedPointsByTheTimeTheSlowestJointNeeds) {
  // Joint 5 may run at 2.61 rad/s, joint 1 at 2.175: the second distance takes 2.61/2.175 as long.
  const std::vector<Waypoint> waypoints{{.q = kReady}, {.q = Moved(4, 0.5)}, {.q = [] {
                                          JointVector q = Moved(4, 0.5);
                                          q[0] += 0.5;
                                          return q;
                                        }()}};
  const Trajectory trajectory(waypoints, {.duration = 4s}, PandaLimits());
  const Duration middle = FromSeconds(4 / (1 + 2.61 / 2.175));
  EXPECT_NEAR(trajectory.Sample(middle).q[4], 0.5, 1e-8);
}

TEST(TrajectoryTest, StretchesByOneFactor) {
  const auto waypoints = Through({0, 0.9, -1.4, 0.2, 2});
  const Trajectory slow(waypoints, {.duration = 20s}, PandaLimits());
  const Trajectory slower(waypoints, {.duration = 40s}, PandaLimits());
  EXPECT_NEAR(slow.peaks().velocity[0] / slower.peaks().velocity[0], 2, 1e-7);
  EXPECT_NEAR(slow.peaks().acceleration[0] / slower.peaks().acceleration[0], 4, 1e-7);
  EXPECT_NEAR(slow.peaks().jerk[0] / slower.peaks().jerk[0], 8, 1e-7);
}

TEST(TrajectoryTest, TakesTheTimeThatVelocityLimitsByPositionNeed) {
  const JointLimits limits = test::Fr3Limits();
  JointVector start = kReady;
  start[5] = 4.0;
  JointVector near_the_end = start;
  near_the_end[5] = limits.q_max[5] - 0.03;
  const Timing timing{.velocity_scale = 1, .acceleration_scale = 1, .jerk_scale = 1};
  const Trajectory path({{.q = start}, {.q = near_the_end}}, timing, limits);
  JointLimits box = limits;
  box.deceleration = {};
  EXPECT_GT(path.duration(),
            Trajectory({{.q = start}, {.q = near_the_end}}, timing, box).duration());
  double largest = 0;
  for (Duration t = kCycle; t < path.duration(); t += kCycle) {
    const JointTarget target = path.Sample(t);
    largest = std::max(largest, target.dq[5] / limits.VelocityLimit(5, target.q[5], target.dq[5]));
  }
  EXPECT_LE(largest, 1);
  EXPECT_GT(largest, 0.99);
}

TEST(TrajectoryTest, RefusesAGoalWhereNoVelocityIsPermitted) {
  const JointLimits limits = test::Fr3Limits();
  JointVector end = kReady;
  end[3] = limits.q_max[3] - 0.01;
  try {
    const Trajectory path({{.q = kReady}, {.q = end}}, {}, limits);
    FAIL() << "it was taken";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("joint 4"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("stay 0.0112 rad"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(Trajectory({{.q = end}, {.q = kReady}}, {}, limits)) << "away from it";
}

TEST(TrajectoryTest, RefusesFewerThanTwoPoints) {
  ExpectRefused({}, {}, HasSubstr("0 points; at least two are needed"));
  ExpectRefused(Through({0}), {}, HasSubstr("1 point; at least two are needed"));
}

TEST(TrajectoryTest, RefusesAValueThatIsNotFinite) {
  auto waypoints = Through({0, 0.5});
  waypoints[1].q[2] = std::nan("");
  waypoints[1].where = "motion.yaml:7";
  ExpectRefused(waypoints, {},
                AllOf(HasSubstr("point 2 (motion.yaml:7)"), HasSubstr("joint 3 is nan")));
  waypoints[1].q[2] = std::numeric_limits<double>::infinity();
  ExpectRefused(waypoints, {}, HasSubstr("joint 3 is inf"));
}

TEST(TrajectoryTest, RefusesAPointOutsideThePositionLimits) {
  auto waypoints = Through({0, 0.5});
  waypoints[1].q[3] = -0.05;
  ExpectRefused(waypoints, {},
                HasSubstr("point 2: joint 4 is -0.05 rad, not inside its limits (-3.0718, -0.0698) "
                          "rad; move the point inside"));
  waypoints[1].q[3] = -0.0698;  // the robot wants it strictly inside
  ExpectRefused(waypoints, {}, HasSubstr("joint 4 is -0.0698 rad, not inside"));
}

TEST(TrajectoryTest, RefusesAPathThatSwingsOutOfThePositionLimitsBetweenPoints) {
  auto waypoints = Timed(Through({0, 0, 0, 0}), {0s, 4s, 8s, 12s});
  waypoints[1].q[1] = waypoints[2].q[1] = 1.75;
  ExpectRefused(
      waypoints, {},
      AllOf(HasSubstr("joint 2 swings to "), HasSubstr("at 6.0000 s, between point 2 and point 3"),
            HasSubstr("not inside its limits (-1.7628, 1.7628)"),
            HasSubstr("put another between them")));
}

TEST(TrajectoryTest, RefusesTimesThatAreIncompleteOrDoNotRise) {
  auto waypoints = Timed(Through({0, 0.1, 0.2}), {0s, 1s, 2s});
  waypoints[2].at.reset();
  ExpectRefused(waypoints, {},
                HasSubstr("point 3 has no time but point 1 has one; give `at` to all"));
  ExpectRefused(Timed(Through({0, 0.1, 0.2}), {0s, 1s, 1s}), {},
                HasSubstr("point 3: its time 1 s is not after the 1 s of point 2"));
  ExpectRefused(Timed(Through({0, 0.1}), {1s, 2s}), {},
                HasSubstr("point 1: its time is 1 s; the first point's must be 0 s"));
  ExpectRefused(Timed(Through({0, 0.1}), {0s, 2s}), {.duration = 3s},
                HasSubstr("the duration is 3 s but the last point's time is 2 s"));
}

TEST(TrajectoryTest, RefusesTimingOutOfRange) {
  ExpectRefused(Through({0, 0.1}), {.duration = 0s}, HasSubstr("the duration is 0 s"));
  ExpectRefused(Through({0, 0.1}), {.duration = 25h}, HasSubstr("at most 86400 s"));
  ExpectRefused(Through({0, 0.1}), {.velocity_scale = 0},
                HasSubstr("the velocity share of the limits is 0; it must lie in (0, 1]"));
  ExpectRefused(Through({0, 0.1}), {.acceleration_scale = 1.1},
                HasSubstr("the acceleration share of the limits is 1.1"));
  ExpectRefused(Through({0, 0.1}), {.jerk_scale = std::nan("")},
                HasSubstr("the jerk share of the limits is nan"));
  ExpectRefused(Through({0, 0.1}), {.velocity_scale = 1e-9}, HasSubstr("at the wanted pace"));
}

TEST(TrajectoryTest, RefusesUntimedNeighboursThatCoincide) {
  ExpectRefused(Through({0, 0.5, 0.5, 1}), {}, HasSubstr("point 2 and point 3 coincide"));
  ExpectRefused(Through({0, 0.5, 0.5000011}), {.duration = 10ns},
                HasSubstr("too short to tell point 2 and point 3 apart"));
}

TEST(TrajectoryTest, NamesTheShortestAdmissibleDurationWhenAVelocityLimitBreaks) {
  // Peak velocity 15/8 d/T: with d = 2 rad at 2.175 rad/s, T = 1.724138 s, and 2e-6 s for rounding.
  const auto waypoints = Timed(Through({0, 2}), {0s, 1500ms});
  ExpectRefused(waypoints, {},
                AllOf(HasSubstr("joint 1 reaches 2.5 rad/s at 0.7500 s, between point 1 and point "
                                "2; its velocity limit is 2.175 rad/s"),
                      HasSubstr("the same path is admissible from 1.725 s in all (now 1.5 s)")));
  EXPECT_NO_THROW(Trajectory(Through({0, 2}), {.duration = 1725ms}, PandaLimits()));
  ExpectRefused(Through({0, 2}), {.duration = 1724ms}, HasSubstr("velocity limit"));
}

TEST(TrajectoryTest, NamesTheLimitThatAsksForMostTime) {
  // 0.05 rad: jerk 60 d/T^3 > 7500 below T = 73.7 ms, acceleration 5.77 d/T^2 > 15 below 138.7 ms.
  ExpectRefused(Through({0, 0.05}), {.duration = 100ms},
                AllOf(HasSubstr("acceleration limit is 15 rad/s^2"), HasSubstr("from 0.139 s")));
  // 0.001 rad: 20 ms against 19.6 ms.
  ExpectRefused(Through({0, 0.001}), {.duration = 10ms},
                AllOf(HasSubstr("jerk limit is 7500 rad/s^3"), HasSubstr("from 0.021 s")));
}

TEST(TrajectoryTest, TellsTheCureForRoughlyRoundedDenseData) {
  std::vector<Waypoint> waypoints;
  for (int i = 0; i <= 1000; ++i) {
    const double s = i / 1000.0;
    const double q = 0.5 * s * s * s * (10 + s * (-15 + 6 * s));
    waypoints.push_back({.q = Moved(0, std::round(q * 1e5) / 1e5), .at = i * kCycle});
  }
  ExpectRefused(waypoints, {}, HasSubstr("only 1 ms apart, give them with more digits"));
}

TEST(TrajectoryTest, SamplingAllocatesNothing) {
  const Trajectory trajectory(Through({0, 0.9, -0.4, 0.2}), {.duration = 6s}, PandaLimits());
  const test::RealtimeGuard guard;
  double sum = 0;
  for (Duration t = -1s; t < 8s; t += 1ms) sum += trajectory.Sample(t).q[0];
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_NE(sum, 0);
}

}  // namespace
}  // namespace twin::reference::trajectory_test
