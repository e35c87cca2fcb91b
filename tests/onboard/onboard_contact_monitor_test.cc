#include "twin/onboard/contact_monitor.h"

#include <gtest/gtest.h>

namespace twin::onboard::onboard_contact_monitor_test {
namespace {

/// Every threshold is another.
setting::CollisionBehavior Distinct() {
  setting::CollisionBehavior b;
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double d = static_cast<double>(i);
    b.lower_torque_nominal[i] = 10 + d;
    b.upper_torque_nominal[i] = 20 + d;
    b.lower_torque_acc[i] = 30 + d;
    b.upper_torque_acc[i] = 40 + d;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    const double d = static_cast<double>(i);
    b.lower_force_nominal[i] = 15 + d;
    b.upper_force_nominal[i] = 25 + d;
    b.lower_force_acc[i] = 35 + d;
    b.upper_force_acc[i] = 45 + d;
  }
  return b;
}

class ContactMonitorTest : public ::testing::TestWithParam<bool> {
 protected:
  ContactMonitorTest() { monitor_.SetBehavior(behavior_); }
  bool accelerates() const { return GetParam(); }
  const JointVector& lower_torque() const {
    return accelerates() ? behavior_.lower_torque_acc : behavior_.lower_torque_nominal;
  }
  const JointVector& upper_torque() const {
    return accelerates() ? behavior_.upper_torque_acc : behavior_.upper_torque_nominal;
  }
  const Vector6& lower_force() const {
    return accelerates() ? behavior_.lower_force_acc : behavior_.lower_force_nominal;
  }
  const Vector6& upper_force() const {
    return accelerates() ? behavior_.upper_force_acc : behavior_.upper_force_nominal;
  }
  void Torque(std::size_t joint, double value) {
    JointVector tau{};
    tau[joint] = value;
    monitor_.Update(tau, {}, accelerates());
  }
  void Force(std::size_t axis, double value) {
    Vector6 F{};
    F[axis] = value;
    monitor_.Update({}, F, accelerates());
  }

  setting::CollisionBehavior behavior_ = Distinct();
  ContactMonitor monitor_;
};

INSTANTIATE_TEST_SUITE_P(Phases, ContactMonitorTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Accelerating" : "Nominal"; });

TEST_P(ContactMonitorTest, ATorqueAboveTheLowerThresholdIsAContactWhileItLasts) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      JointVector expected{};
      Torque(i, sign * lower_torque()[i]);
      EXPECT_EQ(monitor_.joint_contact(), expected) << "at the threshold, joint " << i + 1;
      Torque(i, sign * (lower_torque()[i] + 1e-6));
      expected[i] = 1;
      EXPECT_EQ(monitor_.joint_contact(), expected) << "above, joint " << i + 1;
      EXPECT_EQ(monitor_.joint_collision(), JointVector{});
      EXPECT_EQ(monitor_.cartesian_contact(), Vector6{});
      EXPECT_TRUE(monitor_.Collisions(1).empty());
      Torque(i, 0);
      EXPECT_EQ(monitor_.joint_contact(), JointVector{});
    }
  }
}

TEST_P(ContactMonitorTest, AForceAboveTheLowerThresholdIsAContactWhileItLasts) {
  for (std::size_t i = 0; i < 6; ++i) {
    Force(i, -lower_force()[i]);
    EXPECT_EQ(monitor_.cartesian_contact(), Vector6{});
    Force(i, -lower_force()[i] - 1e-6);
    Vector6 expected{};
    expected[i] = 1;
    EXPECT_EQ(monitor_.cartesian_contact(), expected);
    EXPECT_EQ(monitor_.cartesian_collision(), Vector6{});
    EXPECT_EQ(monitor_.joint_contact(), JointVector{});
    Force(i, 0);
    EXPECT_EQ(monitor_.cartesian_contact(), Vector6{});
  }
}

TEST_P(ContactMonitorTest, ATorqueAboveTheUpperThresholdIsACollisionUntilCleared) {
  for (std::size_t i = 0; i < kJoints; ++i) {
    for (const double sign : {-1.0, 1.0}) {
      monitor_.Clear();
      Torque(i, sign * upper_torque()[i]);
      EXPECT_TRUE(monitor_.Collisions(1).empty()) << "at the threshold, joint " << i + 1;
      const double value = sign * (upper_torque()[i] + 1e-6);
      Torque(i, value);
      JointVector expected{};
      expected[i] = 1;
      EXPECT_EQ(monitor_.joint_collision(), expected);
      EXPECT_EQ(monitor_.joint_contact(), expected);
      const Violations found = monitor_.Collisions(77);
      ASSERT_EQ(found.items().size(), 1u);
      const Violation& violation = found.items()[0];
      EXPECT_EQ(violation.error, RobotError::kJointReflex);
      EXPECT_EQ(violation.axis, static_cast<int>(i));
      EXPECT_EQ(violation.value, value);
      EXPECT_EQ(violation.limit, sign * upper_torque()[i]);
      EXPECT_EQ(violation.message_id, 77u);
      Torque(i, 0);
      EXPECT_TRUE(monitor_.Collisions(1).empty()) << "the push is over";
      EXPECT_EQ(monitor_.joint_contact(), JointVector{});
      EXPECT_EQ(monitor_.joint_collision(), expected) << "but latched";
    }
  }
  monitor_.Clear();
  EXPECT_EQ(monitor_.joint_collision(), JointVector{});
}

TEST_P(ContactMonitorTest, AForceAboveTheUpperThresholdIsACollisionUntilCleared) {
  for (std::size_t i = 0; i < 6; ++i) {
    monitor_.Clear();
    Force(i, upper_force()[i]);
    EXPECT_TRUE(monitor_.Collisions(1).empty());
    Force(i, -upper_force()[i] - 0.5);
    const Violations found = monitor_.Collisions(5);
    ASSERT_EQ(found.items().size(), 1u);
    EXPECT_EQ(found.items()[0].error, RobotError::kCartesianReflex);
    EXPECT_EQ(found.items()[0].axis, static_cast<int>(i));
    EXPECT_EQ(found.items()[0].value, -upper_force()[i] - 0.5);
    EXPECT_EQ(found.items()[0].limit, -upper_force()[i]);
    Force(i, 0);
    Vector6 expected{};
    expected[i] = 1;
    EXPECT_EQ(monitor_.cartesian_collision(), expected);
    EXPECT_EQ(monitor_.joint_collision(), JointVector{});
  }
  monitor_.Clear();
  EXPECT_EQ(monitor_.cartesian_collision(), Vector6{});
}

TEST(ContactMonitorThresholdsTest, ThoseOfTheOtherPhaseDoNotCount) {
  ContactMonitor monitor;
  monitor.SetBehavior(Distinct());
  const JointVector tau{25, 0, 0, 0, 0, 0, 0};  // above nominal, below acc
  monitor.Update(tau, {}, true);
  EXPECT_EQ(monitor.joint_contact(), JointVector{});
  EXPECT_TRUE(monitor.Collisions(1).empty());
  monitor.Update(tau, {}, false);
  EXPECT_EQ(monitor.joint_contact()[0], 1);
  EXPECT_EQ(monitor.Collisions(1).size(), 1u);
}

TEST(ContactMonitorThresholdsTest, ReportsBothReflexesEachByItsFirstAxis) {
  ContactMonitor monitor;
  monitor.SetBehavior(Distinct());
  monitor.Update({0, 0, 100, 0, 0, 100, 0}, {0, 100, 0, 0, 0, 100}, false);
  const Violations found = monitor.Collisions(1);
  ASSERT_EQ(found.items().size(), 2u);
  EXPECT_EQ(found.items()[0].error, RobotError::kJointReflex);
  EXPECT_EQ(found.items()[0].axis, 2);
  EXPECT_EQ(found.items()[1].error, RobotError::kCartesianReflex);
  EXPECT_EQ(found.items()[1].axis, 1);
  EXPECT_EQ(monitor.joint_collision(), (JointVector{0, 0, 1, 0, 0, 1, 0}));
  EXPECT_EQ(monitor.cartesian_collision(), (Vector6{0, 1, 0, 0, 0, 1}));
}

TEST(ContactMonitorThresholdsTest, NewOnesCountFromTheNextUpdateOn) {
  ContactMonitor monitor;
  monitor.SetBehavior(Distinct());
  monitor.Update({15, 0, 0, 0, 0, 0, 0}, {}, false);
  EXPECT_EQ(monitor.joint_contact()[0], 1);
  setting::CollisionBehavior higher = Distinct();
  higher.lower_torque_nominal[0] = 18;
  monitor.SetBehavior(higher);
  monitor.Update({15, 0, 0, 0, 0, 0, 0}, {}, false);
  EXPECT_EQ(monitor.joint_contact()[0], 0);
}

TEST(ContactMonitorThresholdsTest, ZeroThresholdsReportAnythingButZero) {
  ContactMonitor monitor;
  setting::CollisionBehavior none;
  none.lower_torque_nominal = none.upper_torque_nominal = JointVector{};
  none.lower_force_nominal = none.upper_force_nominal = Vector6{};
  monitor.SetBehavior(none);
  monitor.Update({}, {}, false);
  EXPECT_TRUE(monitor.Collisions(1).empty());
  monitor.Update({0, 0, 0, 0, 0, 0, 1e-9}, {0, 0, -1e-9, 0, 0, 0}, false);
  EXPECT_EQ(monitor.Collisions(1).size(), 2u);
}

}  // namespace
}  // namespace twin::onboard::onboard_contact_monitor_test
