#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/motion_generator_fixture.h"
#include "twin/onboard/motion_generator.h"

// What a MotionGenerator refuses, and what just passes.
namespace twin::onboard::onboard_motion_checks_test {
namespace {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Errors = std::vector<RobotError>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kFlipAngle = -0.467002423653011;

// ---- every limit of a motion, from both sides ----

/// Joints that may do anything, or an end effector that may.
GeneratorLimits WideJoints() {
  GeneratorLimits limits = Driver::PandaGeneratorLimits();
  for (const auto field : {&JointLimits::dq_max, &JointLimits::ddq_max, &JointLimits::dddq_max}) {
    for (double& value : limits.joints.*field) value *= 1000;
  }
  return limits;
}
GeneratorLimits WidePoses() {
  GeneratorLimits limits = Driver::PandaGeneratorLimits();
  for (const auto bound :
       {&CartesianLimits::translation, &CartesianLimits::rotation, &CartesianLimits::elbow}) {
    limits.cartesian.*bound = {.dp_max = 1e3, .ddp_max = 1e5, .dddp_max = 1e8};
  }
  return limits;
}

enum class Derivative : std::uint8_t { kVelocity, kAcceleration, kJerk };

std::vector<double> VelocitiesTo(Derivative derivative, double value) {
  switch (derivative) {
    case Derivative::kVelocity: return Speeding(value);
    case Derivative::kAcceleration: return Accelerating(value);
    case Derivative::kJerk: break;
  }
  return OneJerk(value);
}

struct LimitCase {
  std::string name;
  Mode mode;
  Axis axis;
  Derivative derivative;
  GeneratorLimits limits;
  double limit;
  RobotError error;
  int violation_axis;
};

std::vector<LimitCase> LimitCases() {
  const GeneratorLimits panda = Driver::PandaGeneratorLimits();
  const struct {
    Derivative derivative;
    const char* name;
    double CartesianBound::*bound;
    JointVector JointLimits::*joints;
    RobotError cartesian;
    RobotError joint;
    RobotError joint_of_cartesian;
  } derivatives[] = {
      {Derivative::kVelocity, "Velocity", &CartesianBound::dp_max, &JointLimits::dq_max,
       RobotError::kCartesianMotionGeneratorVelocityLimitsViolation,
       RobotError::kJointMotionGeneratorVelocityLimitsViolation,
       RobotError::kCartesianMotionGeneratorJointVelocityLimitsViolation},
      {Derivative::kAcceleration, "Acceleration", &CartesianBound::ddp_max, &JointLimits::ddq_max,
       RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
       RobotError::kJointMotionGeneratorVelocityDiscontinuity,
       RobotError::kCartesianMotionGeneratorJointVelocityDiscontinuity},
      {Derivative::kJerk, "Jerk", &CartesianBound::dddp_max, &JointLimits::dddq_max,
       RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity,
       RobotError::kJointMotionGeneratorAccelerationDiscontinuity,
       RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity},
  };
  std::vector<LimitCase> cases;
  for (const auto& d : derivatives) {
    const std::string what = d.name;
    for (const Mode mode : {Mode::kJointPosition, Mode::kJointVelocity}) {
      const std::string generator =
          mode == Mode::kJointPosition ? "JointPosition" : "JointVelocity";
      cases.push_back({generator + what, mode, Axis::kJoint, d.derivative, panda,
                       (panda.joints.*d.joints)[5], d.joint, 5});
    }
    for (const Mode mode : {Mode::kCartesianPosition, Mode::kCartesianVelocity}) {
      const std::string generator = mode == Mode::kCartesianPosition ? "Pose" : "Twist";
      cases.push_back({fmt::format("{}Translation{}", generator, what), mode, Axis::kTranslation,
                       d.derivative, WideJoints(), panda.cartesian.translation.*d.bound,
                       d.cartesian, 0});
      cases.push_back({fmt::format("{}Rotation{}", generator, what), mode, Axis::kRotation,
                       d.derivative, WideJoints(), panda.cartesian.rotation.*d.bound, d.cartesian,
                       1});
      cases.push_back({fmt::format("{}Elbow{}", generator, what), mode, Axis::kElbow, d.derivative,
                       WideJoints(), panda.cartesian.elbow.*d.bound, d.cartesian, 2});
      // The hand points down: with the elbow held, joint 7 alone turns it, the other way round.
      cases.push_back({fmt::format("{}JointSeven{}", generator, what), mode, Axis::kRotation,
                       d.derivative, WidePoses(), (panda.joints.*d.joints)[6], d.joint_of_cartesian,
                       6});
    }
  }
  return cases;
}

class LimitTest : public ::testing::TestWithParam<LimitCase> {
 protected:
  static Errors RunTo(double value, Driver& driver) {
    const LimitCase& c = GetParam();
    const Motion motion{.axis = c.axis, .joint = 5};
    const bool holds_elbow = c.violation_axis == 6;
    return driver.SendAll(
        motion.Commands(driver, c.mode, VelocitiesTo(c.derivative, value), holds_elbow));
  }
};

TEST_P(LimitTest, PassesJustInsideAndRaisesItsErrorJustBeyond) {
  const LimitCase& c = GetParam();
  for (const double sign : {1.0, -1.0}) {
    Driver inside(c.mode, c.limits);
    EXPECT_THAT(RunTo(sign * c.limit * (1 - 1e-6), inside), IsEmpty());
    Driver beyond(c.mode, c.limits);
    ASSERT_THAT(RunTo(sign * c.limit * (1 + 1e-6), beyond), ElementsAre(c.error));
    const Violation& violation = beyond.found.items()[0];
    EXPECT_EQ(violation.axis, c.violation_axis);
    EXPECT_NEAR(std::abs(violation.value), c.limit * (1 + 1e-6), c.limit * 3e-7);
    EXPECT_EQ(std::abs(violation.limit), c.limit);
    EXPECT_EQ(violation.message_id, beyond.cycle);
  }
}

INSTANTIATE_TEST_SUITE_P(Motions, LimitTest, ::testing::ValuesIn(LimitCases()),
                         [](const auto& info) { return info.param.name; });

// ---- positions ----

/// Slowly along the axis, up to a way that is reached in one second.
Errors Creep(Driver& driver, Mode mode, const Motion& motion, double way, bool has_elbow) {
  std::vector<double> velocities;
  double last = 0;
  for (int k = 1; k <= 1000; ++k) {
    const double now = way * 0.5 * (1 - std::cos(std::numbers::pi * k * kT));
    velocities.push_back((now - last) / kT);
    last = now;
  }
  return driver.SendAll(motion.Commands(driver, mode, velocities, has_elbow));
}

TEST(MotionGeneratorPositionTest, EachGeneratorKeepsTheJointsInTheirRange) {
  struct Case {
    Mode mode;
    Motion motion;
    bool has_elbow;
    std::size_t joint;
    RobotError error;
    int axis;
  };
  const auto joint = RobotError::kJointMotionGeneratorPositionLimitsViolation;
  const auto cartesian = RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation;
  const auto elbow = RobotError::kCartesianMotionGeneratorElbowLimitViolation;
  const Case cases[] = {
      {Mode::kJointPosition, {Axis::kJoint, 4}, false, 4, joint, 4},
      {Mode::kJointVelocity, {Axis::kJoint, 4}, false, 4, joint, 4},
      {Mode::kCartesianPosition, {Axis::kRotation}, true, 6, cartesian, 6},
      {Mode::kCartesianVelocity, {Axis::kRotation}, true, 6, cartesian, 6},
      {Mode::kCartesianPosition, {Axis::kElbow}, true, 2, elbow, 2},
      {Mode::kCartesianVelocity, {Axis::kElbow}, true, 2, elbow, 2},
  };
  for (const Case& c : cases) {
    for (const double way : {0.2, -0.2}) {
      GeneratorLimits limits = Driver::PandaGeneratorLimits();
      limits.joints.q_max[c.joint] = model::kReady[c.joint] + 0.2;
      limits.joints.q_min[c.joint] = model::kReady[c.joint] - 0.2;
      Driver inside(c.mode, limits);
      EXPECT_THAT(Creep(inside, c.mode, c.motion, way * (1 - 1e-6), c.has_elbow), IsEmpty());
      Driver beyond(c.mode, limits);
      EXPECT_THAT(Creep(beyond, c.mode, c.motion, way * (1 + 1e-6), c.has_elbow),
                  ElementsAre(c.error));
      EXPECT_EQ(beyond.found.items()[0].axis, c.axis);
    }
  }
}

TEST(MotionGeneratorPositionTest, WithoutACommandedElbowJointThreeIsAJointAfterInverseKinematics) {
  GeneratorLimits limits = Driver::PandaGeneratorLimits();
  limits.joints.q_max[2] = 0.01;
  limits.joints.q_min[2] = -0.01;
  Driver driver(Mode::kCartesianPosition, limits);
  const Errors errors = Creep(driver, Mode::kCartesianPosition, {Axis::kTranslation}, 0.2, false);
  EXPECT_THAT(errors,
              ElementsAre(RobotError::kCartesianMotionGeneratorJointPositionLimitsViolation));
  EXPECT_EQ(driver.found.items()[0].axis, 2);
}

// ---- the start of a motion ----

TEST(MotionGeneratorStartTest, TheFirstJointPositionIsNear) {
  for (const double step : {0.11, -0.11, kNaN}) {
    Driver driver(Mode::kJointPosition);
    RobotCommand command;
    command.q_c = model::kReady;
    command.q_c[3] += step;
    EXPECT_THAT(driver.Send(command),
                ElementsAre(RobotError::kJointPositionMotionGeneratorStartPoseInvalid));
    EXPECT_EQ(driver.found.items()[0].axis, 3);
    EXPECT_EQ(driver.generator.joints().q_d, model::kReady);
  }
  Driver driver(Mode::kJointPosition);
  RobotCommand command;
  command.q_c = model::kReady;
  command.q_c[3] += 0.099;  // near enough, but a step
  EXPECT_THAT(driver.Send(command),
              ElementsAre(RobotError::kJointMotionGeneratorVelocityDiscontinuity,
                          RobotError::kJointMotionGeneratorAccelerationDiscontinuity));
}

TEST(MotionGeneratorStartTest, TheFirstPoseIsNear) {
  const RobotError start = RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid;
  struct Case {
    Axis axis;
    double inside;
    double beyond;
  };
  for (const Case& c :
       {Case{Axis::kTranslation, 0.0499, 0.0501}, Case{Axis::kRotation, 0.0999, 0.1001}}) {
    const Motion motion{c.axis};
    Driver beyond(Mode::kCartesianPosition);
    EXPECT_THAT(beyond.Send(motion.At(beyond, Mode::kCartesianPosition, c.beyond, 0, false)),
                ElementsAre(start));
    EXPECT_EQ(beyond.found.items()[0].axis, static_cast<int>(c.axis));
    EXPECT_EQ(beyond.generator.joints().q_d, model::kReady);
    Driver inside(Mode::kCartesianPosition);
    EXPECT_THAT(inside.Send(motion.At(inside, Mode::kCartesianPosition, c.inside, 0, false)),
                ElementsAre(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                            RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity));
  }
}

TEST(MotionGeneratorStartTest, TheFirstElbowIsNear) {
  for (const Mode mode : {Mode::kCartesianPosition, Mode::kCartesianVelocity}) {
    for (const double way : {0.1001, -0.1001, kNaN}) {
      Driver driver(mode);
      EXPECT_THAT(driver.Send(Motion{Axis::kElbow}.At(driver, mode, way, 0, true)),
                  ElementsAre(RobotError::kCartesianMotionGeneratorStartElbowInvalid));
    }
    Driver driver(mode);
    EXPECT_THAT(driver.Send(Motion{Axis::kElbow}.At(driver, mode, 0.0999, 0, true)),
                ElementsAre(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                            RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity));
    // An elbow that comes into a motion later is looked at in the same way.
    Driver later(mode);
    EXPECT_THAT(later.Send(Motion{Axis::kTranslation}.At(later, mode, 0, 0, false)), IsEmpty());
    EXPECT_THAT(later.Send(Motion{Axis::kElbow}.At(later, mode, 0.2, 0, true)),
                ElementsAre(RobotError::kCartesianMotionGeneratorStartElbowInvalid));
  }
}

TEST(MotionGeneratorStartTest, PoseAndElbowAreReportedTogether) {
  Driver driver(Mode::kCartesianPosition);
  RobotCommand command =
      Motion{Axis::kTranslation}.At(driver, Mode::kCartesianPosition, 1, 0, true);
  command.elbow_c = {2, 1};
  EXPECT_THAT(driver.Send(command),
              ElementsAre(RobotError::kCartesianPositionMotionGeneratorStartPoseInvalid,
                          RobotError::kCartesianMotionGeneratorStartElbowInvalid));
}

TEST(MotionGeneratorStartTest, TheElbowsSignIsTheArmsWheneverItIsCommanded) {
  for (const Mode mode : {Mode::kCartesianPosition, Mode::kCartesianVelocity}) {
    for (const double sign : {1.0, 0.0, -0.5, kNaN}) {
      Driver driver(mode);
      RobotCommand command = Motion{Axis::kElbow}.At(driver, mode, 0, 0, true);
      EXPECT_THAT(driver.Send(command), IsEmpty());
      command.elbow_c[1] = sign;
      command.elbow_c[0] = 0.09;  // a discontinuity, too
      EXPECT_THAT(driver.Send(command),
                  ElementsAre(RobotError::kCartesianMotionGeneratorElbowSignInconsistent));
    }
  }
}

TEST(MotionGeneratorStartTest, APoseThatIsNoneIsAnInvalidFrameInEveryCycle) {
  for (const bool is_first : {true, false}) {
    for (const std::size_t element : {0, 3, 13, 15}) {
      Driver driver(Mode::kCartesianPosition);
      RobotCommand command =
          Motion{Axis::kTranslation}.At(driver, Mode::kCartesianPosition, 0, 0, true);
      if (!is_first) {
        EXPECT_THAT(driver.Send(command), IsEmpty());
      }
      command.O_T_EE_c[element] = element == 13 ? kNaN : 2;
      command.elbow_c = {2, 1};  // wrong, too, but later
      EXPECT_THAT(driver.Send(command),
                  ElementsAre(RobotError::kCartesianPositionMotionGeneratorInvalidFrame));
    }
  }
}

TEST(MotionGeneratorStartTest, ATwistThatIsNoNumberIsADiscontinuity) {
  for (const std::size_t i : {0, 4}) {
    Driver driver(Mode::kCartesianVelocity);
    RobotCommand command;
    command.O_dP_EE_c[i] = kNaN;
    EXPECT_THAT(driver.Send(command),
                ElementsAre(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                            RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity));
    EXPECT_EQ(driver.generator.joints().q_d, model::kReady);
  }
}

TEST(MotionGeneratorStartTest, RepeatingWhatIsReportedIsExactlyNoMotion) {
  for (const Mode mode : {Mode::kJointPosition, Mode::kJointVelocity, Mode::kCartesianPosition,
                          Mode::kCartesianVelocity}) {
    for (const bool has_elbow : {false, true}) {
      Driver driver(mode);
      EXPECT_EQ(driver.start.O_T_EE_c,
                model::ArmModel::Panda().Pose(model::Frame::kEndEffector, model::kReady,
                                              model::kHandPose));
      EXPECT_EQ(driver.start.elbow_c, (Elbow{0, -1}));
      for (int k = 0; k < 5; ++k) {
        RobotCommand command;
        command.q_c = driver.generator.joints().q_d;
        command.O_T_EE_c = driver.generator.cartesian().O_T_EE_c;
        command.valid_elbow = has_elbow;
        command.elbow_c = driver.generator.cartesian().elbow_c;
        ASSERT_THAT(driver.Send(command), IsEmpty());
        EXPECT_TRUE(driver.generator.AtRest());
        EXPECT_EQ(driver.generator.joints().q_d, model::kReady);
      }
    }
  }
}

TEST(MotionGeneratorStartTest, ASingularArmIsKnown) {
  const GeneratorLimits limits = Driver::PandaGeneratorLimits();
  EXPECT_FALSE(MotionGenerator(limits, model::kReady).IsSingular());
  EXPECT_TRUE(MotionGenerator(limits, {0, 0.9, 0, kFlipAngle - 0.01, 0, 1.4, 0}).IsSingular());
}

// ---- precedence ----

TEST(MotionGeneratorPrecedenceTest, TheCartesianSideComesBeforeTheJoints) {
  // Both sides' jerks and accelerations are beyond.
  Driver driver(Mode::kCartesianPosition);
  EXPECT_THAT(
      driver.Send(Motion{Axis::kTranslation}.At(driver, Mode::kCartesianPosition, 1e-4, 0, false)),
      ElementsAre(RobotError::kCartesianMotionGeneratorVelocityDiscontinuity,
                  RobotError::kCartesianMotionGeneratorAccelerationDiscontinuity));
  // 5000 m/s^3 is within the limit of the pose, not of the joints that make it.
  Driver gentle(Mode::kCartesianPosition);
  const Errors errors =
      gentle.Send(Motion{Axis::kTranslation}.At(gentle, Mode::kCartesianPosition, 5e-6, 0, false));
  EXPECT_THAT(errors,
              Contains(RobotError::kCartesianMotionGeneratorJointAccelerationDiscontinuity));
  EXPECT_EQ(gentle.generator.joints().q_d, model::kReady);
  EXPECT_EQ(gentle.generator.cartesian().O_T_EE_c, gentle.start.O_T_EE_c);
}

TEST(MotionGeneratorPrecedenceTest, AStepWithAViolationIsNotTaken) {
  Driver driver(Mode::kCartesianPosition);
  for (int k = 1; k <= 500; ++k) ASSERT_THAT(driver.Send(CircleAt(driver, k, true)), IsEmpty());
  const JointReference joints = driver.generator.joints();
  const CartesianReference cartesian = driver.generator.cartesian();
  RobotCommand command = CircleAt(driver, 501, true);
  command.O_T_EE_c[13] += 1e-3;
  EXPECT_FALSE(driver.Send(command).empty());
  EXPECT_EQ(driver.generator.joints().q_d, joints.q_d);
  EXPECT_EQ(driver.generator.joints().ddq_d, joints.ddq_d);
  EXPECT_EQ(driver.generator.cartesian().O_T_EE_c, cartesian.O_T_EE_c);
  EXPECT_EQ(driver.generator.cartesian().O_ddP_EE_c, cartesian.O_ddP_EE_c);
}

}  // namespace
}  // namespace twin::onboard::onboard_motion_checks_test
