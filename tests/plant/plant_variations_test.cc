#include <array>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/model/arm_model.h"

namespace twin::plant::plant_variations_test {
namespace {

using MassMatrix = std::array<mjtNum, kJoints * kJoints>;

JointVector SomePose(std::uint64_t k) {
  const Random random(7, RandomStream::kTest);
  JointVector q = kReady;
  for (std::uint32_t i = 0; i < kJoints; ++i) q[i] += 1.2 * (random.Uniform(k, i) - 0.5);
  return q;
}

MassMatrix MassMatrixAt(const JointVector& q, const MujocoPlantOptions& options) {
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(q);
  MassMatrix M{};
  mj_fullM(&plant->model(), M.data(), plant->data().qM);
  return M;
}

TEST(PlantVariationsTest, AScaledArmWeighsAndResistsByTheScale) {
  MujocoPlantOptions options = BareOptions();
  const auto light = MujocoPlant::Create(options);
  const MassMatrix M = MassMatrixAt(SomePose(1), options);
  options.mass_scale = 1.05;
  const auto heavy = MujocoPlant::Create(options);
  const MassMatrix M_heavy = MassMatrixAt(SomePose(1), options);
  const JointVector g = light->GravityTorque(SomePose(1));
  const JointVector g_heavy = heavy->GravityTorque(SomePose(1));
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_NEAR(g_heavy[i], 1.05 * g[i], 1e-9) << i;
  for (std::size_t i = 0; i < M.size(); ++i) EXPECT_NEAR(M_heavy[i], 1.05 * M[i], 1e-9) << i;
}

TEST(PlantVariationsTest, TheHandIsScaledAndTheLoadIsNot) {
  MujocoPlantOptions options = DefaultOptions();
  options.load.m_load = 1;
  const auto mass = [&options] {
    const auto plant = MujocoPlant::Create(options);
    return mj_getTotalmass(&plant->model());
  };
  const double before = mass();
  options.mass_scale = 2;
  EXPECT_NEAR(mass() - 1, 2 * (before - 1), 1e-9);
}

// Against our own model of the arm, which takes any direction of gravity.
TEST(PlantVariationsTest, ALeaningBaseBearsItsShareOfGravity) {
  MujocoPlantOptions options = BareOptions();
  const auto level = MujocoPlant::Create(options);
  options.base_tilt = {.roll = 0.03, .pitch = -0.05};
  const auto leaning = MujocoPlant::Create(options);
  // "Down" in a base that is first rolled about x, then pitched about the level y.
  const double down_after_pitch_x = -std::sin(0.05) * 9.81;
  const double down_after_pitch_z = -std::cos(0.05) * 9.81;
  const Vector3 g_leaning{down_after_pitch_x, std::sin(0.03) * down_after_pitch_z,
                          std::cos(0.03) * down_after_pitch_z};
  const model::ArmModel& arm = model::ArmModel::Panda();
  for (std::uint64_t k = 0; k < 20; ++k) {
    const JointVector q = SomePose(k);
    const JointVector g = level->GravityTorque(q);
    const JointVector g_tilted = leaning->GravityTorque(q);
    const JointVector expected = arm.Gravity(q, {}, g_leaning);
    const JointVector expected_level = arm.Gravity(q, {});
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(g_tilted[i] - g[i], expected[i] - expected_level[i], 1e-6) << i;
    }
    EXPECT_GT(std::abs(g_tilted[0]), 1e-3) << "level, the first joint bears nothing";
  }
}

TEST(PlantVariationsTest, RotorsOfThisArmTakeThePlaceOfTheDrives) {
  MujocoPlantOptions options = BareOptions();
  const MassMatrix M = MassMatrixAt(SomePose(1), options);
  options.armature = true;
  options.arm.armature = JointVector{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7};
  const MassMatrix M_rotors = MassMatrixAt(SomePose(1), options);
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(M_rotors[8 * i] - M[8 * i], (*options.arm.armature)[i], 1e-12);
  }
  options.armature = false;
  EXPECT_EQ(MassMatrixAt(SomePose(1), options), M);
  options.armature = true;
  (*options.arm.armature)[6] = -0.1;
  EXPECT_NE(MessageOf<InputError>([&] {
              (void)MujocoPlant::Create(options);
            }).find("armature of joint 7"),
            std::string::npos);
}

TEST(PlantVariationsTest, EachJointHasItsStiffness) {
  MujocoPlantOptions options = BareOptions();
  options.elasticity = ElasticityProfile::kStatic;
  options.arm.stiffness[1] = 2000;
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(SomePose(2));
  const JointSensors& sensors = plant->sensors();
  EXPECT_NEAR(sensors.theta[1] - sensors.q[1], sensors.tau_J[1] / 2000, 1e-15);
  EXPECT_NEAR(sensors.theta[3] - sensors.q[3], sensors.tau_J[3] / 14250, 1e-15);
}

/// tau_J after each of 60 steps.
std::vector<JointVector> Torques(MujocoPlant& plant) {
  std::vector<JointVector> torques;
  for (int k = 0; k < 60; ++k) {
    plant.Step({.tau = {std::sin(0.3 * k), 0, 0, 10, 0, 0, 0.01 * k}});
    torques.push_back(plant.sensors().tau_J);
  }
  return torques;
}

TEST(PlantVariationsTest, TorqueSensorsAreLate) {
  MujocoPlantOptions options = DefaultOptions();
  const auto prompt = MujocoPlant::Create(options);
  options.arm.torque_delay = std::chrono::microseconds(2300);
  const auto late = MujocoPlant::Create(options);
  prompt->Reset(kReady);
  late->Reset(kReady);
  EXPECT_EQ(late->sensors().tau_J, prompt->sensors().tau_J);
  const std::vector<JointVector> now = Torques(*prompt);
  const std::vector<JointVector> then = Torques(*late);
  EXPECT_EQ(late->sensors().q, prompt->sensors().q);
  EXPECT_EQ(late->sensors().theta, prompt->sensors().theta);
  for (std::size_t k = 3; k < now.size(); ++k) {
    for (std::size_t i = 0; i < kJoints; ++i) {
      EXPECT_NEAR(then[k][i], 0.7 * now[k - 2][i] + 0.3 * now[k - 3][i], 1e-12) << k;
    }
  }
}

TEST(PlantVariationsTest, ASnapshotHoldsTheLateTorques) {
  MujocoPlantOptions options = DefaultOptions();
  options.arm.torque_delay = kLongestTorqueDelay;
  const auto plant = MujocoPlant::Create(options);
  plant->Reset(kReady);
  (void)Torques(*plant);
  const auto saved = plant->Save();
  const std::vector<JointVector> first = Torques(*plant);
  plant->Restore(*saved);
  EXPECT_EQ(Torques(*plant), first);
  EXPECT_NE(first[0], first[1]);
}

/// The URDF's links, from the compiled model.
std::vector<setting::Load> OwnLinks(const MujocoPlantOptions& options) {
  const auto plant = MujocoPlant::Create(options);
  const mjModel& model = plant->model();
  std::vector<setting::Load> links;
  for (std::size_t i = 1; i <= kJoints; ++i) {
    const int body = mj_name2id(&model, mjOBJ_BODY, ("panda_link" + std::to_string(i)).c_str());
    setting::Load& link = links.emplace_back();
    link.m_load = model.body_mass[body];
    std::array<mjtNum, 9> R{};  // by rows
    mju_quat2Mat(R.data(), model.body_iquat + 4 * body);
    for (std::size_t r = 0; r < 3; ++r) {
      link.F_x_Cload[r] = model.body_ipos[3 * body + r];
      for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t k = 0; k < 3; ++k) {
          link.I_load[3 * c + r] += R[3 * r + k] * model.body_inertia[3 * body + k] * R[3 * c + k];
        }
      }
    }
  }
  return links;
}

TEST(PlantVariationsTest, LinksOfThisArmTakeThePlaceOfTheUrdfs) {
  MujocoPlantOptions options = BareOptions();
  const MassMatrix M = MassMatrixAt(SomePose(1), options);
  const JointVector g = MujocoPlant::Create(options)->GravityTorque(SomePose(1));
  options.arm.links = OwnLinks(options);
  // The engine finds principal axes to some 5e-7, which the links read back from it show, too.
  EXPECT_NEAR(options.arm.links[0].I_load[0], 0.70337, 1e-6);
  EXPECT_NEAR(options.arm.links[0].I_load[7], 0.019169, 1e-6);
  const MassMatrix M_same = MassMatrixAt(SomePose(1), options);
  for (std::size_t i = 0; i < M.size(); ++i) EXPECT_NEAR(M_same[i], M[i], 1e-6) << i;
  for (double& I : options.arm.links[6].I_load) I *= 1.5;
  options.arm.links[6].m_load *= 1.5;
  const MassMatrix M_heavy = MassMatrixAt(SomePose(1), options);
  EXPECT_NEAR(M_heavy[48], 1.5 * M[48], 1e-6);
  EXPECT_GT(std::abs(MujocoPlant::Create(options)->GravityTorque(SomePose(1))[3] - g[3]), 0.1);
}

TEST(PlantVariationsTest, LinksThatNoBodyHasAreRefused) {
  MujocoPlantOptions options = BareOptions();
  const std::vector<setting::Load> links = OwnLinks(options);
  const auto refusal = [&] {
    return MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); });
  };
  options.arm.links = {links[0]};
  EXPECT_EQ(refusal(), "links: 1 of them; give all 7, or none");
  options.arm.links = links;
  options.arm.links[2].m_load = 0;
  options.arm.links[2].I_load = {};
  EXPECT_EQ(refusal(), "links[3]: a link has a mass; give one above 0");
  options.arm.links = links;
  options.arm.links[4].I_load[0] = 9;
  EXPECT_NE(refusal().find("links[5]: "), std::string::npos);
}

}  // namespace
}  // namespace twin::plant::plant_variations_test
