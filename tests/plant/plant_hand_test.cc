#include <array>
#include <cmath>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>
#include <Eigen/Dense>

#include "plant/hand_joints.h"
#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"
#include "twin/plant/ideal_plant.h"

namespace twin::plant::plant_hand_test {
namespace {

constexpr std::array<const char*, 3> kHandBodies{"panda_hand", "panda_leftfinger",
                                                 "panda_rightfinger"};

/// What Franka gives of the whole hand, in flange axes.
constexpr model::Payload kWholeHand{
    .m = 0.73, .F_x_C = {-0.01, 0, 0.03}, .I = {0.001, 0, 0, 0, 0.0025, 0, 0, 0, 0.0017}};

using Row3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

int BodyId(const MujocoPlant& plant, const char* name) {
  return mj_name2id(&plant.model(), mjOBJ_BODY, name);
}

double FingerPosition(const MujocoPlant& plant, const char* joint) {
  const int id = mj_name2id(&plant.model(), mjOBJ_JOINT, joint);
  return plant.data().qpos[plant.model().jnt_qposadr[id]];
}

/// Hand and fingers as one body, in flange axes, as the plant's data has them.
model::Payload Measured(const MujocoPlant& plant) {
  const mjModel& model = plant.model();
  const mjData& data = plant.data();
  model::Payload whole;
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  for (const char* name : kHandBodies) {
    const int id = BodyId(plant, name);
    whole.m += model.body_mass[id];
    moment += model.body_mass[id] * Eigen::Map<const Eigen::Vector3d>(data.xipos + 3 * id);
  }
  const Eigen::Vector3d centre = moment / whole.m;
  Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
  for (const char* name : kHandBodies) {
    const int id = BodyId(plant, name);
    const Row3 R = Eigen::Map<const Row3>(data.ximat + 9 * id);
    const Eigen::Vector3d d = Eigen::Map<const Eigen::Vector3d>(data.xipos + 3 * id) - centre;
    const Eigen::Vector3d own = Eigen::Map<const Eigen::Vector3d>(model.body_inertia + 3 * id);
    I += R * own.asDiagonal() * R.transpose();
    I += model.body_mass[id] * (d.squaredNorm() * Eigen::Matrix3d::Identity() - d * d.transpose());
  }
  const int flange = BodyId(plant, "panda_link8");
  const Row3 R_F = Eigen::Map<const Row3>(data.xmat + 9 * flange);
  const Eigen::Vector3d p_F = Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * flange);
  Eigen::Map<Eigen::Vector3d>(whole.F_x_C.data()) = R_F.transpose() * (centre - p_F);
  Eigen::Map<Eigen::Matrix3d>(whole.I.data()) = R_F.transpose() * I * R_F;
  return whole;
}

/// Drives the fingers for so many steps, the arm's brakes closed.
void DriveFor(MujocoPlant& plant, double force, int steps) {
  plant.hand()->Drive({.force = force, .width_d = 0});
  for (int k = 0; k < steps; ++k) plant.Step({.brakes = true});
}

// The engine finds a body's principal axes to 1e-6.
TEST(PlantHandTest, OpenItIsTheBodyFrankaDescribes) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  const model::Payload hand = Measured(*plant);
  EXPECT_NEAR(hand.m, kWholeHand.m, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(hand.F_x_C[i], kWholeHand.F_x_C[i], 1e-12) << i;
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(hand.I[i], kWholeHand.I[i], 5e-9) << i;
}

// Closed, two fingers of 15 g are 4 cm nearer to the middle: 4.8e-5 kg m^2 less across their way.
TEST(PlantHandTest, ClosingLeavesMassAndCentreOfMassWhereTheyAre) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  DriveFor(*plant, -20, 1000);
  ASSERT_LT(plant->hand()->sensors().width, 1e-4);
  const model::Payload hand = Measured(*plant);
  EXPECT_NEAR(hand.m, kWholeHand.m, 1e-12);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(hand.F_x_C[i], kWholeHand.F_x_C[i], 1e-6) << i;
  EXPECT_NEAR(hand.I[8], kWholeHand.I[8] - 4.8e-5, 1e-7);
}

TEST(PlantHandTest, GravityOfArmAndHandIsThatOfTheModelWithItsPayload) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  const Random random(7, RandomStream::kTest);
  for (std::uint64_t pose = 0; pose < 100; ++pose) {
    JointVector q{};
    for (std::uint32_t i = 0; i < kJoints; ++i) {
      const double low = plant->model().jnt_range[2 * i];
      q[i] = low + (plant->model().jnt_range[2 * i + 1] - low) * random.Uniform(pose, i);
    }
    const JointVector expected = model::ArmModel::PandaPlant().Gravity(q, kWholeHand);
    const JointVector compiled = plant->GravityTorque(q);
    plant->Reset(q);
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(compiled[i], expected[i], 1e-9) << "pose " << pose << " joint " << i + 1;
      EXPECT_NEAR(plant->sensors().tau_J[i], expected[i], 1e-9);
    }
  }
}

TEST(PlantHandTest, ThereIsNoneWithoutOne) {
  EXPECT_EQ(MujocoPlant::Create(BareOptions())->hand(), nullptr);
  EXPECT_EQ(IdealPlant().hand(), nullptr);
}

TEST(PlantHandTest, ResetOpensItAndStopsItsDrive) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  DriveFor(*plant, -20, 300);
  plant->Reset(kReady);
  EXPECT_EQ(plant->hand()->sensors().width, 0.08);
  EXPECT_EQ(plant->hand()->sensors().dwidth, 0);
  EXPECT_EQ(plant->hand()->sensors().force, 0);
  for (int k = 0; k < 200; ++k) plant->Step({.brakes = true});
  EXPECT_NEAR(plant->hand()->sensors().width, 0.08, 1e-5);
}

TEST(PlantHandTest, FingersStayInTheirRange) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  for (const double force : {-3.0, -140.0, 3.0, 140.0}) {
    plant->hand()->Drive({.force = force, .width_d = 0});
    for (int k = 0; k < 1000; ++k) {
      plant->Step({.brakes = true});
      ASSERT_GT(plant->hand()->sensors().width, -1e-3);
      ASSERT_LT(plant->hand()->sensors().width, 0.081);
    }
    EXPECT_NEAR(plant->hand()->sensors().width, force > 0 ? 0.08 : 0,
                1e-6 * std::abs(force) + 4e-6);
    EXPECT_NEAR(plant->hand()->sensors().dwidth, 0, 1e-9);
    EXPECT_NEAR(plant->hand()->sensors().force, force, 1e-6 * std::abs(force));
  }
}

// (m + m_drive) ddx = f - D dx, D = 10 N s/m, from rest; the arm points the hand straight down, so
// gravity does not move the fingers. The drive's own part is what its sensor does not show.
TEST(PlantHandTest, FreeFingersObeyTheirEquationOfMotion) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->Reset(kReady);
  const double m = 0.015 + kFingerInertia;
  const double D = 10;
  DriveFor(*plant, -2, 200);
  const double t = 0.2;
  const double dx = -2 / D * (1 - std::exp(-D / m * t));
  const double x = 0.04 - 2 / D * (t - m / D * (1 - std::exp(-D / m * t)));
  EXPECT_NEAR(plant->hand()->sensors().dwidth, 2 * dx, 0.01 * std::abs(2 * dx));
  EXPECT_NEAR(plant->hand()->sensors().width, 2 * x, 0.02 * (0.08 - 2 * x));
  const double ddx = -2 / m * std::exp(-D / m * t);
  EXPECT_NEAR(plant->hand()->sensors().force, 0.015 * ddx, 5e-4);
}

TEST(PlantHandTest, FingersMoveAsOneWhileTheArmIsThrown) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->hand()->Drive({.force = -1, .width_d = 0});
  double apart = 0;
  for (int k = 0; k < 600; ++k) {
    JointVector tau = plant->GravityTorque(plant->sensors().q);
    tau[0] += k % 200 < 100 ? 40 : -40;
    tau[6] += k % 100 < 50 ? 8 : -8;
    plant->Step({.tau = tau});
    apart = std::max(apart, std::abs(FingerPosition(*plant, "panda_finger_joint1") -
                                     FingerPosition(*plant, "panda_finger_joint2")));
  }
  EXPECT_LT(apart, 1e-5);
}

TEST(PlantHandTest, FreeArmHasNoConstraintsToSolve) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  plant->hand()->Drive({.force = -1, .width_d = 0});
  for (int k = 0; k < 200; ++k) {
    plant->Step({.tau = plant->GravityTorque(plant->sensors().q)});
    ASSERT_EQ(plant->data().nefc, 0);
  }
}

/// Sum of the contact forces normal to one finger's pads, N.
double NormalForce(const MujocoPlant& plant, const char* finger) {
  const int body = BodyId(plant, finger);
  double sum = 0;
  for (int c = 0; c < plant.data().ncon; ++c) {
    const mjContact& contact = plant.data().contact[c];
    if (plant.model().geom_bodyid[contact.geom1] != body &&
        plant.model().geom_bodyid[contact.geom2] != body) {
      continue;
    }
    mjtNum wrench[6];
    mj_contactForce(&plant.model(), &plant.data(), c, wrench);
    sum += wrench[0];
  }
  return sum;
}

class PlantHandForceTest : public testing::TestWithParam<double> {};

// A block that is fixed in the world, 50 mm wide, between the fingers at the ready pose.
TEST_P(PlantHandForceTest, EachFingerPressesWithTheDrivesForce) {
  const double force = GetParam();
  const TemporaryFolder folder;
  MujocoPlantOptions options = DefaultOptions();
  options.scene = folder.Write(
      "scene.xml",
      "<mujoco><worldbody><geom type='box' pos='0.3069 0 0.4869' size='0.025 0.025 0.025'/>"
      "</worldbody></mujoco>");
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  DriveFor(*plant, -force, 2000);
  EXPECT_NEAR(NormalForce(*plant, "panda_leftfinger"), force, 0.02 * force);
  EXPECT_NEAR(NormalForce(*plant, "panda_rightfinger"), force, 0.02 * force);
  EXPECT_NEAR(plant->hand()->sensors().force, -force, 0.01 * force);
  EXPECT_NEAR(plant->hand()->sensors().width, 0.05, 2e-4);
  EXPECT_NEAR(plant->hand()->sensors().dwidth, 0, 1e-6);
  EXPECT_EQ(plant->warning_count(), 0u) << plant->DescribeWarnings();
}

INSTANTIATE_TEST_SUITE_P(Forces, PlantHandForceTest, testing::Values(5.0, 20.0, 70.0, 140.0));

TEST(PlantHandTest, WorksWithoutAllocationOrLock) {
  const auto plant = MujocoPlant::Create(DefaultOptions());
  const JointDrive drive{.tau = plant->GravityTorque(kReady)};
  const test::RealtimeGuard guard;
  for (int k = 0; k < 1000; ++k) {
    plant->hand()->Drive({.force = k < 500 ? -20.0 : 20.0, .width_d = 0});
    plant->Step(drive);
  }
  const test::RealtimeGuard::Counts counts = guard.counts();
  EXPECT_EQ(counts, test::RealtimeGuard::Counts{});
}

TEST(PlantHandTest, SameDriveGivesTheSameMotion) {
  const auto run = [] {
    const auto plant = MujocoPlant::Create(DefaultOptions());
    DriveFor(*plant, -20, 700);
    return plant->hand()->sensors().width;
  };
  EXPECT_EQ(run(), run());
}

/// The message about a hand.urdf in which `from` is `to`.
std::string RefusalOfHand(const std::string& from, const std::string& to) {
  const TemporaryFolder folder;
  const auto robots = SourceDir() / "models" / "robots";
  std::string text = ReadText(robots / "hand" / "hand.urdf");
  text.replace(text.find(from), from.size(), to);
  folder.Write("hand/hand.urdf", text);
  folder.Write("hand/primitives.yaml", ReadText(robots / "hand" / "primitives.yaml"));
  folder.Write("panda/primitives.yaml", ReadText(robots / "panda" / "primitives.yaml"));
  MujocoPlantOptions options = DefaultOptions();
  options.urdf = folder.Write("panda/panda.urdf", ReadText(options.urdf));
  return MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); });
}

TEST(PlantHandTest, NamesWhatIsWrongWithAHand) {
  EXPECT_THAT(RefusalOfHand("<mimic joint=\"panda_finger_joint1\"/>", ""),
              testing::HasSubstr("with a <mimic> of the first"));
  EXPECT_THAT(RefusalOfHand("joint1\"/>", "joint1\" multiplier=\"2\"/>"),
              testing::HasSubstr("multiplier 2"));
  EXPECT_THAT(RefusalOfHand("\"panda_finger_joint1\" type=\"prismatic\"",
                            "\"panda_finger_joint1\" type=\"fixed\""),
              testing::HasSubstr("hand.urdf"));
  EXPECT_THAT(RefusalOfHand("lower=\"0\" upper=\"0.04\"", "lower=\"0.04\" upper=\"0.04\""),
              testing::HasSubstr("the range [0.04, 0.04] m"));
}

TEST(IdealHandTest, DoesWhatIsDesiredBetweenItsStops) {
  IdealHand hand;
  EXPECT_EQ(hand.sensors().width, 0.08);
  hand.Drive({.force = -10, .width_d = 0.079});
  hand.Step();
  EXPECT_EQ(hand.sensors().width, 0.079);
  EXPECT_NEAR(hand.sensors().dwidth, -1, 1e-9);
  EXPECT_EQ(hand.sensors().force, 0);
  hand.Drive({.force = -10, .width_d = -0.01});
  hand.Step();
  EXPECT_EQ(hand.sensors().width, 0);
  EXPECT_EQ(hand.sensors().force, -10);
  hand.Drive({.force = 7, .width_d = 0.1});
  hand.Step();
  EXPECT_EQ(hand.sensors().width, 0.08);
  EXPECT_EQ(hand.sensors().force, 7);
}

TEST(IdealHandTest, MovesWithItsPlant) {
  IdealPlant plant(kWholeHand, HandKind::kFrankaHand);
  plant.Reset(kReady);
  ASSERT_NE(plant.hand(), nullptr);
  plant.hand()->Drive({.force = 0, .width_d = 0.05});
  EXPECT_EQ(plant.hand()->sensors().width, 0.08);
  plant.Step({.q_d = kReady});
  EXPECT_EQ(plant.hand()->sensors().width, 0.05);
  plant.Reset(kReady);
  EXPECT_EQ(plant.hand()->sensors().width, 0.08);
}

}  // namespace
}  // namespace twin::plant::plant_hand_test
