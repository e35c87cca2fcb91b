// joint_position, joint_velocity, gravity_hold.

#include <algorithm>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "controllers/gravity_hold.h"
#include "controllers/joint_position.h"
#include "controllers/joint_velocity.h"
#include "support/panda_limits.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::controllers::controllers_joint_space_test {
namespace {

using control::ControllerOutput;
using control::ControllerRequest;
using reference::Trajectory;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

constexpr JointVector kFirst{0, -0.5, 0, -2, 0, 1.5, 0.7};
constexpr JointVector kLast{0.5, -0.4, 0.3, -2.2, -0.3, 1.9, 0};

class JointSpaceTest : public ::testing::Test {
 protected:
  [[nodiscard]] ControllerRequest Request() const {
    return {.trajectory = trajectory_,
            .limits = twin::test::PandaLimits(),
            .cartesian = twin::test::PandaCartesianLimits()};
  }
  template <typename Controller>
  std::string Complaint(const control::Parameters& parameters) const {
    Controller controller(Request());
    control::ParameterReader reader(parameters);
    try {
      controller.Configure(reader);
      reader.RefuseUnread();
    } catch (const InputError& error) {
      return error.what();
    }
    return "(accepted)";
  }
  /// 4 s of updates, counted.
  void RunGuarded(control::Controller& controller) {
    controller.Activate(state_, Time());
    ControllerOutput output;
    const twin::test::RealtimeGuard guard;
    for (int i = 0; i <= 4000; ++i) {
      controller.Update(state_, Time(kCycle * i), output);
      if (i == 2000) state_.q_d = kLast;
    }
    const auto counts = guard.counts();
    EXPECT_EQ(counts, twin::test::RealtimeGuard::Counts{});
    EXPECT_TRUE(output.finished);
  }

  const Trajectory trajectory_{
      {{.q = kFirst}, {.q = kLast}}, {.duration = 2s}, twin::test::PandaLimits()};
  RobotState state_ = [] {
    RobotState state;
    state.q = state.q_d = kFirst;
    return state;
  }();
};

TEST_F(JointSpaceTest, JointPositionFadesTheOffsetOfTheStartByMinimumJerk) {
  state_.q_d[2] += 0.05;
  JointPositionController controller(Request());
  controller.Activate(state_, Time(1s));
  ControllerOutput output;
  for (Duration t{}; t <= 3s; t += 50ms) {
    controller.Update(state_, Time(1s) + t, output);
    const double x = std::min(ToSeconds(t) / 2, 1.0);
    const double s = 10 * std::pow(x, 3) - 15 * std::pow(x, 4) + 6 * std::pow(x, 5);
    const double ds = x < 1 ? 30 * std::pow(x, 2) * std::pow(1 - x, 2) / 2 : 0;
    const reference::JointTarget path = trajectory_.Sample(t);
    EXPECT_NEAR(output.target.joint.q[2], path.q[2] + (1 - s) * 0.05, 1e-15);
    EXPECT_NEAR(output.target.joint.dq[2], path.dq[2] - ds * 0.05, 1e-15);
    EXPECT_EQ(output.target.joint.q[4], path.q[4]) << "no offset there";
    EXPECT_EQ(output.finished, t >= 2s);
  }
  EXPECT_TRUE(output.has_velocity);
  EXPECT_EQ(output.target.joint.q, kLast);
  EXPECT_EQ(output.target.joint.dq, JointVector{});
}

TEST_F(JointSpaceTest, JointPositionRefusesToStartFarAway) {
  JointPositionController controller(Request());
  state_.q_d[5] += 0.11;
  EXPECT_THAT([&] { controller.Activate(state_, Time()); },
              ThrowsMessage<InputError>(HasSubstr("joint 6 of the robot is at")));
  state_.q_d[5] = std::nan("");
  EXPECT_THROW(controller.Activate(state_, Time()), InputError);
}

TEST_F(JointSpaceTest, JointVelocityTakesInAnOffsetByItsGain) {
  // Standing: the reference integrates what is commanded, and once the correction has been let in
  // an offset decays by 1 - K T in each period.
  const Trajectory stand({{.q = kFirst, .at = 0s}, {.q = kFirst, .at = 9s}}, {},
                         twin::test::PandaLimits());
  ControllerRequest request{.trajectory = stand, .limits = {}, .cartesian = {}};
  state_.q_d[1] += 0.015;
  JointVelocityController controller(request, {.K = 2});
  controller.Activate(state_, Time());
  ControllerOutput output;
  double at_one = 0;
  double largest_step = 0;
  double last = 0;
  for (int i = 0; i < 1800; ++i) {
    if (i == 1000) at_one = state_.q_d[1] - kFirst[1];
    controller.Update(state_, Time(kCycle * i), output);
    const double dq = output.target.joint.dq[1];
    largest_step = std::max(largest_step, std::abs(dq - last));
    last = dq;
    state_.q_d[1] += dq * 1e-3;
  }
  EXPECT_GT(at_one, 0.003);
  EXPECT_LT(at_one, 0.015);
  EXPECT_NEAR(state_.q_d[1] - kFirst[1], at_one * std::pow(1 - 2e-3, 800), 1e-12);
  EXPECT_LT(largest_step, 3.75e-3) << "INT's jerk limit at 1 kHz";
}

TEST_F(JointSpaceTest, JointVelocityRestsOnceTheGoalIsReached) {
  JointVelocityController controller(Request());
  controller.Activate(state_, Time());
  ControllerOutput output;
  controller.Update(state_, Time(0s), output);
  state_.q_d = kLast;
  state_.q_d[3] += 2e-4;
  controller.Update(state_, Time(2100ms), output);
  EXPECT_FALSE(output.finished);
  EXPECT_NEAR(output.target.joint.dq[3], -5 * 2e-4, 1e-12);
  state_.q_d[3] = kLast[3] + 0.9e-4;
  controller.Update(state_, Time(2200ms), output);
  EXPECT_TRUE(output.finished);
  EXPECT_EQ(output.target.joint.dq, JointVector{});
}

TEST_F(JointSpaceTest, JointVelocityFinishesInTheEndAnyway) {
  JointVelocityController controller(Request());
  controller.Activate(state_, Time());
  ControllerOutput output;
  controller.Update(state_, Time(0s), output);
  controller.Update(state_, Time(6999ms), output);
  EXPECT_FALSE(output.finished);
  controller.Update(state_, Time(7s), output);
  EXPECT_TRUE(output.finished);
}

TEST_F(JointSpaceTest, GravityHoldGivesDampingAndNothingElse) {
  GravityHoldOptions options;
  options.K_D = {1, 2, 3, 4, 5, 6, 7};
  options.soft_start = Duration::zero();
  GravityHoldController controller(Request(), options);
  controller.Activate(state_, Time());
  state_.dq = {0.1, -0.1, 0.2, -0.2, 0.3, -0.3, 0.4};
  state_.q = kLast;
  ControllerOutput output;
  controller.Update(state_, Time(0s), output);
  for (std::size_t j = 0; j < kJoints; ++j) {
    EXPECT_DOUBLE_EQ(output.target.tau_J_d[j], -options.K_D[j] * state_.dq[j]);
  }
  EXPECT_FALSE(output.finished);
  controller.Update(state_, Time(2s), output);
  EXPECT_TRUE(output.finished);
}

TEST_F(JointSpaceTest, GravityHoldBeginsWithTheTorqueThatHeldTheArm) {
  GravityHoldController controller(Request());
  controller.Activate(state_, Time());
  state_.tau_J_d.fill(0.4);
  ControllerOutput output;
  controller.Update(state_, Time(0s), output);
  EXPECT_EQ(output.target.tau_J_d, state_.tau_J_d);
  controller.Update(state_, Time(50ms), output);
  EXPECT_DOUBLE_EQ(output.target.tau_J_d[0], 0.2);
  controller.Update(state_, Time(100ms), output);
  EXPECT_EQ(output.target.tau_J_d[0], 0);
}

TEST_F(JointSpaceTest, TheyTakeTheirParametersAndRefuseOthers) {
  EXPECT_EQ(Complaint<JointPositionController>({{.key = "blend", .values = {"1 s"}},
                                                {.key = "start_tolerance", .values = {"2 deg"}}}),
            "(accepted)");
  EXPECT_THAT(Complaint<JointPositionController>({{.key = "blend", .values = {"1 ms"}}}),
              HasSubstr("[100 ms, 60 s]"));
  EXPECT_EQ(Complaint<JointVelocityController>({{.key = "K", .values = {"2 1/s"}},
                                                {.key = "goal_time", .values = {"1 s"}},
                                                {.key = "goal_tolerance", .values = {"1 deg"}}}),
            "(accepted)");
  EXPECT_THAT(Complaint<JointVelocityController>({{.key = "K", .values = {"51 1/s"}}}),
              HasSubstr("[0, 50] 1/s"));
  EXPECT_EQ(Complaint<GravityHoldController>({{.key = "damping", .values = {"2 Nms/rad"}}}),
            "(accepted)");
  EXPECT_THAT(Complaint<GravityHoldController>({{.key = "damping", .values = {"2 Ns/m"}}}),
              HasSubstr("Nms/rad"));
  EXPECT_THAT(Complaint<GravityHoldController>({{.key = "blend", .values = {"1 s"}}}),
              HasSubstr("unknown"));
}

TEST_F(JointSpaceTest, JointPositionUpdatesWithoutAllocating) {
  JointPositionController controller(Request());
  RunGuarded(controller);
}

TEST_F(JointSpaceTest, JointVelocityUpdatesWithoutAllocating) {
  JointVelocityController controller(Request());
  RunGuarded(controller);
}

TEST_F(JointSpaceTest, GravityHoldUpdatesWithoutAllocating) {
  GravityHoldController controller(Request());
  RunGuarded(controller);
}

}  // namespace
}  // namespace twin::controllers::controllers_joint_space_test
