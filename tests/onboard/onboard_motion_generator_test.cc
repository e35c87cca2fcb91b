#include "twin/onboard/motion_generator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "onboard/motion_generator_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/random.h"

namespace twin::onboard::onboard_motion_generator_test {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using Errors = std::vector<RobotError>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

double Apart(const Transform& a, const Transform& b) {
  double apart = 0;
  for (std::size_t i = 0; i < 16; ++i) apart = std::max(apart, std::abs(a[i] - b[i]));
  return apart;
}

bool IsFinite(const MotionGenerator& generator) {
  const auto all = [](const auto& x) {
    return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
  };
  return all(generator.joints().q_d) && all(generator.joints().dq_d) &&
         all(generator.joints().ddq_d) && all(generator.cartesian().O_T_EE_c) &&
         all(generator.cartesian().O_ddP_EE_c) && all(generator.O_T_EE_d()) &&
         all(generator.O_dP_EE_d());
}

// ---- joint generators are arithmetic alone ----

TEST(MotionGeneratorJointTest, PassThroughBitForBit) {
  for (const Mode mode : {Mode::kJointPosition, Mode::kJointVelocity}) {
    Driver driver(mode);
    JointReference expected = JointReference::Rest(model::kReady);
    for (int k = 1; k <= 1000; ++k) {
      RobotCommand command;
      for (std::size_t i = 0; i < kJoints; ++i) {
        command.q_c[i] = model::kReady[i] + 0.1 * (1 - std::cos(2e-3 * k));
        command.dq_c[i] = 0.2 * std::sin(2e-3 * k);
      }
      const bool is_lost = k % 7 == 0;
      if (is_lost) {
        expected = expected.AfterLoss();
        ASSERT_THAT(driver.Lose(), IsEmpty());
      } else {
        expected = mode == Mode::kJointPosition ? expected.AfterPosition(command.q_c)
                                                : expected.AfterVelocity(command.dq_c);
        ASSERT_THAT(driver.Send(command), IsEmpty());
      }
      ASSERT_EQ(driver.generator.joints().q_d, expected.q_d);
      ASSERT_EQ(driver.generator.joints().dq_d, expected.dq_d);
      ASSERT_EQ(driver.generator.joints().ddq_d, expected.ddq_d);
      const model::ArmModel& arm = model::ArmModel::Panda();
      const auto frame = model::Frame::kEndEffector;
      ASSERT_EQ(driver.generator.O_T_EE_d(), arm.Pose(frame, expected.q_d, model::kHandPose));
      ASSERT_EQ(driver.generator.O_dP_EE_d(),
                arm.Twist(frame, expected.q_d, expected.dq_d, model::kHandPose));
      ASSERT_EQ(driver.generator.cartesian().O_T_EE_c, driver.generator.O_T_EE_d());
      ASSERT_EQ(driver.generator.cartesian().O_dP_EE_c, driver.generator.O_dP_EE_d());
      ASSERT_EQ(driver.generator.cartesian().O_ddP_EE_c, Vector6{});
      ASSERT_EQ(driver.generator.cartesian().delbow_c, expected.dq_d[2]);
    }
  }
}

// ---- the motions of libfranka's examples ----

class CartesianMotionTest : public ::testing::TestWithParam<bool> {};

TEST_P(CartesianMotionTest, ACircleRunsAndFinishes) {
  Driver driver(Mode::kCartesianPosition);
  for (int k = 0; k <= 10000; ++k) {
    ASSERT_THAT(driver.Send(CircleAt(driver, k, GetParam())), IsEmpty()) << "cycle " << k;
    ASSERT_LT(Apart(driver.generator.O_T_EE_d(), driver.generator.cartesian().O_T_EE_c), 1e-9);
  }
  EXPECT_TRUE(driver.generator.CheckStandingStill(1).empty());
  EXPECT_FALSE(driver.generator.AtRest());
  driver.generator.StandStill();
  driver.generator.StandStill();
  EXPECT_TRUE(driver.generator.AtRest());
}

TEST_P(CartesianMotionTest, TheSameCircleRunsByTwists) {
  Driver driver(Mode::kCartesianVelocity);
  const auto pose = [&](int k) { return CircleAt(driver, k, GetParam()).O_T_EE_c; };
  for (int k = 1; k <= 10000; ++k) {
    RobotCommand command = CircleAt(driver, k, GetParam());
    for (std::size_t i = 0; i < 3; ++i) {
      command.O_dP_EE_c[i] = (pose(k)[12 + i] - pose(k - 1)[12 + i]) / kT;
    }
    command.O_T_EE_c = {};
    ASSERT_THAT(driver.Send(command), IsEmpty()) << "cycle " << k;
    ASSERT_LT(Apart(driver.generator.O_T_EE_d(), pose(k)), 1e-9);
  }
  EXPECT_TRUE(driver.generator.CheckStandingStill(1).empty());
}

TEST_P(CartesianMotionTest, HoldsTheAccelerationThroughLosses) {
  for (int losses = 1; losses <= 19; ++losses) {
    for (const Mode mode : {Mode::kCartesianPosition, Mode::kCartesianVelocity}) {
      Driver driver(mode);
      const auto velocity = [](int k) { return 0.1 * (1 - std::cos(std::numbers::pi * k * kT)); };
      double way = 0;
      const auto send = [&](int k) {
        way += kT * velocity(k);
        return driver.Send(
            Motion{Axis::kTranslation}.At(driver, mode, way, velocity(k), GetParam()));
      };
      for (int k = 1; k <= 300; ++k) ASSERT_THAT(send(k), IsEmpty());
      CartesianReference expected = driver.generator.cartesian();
      for (int k = 301; k < 301 + losses; ++k) {
        expected = expected.AfterLoss();
        ASSERT_THAT(driver.Lose(), IsEmpty());
        way += kT * velocity(k);
        ASSERT_EQ(driver.generator.cartesian().O_T_EE_c, expected.O_T_EE_c);
        ASSERT_EQ(driver.generator.cartesian().O_dP_EE_c, expected.O_dP_EE_c);
        ASSERT_EQ(driver.generator.cartesian().O_ddP_EE_c, expected.O_ddP_EE_c);
        ASSERT_LT(Apart(driver.generator.O_T_EE_d(), expected.O_T_EE_c), 1e-9);
      }
      // One loss of a smooth motion is hardly noticed.
      if (losses == 1) {
        EXPECT_THAT(send(302), IsEmpty());
      }
    }
  }
}

TEST_P(CartesianMotionTest, ALossThatRunsIntoALimitIsAViolation) {
  GeneratorLimits limits = Driver::PandaGeneratorLimits();
  for (double& ddq_max : limits.joints.ddq_max) ddq_max *= 10;
  for (double& dq_max : limits.joints.dq_max) dq_max *= 10;
  Driver driver(Mode::kCartesianVelocity, limits);
  // Speeding up, 10 ms before the limit is reached.
  const std::vector<double> velocities = Speeding(2.0);
  for (const double v : velocities) {
    if (v > 1.6) break;
    ASSERT_THAT(driver.Send(Motion{Axis::kTranslation}.At(driver, Mode::kCartesianVelocity, 0, v,
                                                          GetParam())),
                IsEmpty());
  }
  Errors errors;
  int lost = 0;
  while (errors.empty() && lost < 100) {
    errors = driver.Lose();
    ++lost;
  }
  EXPECT_THAT(errors, ElementsAre(RobotError::kCartesianMotionGeneratorVelocityLimitsViolation));
  EXPECT_GT(lost, 5);
}

TEST_P(CartesianMotionTest, AMotionThatStillMovesMayNotFinish) {
  Driver driver(Mode::kCartesianPosition);
  for (int k = 0; k <= 2500; ++k) {
    ASSERT_THAT(driver.Send(CircleAt(driver, k, GetParam())), IsEmpty());
  }
  const Violations found = driver.generator.CheckStandingStill(7);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found.items()[0].error, RobotError::kCartesianMotionGeneratorVelocityDiscontinuity);
  EXPECT_EQ(found.items()[0].message_id, 7u);
}

TEST_P(CartesianMotionTest, BrakesToRestWithinTheJointsLimits) {
  Driver driver(Mode::kCartesianPosition);
  for (int k = 0; k <= 2500; ++k) {
    ASSERT_THAT(driver.Send(CircleAt(driver, k, GetParam())), IsEmpty());
  }
  const JointLimits limits = test::PandaLimits();
  int cycles = 0;
  do {
    driver.generator.Brake();
    for (std::size_t i = 0; i < kJoints; ++i) {
      ASSERT_LE(std::abs(driver.generator.joints().ddq_d[i]), limits.ddq_max[i]);
      ASSERT_LE(std::abs(driver.generator.joints().dddq_d[i]), limits.dddq_max[i] * (1 + 1e-9));
    }
    ASSERT_EQ(driver.generator.cartesian().O_T_EE_c, driver.generator.O_T_EE_d());
  } while (!driver.generator.AtRest() && ++cycles < 1000);
  EXPECT_GT(cycles, 5);
  EXPECT_LT(cycles, 100);
}

INSTANTIATE_TEST_SUITE_P(Elbow, CartesianMotionTest, ::testing::Bool(),
                         [](const auto& info) { return info.param ? "Commanded" : "Free"; });

TEST(MotionGeneratorTest, TheElbowMotionOfTheExamplesRuns) {
  Driver driver(Mode::kCartesianPosition);
  for (int k = 0; k <= 10000; ++k) {
    const double angle = std::numbers::pi / 10 * (1 - std::cos(std::numbers::pi / 5 * kT * k));
    ASSERT_THAT(
        driver.Send(Motion{Axis::kElbow}.At(driver, Mode::kCartesianPosition, angle, 0, true)),
        IsEmpty())
        << "cycle " << k;
    ASSERT_LT(Apart(driver.generator.O_T_EE_d(), driver.start.O_T_EE_c), 1e-9);
    ASSERT_EQ(driver.generator.joints().q_d[2], driver.generator.cartesian().elbow_c[0]);
  }
  EXPECT_TRUE(driver.generator.CheckStandingStill(1).empty());
}

TEST(MotionGeneratorTest, WithoutACommandedElbowItsStateIsThatOfJointThree) {
  Driver driver(Mode::kCartesianVelocity);
  for (const double v : Speeding(0.2)) {
    ASSERT_THAT(
        driver.Send(Motion{Axis::kTranslation}.At(driver, Mode::kCartesianVelocity, 0, v, false)),
        IsEmpty());
  }
  const JointReference& joints = driver.generator.joints();
  EXPECT_GT(std::abs(joints.dq_d[2]), 1e-3);
  EXPECT_EQ(driver.generator.cartesian().elbow_c, (Elbow{joints.q_d[2], -1}));
  EXPECT_EQ(driver.generator.cartesian().delbow_c, joints.dq_d[2]);
  EXPECT_EQ(driver.generator.cartesian().ddelbow_c, joints.ddq_d[2]);
}

TEST(MotionGeneratorTest, TakesOverWhereTheArmIs) {
  Driver driver(Mode::kJointPosition);
  const JointVector q{0.1, -0.5, 0.2, -2, 0.1, 1.4, 0.6};
  const JointVector dq{0.3, 0, 0, -0.2, 0, 0, 0.1};
  driver.generator.TakeOver(q, dq);
  EXPECT_EQ(driver.generator.joints().q_d, q);
  EXPECT_EQ(driver.generator.joints().dq_d, dq);
  EXPECT_EQ(driver.generator.joints().ddq_d, JointVector{});
  EXPECT_FALSE(driver.generator.AtRest());
  EXPECT_EQ(driver.generator.O_T_EE_d(),
            model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q, model::kHandPose));
  driver.generator.Rest();
  EXPECT_TRUE(driver.generator.AtRest());
}

// ---- filters ----

constexpr double kGain100Hz = 0.385869545095137;  // T / (T + 1 / (2 pi 100 Hz))

TEST(MotionGeneratorFilterTest, EachGeneratorHasItsOwn) {
  struct Case {
    double setting::Filters::*filter;
    Mode mode;
    Axis axis;
  };
  for (const Case& c :
       {Case{&setting::Filters::joint_position_hz, Mode::kJointPosition, Axis::kJoint},
        {&setting::Filters::joint_velocity_hz, Mode::kJointVelocity, Axis::kJoint},
        {&setting::Filters::cartesian_position_hz, Mode::kCartesianPosition, Axis::kTranslation},
        {&setting::Filters::cartesian_position_hz, Mode::kCartesianPosition, Axis::kRotation},
        {&setting::Filters::cartesian_position_hz, Mode::kCartesianPosition, Axis::kElbow},
        {&setting::Filters::cartesian_velocity_hz, Mode::kCartesianVelocity, Axis::kTranslation},
        {&setting::Filters::cartesian_velocity_hz, Mode::kCartesianVelocity, Axis::kElbow}}) {
    constexpr double kWay = 1e-6;
    constexpr double kSpeed = 1e-3;
    const auto speed_after = [&](double hz) {
      setting::Filters set;
      set.*c.filter = hz;
      Driver driver(c.mode);
      driver.generator.SetFilters(set);
      const Motion motion{.axis = c.axis, .joint = 2};
      EXPECT_THAT(driver.Send(motion.At(driver, c.mode, kWay, kSpeed, false)), IsEmpty());
      const CartesianReference& reference = driver.generator.cartesian();
      switch (c.axis) {
        case Axis::kTranslation: return reference.O_dP_EE_c[1];
        case Axis::kRotation: return reference.O_dP_EE_c[5];
        case Axis::kElbow: return reference.delbow_c;
        case Axis::kJoint: break;
      }
      return driver.generator.joints().dq_d[2];
    };
    EXPECT_NEAR(speed_after(1000), kSpeed, 1e-12);
    EXPECT_NEAR(speed_after(100), kGain100Hz * kSpeed, 1e-12);
  }
}

TEST(MotionGeneratorFilterTest, APoseThatIsNoneStaysAnInvalidFrame) {
  Driver driver(Mode::kCartesianPosition);
  setting::Filters filters;
  filters.cartesian_position_hz = 10;
  driver.generator.SetFilters(filters);
  RobotCommand command = CircleAt(driver, 0, false);
  command.O_T_EE_c[0] *= 1.1;
  EXPECT_THAT(driver.Send(command),
              ElementsAre(RobotError::kCartesianPositionMotionGeneratorInvalidFrame));
}

// ---- hostile streams ----

/// A random command: near the last one, or anything.
RobotCommand HostileCommand(const MotionGenerator& generator, const Random& random,
                            std::uint64_t k) {
  const auto uniform = [&](std::uint32_t draw) { return 2 * random.Uniform(k, draw) - 1; };
  const double scale = std::pow(10, -8 + 6 * random.Uniform(k, 0));
  RobotCommand command;
  for (std::uint32_t i = 0; i < kJoints; ++i) {
    command.q_c[i] =
        generator.joints().q_d[i] + kT * generator.joints().dq_d[i] + scale * uniform(1 + i);
    command.dq_c[i] = generator.joints().dq_d[i] + scale * 1e3 * uniform(10 + i);
  }
  const CartesianReference ahead = generator.cartesian().AfterLoss();
  const Eigen::Vector3d phi = scale * Eigen::Vector3d(uniform(20), uniform(21), uniform(22));
  const Eigen::Vector3d p = scale * Eigen::Vector3d(uniform(23), uniform(24), uniform(25));
  command.O_T_EE_c = model::Turned(ahead.O_T_EE_c, phi, model::Position(ahead.O_T_EE_c) + p);
  command.O_dP_EE_c = ahead.O_dP_EE_c;
  for (std::uint32_t i = 0; i < 6; ++i) command.O_dP_EE_c[i] += scale * 1e3 * uniform(30 + i);
  command.valid_elbow = random.Uniform(k / 1000, 40) < 0.5;
  command.elbow_c = {ahead.elbow_c[0] + scale * uniform(41), ahead.elbow_c[1]};
  if (k % 997 == 0) {
    const double odd[] = {kNaN, std::numeric_limits<double>::infinity(), 1e300, -1e300, 0};
    const auto at = static_cast<std::size_t>(random.Uniform(k, 42) * 16);
    const double value = odd[k % 5];
    command.q_c[at % kJoints] = value;
    command.dq_c[at % kJoints] = value;
    command.O_T_EE_c[at] = value;
    command.O_dP_EE_c[at % 6] = value;
    command.elbow_c[at % 2] = value;
  }
  return command;
}

TEST(MotionGeneratorTest, HostileStreamsNeverLeaveTheLimits) {
  const Random random(5, RandomStream::kTest);
  const GeneratorLimits limits = Driver::PandaGeneratorLimits();
  constexpr Mode kModes[] = {Mode::kJointPosition, Mode::kJointVelocity, Mode::kCartesianPosition,
                             Mode::kCartesianVelocity};
  MotionGenerator generator(limits, model::kReady);
  generator.SetEndEffector(model::kHandPose);
  bool is_first = true;
  std::uint64_t taken = 0;
  std::uint64_t motions = 0;
  for (std::uint64_t k = 0; k < 100'000; ++k) {
    if (is_first) {
      generator.TakeOver(model::SampleOf(motions).q, {});
      const Mode mode = kModes[++motions % 4];
      if (mode >= Mode::kCartesianPosition && generator.IsSingular()) continue;
      generator.Start({.generator = mode});
    }
    const bool is_lost = random.Uniform(k, 50) < 0.1;
    const Violations found =
        is_lost ? generator.Hold(k)
                : generator.Take(HostileCommand(generator, random, k), is_first, k);
    ASSERT_TRUE(IsFinite(generator)) << k;
    is_first = !found.empty();
    if (is_first) {
      generator.Brake();
      ASSERT_TRUE(IsFinite(generator)) << k;
      continue;
    }
    ++taken;
    for (std::size_t i = 0; i < kJoints; ++i) {
      const JointReference& joints = generator.joints();
      ASSERT_LE(std::abs(joints.dq_d[i]), limits.joints.dq_max[i] * (1 + 1e-9));
      ASSERT_LE(std::abs(joints.ddq_d[i]), limits.joints.ddq_max[i] * (1 + 1e-9));
      ASSERT_GE(joints.q_d[i], limits.joints.q_min[i] - 1e-8);
      ASSERT_LE(joints.q_d[i], limits.joints.q_max[i] + 1e-8);
    }
  }
  EXPECT_GT(taken, 20'000u);
  EXPECT_GT(motions, 1000u);
}

TEST(MotionGeneratorTest, AllocatesNothing) {
  for (const Mode mode : {Mode::kJointPosition, Mode::kJointVelocity, Mode::kCartesianPosition,
                          Mode::kCartesianVelocity}) {
    Driver driver(mode);
    RobotCommand command = CircleAt(driver, 0, true);
    command.q_c = model::kReady;
    std::size_t violations = 0;
    const test::RealtimeGuard guard;
    driver.generator.Start({.generator = mode});
    driver.generator.Rest();
    for (int k = 0; k < 1000; ++k) {
      command.q_c[6] += 1e-7;
      command.O_dP_EE_c[1] = 1e-5 * k;
      violations += driver.generator.Take(command, k == 0, 1).size();
      if (k % 10 == 0) violations += driver.generator.Hold(1).size();
    }
    command.O_T_EE_c[5] = kNaN;
    command.q_c[0] = kNaN;
    (void)driver.generator.Take(command, false, 1);
    (void)driver.generator.CheckStandingStill(1);
    (void)driver.generator.IsSingular();
    driver.generator.StandStill();
    driver.generator.Brake();
    driver.generator.TakeOver(model::kReady, {});
    EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
    EXPECT_EQ(violations, 0u);
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_motion_generator_test
