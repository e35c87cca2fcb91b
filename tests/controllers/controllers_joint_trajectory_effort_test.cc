#include "controllers/joint_trajectory_effort.h"

#include <cmath>
#include <limits>
#include <string>

#include <gmock/gmock.h>

#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::controllers::controllers_joint_trajectory_effort_test {
namespace {

using control::CommandInterface;
using control::ControllerOutput;
using reference::JointTarget;
using reference::Trajectory;
using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;
using namespace std::chrono_literals;

constexpr JointVector kFirst{0, -0.5, 0, -2, 0, 1.5, 0.7};
constexpr JointVector kLast{0.5, -0.4, 0.3, -2.2, -0.3, 1.9, 0};
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

Trajectory TestTrajectory() {
  return Trajectory({{.q = kFirst}, {.q = kLast}}, {.duration = 2s}, twin::test::PandaLimits());
}

RobotState StateAt(const JointVector& q, const JointVector& dq = {},
                   const JointVector& tau_J_d = {}) {
  RobotState state;
  state.q = q;
  state.dq = dq;
  state.tau_J_d = tau_J_d;
  return state;
}

/// A state off the path by a little, differently in every joint.
RobotState StateNear(const JointTarget& target) {
  RobotState state = StateAt(target.q, target.dq);
  for (std::size_t j = 0; j < kJoints; ++j) {
    state.q[j] -= 1e-3 * static_cast<double>(j + 1);
    state.dq[j] += 2e-3 * static_cast<double>(j + 1);
  }
  return state;
}

/// Without a soft start, so that the law stands alone.
JointTrajectoryEffortOptions Plain() {
  JointTrajectoryEffortOptions options;
  options.soft_start = Duration::zero();
  return options;
}

TEST(JointTrajectoryEffortControllerTest, HasThePapersGains) {
  const JointTrajectoryEffortOptions options;
  EXPECT_EQ(options.K_P, (JointVector{600, 600, 600, 600, 250, 150, 50}));
  EXPECT_EQ(options.K_I, JointVector{});
  EXPECT_EQ(options.K_D, (JointVector{30, 30, 30, 30, 10, 10, 5}));
}

TEST(JointTrajectoryEffortControllerTest, CommandsTorque) {
  EXPECT_EQ(JointTrajectoryEffortController(TestTrajectory()).command_interface(),
            CommandInterface::kTorque);
}

TEST(JointTrajectoryEffortControllerTest, GivesTheTorqueOfItsLawAlongThePath) {
  const Trajectory trajectory = TestTrajectory();
  const JointTrajectoryEffortOptions options = Plain();
  JointTrajectoryEffortController controller(trajectory, options);
  controller.Activate(StateAt(kFirst), Time(3s));
  ControllerOutput output;
  for (Duration t{}; t < 2s; t += 8ms) {
    const JointTarget target = trajectory.Sample(t);
    const RobotState state = StateNear(target);
    controller.Update(state, Time(3100ms) + t, output);
    EXPECT_EQ(output.target.joint.q, target.q);
    EXPECT_FALSE(output.finished);
    for (std::size_t j = 0; j < kJoints; ++j) {
      // The errors StateNear() makes: +1e-3 (j + 1) rad and -2e-3 (j + 1) rad/s.
      const double n = static_cast<double>(j + 1);
      EXPECT_NEAR(output.target.tau_J_d[j], 1e-3 * n * options.K_P[j] - 2e-3 * n * options.K_D[j],
                  1e-10);
    }
  }
}

TEST(JointTrajectoryEffortControllerTest, GivesNoTorqueOnThePath) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryEffortController controller(trajectory);
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  for (Duration t{}; t < 3s; t += 50ms) {
    const JointTarget target = trajectory.Sample(t);
    controller.Update(StateAt(target.q, target.dq), Time(t), output);
    for (const double tau : output.target.tau_J_d) EXPECT_EQ(tau, 0);
  }
}

TEST(JointTrajectoryEffortControllerTest, IsNotDelayedByASkippedUpdate) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryEffortController controller(trajectory);
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(1s), output);
  controller.Update(StateAt(kFirst), Time(1700ms), output);
  EXPECT_EQ(output.target.joint.q, trajectory.Sample(700ms).q);
}

TEST(JointTrajectoryEffortControllerTest, BeginsWithTheTorqueThatHeldTheArmAndFadesInALine) {
  JointTrajectoryEffortController controller(TestTrajectory());
  const JointVector holding{0.9, -0.8, 0.7, 1.2, -0.5, 0.4, 0.3};
  JointVector q = kFirst;
  q[0] += 5e-3;  // 3 Nm by the law
  controller.Activate(StateAt(q), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(q, {}, holding), Time(0s), output);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(output.target.tau_J_d[j], holding[j], 1e-12);
  }

  // Half a soft start later half of the difference is left, and the state's torque does not count.
  JointTrajectoryEffortController plain(TestTrajectory(), Plain());
  ControllerOutput law;
  plain.Update(StateAt(q), Time(0s), law);
  JointVector bump{};
  for (std::size_t j = 0; j < kJoints; ++j) bump[j] = holding[j] - law.target.tau_J_d[j];
  controller.Update(StateAt(q, {}, JointVector{9, 9, 9, 9, 9, 9, 9}), Time(50ms), output);
  plain.Update(StateAt(q), Time(50ms), law);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(output.target.tau_J_d[j], law.target.tau_J_d[j] + 0.5 * bump[j], 1e-12);
  }
  controller.Update(StateAt(q), Time(100ms), output);
  plain.Update(StateAt(q), Time(100ms), law);
  EXPECT_EQ(output.target.tau_J_d, law.target.tau_J_d);
}

TEST(JointTrajectoryEffortControllerTest, IntegratesTheErrorOverTheElapsedTime) {
  JointTrajectoryEffortOptions options = Plain();
  options.K_P = options.K_D = JointVector{};
  options.K_I.fill(10);
  JointTrajectoryEffortController controller(TestTrajectory(), options);
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  for (const double tau : output.target.tau_J_d) EXPECT_EQ(tau, 0);
  JointVector q = kLast;
  q[2] -= 0.02;
  controller.Update(StateAt(kLast), Time(2s), output);  // on the goal from here on
  const double at_end = output.target.tau_J_d[2];
  controller.Update(StateAt(q), Time(2100ms), output);
  controller.Update(StateAt(q), Time(2300ms), output);
  EXPECT_NEAR(output.target.tau_J_d[2] - at_end, 10 * 0.02 * 0.3, 1e-12);
}

TEST(JointTrajectoryEffortControllerTest, TheIntegralDoesNotWindUp) {
  JointTrajectoryEffortOptions options = Plain();
  options.K_P = options.K_D = JointVector{};
  options.K_I.fill(100);
  JointTrajectoryEffortController controller(TestTrajectory(), options);
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  JointVector q = kLast;
  q[4] -= 0.1;  // blocked short of the goal
  for (Duration t{}; t < 20s; t += 10ms) controller.Update(StateAt(q), Time(t), output);
  EXPECT_EQ(output.target.tau_J_d[4], options.integral_max[4]);
  // 3 Nm are taken back by 10 Nm/s in 0.3 s of the opposite error, however long it was blocked.
  q[4] += 0.2;
  for (Duration t = 20s; t < 20310ms; t += 10ms) controller.Update(StateAt(q), Time(t), output);
  EXPECT_LE(output.target.tau_J_d[4], 0);
}

TEST(JointTrajectoryEffortControllerTest, FinishesWhenTheArmHasSettledNotBefore) {
  JointTrajectoryEffortController controller(TestTrajectory());
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  controller.Update(StateAt(kLast), Time(1999ms), output);
  EXPECT_FALSE(output.finished) << "at the goal, but the path is not over";
  JointVector q = kLast;
  q[5] += 0.011;
  controller.Update(StateAt(q), Time(2s), output);
  EXPECT_FALSE(output.finished) << "off the goal";
  controller.Update(StateAt(kLast, {0, 0, 0, 0, 0, 0, -0.011}), Time(2100ms), output);
  EXPECT_FALSE(output.finished) << "still moving";
  q[5] = kLast[5] + 0.009;
  controller.Update(StateAt(q, {0, 0, 0, 0, 0, 0, -0.009}), Time(2200ms), output);
  EXPECT_TRUE(output.finished);
  controller.Update(StateAt(kFirst), Time(2300ms), output);
  EXPECT_TRUE(output.finished) << "for good";
  EXPECT_EQ(output.target.joint.q, kLast);
  EXPECT_EQ(output.target.joint.dq, JointVector{});
}

TEST(JointTrajectoryEffortControllerTest, FinishesAfterTheSettlingTimeAnyway) {
  JointTrajectoryEffortController controller(TestTrajectory());
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  controller.Update(StateAt(kFirst), Time(2999ms), output);
  EXPECT_FALSE(output.finished);
  controller.Update(StateAt(kFirst), Time(3s), output);
  EXPECT_TRUE(output.finished);
}

TEST(JointTrajectoryEffortControllerTest, StartsAnewAfterEachActivation) {
  JointTrajectoryEffortOptions options = Plain();
  options.K_I.fill(10);
  JointTrajectoryEffortController controller(TestTrajectory(), options);
  ControllerOutput output;
  for (const Duration start : std::initializer_list<Duration>{0s, 10s, 20s}) {
    controller.Activate(StateAt(kFirst), Time(start));
    controller.Update(StateAt(kFirst), Time(start), output);
    EXPECT_EQ(output.target.joint.q, kFirst);
    EXPECT_EQ(output.target.tau_J_d, JointVector{}) << "nothing of the integral is left";
    EXPECT_FALSE(output.finished);
    controller.Update(StateAt(kFirst), Time(start + 1s), output);
    controller.Update(StateAt(kLast), Time(start + 2s), output);
    EXPECT_TRUE(output.finished);
    controller.Deactivate();
  }
}

TEST(JointTrajectoryEffortControllerTest, RefusesToStartAwayFromTheFirstPoint) {
  JointTrajectoryEffortController controller(TestTrajectory());
  JointVector q = kFirst;
  q[3] += 0.0199;
  EXPECT_NO_THROW(controller.Activate(StateAt(q), Time(0s)));
  q[3] = -1.9;
  EXPECT_THAT([&] { controller.Activate(StateAt(q), Time(0s)); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("joint 4 of the robot is at -1.900000 rad"),
                                              HasSubstr("starts at -2.000000 rad"),
                                              HasSubstr("differ by 0.02 rad"),
                                              HasSubstr("Move the robot to the first point"))));
  q[3] = kNaN;
  EXPECT_THROW(controller.Activate(StateAt(q), Time(0s)), InputError);
}

TEST(JointTrajectoryEffortControllerTest, RefusesOptionsOutOfRangeByName) {
  const auto refuses = [](const JointTrajectoryEffortOptions& options, const std::string& name) {
    EXPECT_THAT([&] { JointTrajectoryEffortController(TestTrajectory(), options); },
                ThrowsMessage<InputError>(HasSubstr(name)));
  };
  const auto with = [](auto change) {
    JointTrajectoryEffortOptions options;
    change(options);
    return options;
  };
  refuses(with([](auto& o) { o.K_P[0] = -1; }), "K_P[0]");
  refuses(with([](auto& o) { o.K_I[6] = kNaN; }), "K_I[6]");
  refuses(with([](auto& o) { o.K_D[3] = 2e3; }), "K_D[3]");
  refuses(with([](auto& o) { o.integral_max[1] = -0.1; }), "integral_max[1]");
  refuses(with([](auto& o) { o.soft_start = -1ms; }), "soft_start");
  refuses(with([](auto& o) { o.start_tolerance_rad = 0.2; }), "start_tolerance_rad");
  refuses(with([](auto& o) { o.settled_distance_rad = 0; }), "settled_distance_rad");
  refuses(with([](auto& o) { o.settled_speed_rad_per_s = kNaN; }), "settled_speed_rad_per_s");
  refuses(with([](auto& o) { o.settling_time = 61s; }), "settling_time");
}

/// Options with these tolerances, without a soft start.
JointTrajectoryEffortOptions Tolerant(double path, double goal) {
  JointTrajectoryEffortOptions options = Plain();
  options.path_tolerance.fill(path);
  options.goal_tolerance.fill(goal);
  return options;
}

TEST(JointTrajectoryEffortControllerTest, GivesUpOffThePathNamingJointDistanceAndTolerance) {
  const Trajectory trajectory = TestTrajectory();
  JointTrajectoryEffortController controller(trajectory, Tolerant(0.1, 0));
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  JointVector q = trajectory.Sample(1s).q;
  q[4] += 0.0999;
  controller.Update(StateAt(q), Time(1s), output);
  EXPECT_FALSE(output.failed);
  EXPECT_EQ(controller.Explain(), "");
  q = trajectory.Sample(1100ms).q;
  q[4] -= 0.11;
  controller.Update(StateAt(q), Time(1100ms), output);
  EXPECT_TRUE(output.failed);
  EXPECT_FALSE(output.finished);
  EXPECT_THAT(controller.Explain(), AllOf(HasSubstr("joint 5 was 0.1100 rad off the path"),
                                          HasSubstr("1.100 s"), HasSubstr("0.1000 rad")));
  ControllerOutput later;
  controller.Update(StateAt(kLast), Time(5s), later);
  EXPECT_TRUE(later.failed) << "for good";
}

TEST(JointTrajectoryEffortControllerTest, GivesUpOffTheGoalAfterItsTimeAndNotBefore) {
  JointTrajectoryEffortController controller(TestTrajectory(), Tolerant(0, 0.05));
  controller.Activate(StateAt(kFirst), Time(0s));
  ControllerOutput output;
  controller.Update(StateAt(kFirst), Time(0s), output);
  JointVector q = kLast;
  q[1] += 0.06;
  controller.Update(StateAt(q), Time(2999ms), output);
  EXPECT_FALSE(output.failed);
  controller.Update(StateAt(q), Time(3s), output);
  EXPECT_TRUE(output.failed);
  EXPECT_THAT(controller.Explain(),
              AllOf(HasSubstr("joint 2 was 0.0600 rad off the goal"), HasSubstr("goal_time")));
}

TEST(JointTrajectoryEffortControllerTest, IsFinishedWithinItsGoalTolerance) {
  JointTrajectoryEffortController controller(TestTrajectory(), Tolerant(0, 0.05));
  for (const Duration begin : std::initializer_list<Duration>{0s, 10s}) {
    controller.Activate(StateAt(kFirst), Time(begin));
    ControllerOutput output;
    controller.Update(StateAt(kFirst), Time(begin), output);
    JointVector q = kLast;
    q[1] += 0.04;
    controller.Update(StateAt(q), Time(begin + 2500ms), output);
    EXPECT_FALSE(output.finished) << "not settled";
    controller.Update(StateAt(q), Time(begin + 3s), output);
    EXPECT_TRUE(output.finished);
    EXPECT_FALSE(output.failed);
    controller.Deactivate();
  }
}

TEST(JointTrajectoryEffortControllerTest, TakesItsParameters) {
  JointTrajectoryEffortController controller(TestTrajectory());
  const control::Parameters parameters{
      {.key = "K_P", .values = {"300 Nm/rad"}},
      {.key = "K_I", .values = {"5 Nm/rad/s"}},
      {.key = "K_D.unit", .values = {"Nms/rad"}},
      {.key = "K_D.values", .values = {"1", "2", "3", "4", "5", "6", "7"}, .is_list = true},
      {.key = "path_tolerance", .values = {"0.2 rad"}},
      {.key = "goal_tolerance", .values = {"1 deg"}},
      {.key = "goal_time", .values = {"2 s"}},
      {.key = "stopped_velocity_tolerance", .values = {"0.02 rad/s"}}};
  control::ParameterReader reader(parameters);
  controller.Configure(reader);
  EXPECT_NO_THROW(reader.RefuseUnread());
  const JointTrajectoryEffortOptions& o = controller.options();
  EXPECT_EQ(o.K_P[6], 300);
  EXPECT_EQ(o.K_I[0], 5);
  EXPECT_EQ(o.K_D[6], 7);
  EXPECT_EQ(o.path_tolerance[3], 0.2);
  EXPECT_NEAR(o.goal_tolerance[3], 0.01745, 1e-5);
  EXPECT_EQ(o.settling_time, 2s);
  EXPECT_EQ(o.settled_speed_rad_per_s, 0.02);
}

TEST(JointTrajectoryEffortControllerTest, UpdatesWithoutAllocating) {
  JointTrajectoryEffortController controller(TestTrajectory());
  const RobotState state = StateAt(kFirst);
  controller.Activate(state, Time(0s));
  ControllerOutput output;
  const twin::test::RealtimeGuard guard;
  for (Duration t{}; t < 4s; t += 1ms) controller.Update(state, Time(t), output);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, twin::test::RealtimeGuard::Counts{});
  EXPECT_TRUE(output.finished);
}

}  // namespace
}  // namespace twin::controllers::controllers_joint_trajectory_effort_test
