#include "twin/plant/shared_model.h"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/plant/contact_watch.h"

namespace twin::plant::plant_shared_model_test {
namespace {

using testing::HasSubstr;

MujocoPlantOptions ArmAt(const std::string& name, double x, double yaw = 0) {
  MujocoPlantOptions options = DefaultOptions();
  options.prefix = name + "/";
  options.pose = {.position = {x, 0, 0}, .yaw = yaw};
  return options;
}

/// Two arms on one thread without turns of their own: the first one's drive is set, then the
/// second one's step takes both.
struct Pair {
  explicit Pair(const std::vector<MujocoPlantOptions>& arms)
      : shared(SharedModel::Create(arms, [this] { second->Step(second_drive); })),
        first(shared->Take(arms[0].prefix)),
        second(shared->Take(arms[1].prefix)) {
    first->Reset(kReady);
    second->Reset(kReady);
  }
  void Step(const JointDrive& drive, const JointDrive& other) {
    second_drive = other;
    first->Step(drive);
  }

  JointDrive second_drive;
  std::shared_ptr<SharedModel> shared;
  std::unique_ptr<MujocoPlant> first;
  std::unique_ptr<MujocoPlant> second;
};

JointDrive Braked() {
  JointDrive drive;
  drive.brakes = true;
  return drive;
}

TEST(SharedModelTest, HasEachArmUnderItsPrefix) {
  const Pair pair({ArmAt("left", 0), ArmAt("right", 1)});
  const mjModel& model = pair.first->model();
  EXPECT_EQ(&model, &pair.second->model());
  for (const char* body : {"left/panda_link0", "left/panda_hand", "right/panda_link7"}) {
    EXPECT_GT(mj_name2id(&model, mjOBJ_BODY, body), 0) << body;
  }
  EXPECT_EQ(pair.first->prefix(), "left/");
  // Two arms with two fingers each, of which each plant shows its own.
  EXPECT_EQ(model.nq, 18);
  EXPECT_EQ(pair.first->qpos_size(), 9U);
}

TEST(SharedModelTest, PutsEachBaseWhereItsPoseSays) {
  const Pair pair({ArmAt("left", 0.3), ArmAt("right", -1, std::acos(-1) / 2)});
  const mjModel& model = pair.first->model();
  const mjData& data = pair.first->data();
  const int left = mj_name2id(&model, mjOBJ_BODY, "left/panda_link0");
  const int right = mj_name2id(&model, mjOBJ_BODY, "right/panda_link0");
  EXPECT_DOUBLE_EQ(data.xpos[3 * left], 0.3);
  EXPECT_DOUBLE_EQ(data.xpos[3 * right], -1);
  EXPECT_NEAR(data.xmat[9 * right + 3], 1, 1e-15);  // its x axis is the world's y
}

TEST(SharedModelTest, MovesTheArmsAsEachAloneDoes) {
  Pair pair({ArmAt("left", 0), ArmAt("right", 5)});
  MujocoPlantOptions alone = ArmAt("", 0);
  alone.prefix.clear();
  const auto single = MujocoPlant::Create(alone);
  single->Reset(kReady);
  JointDrive drive;
  drive.tau = single->GravityTorque(kReady);
  drive.tau[3] += 2;
  for (int k = 0; k < 500; ++k) {
    single->Step(drive);
    pair.Step(drive, Braked());
  }
  // No constraint acts on either but the brakes, which are the other's: the engine's solver, common
  // to both, leaves its tolerance.
  for (std::size_t i = 0; i < kJoints; ++i) {
    EXPECT_NEAR(pair.first->sensors().q[i], single->sensors().q[i], 1e-9);
    EXPECT_NEAR(pair.second->sensors().q[i], kReady[i], 1e-6);
  }
  EXPECT_GT(std::abs(single->sensors().q[3] - kReady[3]), 0.01);
}

TEST(SharedModelTest, LetsTheArmsTouchEachOther) {
  // Wrist to wrist, a centimetre apart: the first pushes on.
  Pair pair({ArmAt("left", 0), ArmAt("right", 0.72, std::acos(-1))});
  ContactWatch watch(*pair.first);
  JointDrive drive;
  for (int k = 0; k < 500 && watch.cycles() == 0; ++k) {
    drive.tau = pair.first->GravityTorque(pair.first->sensors().q);
    drive.tau[1] += 10;
    pair.Step(drive, Braked());
    watch.Look(Time(pair.first->plant_time()));
  }
  ASSERT_GT(watch.cycles(), 0U);
  for (int k = 0; k < 20; ++k) {
    pair.Step(drive, Braked());
    watch.Look(Time(pair.first->plant_time()));
  }
  watch.Keep(Time(pair.first->plant_time()));
  const std::vector<ContactPair> pairs = watch.Pairs();
  EXPECT_THAT(pairs.front().a, testing::StartsWith("left/"));
  EXPECT_THAT(pairs.front().b, testing::StartsWith("right/"));
  EXPECT_GT(watch.Moments().front().contacts.front().force, 1) << watch.Moments().front().Text();
}

TEST(SharedModelTest, StepsOnceAllHaveDriven) {
  int asked = 0;
  std::vector<MujocoPlantOptions> arms{ArmAt("left", 0), ArmAt("right", 2)};
  std::unique_ptr<MujocoPlant> second;
  const auto shared = SharedModel::Create(arms, [&] {
    ++asked;
    second->Step(Braked());
  });
  const auto first = shared->Take("left/");
  second = shared->Take("right/");
  first->Step(Braked());
  EXPECT_EQ(asked, 1);
  EXPECT_EQ(first->plant_time(), kCycle);
}

TEST(SharedModelTest, HoldsAnArmThatIsGoneByItsBrakes) {
  const std::vector<MujocoPlantOptions> arms{ArmAt("left", 0), ArmAt("right", 2)};
  const auto shared = SharedModel::Create(arms, [] { FAIL() << "nobody is to be waited for"; });
  const auto first = shared->Take("left/");
  auto second = shared->Take("right/");
  second->Reset(kReady);
  const mjModel& model = first->model();
  const int elbow = model.jnt_qposadr[mj_name2id(&model, mjOBJ_JOINT, "right/panda_joint4")];
  second.reset();
  for (int k = 0; k < 500; ++k) first->Step(Braked());
  EXPECT_NEAR(first->data().qpos[elbow], kReady[3], 1e-5);
}

TEST(SharedModelTest, DoesNotAwaitAnArmOfWhichThePlantWillNotBeTaken) {
  const auto shared = SharedModel::Create(std::vector{ArmAt("left", 0), ArmAt("right", 1)},
                                          [] { FAIL() << "there is nobody to wait for"; });
  const auto left = shared->Take("left/");
  left->Reset(kReady);
  shared->Forgo("right/");
  shared->Forgo("left/");  // is taken
  left->Step(Braked());
  EXPECT_EQ(left->plant_time(), kCycle);
  EXPECT_THROW(static_cast<void>(shared->Take("right/")), InputError);
}

TEST(SharedModelTest, AwaitsArmsUntilAllStandBy) {
  const Pair pair({ArmAt("left", 0), ArmAt("right", 2)});
  pair.first->StandBy();
  EXPECT_TRUE(pair.first->is_awaited());
  pair.second->StandBy();
  EXPECT_FALSE(pair.first->is_awaited());
}

TEST(SharedModelTest, SetsBackOneArmAlone) {
  Pair pair({ArmAt("left", 0), ArmAt("right", 2)});
  for (int k = 0; k < 100; ++k) pair.Step(JointDrive{}, JointDrive{});
  const JointVector fallen = pair.second->sensors().q;
  ASSERT_GT(std::abs(fallen[1] - kReady[1]), 1e-3);
  pair.first->Reset(kReady);
  EXPECT_EQ(pair.first->sensors().q, kReady);
  EXPECT_EQ(pair.first->sensors().dq, JointVector{});
  EXPECT_EQ(pair.second->sensors().q, fallen);
}

TEST(SharedModelTest, PushesTheArmOfWhichAForceSpeaks) {
  std::vector<MujocoPlantOptions> arms{ArmAt("left", 0), ArmAt("right", 2)};
  arms[1].perturbations.push_back(Push{.body = "panda_link4", .begin = {}, .force = {0, 100, 0}});
  Pair pair(arms);
  JointDrive drive;
  drive.tau = pair.first->GravityTorque(kReady);
  for (int k = 0; k < 200; ++k) pair.Step(drive, drive);
  EXPECT_LT(std::abs(pair.first->sensors().q[0] - kReady[0]), 1e-3);
  EXPECT_GT(std::abs(pair.second->sensors().q[0] - kReady[0]), 1e-2);
}

TEST(SharedModelTest, StepsWithoutAllocationOrLock) {
  Pair pair({ArmAt("left", 0), ArmAt("right", 0.8)});
  const test::RealtimeGuard guard;
  for (int k = 0; k < 500; ++k) pair.Step(JointDrive{}, JointDrive{});  // they fall, and touch
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts());
  EXPECT_EQ(pair.first->warning_count(), 0U) << pair.first->DescribeWarnings();
}

TEST(SharedModelTest, RefusesOnePrefixTwiceAndAnArmTwice) {
  const std::vector<MujocoPlantOptions> twice{ArmAt("left", 0), ArmAt("left", 2)};
  EXPECT_THROW(static_cast<void>(SharedModel::Create(twice, {})), InputError);
  const std::vector<MujocoPlantOptions> arms{ArmAt("left", 0), ArmAt("right", 2)};
  const auto shared = SharedModel::Create(arms, {});
  const auto left = shared->Take("left/");
  EXPECT_THROW((void)shared->Take("left/"), InputError);
  EXPECT_THROW((void)shared->Take("middle/"), InputError);
}

TEST(SharedModelTest, FindsArmsThatOverlap) {
  const std::vector<JointVector> ready{kReady, kReady};
  const std::vector<MujocoPlantOptions> apart{ArmAt("left", 0), ArmAt("right", 1.5)};
  EXPECT_FALSE(ArmsOverlap(apart, ready).has_value());
  const std::vector<MujocoPlantOptions> near{ArmAt("left", 0), ArmAt("right", 0.3)};
  const auto overlap = ArmsOverlap(near, ready);
  ASSERT_TRUE(overlap.has_value());
  EXPECT_THAT(overlap->part, testing::StartsWith("left/"));
  EXPECT_THAT(overlap->other, testing::StartsWith("right/"));
}

TEST(SharedModelTest, BoundsTheReachOfAnArm) {
  MujocoPlantOptions options = ArmAt("", 2);
  options.prefix.clear();
  const Reach reach = ReachOf(options);
  EXPECT_NEAR(reach.p_W[0], 2, 1e-12);
  EXPECT_NEAR(reach.p_W[2], 0.333, 1e-12);  // joint 2
  // The flange's 0.855 m of the data sheet and the hand's 0.1 m to 0.2 m lie within.
  EXPECT_GT(reach.radius, 1.0);
  EXPECT_LT(reach.radius, 1.7);
  // Wherever the joints stand, no shape leaves the ball.
  const auto plant = MujocoPlant::Create(options);
  const mjModel& model = plant->model();
  for (int pose = 0; pose < 200; ++pose) {
    JointVector q{};
    for (std::size_t i = 0; i < kJoints; ++i) {
      q[i] = std::sin(1.7 * pose + 2.3 * static_cast<double>(i * pose)) * 2.8;
    }
    plant->Reset(q);
    const mjData& data = plant->data();
    for (int geom = 0; geom < model.ngeom; ++geom) {
      const int body = model.geom_bodyid[geom];
      if (model.body_weldid[body] == 0 || model.geom_contype[geom] == 0) continue;
      const double away = std::hypot(data.geom_xpos[3 * geom] - reach.p_W[0],
                                     data.geom_xpos[3 * geom + 1] - reach.p_W[1],
                                     data.geom_xpos[3 * geom + 2] - reach.p_W[2]);
      EXPECT_LE(away, reach.radius);
    }
  }
}

}  // namespace
}  // namespace twin::plant::plant_shared_model_test
