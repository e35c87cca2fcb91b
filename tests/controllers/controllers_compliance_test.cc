#include "controllers/compliance.h"

#include <cmath>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "support/dense.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/model/transform.h"

namespace twin::controllers::controllers_compliance_test {
namespace {

using control::ControllerOutput;
using control::ControllerRequest;
using model::ArmModel;
using reference::Trajectory;
using ::testing::AllOf;
using ::testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

using Vector7 = Eigen::Matrix<double, 7, 1>;
using EigenVector6 = Eigen::Matrix<double, 6, 1>;
using Matrix67 = Eigen::Matrix<double, 6, 7>;

const JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};
const Transform kHand{0.8, -0.6, 0, 0, 0.6, 0.8, 0, 0, 0, 0, 1, 0, 0.01, 0, 0.1034, 1};

Trajectory Standing(const JointVector& q, Duration length = 2s) {
  return Trajectory({{.q = q, .at = 0s}, {.q = q, .at = length}}, {}, twin::test::PandaLimits());
}

ControllerRequest RequestOf(const Trajectory& trajectory) {
  return {.trajectory = trajectory,
          .interface = control::CommandInterface::kTorque,
          .limits = twin::test::PandaLimits(),
          .cartesian = twin::test::PandaCartesianLimits()};
}

/// Without a soft start, so that the law stands alone.
ComplianceOptions Plain() {
  ComplianceOptions options;
  options.soft_start = Duration::zero();
  return options;
}

/// A state of an arm with a hand and a load, near kReady and in motion.
RobotState RandomState(std::uint64_t number) {
  const Random random(7, RandomStream::kTest);
  RobotState state;
  for (std::uint32_t j = 0; j < kJoints; ++j) {
    state.q[j] = kReady[j] + 0.3 * (2 * random.Uniform(number, j) - 1);
    state.dq[j] = 2 * random.Uniform(number, 7 + j) - 1;
  }
  state.F_T_EE = kHand;
  state.m_ee = 0.73;
  state.F_x_Cee = {-0.01, 0, 0.03};
  state.I_ee = {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017};
  state.m_load = 0.5;
  state.F_x_Cload = {0, 0.02, 0.1};
  return state;
}

Eigen::Matrix4d Matrix(const Transform& T) {
  return Eigen::Map<const Eigen::Matrix4d>(T.data());
}

/// The paper's law by other means: pseudo-inverse by singular values, rotation by angle and axis,
/// Coriolis as what inverse dynamics leaves.
Vector7 PapersLaw(const RobotState& state, const Transform& O_T_d, const ComplianceOptions& o,
                  double friction) {
  const ArmModel& arm = ArmModel::Panda();
  const auto jacobian = arm.ZeroJacobian(model::Frame::kEndEffector, state.q, state.F_T_EE);
  const Matrix67 J = Eigen::Map<const Matrix67>(jacobian.data());
  const Vector7 q = Eigen::Map<const Vector7>(state.q.data());
  const Vector7 dq = Eigen::Map<const Vector7>(state.dq.data());
  const Eigen::Matrix4d X = Matrix(arm.Pose(model::Frame::kEndEffector, state.q, state.F_T_EE));
  const Eigen::Matrix4d X_d = Matrix(O_T_d);
  const Eigen::Matrix3d turn = X_d.topLeftCorner<3, 3>() * X.topLeftCorner<3, 3>().transpose();
  const Eigen::AngleAxisd angle_axis(turn);
  EigenVector6 e;
  e << (X_d - X).topRightCorner<3, 1>(), angle_axis.angle() * angle_axis.axis();
  const EigenVector6 F = Eigen::Map<const EigenVector6>(o.K_P.data()).asDiagonal() * e -
                         Eigen::Map<const EigenVector6>(o.K_D.data()).asDiagonal() * (J * dq);
  const Vector7 tau_0 =
      o.k_0 * (Eigen::Map<const Vector7>(o.q_0.data()) - q) - 2 * std::sqrt(o.k_0) * dq;
  const model::Payload payload = model::Combine({state.m_ee, state.F_x_Cee, state.I_ee},
                                                {state.m_load, state.F_x_Cload, state.I_load});
  const JointVector with_g = arm.InverseDynamics(state.q, state.dq, JointVector{}, payload);
  const JointVector g = arm.Gravity(state.q, payload);
  const JointVector tau_f = model::ResidualFriction(state.dq);
  Vector7 tau =
      J.transpose() * F + tau_0 - J.transpose() * twin::test::LeastSquares(J.transpose(), tau_0);
  for (int j = 0; j < 7; ++j) {
    const auto i = static_cast<std::size_t>(j);
    tau[j] += with_g[i] - g[i] + friction * tau_f[i];
  }
  return tau;
}

TEST(ComplianceTest, GivesThePapersLawInMotion) {
  ComplianceOptions options = Plain();
  options.K_P = {900, 700, 500, 90, 70, 50};
  options.K_D = {100, 80, 60, 10, 8, 6};
  for (std::uint64_t i = 0; i < 20; ++i) {
    const RobotState start = RandomState(2 * i);
    const Trajectory trajectory = Standing(start.q);
    ComplianceController controller(RequestOf(trajectory), options);
    controller.Activate(start, Time());
    const Transform O_T_d =
        ArmModel::Panda().Pose(model::Frame::kEndEffector, start.q, start.F_T_EE);
    ControllerOutput output;
    // A state far from the reference, within half a turn.
    const RobotState state = RandomState(2 * i + 1);
    controller.Update(state, Time(), output);
    const Vector7 expected = PapersLaw(state, O_T_d, options, 1);
    for (int j = 0; j < 7; ++j) {
      // The damping of the pseudo-inverse, 1e-6, against none.
      EXPECT_NEAR(output.target.tau_J_d[static_cast<std::size_t>(j)], expected[j], 2e-4) << i;
    }
  }
}

TEST(ComplianceTest, IsASpringAtStandstill) {
  // A reference moved by d asks for J^T K d, and for nothing when it is not.
  const Trajectory trajectory = Standing(kReady);
  ComplianceOptions options = Plain();
  options.k_0 = 0;
  RobotState state;
  state.q = kReady;
  const ArmModel& arm = ArmModel::Panda();
  const Transform here = arm.Pose(model::Frame::kEndEffector, kReady);
  Transform moved = here;
  moved[13] += 0.004;
  const reference::PoseTrajectory poses({{.O_T_EE = here}, {.O_T_EE = moved}}, {.duration = 1s},
                                        twin::test::PandaCartesianLimits());
  ControllerRequest request = RequestOf(trajectory);
  request.poses = &poses;
  ComplianceController controller(request, options);
  controller.Activate(state, Time());
  ControllerOutput output;
  controller.Update(state, Time(0s), output);
  for (const double tau : output.target.tau_J_d) EXPECT_NEAR(tau, 0, 1e-12);
  controller.Update(state, Time(1s), output);
  const auto J = arm.ZeroJacobian(model::Frame::kEndEffector, kReady);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(output.target.tau_J_d[j], J[6 * j + 1] * 1000 * 0.004, 1e-9);
  }
}

TEST(ComplianceTest, ItsNullSpaceTorqueDoesNoWorkOnTheEndEffector) {
  // J tau_n = 0: the projector takes out all that J^T could give.
  ComplianceOptions options = Plain();
  options.K_P = options.K_D = Vector6{};
  options.k_0 = 4;
  const Trajectory trajectory = Standing(kReady);
  RobotState state;
  state.q = kReady;
  ComplianceController controller(RequestOf(trajectory), options);
  controller.Activate(state, Time());
  ControllerOutput output;
  controller.Update(state, Time(), output);
  const auto jacobian = ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, kReady);
  const Vector7 tau = Eigen::Map<const Vector7>(output.target.tau_J_d.data());
  EXPECT_GT(tau.norm(), 0.1) << "nothing left to look at";
  const EigenVector6 left = Eigen::Map<const Matrix67>(jacobian.data()) * tau;
  EXPECT_LT(left.norm(), 1e-4 * tau.norm());
}

TEST(ComplianceTest, IsContinuousWhereTheArmIsSingular) {
  const JointVector stretched{0, 0, 0, -0.0709, 0, 1.5, 0};
  const Trajectory trajectory = Standing(stretched);
  RobotState state;
  state.q = stretched;
  ComplianceController controller(RequestOf(trajectory), Plain());
  controller.Activate(state, Time());
  ControllerOutput output;
  controller.Update(state, Time(), output);
  for (const double tau : output.target.tau_J_d) EXPECT_LT(std::abs(tau), 5);
}

TEST(ComplianceTest, MakesUpForTheFrictionThatTheRobotLeaves) {
  const Trajectory trajectory = Standing(kReady);
  RobotState start;
  start.q = kReady;
  RobotState state = start;
  state.dq = {0.3, -0.2, 0.1, 0.4, -0.5, 0.6, -0.7};
  const auto torque = [&](double robots_share, double& left) {
    ControllerRequest request = RequestOf(trajectory);
    request.friction_compensated = robots_share;
    ComplianceController controller(request, Plain());
    controller.Activate(start, Time());
    ControllerOutput output;
    controller.Update(state, Time(), output);
    left = 1 - robots_share;
    return output.target.tau_J_d;
  };
  double share_a = 0, share_b = 0;
  const JointVector all = torque(0, share_a);
  const JointVector rest = torque(0.8, share_b);
  const JointVector tau_f = model::ResidualFriction(state.dq);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(all[j] - rest[j], (share_a - share_b) * tau_f[j], 1e-12);
  }
}

TEST(ComplianceTest, BeginsWithTheTorqueThatHeldTheArm) {
  const Trajectory trajectory = Standing(kReady);
  RobotState state;
  state.q = kReady;
  state.tau_J_d = {0.5, -0.4, 0.3, 0.2, -0.1, 0.1, 0.2};
  ComplianceController controller(RequestOf(trajectory));
  controller.Activate(state, Time());
  ControllerOutput output;
  controller.Update(state, Time(), output);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_NEAR(output.target.tau_J_d[j], state.tau_J_d[j], 1e-12);
  }
}

TEST(ComplianceTest, IsFinishedAfterItsPathAndARest) {
  const Trajectory trajectory = Standing(kReady, 1s);
  RobotState state;
  state.q = kReady;
  ComplianceController controller(RequestOf(trajectory));
  for (const Duration begin : {Duration(0s), Duration(10s)}) {
    controller.Activate(state, Time(begin));
    ControllerOutput output;
    controller.Update(state, Time(begin), output);
    controller.Update(state, Time(begin + 1499ms), output);
    EXPECT_FALSE(output.finished);
    controller.Update(state, Time(begin + 1500ms), output);
    EXPECT_TRUE(output.finished);
    controller.Deactivate();
  }
}

/// What configuring complains of.
std::string Complaint(const control::Parameters& parameters, double robots_share = 0) {
  const Trajectory trajectory = Standing(kReady);
  ControllerRequest request = RequestOf(trajectory);
  request.friction_compensated = robots_share;
  ComplianceController controller(request);
  control::ParameterReader reader(parameters);
  try {
    controller.Configure(reader);
    reader.RefuseUnread();
  } catch (const InputError& error) {
    return error.what();
  }
  return "(accepted)";
}

TEST(ComplianceTest, TakesItsParameters) {
  const Trajectory trajectory = Standing(kReady);
  ComplianceController controller(RequestOf(trajectory));
  const control::Parameters parameters{
      {.key = "stiffness.translation", .values = {"100 N/m"}},
      {.key = "stiffness.rotation",
       .values = {"1 Nm/rad", "2 Nm/rad", "3 Nm/rad"},
       .is_list = true},
      {.key = "damping.translation", .values = {"10 Ns/m"}},
      {.key = "k0", .values = {"0.3 Nm/rad"}},
      {.key = "q0.unit", .values = {"deg"}},
      {.key = "q0.values", .values = {"0", "0", "0", "-90", "0", "90", "0"}, .is_list = true},
      {.key = "coriolis_compensation", .values = {"false"}},
      {.key = "reference", .values = {"hold"}}};
  control::ParameterReader reader(parameters);
  controller.Configure(reader);
  EXPECT_NO_THROW(reader.RefuseUnread());
  const ComplianceOptions& o = controller.options();
  EXPECT_EQ(o.K_P, (Vector6{100, 100, 100, 1, 2, 3}));
  EXPECT_EQ(o.K_D, (Vector6{10, 10, 10, 10, 10, 10}));
  EXPECT_EQ(o.k_0, 0.3);
  EXPECT_DOUBLE_EQ(o.q_0[3], -std::numbers::pi / 2);
  EXPECT_FALSE(o.coriolis);
  EXPECT_EQ(o.friction, 1.0);
}

TEST(ComplianceTest, RefusesParametersOutOfRange) {
  EXPECT_THAT(Complaint({{.key = "stiffness.translation", .values = {"6000 N/m"}}}),
              HasSubstr("[0, 5000] N/m"));
  EXPECT_THAT(Complaint({{.key = "k0", .values = {"-1 Nm/rad"}}}), HasSubstr("k0"));
  EXPECT_THAT(Complaint({{.key = "K_P", .values = {"1 N/m"}}}), HasSubstr("unknown"));
  const control::Parameter all{.key = "friction_compensation", .values = {"1"}};
  EXPECT_EQ(Complaint({all}), "(accepted)");
  EXPECT_THAT(Complaint({all}, 0.8), AllOf(HasSubstr("twice"), HasSubstr("onboard.friction")));
}

TEST(ComplianceTest, RefusesToStartElsewhere) {
  const Trajectory trajectory = Standing(kReady);
  ComplianceController controller(RequestOf(trajectory));
  RobotState state;
  state.q = kReady;
  state.q[0] += 0.03;
  EXPECT_THAT([&] { controller.Activate(state, Time()); },
              ::testing::ThrowsMessage<InputError>(HasSubstr("from where the path begins")));
  state.q[0] = std::nan("");
  EXPECT_THROW(controller.Activate(state, Time()), InputError);
}

TEST(ComplianceTest, UpdatesWithoutAllocating) {
  const Trajectory trajectory = Standing(kReady, 1s);
  const RobotState state = RandomState(1);
  RobotState start = state;
  start.q = kReady;
  ComplianceController controller(RequestOf(trajectory));
  controller.Activate(start, Time());
  ControllerOutput output;
  const twin::test::RealtimeGuard guard;
  for (int i = 0; i <= 1500; ++i) controller.Update(state, Time(kCycle * i), output);
  const auto counts = guard.counts();
  EXPECT_EQ(counts, twin::test::RealtimeGuard::Counts{});
  EXPECT_TRUE(output.finished);
}

}  // namespace
}  // namespace twin::controllers::controllers_compliance_test
