#include <cmath>
#include <filesystem>
#include <memory>

#include <gtest/gtest.h>

#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/model/mass_properties.h"
#include "twin/onboard/onboard_controller.h"
#include "twin/run/run.h"

namespace twin::scenario::scenario_load_test {
namespace {

constexpr setting::Load kKilogram{.m_load = 1, .F_x_Cload = {0.02, -0.01, 0.1}};
constexpr JointVector kReady{
    0, -0.78539816339744831, 0, -2.3561944901923448, 0, 1.5707963267948966, 0.78539816339744831};

model::Payload PayloadOf(const setting::Load& load) {
  return {load.m_load, load.F_x_Cload, load.I_load};
}

/// INT and the body as a scenario makes them, without a workstation: the arm is held in Idle.
class HeldArm {
 public:
  /// @param load  what is really there.
  HeldArm(const JointVector& q, const setting::Load& load) {
    Scenario scenario;
    scenario.robot.q_start = q;
    scenario.robot.load = load;
    const run::RunFiles files{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
    const RobotData robot = LoadRobotData(files.models, "panda", scenario.robot.hand);
    const robot::RobotConfig config = run::MakeRobotConfig(scenario, robot, files);
    end_effector_ = config.onboard.end_effector;
    K_theta_ = config.onboard.joint_impedance.K_theta;
    plant_ = plant::MujocoPlant::Create(config.plant);
    plant_->Reset(q);
    onboard_ = std::make_unique<onboard::OnboardController>(config.onboard, q);
  }

  void Configure(const Setting& setting) {
    ASSERT_EQ(onboard_->Configure(setting), SetterStatus::kSuccess);
  }

  void Settle() {
    for (int k = 0; k < 3000; ++k) {
      plant_->Step(onboard_->Cycle(nullptr, plant_->sensors()));
      onboard_->FillState(plant_->sensors(), state_);
    }
    ASSERT_TRUE(state_.errors.none());
    for (const double dq : plant_->sensors().dq) ASSERT_LT(std::abs(dq), 1e-6) << "still moves";
  }

  [[nodiscard]] JointVector Deflection() const {
    JointVector dq{};
    for (std::size_t i = 0; i < kJoints; ++i) dq[i] = plant_->sensors().q[i] - state_.q_d[i];
    return dq;
  }

  /// K_theta^-1 (g with a load - g without), at q_d.
  [[nodiscard]] JointVector DeflectionBy(const setting::Load& load) const {
    const model::ArmModel& arm = model::ArmModel::Panda();
    const auto with = arm.Gravity(state_.q_d, model::Combine(end_effector_, PayloadOf(load)));
    const auto without = arm.Gravity(state_.q_d, end_effector_);
    JointVector dq{};
    for (std::size_t i = 0; i < kJoints; ++i) dq[i] = (with[i] - without[i]) / K_theta_[i];
    return dq;
  }

  [[nodiscard]] const RobotState& state() const { return state_; }
  [[nodiscard]] plant::MujocoPlant& plant() { return *plant_; }

 private:
  model::Payload end_effector_;
  JointVector K_theta_{};
  std::unique_ptr<plant::MujocoPlant> plant_;
  std::unique_ptr<onboard::OnboardController> onboard_;
  RobotState state_;
};

JointVector SomePose(std::uint64_t k) {
  const Random random(11, RandomStream::kTest);
  JointVector q = kReady;
  for (std::uint32_t i = 0; i < kJoints; ++i) q[i] += 0.8 * (random.Uniform(k, i) - 0.5);
  return q;
}

/// Within 10 % of the longest deflection; joints that hardly bend say nothing.
void ExpectNear(const JointVector& measured, const JointVector& expected, double sign) {
  double largest = 0;
  for (const double dq : expected) largest = std::max(largest, std::abs(dq));
  ASSERT_GT(largest, 5e-4) << "nothing to see";
  for (std::size_t i = 0; i < kJoints; ++i) {
    const double tolerance = 0.1 * std::max(std::abs(expected[i]), 0.05 * largest);
    EXPECT_NEAR(measured[i], sign * expected[i], tolerance) << "joint " << i + 1;
  }
}

TEST(ScenarioLoadTest, SagsByTheWeightTheRobotIsNotToldOf) {
  for (std::uint64_t k = 0; k < 5; ++k) {
    HeldArm arm(SomePose(k), kKilogram);
    arm.Settle();
    ExpectNear(arm.Deflection(), arm.DeflectionBy(kKilogram), -1);
  }
}

TEST(ScenarioLoadTest, RisesByTheWeightThatIsNotThere) {
  HeldArm arm(SomePose(7), {});
  arm.Configure(kKilogram);
  arm.Settle();
  ExpectNear(arm.Deflection(), arm.DeflectionBy(kKilogram), 1);
}

TEST(ScenarioLoadTest, HoldsStillWhatItIsToldOf) {
  for (std::uint64_t k = 0; k < 5; ++k) {
    HeldArm arm(SomePose(k), kKilogram);
    arm.Configure(kKilogram);
    arm.Settle();
    for (const double dq : arm.Deflection()) EXPECT_LT(std::abs(dq), 1e-5);
    for (const double tau : arm.state().tau_ext_hat_filtered) EXPECT_LT(std::abs(tau), 0.05);
  }
}

TEST(ScenarioLoadTest, SetLoadMakesNothingHeavier) {
  HeldArm arm(kReady, {});
  const JointVector before = arm.plant().GravityTorque(kReady);
  arm.Configure(kKilogram);
  arm.Settle();
  EXPECT_EQ(arm.plant().GravityTorque(kReady), before);
  const JointVector there = arm.plant().GravityTorque(arm.state().q);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(arm.state().tau_J[i], there[i], 0.02) << "the sensors show what really hangs there";
  }
}

TEST(ScenarioLoadTest, TheWeightThatIsNotToldLooksLikeAForceFromOutside) {
  HeldArm arm(kReady, kKilogram);
  arm.Settle();
  // As what the robot does to its surroundings: it holds the weight up.
  EXPECT_NEAR(arm.state().O_F_ext_hat_K[2], 9.81, 0.5);
  EXPECT_NEAR(arm.state().O_F_ext_hat_K[0], 0, 0.5);
  EXPECT_NEAR(arm.state().O_F_ext_hat_K[1], 0, 0.5);
}

TEST(ScenarioLoadTest, TheHandTakesPartInSelfCollisionAndLimitsWhereThereIsOne) {
  const run::RunFiles files{std::filesystem::path(TWIN_SOURCE_DIR) / "models", {}, {}, false};
  for (const plant::HandKind hand : {plant::HandKind::kNone, plant::HandKind::kFrankaHand}) {
    Scenario scenario;
    scenario.robot.q_start = kReady;
    scenario.robot.hand = hand;
    const onboard::OnboardConfig config = run::MakeServedConfig(scenario, files).onboard;
    EXPECT_EQ(config.sensing.measured.has_hand, hand != plant::HandKind::kNone);
    EXPECT_EQ(config.guard_has_hand, hand != plant::HandKind::kNone);
  }
}

}  // namespace
}  // namespace twin::scenario::scenario_load_test
