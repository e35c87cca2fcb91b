#include "twin/core/setting.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace twin {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The field and element that are wrong.
std::string FieldOf(const Setting& setting) {
  const std::optional<BadValue> bad = FindBadValue(setting);
  if (!bad) return "sound";
  std::string text(bad->field);
  if (bad->index) text += "[" + std::to_string(*bad->index) + "]";
  return text;
}

Transform TurnedAboutZ(double angle) {
  Transform X = kIdentityTransform;
  X[0] = X[5] = std::cos(angle);
  X[1] = std::sin(angle);
  X[4] = -X[1];
  return X;
}

TEST(SettingTest, WhatTheRobotStartsWithIsSound) {
  for (const Setting& setting :
       {Setting(setting::JointImpedance()), Setting(setting::CartesianImpedance()),
        Setting(setting::CollisionBehavior()), Setting(setting::GuidingMode()),
        Setting(setting::StiffnessFrame()), Setting(setting::EndEffectorFrame()),
        Setting(setting::Load()), Setting(setting::Filters())}) {
    EXPECT_EQ(FieldOf(setting), "sound") << Name(setting);
  }
}

TEST(SettingTest, JointStiffnessEndsAtItsBounds) {
  setting::JointImpedance impedance;
  for (const double K : {0.0, 14250.0}) {
    impedance.K_theta[6] = K;
    EXPECT_EQ(FieldOf(impedance), "sound");
  }
  for (const double K : {-1e-9, 14250.001, kNaN, kInfinity, -kInfinity}) {
    impedance.K_theta[6] = K;
    EXPECT_EQ(FieldOf(impedance), "K_theta[6]") << K;
  }
}

TEST(SettingTest, CartesianStiffnessHasOneRangeAlongAndOneAboutTheAxes) {
  setting::CartesianImpedance impedance{{10, 3000, 10, 1, 300, 1}};
  EXPECT_EQ(FieldOf(impedance), "sound");
  impedance.K_x = {9.9, 3000, 10, 1, 300, 1};
  EXPECT_EQ(FieldOf(impedance), "K_x[0]");
  impedance.K_x = {10, 3000, 10, 1, 300.1, 1};
  EXPECT_EQ(FieldOf(impedance), "K_x[4]");
}

TEST(SettingTest, NoLowerThresholdStandsAboveItsUpper) {
  setting::CollisionBehavior behavior;
  behavior.lower_force_nominal[2] = 20.5;
  EXPECT_EQ(FieldOf(behavior), "lower_force_thresholds_nominal[2]");
  behavior.upper_force_nominal[2] = 20.5;
  EXPECT_EQ(FieldOf(behavior), "sound");
  behavior.upper_torque_acc[5] = kNaN;
  EXPECT_EQ(FieldOf(behavior), "upper_torque_thresholds_acceleration[5]");
}

TEST(SettingTest, AFrameMustBeRigid) {
  EXPECT_EQ(FieldOf(setting::StiffnessFrame{TurnedAboutZ(0.3)}), "sound");
  Transform X = TurnedAboutZ(0.3);
  X[0] += 1e-4;
  EXPECT_EQ(FieldOf(setting::EndEffectorFrame{X}), "NE_T_EE");
  X = TurnedAboutZ(0.3);
  X[15] = 0;
  EXPECT_EQ(FieldOf(setting::StiffnessFrame{X}), "EE_T_K");
  Transform mirrored = kIdentityTransform;
  mirrored[10] = -1;
  EXPECT_FALSE(IsRigid(mirrored));
  X = kIdentityTransform;
  X[13] = kNaN;
  EXPECT_FALSE(IsRigid(X));
}

TEST(SettingTest, ALoadHasAMassThatCanBe) {
  EXPECT_EQ(FieldOf(setting::Load{.m_load = 3, .F_x_Cload = {0, 0, 0.1}, .I_load = {}}), "sound");
  EXPECT_EQ(FieldOf(setting::Load{.m_load = -0.1, .F_x_Cload = {}, .I_load = {}}), "load_mass");
  EXPECT_EQ(FieldOf(setting::Load{.m_load = 1, .F_x_Cload = {0, kNaN, 0}, .I_load = {}}),
            "F_x_Cload[1]");
}

TEST(SettingTest, ACutoffIsAFrequencyOfTheFilters) {
  EXPECT_EQ(FieldOf(setting::Filters{.joint_position_hz = 1}), "sound");
  EXPECT_EQ(FieldOf(setting::Filters{.joint_velocity_hz = 0.5}), "joint_velocity_filter_frequency");
  EXPECT_EQ(FieldOf(setting::Filters{.controller_hz = 1001}), "controller_filter_frequency");
}

TEST(SettingTest, ItsNameIsThatOfTheRequest) {
  EXPECT_EQ(Name(Setting(setting::Load())), "Set Load");
  EXPECT_EQ(Name(Setting(setting::EndEffectorFrame())), "Set NE to EE");
}

TEST(SettingTest, WhatIsWrongIsSaidInWords) {
  const auto text = [](const Setting& setting) { return Describe(FindBadValue(setting).value()); };
  EXPECT_EQ(text(setting::JointImpedance{{0, -3}}),
            "K_theta[1] is -3; it must be in [0, 14250] Nm/rad");
  EXPECT_EQ(text(setting::Load{.m_load = 200, .F_x_Cload = {}, .I_load = {}}),
            "load_mass is 200; it must be in [0, 100] kg");
  EXPECT_EQ(text(setting::StiffnessFrame{Transform{}}),
            "EE_T_K must be a rigid transform, 4 x 4 column-major");
}

}  // namespace
}  // namespace twin
