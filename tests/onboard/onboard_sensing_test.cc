#include "twin/onboard/sensing.h"

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "onboard/arm_samples.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"

namespace twin::onboard::onboard_sensing_test {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<RobotError> Errors(const Violations& found) {
  std::vector<RobotError> errors;
  for (const Violation& violation : found.items()) errors.push_back(violation.error);
  return errors;
}

class SensingTest : public ::testing::Test {
 protected:
  SensingTest() { sensing_.Reset(sensors_, setup_); }

  void Update(int cycles, bool accelerates = false) {
    for (int k = 0; k < cycles; ++k) sensing_.Update(sensors_, setup_, accelerates);
  }
  /// From now on the robot pushes at K with this wrench, base axes.
  void Push(const Vector6& F) {
    sensors_ = RestingAt(q_);
    const JointVector tau = TorqueOf(F, q_, setup_.EE_T_K);
    for (std::size_t i = 0; i < kJoints; ++i) sensors_.tau_J[i] += tau[i];
  }

  JointVector q_ = model::kReady;
  JointSensors sensors_ = RestingAt(q_);
  ArmSetup setup_ = HandSetup();
  Sensing sensing_{PandaSensing()};
};

TEST_F(SensingTest, AtRestWithoutContactThereIsNothing) {
  Update(1000);
  for (std::size_t i = 0; i < kJoints; ++i)
    EXPECT_NEAR(sensing_.tau_ext_hat_filtered()[i], 0, 1e-12);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(sensing_.O_F_ext_hat_K()[i], 0, 1e-10);
  EXPECT_EQ(sensing_.joint_contact(), JointVector{});
  EXPECT_EQ(sensing_.cartesian_contact(), Vector6{});
  EXPECT_THAT(Errors(sensing_.Collisions(1)), IsEmpty());
  EXPECT_THAT(Errors(sensing_.CheckMeasured({}, 1)), IsEmpty());
  EXPECT_FALSE(sensing_.NeedsManualRecovery());
}

TEST_F(SensingTest, APushShowsAtKInBothAxes) {
  setup_.EE_T_K = kTiltedK;
  const Vector6 F{4, -6, 9, 0.5, -0.3, 0.8};
  Push(F);
  Update(500);
  const JointVector tau = TorqueOf(F, q_, kTiltedK);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(sensing_.tau_ext_hat_filtered()[i], tau[i], 1e-9);
  }
  double square_O = 0;
  double square_K = 0;
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(sensing_.O_F_ext_hat_K()[i], F[i], 1e-9);
  for (std::size_t i = 0; i < 3; ++i) {
    square_O += F[i] * F[i];
    square_K += sensing_.K_F_ext_hat_K()[i] * sensing_.K_F_ext_hat_K()[i];
  }
  EXPECT_NEAR(square_K, square_O, 1e-8);
  EXPECT_GT(std::abs(sensing_.K_F_ext_hat_K()[0] - F[0]), 0.1) << "other axes, other figures";
}

TEST_F(SensingTest, ThePushArrivesWithTheTimeConstantOfTheGain) {
  Push({0, 0, -20, 0, 0, 0});
  Update(10);  // 10 ms at 100/s
  EXPECT_NEAR(sensing_.O_F_ext_hat_K()[2], -20 * (1 - std::exp(-1.0)), 1e-9);
}

TEST_F(SensingTest, ACollisionIsLatchedAndClearedByRecovery) {
  setting::CollisionBehavior behavior;
  behavior.lower_force_nominal.fill(10);
  behavior.upper_force_nominal.fill(30);
  behavior.upper_torque_nominal.fill(100);
  sensing_.SetCollisionBehavior(behavior);
  Push({0, 20, 0, 0, 0, 0});
  Update(200);
  double contacts = 0;
  for (const double level : sensing_.cartesian_contact()) contacts += level;
  EXPECT_GE(contacts, 1);
  EXPECT_EQ(sensing_.cartesian_collision(), Vector6{});
  Push({0, 60, 0, 0, 0, 0});
  Update(200);
  EXPECT_THAT(Errors(sensing_.Collisions(9)), ElementsAre(RobotError::kCartesianReflex));
  const Vector6 latched = sensing_.cartesian_collision();
  EXPECT_NE(latched, Vector6{});
  Push({});
  Update(200);
  EXPECT_THAT(Errors(sensing_.Collisions(9)), IsEmpty());
  EXPECT_EQ(sensing_.cartesian_contact(), Vector6{});
  EXPECT_EQ(sensing_.cartesian_collision(), latched);
  sensing_.Reset(sensors_, setup_);
  EXPECT_EQ(sensing_.cartesian_collision(), latched) << "a new payload is no recovery";
  sensing_.ClearCollisions();
  EXPECT_EQ(sensing_.cartesian_collision(), Vector6{});
}

TEST_F(SensingTest, TheReferencesPhaseChoosesTheThresholds) {
  setting::CollisionBehavior behavior;
  behavior.lower_torque_acc.fill(100);
  behavior.upper_torque_acc.fill(100);
  behavior.lower_torque_nominal.fill(2);
  behavior.upper_torque_nominal.fill(2);
  behavior.lower_force_acc = behavior.upper_force_acc = Vector6{500, 500, 500, 500, 500, 500};
  behavior.lower_force_nominal = behavior.upper_force_nominal = behavior.upper_force_acc;
  sensing_.SetCollisionBehavior(behavior);
  Push({0, 0, 25, 0, 0, 0});
  Update(300, true);
  EXPECT_THAT(Errors(sensing_.Collisions(1)), IsEmpty());
  Update(1, false);
  EXPECT_THAT(Errors(sensing_.Collisions(1)), ElementsAre(RobotError::kJointReflex));
}

TEST_F(SensingTest, NearASingularityThereIsTorqueButNoWrench) {
  q_[3] = -0.467;
  sensors_ = RestingAt(q_);
  sensing_.Reset(sensors_, setup_);
  Push({0, 0, 30, 0, 0, 0});
  Update(300);
  EXPECT_GT(std::abs(sensing_.tau_ext_hat_filtered()[1]), 5);
  EXPECT_EQ(sensing_.O_F_ext_hat_K(), Vector6{});
  EXPECT_EQ(sensing_.K_F_ext_hat_K(), Vector6{});
  EXPECT_EQ(sensing_.cartesian_contact(), Vector6{});
}

TEST_F(SensingTest, AnotherPayloadStartsAnew) {
  Push({0, 0, 30, 0, 0, 0});
  Update(300);
  EXPECT_NE(sensing_.cartesian_contact(), Vector6{});
  sensing_.Reset(sensors_, setup_);
  EXPECT_EQ(sensing_.tau_ext_hat_filtered(), JointVector{});
  EXPECT_EQ(sensing_.O_F_ext_hat_K(), Vector6{});
  EXPECT_EQ(sensing_.cartesian_contact(), Vector6{});
}

TEST_F(SensingTest, KnowsThePoseOfTheEndEffector) {
  sensors_.q = q_ = RegularPose(2);
  Update(1);
  EXPECT_EQ(sensing_.arm().EE.O_T_frame,
            model::ArmModel::Panda().Pose(model::Frame::kEndEffector, q_, model::kHandPose));
}

TEST_F(SensingTest, AJointBeyondItsLimitNeedsPeople) {
  sensors_ = RestingAt(q_);
  sensors_.q[0] = 2.9;  // within the margin
  Update(1);
  EXPECT_THAT(Errors(sensing_.CheckMeasured({}, 1)), IsEmpty());
  EXPECT_FALSE(sensing_.NeedsManualRecovery());
  sensors_.q[0] = 2.91;
  Update(1);
  EXPECT_THAT(Errors(sensing_.CheckMeasured({}, 7)),
              ElementsAre(RobotError::kJointPositionLimitsViolation));
  EXPECT_TRUE(sensing_.NeedsManualRecovery());
}

TEST_F(SensingTest, TheEndEffectorsVelocityIsThatOfTheJoints) {
  // Joint 7 alone turns EE about its own axis.
  sensors_.dq[6] = 2.8;
  Update(1);
  EXPECT_THAT(Errors(sensing_.CheckMeasured({}, 1)), IsEmpty());
  const Violations found = sensing_.CheckMeasured({}, 1, true);
  ASSERT_THAT(Errors(found), ElementsAre(RobotError::kCartesianVelocityViolation));
  EXPECT_EQ(found.items()[0].axis, 1);
  EXPECT_NEAR(found.items()[0].value, 2.8, 1e-9);
  // Joint 1 sweeps EE around the base: 2.3 rad/s times its distance from the axis.
  sensors_ = RestingAt({0, 1.2, 0, -0.8, 0, 1.9, 0});
  sensors_.dq[0] = 2.3;
  Update(1);
  const Transform& O_T_EE = sensing_.arm().EE.O_T_frame;
  const double v = 2.3 * std::hypot(O_T_EE[12], O_T_EE[13]);
  ASSERT_LT(v, 2.0);
  EXPECT_THAT(Errors(sensing_.CheckMeasured({}, 1)), IsEmpty());
  SensingConfig slower = PandaSensing();
  slower.measured.translation_max_m_per_s = 0.99 * v;
  Sensing other(slower);
  other.Update(sensors_, setup_, false);
  const Violations fast = other.CheckMeasured({}, 1);
  ASSERT_THAT(Errors(fast), ElementsAre(RobotError::kCartesianVelocityViolation));
  EXPECT_NEAR(fast.items()[0].value, v, 1e-9);
}

TEST_F(SensingTest, PowerIsOfTheTorqueThatActs) {
  sensors_.dq = {2, 0, 0, 2, 0, 0, 0};
  Update(1);
  const JointVector g = model::ArmModel::Panda().Gravity(q_, model::kHand);
  const JointVector tau_J_d{150, 0, 0, 55 - g[3], 0, 0, 0};
  EXPECT_THAT(Errors(sensing_.CheckMeasured({140, 0, 0, 55 - g[3], 0, 0, 0}, 1)), IsEmpty());
  const Violations found = sensing_.CheckMeasured(tau_J_d, 1);
  ASSERT_THAT(Errors(found), ElementsAre(RobotError::kPowerLimitViolation));
  EXPECT_NEAR(found.items()[0].value, 410, 1e-9);
}

TEST_F(SensingTest, AFoldedArmIsAboutToMeetItself) {
  q_ = {0, -0.5, 1.57, -3.05, 0, 1.5, 0};
  sensors_ = RestingAt(q_);
  Update(1);
  const double distance = model::SelfDistance(q_, true);
  ASSERT_LT(distance, 0.01);
  const Violations found = sensing_.CheckMeasured({}, 1);
  ASSERT_THAT(Errors(found), ElementsAre(RobotError::kSelfCollisionAvoidanceViolation));
  EXPECT_EQ(found.items()[0].value, distance);
  EXPECT_EQ(found.items()[0].limit, 0.01);
}

TEST_F(SensingTest, ACycleTakesNoMemory) {
  Push({0, 0, 60, 0, 0, 0});
  sensors_.dq[0] = 3;
  std::size_t violations = 0;
  const test::RealtimeGuard guard;
  sensing_.Reset(sensors_, setup_);
  for (std::uint64_t k = 0; k < 1000; ++k) {
    sensors_.q[3] += 1e-3;
    sensing_.Update(sensors_, setup_, k % 2 == 0);
    violations += sensing_.Collisions(k).size();
    violations += sensing_.CheckMeasured({}, k, true).size();
    sensing_.ClearCollisions();
  }
  const auto counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
  EXPECT_GT(violations, 1000u);
}

TEST(SensingConfigTest, NamesTheFieldThatIsOutOfRange) {
  const std::vector<std::pair<std::string, std::function<void(SensingConfig&)>>> cases{
      {"observer_gain", [](SensingConfig& c) { c.observer_gain = 0; }},
      {"observer_gain", [](SensingConfig& c) { c.observer_gain = 1001; }},
      {"wrench_gain_max", [](SensingConfig& c) { c.wrench_gain_max = -1; }},
      {"q_margin_rad", [](SensingConfig& c) { c.measured.q_margin_rad = -0.01; }},
      {"velocity_margin", [](SensingConfig& c) { c.measured.velocity_margin = -0.1; }},
      {"translation_max_m_per_s", [](SensingConfig& c) { c.measured.translation_max_m_per_s = 0; }},
      {"power_max_W",
       [](SensingConfig& c) { c.measured.power_max_W = std::numeric_limits<double>::quiet_NaN(); }},
      {"clearance_m", [](SensingConfig& c) { c.measured.clearance_m = -1; }},
      {"tau_J_range[4]",
       [](SensingConfig& c) { c.measured.tau_J_range = JointVector{1, 1, 1, 1, 0, 1, 1}; }},
  };
  EXPECT_NO_THROW(PandaSensing().Validate());
  for (const auto& [field, spoil] : cases) {
    SensingConfig config = PandaSensing();
    spoil(config);
    try {
      config.Validate();
      ADD_FAILURE() << field;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(field));
    }
  }
}

}  // namespace
}  // namespace twin::onboard::onboard_sensing_test
