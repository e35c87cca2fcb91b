#include "controllers/cartesian_pose.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include "support/dense.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/joint_vector.h"
#include "twin/core/random.h"
#include "twin/model/inverse_kinematics.h"
#include "twin/model/transform.h"
#include "twin/onboard/joint_reference.h"

namespace twin::controllers::controllers_cartesian_pose_test {
namespace {

using control::ControllerOutput;
using control::ControllerRequest;
using model::ArmModel;
using reference::PoseTrajectory;
using reference::Trajectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

const JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
constexpr auto kEndEffector = model::Frame::kEndEffector;

Transform PoseAt(const JointVector& q) {
  return ArmModel::Panda().Pose(kEndEffector, q);
}

Transform Moved(Transform pose, double x, double y, double z) {
  pose[12] += x;
  pose[13] += y;
  pose[14] += z;
  return pose;
}

/// A path of poses from where the arm is at `q`, and all a controller needs of it.
struct Bench {
  explicit Bench(const std::vector<reference::PoseWaypoint>& waypoints,
                 const JointVector& q = kReady)
      : poses(waypoints,
              {.duration = {}, .velocity_scale = 0.3, .acceleration_scale = 0.1, .jerk_scale = 0.1},
              twin::test::PandaCartesianLimits()),
        stand({{.q = q, .at = 0s}, {.q = q, .at = poses.duration()}}, {},
              twin::test::PandaLimits()) {
    state.q = state.q_d = q;
  }
  [[nodiscard]] ControllerRequest request() const {
    return {.trajectory = stand,
            .poses = &poses,
            .limits = twin::test::PandaLimits(),
            .cartesian = twin::test::PandaCartesianLimits()};
  }

  PoseTrajectory poses;
  Trajectory stand;
  RobotState state;
};

Bench Box() {
  const Transform start = PoseAt(kReady);
  return Bench({{.O_T_EE = start},
                {.O_T_EE = Moved(start, 0.1, 0.15, -0.1)},
                {.O_T_EE = Moved(start, -0.05, 0.15, 0.1)},
                {.O_T_EE = start}});
}

TEST(DampedLeastSquaresTest, IsTheFormulaWithSevenBySevenMatrices) {
  using Matrix67 = Eigen::Matrix<double, 6, 7>;
  using Matrix7 = Eigen::Matrix<double, 7, 7>;
  const Random random(11, RandomStream::kTest);
  for (const double alpha : {1e-6, 1e-3, 1.0}) {
    for (std::uint64_t i = 0; i < 20; ++i) {
      model::Jacobian J{};
      Vector6 v{};
      for (std::uint32_t k = 0; k < J.size(); ++k) J[k] = 2 * random.Uniform(i, k) - 1;
      for (std::uint32_t k = 0; k < 6; ++k) v[k] = 2 * random.Uniform(i, 100 + k) - 1;
      const Eigen::Map<const Matrix67> jacobian(J.data());
      const Matrix7 A = jacobian.transpose() * jacobian + alpha * Matrix7::Identity();
      const Eigen::VectorXd expected = twin::test::Solve(
          A, jacobian.transpose() * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(v.data()));
      const JointVector dq = model::DampedLeastSquares(J, v, alpha);
      for (std::size_t j = 0; j < kJoints; ++j) {
        EXPECT_NEAR(dq[j], expected[static_cast<Eigen::Index>(j)], 1e-7) << alpha;
      }
    }
  }
}

TEST(CartesianPoseTest, FollowsThePathAndRestsAtItsGoal) {
  const Bench bench = Box();
  CartesianPoseController controller(bench.request());
  controller.Activate(bench.state, Time(5s));
  ControllerOutput output;
  double most = 0;
  Duration t{};
  for (; t <= bench.poses.duration() + 1s && !output.finished; t += 1ms) {
    controller.Update(bench.state, Time(5s) + t, output);
    ASSERT_FALSE(output.failed) << controller.Explain();
    most = std::max(
        most,
        HalfNorm(model::WayTo(PoseAt(output.target.joint.q), bench.poses.Sample(t).O_T_EE), 0));
  }
  // T a / (2 K_P) for the 0.75 m/s^2 that 0.1 of the limits is at most, twice for the arm's own
  // part.
  EXPECT_LT(most, 2 * 1e-3 * 0.75 / (2 * 10));
  ASSERT_TRUE(output.finished);
  EXPECT_LT(t, bench.poses.duration() + 20ms);
  const JointVector q = output.target.joint.q;
  EXPECT_EQ(output.target.joint.dq, JointVector{});
  controller.Update(bench.state, Time(5s) + t + 1s, output);
  EXPECT_EQ(output.target.joint.q, q) << "at rest, bit for bit";
  const Vector6 left = model::WayTo(PoseAt(q), bench.poses.goal());
  EXPECT_LE(HalfNorm(left, 0), 1e-5);
  EXPECT_LE(HalfNorm(left, 3), 1e-5);
}

TEST(CartesianPoseTest, GivesTheVelocityOfItsPositions) {
  const Bench bench = Box();
  CartesianPoseController controller(bench.request());
  controller.Activate(bench.state, Time());
  ControllerOutput output;
  JointVector last = kReady;
  for (Duration t{}; t <= 1s; t += 4ms) {
    controller.Update(bench.state, Time(t), output);
    for (std::size_t j = 0; j < kJoints; ++j) {
      EXPECT_NEAR((output.target.joint.q[j] - last[j]) / 4e-3, output.target.joint.dq[j], 1e-9);
    }
    last = output.target.joint.q;
  }
  EXPECT_TRUE(output.has_velocity);
}

TEST(CartesianPoseTest, AnErrorOfTheStartDecaysByItsGain) {
  // Standing 4 mm off: e(t) = e(0) exp(-K_P t), by Euler's steps (1 - K_P dt)^n.
  const Transform start = PoseAt(kReady);
  const Transform off = Moved(start, 0.004, 0, 0);
  const PoseTrajectory poses({{.O_T_EE = off, .at = 0s}, {.O_T_EE = off, .at = 1s}}, {},
                             twin::test::PandaCartesianLimits());
  Bench bench = Box();
  ControllerRequest request = bench.request();
  request.poses = &poses;
  CartesianPoseController controller(request);
  controller.Activate(bench.state, Time());
  ControllerOutput output;
  for (int i = 0; i <= 300; ++i) controller.Update(bench.state, Time(kCycle * i), output);
  const double left = HalfNorm(model::WayTo(PoseAt(output.target.joint.q), off), 0);
  EXPECT_NEAR(left, 0.004 * std::pow(1 - 10 * 1e-3, 300), 2e-6);
}

TEST(CartesianPoseTest, ASkippedUpdateDelaysNothing) {
  const Bench bench = Box();
  CartesianPoseController controller(bench.request());
  controller.Activate(bench.state, Time());
  ControllerOutput output;
  for (const Duration t : {0ms, 1ms, 2ms, 40ms, 41ms}) {
    controller.Update(bench.state, Time(t), output);
  }
  const Vector6 way = model::WayTo(PoseAt(output.target.joint.q), bench.poses.Sample(41ms).O_T_EE);
  EXPECT_LT(HalfNorm(way, 0), 1e-4);
}

/// Runs until the controller says that it is done or gives up.
std::string ReasonToGiveUp(const Bench& bench, const CartesianPoseOptions& options = {}) {
  CartesianPoseController controller(bench.request(), options);
  controller.Activate(bench.state, Time());
  ControllerOutput output;
  for (Duration t{}; t < 60s && !output.finished && !output.failed; t += 2ms) {
    controller.Update(bench.state, Time(t), output);
  }
  EXPECT_EQ(output.failed, !controller.Explain().empty());
  return controller.Explain();
}

TEST(CartesianPoseTest, GivesUpAtASingularity) {
  // Away from the base until the elbow is stretched and beyond.
  const Transform start = PoseAt(kReady);
  const Bench bench({{.O_T_EE = start}, {.O_T_EE = Moved(start, 0.6, 0, 0)}});
  EXPECT_THAT(ReasonToGiveUp(bench),
              ::testing::AnyOf(HasSubstr("near a singularity"), HasSubstr("the end of its range")));
}

/// Turning about the vertical at the spot takes joint 7 to its end.
Bench TurningTooFar() {
  const Transform start = PoseAt(kReady);
  Transform turned = start;
  const double c = std::cos(-2.6), s = std::sin(-2.6);
  for (std::size_t column = 0; column < 3; ++column) {
    turned[4 * column] = c * start[4 * column] - s * start[4 * column + 1];
    turned[4 * column + 1] = s * start[4 * column] + c * start[4 * column + 1];
  }
  return Bench({{.O_T_EE = start}, {.O_T_EE = turned}});
}

TEST(CartesianPoseTest, GivesUpAtTheEndOfAJointsRange) {
  EXPECT_THAT(ReasonToGiveUp(TurningTooFar()),
              AllOf(HasSubstr("joint 7"), HasSubstr("the end of its range")));
}

TEST(CartesianPoseTest, GivesUpWhereTheRobotCanStillStop) {
  const Bench bench = TurningTooFar();
  CartesianPoseController controller(bench.request());
  controller.Activate(bench.state, Time());
  const JointLimits limits = twin::test::PandaLimits();
  ControllerOutput output;
  JointVector q{};
  JointVector dq{};
  for (Duration t{}; t < 60s && !output.failed; t += 1ms) {
    q = output.target.joint.q;
    dq = output.target.joint.dq;
    controller.Update(bench.state, Time(t), output);
  }
  ASSERT_TRUE(output.failed);
  ASSERT_GT(dq[6], 0.1);
  onboard::JointReference robot{.q_d = q, .dq_d = dq};
  while (!robot.AtRest()) robot = onboard::StopStep(robot, limits);
  EXPECT_LE(robot.q_d[6], limits.q_max[6] - 0.01);
}

TEST(CartesianPoseTest, GivesUpWhenTheGoalIsNotReachedInTime) {
  // Without a gain the error of the start stays.
  CartesianPoseOptions options;
  options.K_P.fill(0);
  const Transform start = PoseAt(kReady);
  const Transform off = Moved(start, 0.003, 0, 0);
  const Bench bench({{.O_T_EE = off}, {.O_T_EE = Moved(off, 0, 0.05, 0)}});
  EXPECT_THAT(ReasonToGiveUp(bench, options), HasSubstr("0.0030"));
}

TEST(CartesianPoseTest, FollowsTheEndEffectorOfAPathThroughJointSpace) {
  JointVector q = kReady;
  q[0] += 0.3;
  q[3] += 0.2;
  const Trajectory trajectory({{.q = kReady}, {.q = q}}, {.duration = 3s},
                              twin::test::PandaLimits());
  CartesianPoseController controller({.trajectory = trajectory,
                                      .limits = twin::test::PandaLimits(),
                                      .cartesian = twin::test::PandaCartesianLimits()});
  RobotState state;
  state.q = state.q_d = kReady;
  state.F_T_EE[14] = 0.1034;
  controller.Activate(state, Time());
  ControllerOutput output;
  for (Duration t{}; t <= 3s; t += 1ms) {
    controller.Update(state, Time(t), output);
    const auto pose = [&](const JointVector& at) {
      return ArmModel::Panda().Pose(kEndEffector, at, state.F_T_EE);
    };
    const Vector6 way = model::WayTo(pose(output.target.joint.q), pose(trajectory.Sample(t).q));
    ASSERT_LT(HalfNorm(way, 0), 5e-5);
  }
}

TEST(CartesianPoseTest, StartsAnewAfterEachActivation) {
  const Bench bench = Box();
  CartesianPoseController controller(bench.request());
  ControllerOutput output;
  for (const Duration begin : {Duration(0s), Duration(100s)}) {
    controller.Activate(bench.state, Time(begin));
    controller.Update(bench.state, Time(begin), output);
    EXPECT_EQ(output.target.joint.q, kReady);
    EXPECT_FALSE(output.finished);
    for (Duration t{}; t < 30s && !output.finished; t += 2ms) {
      controller.Update(bench.state, Time(begin + t), output);
    }
    EXPECT_TRUE(output.finished);
    controller.Deactivate();
  }
}

TEST(CartesianPoseTest, TakesItsParametersAndRefusesOthers) {
  const Bench bench = Box();
  const auto complaint = [&](const control::Parameters& parameters) -> std::string {
    CartesianPoseController controller(bench.request());
    control::ParameterReader reader(parameters);
    try {
      controller.Configure(reader);
      reader.RefuseUnread();
    } catch (const InputError& error) {
      return error.what();
    }
    return "(accepted)";
  };
  EXPECT_EQ(complaint({{.key = "K_P", .values = {"20 1/s"}},
                       {.key = "alpha", .values = {"1e-4"}},
                       {.key = "goal_time", .values = {"3 s"}},
                       {.key = "reference", .values = {"path"}}}),
            "(accepted)");
  EXPECT_THAT(complaint({{.key = "K_P", .values = {"200 1/s"}}}), HasSubstr("[0, 100] 1/s"));
  EXPECT_THAT(complaint({{.key = "alpha", .values = {"2"}}}), HasSubstr("[0, 1]"));
  EXPECT_THAT(complaint({{.key = "beta", .values = {"2"}}}), HasSubstr("unknown"));
}

TEST(CartesianPoseTest, UpdatesWithoutAllocating) {
  const Bench bench = Box();
  CartesianPoseController controller(bench.request());
  controller.Activate(bench.state, Time());
  ControllerOutput output;
  const twin::test::RealtimeGuard guard;
  Duration t{};
  for (; t < 60s && !output.finished; t += 1ms) controller.Update(bench.state, Time(t), output);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, twin::test::RealtimeGuard::Counts{});
  EXPECT_TRUE(output.finished);
  EXPECT_GT(t, 1s);
}

}  // namespace
}  // namespace twin::controllers::controllers_cartesian_pose_test
