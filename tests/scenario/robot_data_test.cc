#include "twin/scenario/robot_data.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/file_bytes.h"
#include "plant/joint_parameters.h"
#include "plant/robot_description.h"
#include "twin/core/error.h"
#include "twin/model/mass_properties.h"

namespace twin::scenario::robot_data_test {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::filesystem::path kModels = std::filesystem::path(TWIN_SOURCE_DIR) / "models";

/// A file that is gone when the test is over.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text)
      : path_(std::filesystem::path(::testing::TempDir()) / "robot_data_test_limits.yaml") {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

std::string LimitsText() {
  return plant::ReadFileBytes(kModels / "robots" / "panda" / "limits.yaml", "limits");
}

TEST(RobotDataTest, HasTheLimitsFrankaPublishes) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kFrankaHand);
  EXPECT_EQ(robot.limits.q_max[5], 3.7525);
  EXPECT_EQ(robot.limits.q_min[3], -3.0718);
  EXPECT_EQ(robot.limits.dq_max, (JointVector{2.175, 2.175, 2.175, 2.175, 2.61, 2.61, 2.61}));
  EXPECT_EQ(robot.limits.ddq_max, (JointVector{15, 7.5, 10, 12.5, 15, 20, 20}));
  EXPECT_EQ(robot.limits.dddq_max, (JointVector{7500, 3750, 5000, 6250, 7500, 10000, 10000}));
  EXPECT_EQ(robot.limits.tau_max, (JointVector{87, 87, 87, 87, 12, 12, 12}));
  EXPECT_EQ(robot.limits.dtau_max[6], 1000);
  EXPECT_TRUE(std::filesystem::exists(robot.urdf));
}

TEST(RobotDataTest, HasTheCartesianLimitsFrankaPublishes) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kFrankaHand);
  const auto expect = [](const CartesianBound& bound, double dp, double ddp, double dddp) {
    EXPECT_EQ(bound.dp_max, dp);
    EXPECT_EQ(bound.ddp_max, ddp);
    EXPECT_EQ(bound.dddp_max, dddp);
  };
  expect(robot.cartesian.translation, 1.7, 13, 6500);
  expect(robot.cartesian.rotation, 2.5, 25, 12500);
  expect(robot.cartesian.elbow, 2.175, 10, 5000);
  EXPECT_NO_THROW(robot.cartesian.Validate());
}

TEST(RobotDataTest, GivesIntTheRotorsTheSimulatedDrivesHave) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kNone);
  EXPECT_EQ(robot.rotor_inertia, plant::kArmature);
}

/// An open finger in the axes of the palm. @param side  +1 or -1: which way it opens along y.
model::Payload OpenFinger(const plant::Link& link, double side) {
  const Vector3& p = link.X_PL.p;
  const Vector3& com = link.inertial->com;
  EXPECT_EQ(com, Vector3{}) << "whichever way the finger's frame is turned";
  return {link.inertial->mass, {p[0], p[1] + side * link.q_max, p[2]}, link.inertial->I};
}

TEST(RobotDataTest, SaysOfTheHandWhatItsBodiesHaveWhenItIsOpen) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kFrankaHand);
  const auto file = kModels / "robots" / "hand" / "hand.urdf";
  const auto hand = plant::ParseUrdf(plant::ReadFileBytes(file, "hand"), file.string());
  const plant::Inertial& palm = *hand.Find("panda_hand")->inertial;
  const model::Payload fingers = model::Combine(OpenFinger(*hand.Find("panda_leftfinger"), 1),
                                                OpenFinger(*hand.Find("panda_rightfinger"), -1));
  const model::Payload body = model::Combine({palm.mass, palm.com, palm.I}, fingers);
  // Hand axes are flange axes turned by -45 deg about z.
  const double c = std::sqrt(0.5);
  const Vector3& com = body.F_x_C;
  EXPECT_NEAR(robot.end_effector.m, body.m, 1e-12);
  EXPECT_NEAR(robot.end_effector.F_x_C[0], c * com[0] + c * com[1], 1e-12);
  EXPECT_NEAR(robot.end_effector.F_x_C[1], -c * com[0] + c * com[1], 1e-12);
  EXPECT_NEAR(robot.end_effector.F_x_C[2], com[2], 1e-12);
  // R I R^T with R the turn by -45 deg: the entries of the flange's inertia from the hand's.
  const Matrix3& I = body.I;
  EXPECT_NEAR(robot.end_effector.I[0], (I[0] + I[4]) / 2 + I[1], 1e-12);
  EXPECT_NEAR(robot.end_effector.I[4], (I[0] + I[4]) / 2 - I[1], 1e-12);
  EXPECT_NEAR(robot.end_effector.I[8], I[8], 1e-12);
}

TEST(RobotDataTest, PutsTheNominalEndEffectorBetweenTheFingerTips) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kFrankaHand);
  const double c = std::sqrt(0.5);
  const Transform expected{c, -c, 0, 0, c, c, 0, 0, 0, 0, 1, 0, 0, 0, 0.1034, 1};
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_NEAR(robot.F_T_NE[i], expected[i], 1e-15) << i;
  }
}

TEST(RobotDataTest, HasNoEndEffectorWithoutAHand) {
  const RobotData robot = LoadRobotData(kModels, "panda", plant::HandKind::kNone);
  EXPECT_EQ(robot.end_effector.m, 0);
  EXPECT_EQ(robot.F_T_NE, kIdentityTransform);
}

TEST(RobotDataTest, NamesTheRobotsThereAre) {
  EXPECT_THAT([] { (void)LoadRobotData(kModels, "pandas", plant::HandKind::kNone); },
              ThrowsMessage<InputError>(HasSubstr("\"pandas\" is unknown; ")));
  EXPECT_THAT([] { (void)LoadRobotData(kModels, "pandas", plant::HandKind::kNone); },
              ThrowsMessage<InputError>(HasSubstr(" has: fr3, panda")));
}

TEST(RobotDataTest, RefusesALimitInTheWrongUnit) {
  std::string text = LimitsText();
  text.replace(text.find("unit: rad/s,"), 12, "unit: rad,  ");
  const TemporaryFile file(text);
  EXPECT_THAT(
      [&] { (void)LoadJointLimits(file.path()); },
      ThrowsMessage<InputError>(HasSubstr("joints.dq_max.unit: unit \"rad\" does not fit")));
}

/// The panda's limits with one change, and what the message must say.
void ExpectCartesianRefused(const std::string& from, const std::string& to,
                            const std::string& says) {
  std::string text = LimitsText();
  text.replace(text.find(from), from.size(), to);
  const TemporaryFile file(text);
  EXPECT_THAT([&] { (void)LoadCartesianLimits(file.path()); },
              ThrowsMessage<InputError>(HasSubstr(says)));
}

TEST(RobotDataTest, NamesThePlaceOfABadCartesianLimit) {
  ExpectCartesianRefused("{unit: m/s, value: 1.7}", "{unit: rad/s, value: 1.7}",
                         "robot_data_test_limits.yaml:17: cartesian.translation.dp_max.unit: unit "
                         "\"rad/s\" does not fit a velocity");
  ExpectCartesianRefused("value: 25.0", "value: 0",
                         "robot_data_test_limits.yaml:22: cartesian.rotation.ddp_max.value: 0 is "
                         "out of range");
  ExpectCartesianRefused("value: 5000.0", "value: -5000", "cartesian.elbow.dddp_max.value: -5000");
  ExpectCartesianRefused("value: 5000.0", "value: .inf", "is not a plain finite number");
  ExpectCartesianRefused(
      "  elbow:", "  elbows:", "unknown key \"elbows\"; did you mean \"elbow\"?");
  ExpectCartesianRefused("cartesian:", "joints2:", "unknown key \"joints2\"");
}

TEST(RobotDataTest, NeedsTheCartesianLimits) {
  const std::string text = LimitsText();
  const TemporaryFile file(text.substr(0, text.find("cartesian:")));
  EXPECT_THAT([&] { (void)LoadCartesianLimits(file.path()); },
              ThrowsMessage<InputError>(HasSubstr("key \"cartesian\" is missing")));
  EXPECT_NO_THROW((void)LoadJointLimits(file.path()));
}

TEST(RobotDataTest, RefusesARangeThatIsUpsideDown) {
  std::string text = LimitsText();
  text.replace(text.find("-1.7628"), 7, "+1.9628");
  const TemporaryFile file(text);
  EXPECT_THAT([&] { (void)LoadJointLimits(file.path()); },
              ThrowsMessage<InputError>(HasSubstr("q_min must be below q_max")));
}

}  // namespace
}  // namespace twin::scenario::robot_data_test
