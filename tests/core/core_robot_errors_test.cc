#include "twin/core/robot_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string_view>

namespace twin::core_robot_errors_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

// Index and printed name, typed from libfranka 0.9.2 (include/franka/errors.h, src/errors.cc), in
// the order of the robot state's array.
constexpr std::string_view kPrintedNames[] = {
    "joint_position_limits_violation",
    "cartesian_position_limits_violation",
    "self_collision_avoidance_violation",
    "joint_velocity_violation",
    "cartesian_velocity_violation",
    "force_control_safety_violation",
    "joint_reflex",
    "cartesian_reflex",
    "max_goal_pose_deviation_violation",
    "max_path_pose_deviation_violation",
    "cartesian_velocity_profile_safety_violation",
    "joint_position_motion_generator_start_pose_invalid",
    "joint_motion_generator_position_limits_violation",
    "joint_motion_generator_velocity_limits_violation",
    "joint_motion_generator_velocity_discontinuity",
    "joint_motion_generator_acceleration_discontinuity",
    "cartesian_position_motion_generator_start_pose_invalid",
    "cartesian_motion_generator_elbow_limit_violation",
    "cartesian_motion_generator_velocity_limits_violation",
    "cartesian_motion_generator_velocity_discontinuity",
    "cartesian_motion_generator_acceleration_discontinuity",
    "cartesian_motion_generator_elbow_sign_inconsistent",
    "cartesian_motion_generator_start_elbow_invalid",
    "force_controller_desired_force_tolerance_violation",
    "start_elbow_sign_inconsistent",
    "communication_constraints_violation",
    "power_limit_violation",
    "cartesian_motion_generator_joint_position_limits_violation",
    "cartesian_motion_generator_joint_velocity_limits_violation",
    "cartesian_motion_generator_joint_velocity_discontinuity",
    "cartesian_motion_generator_joint_acceleration_discontinuity",
    "cartesian_position_motion_generator_invalid_frame_flag",
    "controller_torque_discontinuity",
    "joint_p2p_insufficient_torque_for_planning",
    "tau_J_range_violation",
    "instability_detected",
    "joint_move_in_wrong_direction",
    "cartesian_spline_motion_generator_violation",
    "joint_via_motion_generator_planning_joint_limit_violation",
    "base_acceleration_initialization_timeout",
    "base_acceleration_invalid_reading",
};

TEST(RobotErrorTest, All41PrintTheNameOfTheirIndex) {
  ASSERT_EQ(std::size(kPrintedNames), kRobotErrorCount);
  for (std::size_t i = 0; i < kRobotErrorCount; ++i) {
    EXPECT_EQ(Name(static_cast<RobotError>(i)), kPrintedNames[i]) << i;
  }
}

TEST(RobotErrorTest, EnumeratorsOfTheOnboardChecksHaveTheirIndex) {
  EXPECT_EQ(static_cast<int>(RobotError::kJointPositionMotionGeneratorStartPoseInvalid), 11);
  EXPECT_EQ(static_cast<int>(RobotError::kJointMotionGeneratorPositionLimitsViolation), 12);
  EXPECT_EQ(static_cast<int>(RobotError::kJointMotionGeneratorVelocityLimitsViolation), 13);
  EXPECT_EQ(static_cast<int>(RobotError::kJointMotionGeneratorVelocityDiscontinuity), 14);
  EXPECT_EQ(static_cast<int>(RobotError::kJointMotionGeneratorAccelerationDiscontinuity), 15);
  EXPECT_EQ(static_cast<int>(RobotError::kCommunicationConstraintsViolation), 25);
  EXPECT_EQ(static_cast<int>(RobotError::kTauJRangeViolation), 34);
}

TEST(RobotErrorTest, AValueBeyondTheLastIsNamedUnknown) {
  EXPECT_EQ(Name(static_cast<RobotError>(kRobotErrorCount)), "unknown_error");
}

TEST(FormatErrorsTest, PrintsAsLibfrankaDoes) {
  RobotErrors errors;
  EXPECT_EQ(FormatErrors(errors), "[]");
  errors.set(34);
  EXPECT_EQ(FormatErrors(errors), R"(["tau_J_range_violation"])");
  errors.set(6);
  EXPECT_EQ(FormatErrors(errors), R"(["joint_reflex", "tau_J_range_violation"])");
}

TEST(DescribeTest, SaysErrorJointValueLimitUnitCycleAndHowItWasComputed) {
  const Violation violation{.error = RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                            .axis = 1,
                            .value = -7.625,
                            .limit = -7.5,
                            .message_id = 4711};
  EXPECT_THAT(Describe(violation),
              AllOf(HasSubstr("joint_motion_generator_velocity_discontinuity"),
                    HasSubstr("joint 2"), HasSubstr("-7.625 rad/s^2"), HasSubstr("limit -7.5"),
                    HasSubstr("4711"), HasSubstr("computed as")));
}

TEST(DescribeTest, NamesNoJointWhenNoneIsToBlame) {
  const Violation violation{.error = RobotError::kCommunicationConstraintsViolation,
                            .value = 20,
                            .limit = 20,
                            .message_id = 99};
  EXPECT_THAT(Describe(violation),
              AllOf(HasSubstr("20 cycles in a row"), HasSubstr("; 20 end a motion"),
                    Not(HasSubstr("joint")), Not(HasSubstr("computed as"))));
}

TEST(DescribeTest, TellsAMissingFirstCommandFromCommandsLostInARow) {
  const Violation violation{.error = RobotError::kCommunicationConstraintsViolation,
                            .axis = 0,
                            .value = 1000,
                            .limit = 1000,
                            .message_id = 99};
  EXPECT_THAT(Describe(violation), AllOf(HasSubstr("no first command in 1000 cycles"),
                                         Not(HasSubstr("in a row")), Not(HasSubstr("joint"))));
}

TEST(DescribeTest, NamesTheAxisOfACartesianMotionWithItsUnit) {
  Violation violation{.error = RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity,
                      .axis = 0,
                      .value = 7000,
                      .limit = 6500,
                      .message_id = 1};
  EXPECT_THAT(Describe(violation), HasSubstr(": translation, jerk 7000 m/s^3"));
  violation.axis = 1;
  EXPECT_THAT(Describe(violation), HasSubstr(": rotation, jerk 7000 rad/s^3"));
  violation.axis = 2;
  EXPECT_THAT(Describe(violation), HasSubstr(": elbow, jerk 7000 rad/s^3"));
}

TEST(DescribeTest, NamesTheAxisOfTheStiffnessFrame) {
  Violation violation{.error = RobotError::kCartesianReflex,
                      .axis = 2,
                      .value = -25,
                      .limit = -20,
                      .message_id = 1};
  EXPECT_THAT(Describe(violation), HasSubstr(": z of K, external force -25 N is"));
  violation.axis = 5;
  EXPECT_THAT(Describe(violation), HasSubstr(": Y of K, external force -25 Nm is"));
}

}  // namespace
}  // namespace twin::core_robot_errors_test
