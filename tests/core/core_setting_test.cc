#include "twin/core/setting.h"

#include <cmath>
#include <limits>
#include <string>

#include <gtest/gtest.h>

namespace twin::core_setting_test {
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

/// The first thing wrong with a load of 1 kg that has this inertia.
std::string FieldOfInertia(const Matrix3& I) {
  return FieldOf(setting::Load{.m_load = 1, .F_x_Cload = {}, .I_load = I});
}

TEST(SettingTest, ALoadHasTheInertiaOfABody) {
  // R diag(1, 2, 2.5) R^T, R a turn by an angle whose cosine is 0.6 about z: symmetric, definite.
  EXPECT_EQ(FieldOfInertia({1.64, -0.48, 0, -0.48, 1.36, 0, 0, 0, 2.5}), "sound");
  EXPECT_EQ(FieldOfInertia({1, 0, 0, 0, 2, 0, 0, 0, 3}), "sound") << "a plate";
  EXPECT_EQ(FieldOfInertia({0, 0, 0, 0, 2, 0, 0, 0, 2}), "sound") << "a rod";
  EXPECT_EQ(FieldOfInertia({}), "sound") << "a point";
  EXPECT_EQ(FieldOfInertia({-1, 0, 0, 0, -1, 0, 0, 0, -1}), "load_inertia");
  EXPECT_EQ(FieldOfInertia({1, 0, 0, 0, 2, 0, 0, 0, 3.1}), "load_inertia") << "no triangle";
  EXPECT_EQ(FieldOfInertia({1, 0, 0, 0, 1, 0, 0, 0, -0.1}), "load_inertia");
  EXPECT_EQ(FieldOfInertia({1, 1.1, 0, 1.1, 1, 0, 0, 0, 1}), "load_inertia") << "indefinite";
  EXPECT_EQ(FieldOfInertia({0, 1, 0, 1, 0, 0, 0, 0, 0}), "load_inertia") << "products alone";
  EXPECT_EQ(FieldOfInertia({1, 0.1, 0, 0, 1, 0, 0, 0, 1}), "load_inertia") << "not symmetric";
  EXPECT_EQ(FieldOfInertia({1, 0, 0, 0, kNaN, 0, 0, 0, 1}), "load_inertia[4]");
}

TEST(SettingTest, RotatedInertiasStayThoseOfBodiesDespiteRounding) {
  for (int k = 0; k < 1000; ++k) {
    const double c = std::cos(0.37 * k);
    const double s = std::sin(0.37 * k);
    // Of a plate, about z and then about x.
    const double xx = c * c * 1e-3 + s * s * 2e-3;
    const double yy = s * s * 1e-3 + c * c * 2e-3;
    const double xy = c * s * (1e-3 - 2e-3);
    const double zz = 3e-3;
    EXPECT_EQ(
        FieldOfInertia({xx, c * xy, s * xy, c * xy, c * c * yy + s * s * zz, c * s * (yy - zz),
                        s * xy, s * c * (yy - zz), s * s * yy + c * c * zz}),
        "sound")
        << k;
  }
}

TEST(SettingTest, WithoutMassThereIsNoInertia) {
  EXPECT_EQ(FieldOf(setting::Load{}), "sound");
  EXPECT_EQ(FieldOf(setting::Load{.m_load = 0, .F_x_Cload = {0, 0, 0.1}, .I_load = {}}), "sound");
  EXPECT_EQ(
      FieldOf(setting::Load{.m_load = 0, .F_x_Cload = {}, .I_load = {1, 0, 0, 0, 1, 0, 0, 0, 1}}),
      "load_inertia");
}

TEST(SettingTest, AFrameIsNearTheArm) {
  Transform X = kIdentityTransform;
  for (const double far : {1e300, -11.0}) {
    X[14] = far;
    EXPECT_EQ(FieldOf(setting::EndEffectorFrame{X}), "NE_T_EE") << far;
    EXPECT_EQ(FieldOf(setting::StiffnessFrame{X}), "EE_T_K") << far;
  }
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
  EXPECT_EQ(
      text(setting::Load{.m_load = 1, .F_x_Cload = {}, .I_load = {-1, 0, 0, 0, -1, 0, 0, 0, -1}}),
      "load_inertia must be that of a body (symmetric, no principal moment negative or above "
      "the other two together; 0 without a mass)");
  EXPECT_EQ(text(setting::StiffnessFrame{Transform{}}),
            "EE_T_K must be a rigid transform, 4 x 4 column-major, within 10 m");
}

}  // namespace
}  // namespace twin::core_setting_test
