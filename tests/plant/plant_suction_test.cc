#include "plant/suction.h"

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/plant/ideal_plant.h"
#include "twin/plant/observers.h"

namespace twin::plant::plant_suction_test {
namespace {

constexpr double kSide = 0.1;    // of the box, m
constexpr double kRing = 0.018;  // of the cup, m
constexpr double kGravity = 9.81;
constexpr double kCupArea = std::numbers::pi * kRing * kRing;

MujocoPlantOptions PumpOptions() {
  MujocoPlantOptions options = DefaultOptions();
  options.hand = HandKind::kCobotPump;
  return options;
}

Vector3 PositionOf(const MujocoPlant& plant, const std::string& name) {
  const int body = mj_name2id(&plant.model(), mjOBJ_BODY, name.c_str());
  const mjtNum* p = plant.data().xpos + 3 * body;
  return {p[0], p[1], p[2]};
}

Transform At(double x, double y, double z) {
  return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
}

/// The cup's face, which looks down, on a box, which stands on a pedestal that can be taken away.
class SuctionTest : public testing::Test {
 protected:
  /// @param aside  of the box's middle from the cup's, m.
  void Stand(double mass, double aside = 0) {
    MujocoPlantOptions options = PumpOptions();
    const Vector3 face = PositionOf(*MujocoPlant::Create(options), "panda_cup");
    constexpr double kTouch = 2e-4;
    const double top = face[2] + kTouch;
    const double bottom = top - kSide;
    options.objects = {{.name = "box",
                        .size = {kSide, kSide, kSide},
                        .mass = mass,
                        .X_WB = At(face[0] + aside, face[1], top - kSide / 2)},
                       {.name = "pedestal",
                        .size = {0.2, 0.2, bottom},
                        .mass = 50,
                        .X_WB = At(face[0] + aside, face[1], bottom / 2)}};
    plant_ = MujocoPlant::Create(options);
  }
  void StepFor(int steps) {
    for (int k = 0; k < steps; ++k) plant_->Step({.brakes = true});
  }
  void Suck(int steps = 1000) {
    plant_->suction()->Drive({.power = 1, .vents = false});
    StepFor(steps);
  }
  void TakePedestalAway() {
    ASSERT_FALSE(plant_->Place(FreeBodyNamed(plant_->model(), "pedestal"), At(-1, 1, 0.5)));
  }
  [[nodiscard]] double height() const { return PositionOf(*plant_, "box")[2]; }
  [[nodiscard]] double mbar() { return plant_->suction()->sensors().vacuum / 100; }
  /// Sucks, takes the support away and waits. @returns how far the box has sunk, m.
  double Sinks(int steps = 1000) {
    Suck();
    TakePedestalAway();
    const double before = height();
    StepFor(steps);
    return before - height();
  }

  std::unique_ptr<MujocoPlant> plant_;
};

TEST_F(SuctionTest, ItsBodyIsTheOneFrankaDescribes) {
  const auto plant = MujocoPlant::Create(PumpOptions());
  const int body = mj_name2id(&plant->model(), mjOBJ_BODY, "panda_cobot_pump");
  EXPECT_EQ(plant->model().body_mass[body], 1.01);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(plant->model().body_ipos[3 * body + i], i == 2 ? 0.063 : 0, 1e-12);
    EXPECT_NEAR(plant->model().body_inertia[3 * body + i], 0.001, 1e-12);
  }
  EXPECT_EQ(plant->hand(), nullptr);
  EXPECT_EQ(plant->warning_count(), 0u);
  EXPECT_EQ(MujocoPlant::Create(DefaultOptions())->suction(), nullptr);
}

// Q_0 (1 - p / p_max) = C A sqrt(2 p / rho) of a bore of 4 mm.
TEST_F(SuctionTest, AnOpenCupHasHardlyAnyVacuum) {
  plant_ = MujocoPlant::Create(PumpOptions());
  Suck();
  EXPECT_NEAR(mbar(), 4.2, 0.1);
}

// p = p_max (1 - exp(-t / T)), T = V p_max / (p_air Q_0) = 111 ms.
TEST_F(SuctionTest, ASealedCupIsEmptiedAtThePumpsRate) {
  Stand(1);
  const double T = 30e-6 * 75e3 / (101'325 * 0.2e-3);
  plant_->suction()->Drive({.power = 1, .vents = false});
  for (int k = 1; k <= 500; ++k) {
    StepFor(1);
    ASSERT_NEAR(mbar(), 750 * (1 - std::exp(-k * 1e-3 / T)), 4) << k;
  }
}

TEST_F(SuctionTest, TheValveLetsAirInWithinMilliseconds) {
  Stand(1);
  Suck();
  ASSERT_GT(mbar(), 700);
  plant_->suction()->Drive({});
  StepFor(20);
  EXPECT_LT(mbar(), 1);
}

TEST_F(SuctionTest, HoldsAKilogramWithoutCreep) {
  Stand(1);
  EXPECT_NEAR(Sinks(100), 0, 2e-4);
  const double before = height();
  StepFor(5000);
  EXPECT_NEAR(height(), before, 2e-6);
  EXPECT_GT(mbar(), 740);
}

TEST_F(SuctionTest, TheArmCarriesWhatHangsOnIt) {
  Stand(2);
  EXPECT_NEAR(Sinks(), 0, 1e-3);
  const JointVector held = plant_->sensors().tau_J;
  plant_->suction()->Drive({});
  StepFor(500);
  const JointVector alone = plant_->sensors().tau_J;
  // About joint 2, in x behind the cup by its distance from the axis.
  const double lever = PositionOf(*plant_, "panda_cup")[0] - PositionOf(*plant_, "panda_link2")[0];
  EXPECT_NEAR(std::abs(held[1] - alone[1]), 2 * kGravity * lever, 0.02);
}

TEST_F(SuctionTest, DropsTenKilograms) {
  Stand(10);
  ASSERT_LT(75e3 * kCupArea, 10 * kGravity);
  EXPECT_GT(Sinks(), 0.2);
  EXPECT_LT(mbar(), 5);
}

TEST_F(SuctionTest, HoldsUpToVacuumTimesArea) {
  const double most = 75e3 * kCupArea / kGravity;  // 7.8 kg
  Stand(0.96 * most);
  EXPECT_NEAR(Sinks(), 0, 1e-3);
  Stand(1.04 * most);
  EXPECT_GT(Sinks(), 0.2);
}

TEST_F(SuctionTest, WhatGetsTooHeavyFalls) {
  Stand(1);
  ASSERT_NEAR(Sinks(), 0, 2e-4);
  plant_->SetMass(FreeBodyNamed(plant_->model(), "box"), 10);
  const double before = height();
  StepFor(500);
  EXPECT_LT(height(), before - 0.2);
}

TEST_F(SuctionTest, DropsWhatThePumpLetsGo) {
  Stand(1);
  ASSERT_NEAR(Sinks(), 0, 2e-4);
  plant_->suction()->Drive({});
  StepFor(300);
  EXPECT_LT(mbar(), 1);
  EXPECT_LT(height(), 0.3);
}

// The ring is 36 mm wide; with the box's edge under a part of it the cup leaks, and holds nothing.
TEST_F(SuctionTest, LeaksOverAnEdge) {
  Stand(0.5, kSide / 2 - kRing + 0.5e-3);  // the ring just beyond the edge
  Suck();
  EXPECT_LT(mbar(), 400);
  EXPECT_GT(mbar(), 20);
  Stand(0.5, kSide / 2);  // half of it
  Suck();
  EXPECT_LT(mbar(), 20);
  TakePedestalAway();
  StepFor(500);
  EXPECT_LT(height(), 0.3);
}

TEST_F(SuctionTest, HoldsAnyPlaceThatCoversTheCup) {
  Stand(0.3, 0.02);
  EXPECT_NEAR(Sinks(), 0, 1e-3);
}

// An object 0.1 m off its middle tilts about the ring: its weight acts beyond it.
TEST_F(SuctionTest, AFarWeightTiltsOffTheCup) {
  Stand(4, kSide / 2 - kRing - 1e-3);
  ASSERT_GT(4 * kGravity * (kSide / 2 - kRing - 1e-3), (75e3 * kCupArea - 4 * kGravity) * kRing);
  EXPECT_GT(Sinks(), 0.2);
}

TEST_F(SuctionTest, ATableThatItAlmostTouchesPullsTheArm) {
  MujocoPlantOptions options = PumpOptions();
  const Vector3 face = PositionOf(*MujocoPlant::Create(options), "panda_cup");
  options.objects = {{.name = "table",
                      .size = {0.3, 0.3, 0.1},
                      .X_WB = At(face[0], face[1], face[2] - 1e-3 - 0.05)}};
  plant_ = MujocoPlant::Create(options);
  StepFor(10);
  const double before = plant_->sensors().tau_J[1];
  Suck();
  EXPECT_GT(mbar(), 740);
  const double lever = face[0] - PositionOf(*plant_, "panda_link2")[0];
  EXPECT_NEAR(std::abs(plant_->sensors().tau_J[1] - before), 75e3 * kCupArea * lever, 0.1);
}

TEST_F(SuctionTest, SavedAndRestoredItDoesTheSameAgain) {
  Stand(1);
  Suck(150);
  const auto saved = plant_->Save();
  const auto replay = [this] {
    TakePedestalAway();
    std::vector<double> heights;
    for (int k = 0; k < 300; ++k) {
      if (k == 200) plant_->suction()->Drive({});
      StepFor(1);
      heights.push_back(height());
      heights.push_back(mbar());
    }
    return heights;
  };
  const auto first = replay();
  plant_->Restore(*saved);
  plant_->suction()->Drive({.power = 1, .vents = false});
  EXPECT_EQ(replay(), first);
}

TEST_F(SuctionTest, ResetLeavesNoVacuum) {
  Stand(1);
  Suck();
  plant_->Reset(kReady);
  EXPECT_EQ(mbar(), 0);
  StepFor(1000);
  EXPECT_EQ(mbar(), 0) << "the pump rests";
}

TEST_F(SuctionTest, IsForRealTime) {
  Stand(1);
  const test::RealtimeGuard guard;
  Suck();
  plant_->suction()->Drive({});
  StepFor(100);
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
}

TEST(IdealSuctionTest, NeverHasAVacuum) {
  IdealPlant plant({}, HandKind::kCobotPump);
  ASSERT_NE(plant.suction(), nullptr);
  EXPECT_EQ(plant.hand(), nullptr);
  plant.suction()->Drive({.power = 1, .vents = false});
  plant.Step({});
  EXPECT_EQ(plant.suction()->sensors().vacuum, 0);
}

/// A copy of the models' robots, whose pump can be spoilt.
TEST(SuctionSourcesTest, APumpWithoutCupsOrWithTooManyIsRefused) {
  const TemporaryFolder folder;
  std::filesystem::copy(SourceDir() / "models" / "robots", folder.path(),
                        std::filesystem::copy_options::recursive);
  MujocoPlantOptions options = PumpOptions();
  options.urdf = folder.path() / "panda" / "panda.urdf";
  std::string urdf = ReadText(folder.path() / "cobot_pump" / "cobot_pump.urdf");
  for (std::size_t at = 0; (at = urdf.find("\"lip_", at)) != std::string::npos;) {
    urdf.replace(at, 5, "\"rim_");
  }
  folder.Write("cobot_pump/cobot_pump.urdf", urdf);
  EXPECT_THAT(MessageOf<InputError>([&] { (void)MujocoPlant::Create(options); }),
              testing::HasSubstr("0 links have collision shapes named lip...; a vacuum gripper has "
                                 "one to 4 suction cups"));
}

}  // namespace
}  // namespace twin::plant::plant_suction_test
