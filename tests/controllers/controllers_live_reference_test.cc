// The compliance controller led by an operator.
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/LU>

#include "controllers/compliance.h"
#include "support/panda_limits.h"
#include "twin/control/live_reference.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"

namespace twin::controllers::controllers_live_reference_test {
namespace {

using control::ControllerOutput;
using control::Parameters;
using testing::HasSubstr;
using namespace std::chrono_literals;  // NOLINT(google-build-using-namespace): 1s

const JointVector kReady{0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854};

/// Leads straight upwards, until it is told to end.
class Leader final : public control::LiveReference {
 public:
  int begins = 0;
  bool ends = false;
  reference::PoseTarget target;
  std::optional<reference::JointTarget> joints;

  void Begin(const Transform& O_T_EE, Time /*now*/) override {
    ++begins;
    target = {O_T_EE, {}};
  }
  [[nodiscard]] reference::PoseTarget Next(const RobotState& /*state*/,
                                           Time /*now*/) noexcept override {
    target.O_T_EE[14] += 1e-4;
    return target;
  }
  [[nodiscard]] std::optional<reference::JointTarget> posture() const noexcept override {
    return joints;
  }
  [[nodiscard]] bool finished() const noexcept override { return ends; }
};

class LiveReferenceTest : public testing::Test {
 protected:
  void Start() {
    control::ParameterReader reader(parameters_);
    controller_.Configure(reader);
    controller_.Activate(state_, Time{});
  }
  ControllerOutput Update(Duration at) {
    ControllerOutput output;
    controller_.Update(state_, Time{at}, output);
    return output;
  }

  const reference::Trajectory standing_{
      {{.q = kReady, .at = 0s}, {.q = kReady, .at = 60s}}, {}, twin::test::PandaLimits()};
  const Parameters parameters_{{.key = "reference", .values = {"live"}}};
  Leader leader_;
  RobotState state_ = [] {
    RobotState state;
    state.q = kReady;
    return state;
  }();
  ComplianceController controller_{{.trajectory = standing_,
                                    .interface = control::CommandInterface::kTorque,
                                    .live = &leader_,
                                    .limits = twin::test::PandaLimits(),
                                    .cartesian = twin::test::PandaCartesianLimits()}};
};

TEST_F(LiveReferenceTest, BeginsWhereTheEndEffectorIs) {
  Start();
  EXPECT_EQ(leader_.begins, 1);
  EXPECT_EQ(leader_.target.O_T_EE,
            model::ArmModel::Panda().Pose(model::Frame::kEndEffector, kReady));
}

TEST_F(LiveReferenceTest, FollowsWhatItIsLedTo) {
  Start();
  for (int i = 0; i < 10; ++i) static_cast<void>(Update(i * 1ms));
  EXPECT_EQ(Update(10ms).target.pose.O_T_EE, leader_.target.O_T_EE);
}

// The torques of two postures differ by k_0 times their difference in the null space of J.
TEST_F(LiveReferenceTest, PullsTheNullSpaceToThePostureOfItsReference) {
  Start();
  leader_.joints = reference::JointTarget{.q = kReady};
  static_cast<void>(Update(0s));
  const JointVector at_rest = Update(1s).target.tau_J_d;
  // The self-motion of the arm: swivels the elbow, q1 and q7 against q3, and the rest with them.
  const model::Jacobian jacobian =
      model::ArmModel::Panda().ZeroJacobian(model::Frame::kEndEffector, kReady);
  const Eigen::Map<const Eigen::Matrix<double, 6, 7>> J(jacobian.data());
  const Eigen::Matrix<double, 7, 1> n = J.fullPivLu().kernel().col(0).normalized();
  constexpr double kAway = 0.1;  // rad
  for (std::size_t i = 0; i < kJoints; ++i) {
    leader_.joints->q[i] += kAway * n[static_cast<Eigen::Index>(i)];
  }
  leader_.target.O_T_EE[14] -= 1e-4;  // the next update leads to the same pose
  const JointVector away = Update(1s + 1ms).target.tau_J_d;
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(away[i] - at_rest[i],
                ComplianceOptions().k_0 * kAway * n[static_cast<Eigen::Index>(i)], 1e-9);
  }
}

TEST_F(LiveReferenceTest, GoesOnUntilItIsEnded) {
  Start();
  EXPECT_FALSE(Update(50s).finished);
}

TEST_F(LiveReferenceTest, IsFinishedARestAfterItIsEnded) {
  Start();
  static_cast<void>(Update(0s));
  leader_.ends = true;
  static_cast<void>(Update(1s));
  EXPECT_FALSE(Update(1s + ComplianceOptions().settling_time - 1ms).finished);
  EXPECT_TRUE(Update(1s + ComplianceOptions().settling_time).finished);
}

TEST_F(LiveReferenceTest, RefusesToBeLedByNobody) {
  ComplianceController controller({.trajectory = standing_,
                                   .interface = control::CommandInterface::kTorque,
                                   .limits = twin::test::PandaLimits()});
  control::ParameterReader reader(parameters_);
  try {
    controller.Configure(reader);
    FAIL() << "it was taken";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("this run has none"));
  }
}

}  // namespace
}  // namespace twin::controllers::controllers_live_reference_test
