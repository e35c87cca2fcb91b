#include "twin/planning/collision_world.h"

#include <array>
#include <cmath>
#include <fstream>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "planning/engine_view.h"
#include "planning/planning_fixture.h"
#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/model/arm_model.h"
#include "twin/model/self_collision.h"
#include "twin/model/transform.h"
#include "twin/onboard/measured_monitor.h"
#include "twin/plant/shared_model.h"

namespace twin::planning::planning_collision_world_test {
namespace {

using NamePairs = std::set<std::pair<std::string, std::string>>;
using testing::HasSubstr;

constexpr double kWidth = 0.05;

NamePairs NamesOf(const std::vector<Touch>& touches) {
  NamePairs pairs;
  for (const Touch& touch : touches) {
    pairs.insert(std::minmax(std::string(touch.a), std::string(touch.b)));
  }
  return pairs;
}

Transform At(double x, double y, double z) {
  Transform X = kIdentityTransform;
  X[12] = x;
  X[13] = y;
  X[14] = z;
  return X;
}

Transform FlangeAt(const JointVector& q) {
  return model::ArmModel::Panda().Pose(model::Frame::kFlange, q);
}

/// Counts and compares the verdicts of the world and of the engine.
void ExpectSameContacts(CollisionWorld& world, EngineView& engine, double clearance,
                        std::uint64_t count) {
  world.SetHandWidth(kWidth);
  world.SetSelfGuard(std::nullopt);  // which makes no contacts
  std::uint64_t touching = 0;
  for (std::uint64_t n = 0; n < count; ++n) {
    const JointVector q = Drawn(1, n);
    engine.Set(q, kWidth);
    const NamePairs expected = engine.RobotContacts();
    ASSERT_EQ(NamesOf(world.Touches(q, clearance)), expected) << "configuration " << n;
    ASSERT_EQ(world.IsFree(q, clearance), expected.empty()) << "configuration " << n;
    touching += expected.empty() ? 0 : 1;
  }
  EXPECT_GT(touching, count / 10);
  EXPECT_LT(touching, count * 9 / 10);
}

TEST(CollisionWorldTest, FindsTheContactsTheEngineMakes) {
  CollisionWorld world(Options("clutter.xml"));
  EngineView engine(Options("clutter.xml"));
  ExpectSameContacts(world, engine, 0, 1500);
}

TEST(CollisionWorldTest, FindsTheContactsTheEngineMakesOfMeshes) {
  if (!HaveMeshes()) GTEST_SKIP() << "missing: the arm's meshes";
  CollisionWorld world(MeshOptions("clutter.xml"));
  EngineView engine(MeshOptions("clutter.xml"));
  ExpectSameContacts(world, engine, 0, 300);
}

TEST(CollisionWorldTest, ClearanceIsTheMarginOfTheEnginesContacts) {
  constexpr double kClearance = 0.03;
  CollisionWorld world(Options("clutter.xml"));
  EngineView engine(Options("clutter.xml"));
  mjModel& model = engine.model();
  for (int geom = 0; geom < model.ngeom; ++geom) model.geom_margin[geom] = kClearance;
  ExpectSameContacts(world, engine, kClearance, 500);
}

TEST(CollisionWorldTest, WhatTheRobotItselfWouldStopIsNotFree) {
  EXPECT_EQ(CollisionWorld::kSelfGuard, onboard::MeasuredBounds{}.clearance_m);
  constexpr double kClearance = 0.005;
  CollisionWorld guarded(Options("floor.xml"));
  CollisionWorld bare(Options("floor.xml"));
  bare.SetSelfGuard(std::nullopt);
  int stopped = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const JointVector q = Drawn(6, n);
    const double distance = model::SelfDistance(q, true);
    const double wanted = CollisionWorld::kSelfGuard + kClearance;
    const bool free = bare.IsFree(q, kClearance);
    ASSERT_EQ(guarded.IsFree(q, kClearance), free && distance >= wanted) << n;
    if (!free || distance >= wanted) continue;
    const auto touches = guarded.Touches(q, kClearance);
    ASSERT_EQ(touches.size(), 1);
    EXPECT_EQ(touches.front().a, kGuardedArm);
    EXPECT_NEAR(touches.front().distance, distance - CollisionWorld::kSelfGuard, 1e-12);
    ++stopped;
  }
  EXPECT_GT(stopped, 10);
}

TEST(CollisionWorldTest, TheReadyPoseIsFreeInEveryScene) {
  for (const char* scene : {"floor.xml", "table_box.xml", "table_ball.xml", "clutter.xml"}) {
    CollisionWorld world(Options(scene));
    EXPECT_TRUE(world.IsFree(kReady, 0.05))
        << scene << ": " << Describe(world.Touches(kReady, 0.05));
  }
}

TEST(CollisionWorldTest, WorksWithoutAHand) {
  plant::MujocoPlantOptions options = Options("clutter.xml");
  options.hand = plant::HandKind::kNone;
  CollisionWorld bare(options);
  CollisionWorld with_hand(Options("clutter.xml"));
  bare.SetHandWidth(kWidth);
  EXPECT_TRUE(bare.IsFree(kReady));
  EXPECT_LT(bare.reach()[6], with_hand.reach()[6]);
}

TEST(CollisionWorldTest, NamesWhatTouchesAndWhatIsNear) {
  CollisionWorld world(Options("clutter.xml"));
  // The finger tips are 0.1122 m beyond the flange: 5 mm inside the table, and above it.
  const double touching = 0.22 + 0.1122;
  const auto touches = world.Touches(Reaching(Down(0.47, -0.15, touching - 0.005)));
  EXPECT_EQ(NamesOf(touches),
            (NamePairs{{"panda_leftfinger", "table"}, {"panda_rightfinger", "table"}}));
  EXPECT_THAT(Describe(touches), HasSubstr("finger and table overlap"));
  const auto near = world.Touches(Reaching(Down(0.47, -0.15, touching + 0.005)), 0.01);
  ASSERT_FALSE(near.empty());
  EXPECT_NEAR(near.front().distance, 0.005, 1e-6);
  EXPECT_THAT(Describe(near), HasSubstr("finger and table are 5.0 mm apart"));
}

TEST(CollisionWorldTest, AConfigurationBeyondALimitIsNotFree) {
  CollisionWorld world(Options("floor.xml"));
  const JointVector q{0, -0.785, 0, -2.356, 0, 1.571, 0.785};
  const double elbow = model::ArmModel::Panda().Pose(model::Frame::kJoint4, q)[14];
  const auto ceiling = [](double z) {
    return model::LabLimits{
        .regions = {
            {"ceiling", {model::LimitedPart::kElbow}, true, model::HalfSpace{{0, 0, 1}, z}}}};
  };
  ASSERT_TRUE(world.IsFree(q));
  world.SetLimits(ceiling(elbow + 0.01), {});
  EXPECT_TRUE(world.IsFree(q, 0.009));
  EXPECT_FALSE(world.IsFree(q, 0.011));
  world.SetLimits(ceiling(elbow - 0.01), {});
  EXPECT_FALSE(world.IsFree(q));
  EXPECT_EQ(Describe(world.Touches(q)), "the elbow is 10.0 mm beyond the limit \"ceiling\"");
  world.SetLimits({}, {});
  EXPECT_TRUE(world.IsFree(q));
}

TEST(CollisionWorldTest, CountsItsChecks) {
  CollisionWorld world(Options("floor.xml"));
  const std::uint64_t before = world.checks();
  EXPECT_TRUE(world.IsFree(kReady));
  EXPECT_TRUE(world.Touches(kReady).empty());
  EXPECT_EQ(world.checks(), before + 2);
}

TEST(CollisionWorldTest, AChecksAllocatesNothing) {
  CollisionWorld world(Options("clutter.xml"));
  int free = 0;
  test::RealtimeGuard guard;
  for (std::uint64_t n = 0; n < 200; ++n) free += world.IsFree(Drawn(2, n), 0.01) ? 1 : 0;
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_GT(free, 0);
}

TEST(CollisionWorldTest, FindsFixedShapesWithTheGradientOfTheirDistance) {
  CollisionWorld world(Options("floor.xml"));
  constexpr double kHorizon = 0.1;
  constexpr double kStep = 1e-6;  // rad
  const auto nearest = [&world](const JointVector& q) {
    std::array<Clearance, 16> near;
    const std::size_t count = world.NearFixed(q, kHorizon, near);
    return count == 0 ? Clearance{kHorizon, {}}
                      : *std::min_element(near.begin(), near.begin() + count,
                                          [](const Clearance& a, const Clearance& b) {
                                            return a.distance < b.distance;
                                          });
  };
  int compared = 0;
  for (std::uint64_t n = 0; n < 200; ++n) {
    const JointVector q = Drawn(3, n);
    const Clearance here = nearest(q);
    if (here.distance < 0.01 || here.distance > 0.09) continue;
    double norm = 0;
    for (const double g : here.gradient) norm = std::hypot(norm, g);
    for (std::size_t i = 0; i < kJoints; ++i) {
      JointVector before = q;
      JointVector after = q;
      before[i] -= kStep;
      after[i] += kStep;
      const double far = nearest(after).distance;
      const double close = nearest(before).distance;
      // Where another point of a shape becomes the closest, there is no gradient.
      if (std::abs(far + close - 2 * here.distance) > 1e-10) continue;
      const double slope = (far - close) / (2 * kStep);
      // Beside boxes, MuJoCo 2.2.2 gives half of the distance; contact normals do not know.
      const double off_twice = here.distance < 0.06 ? 1 : std::abs(here.gradient[i] - 2 * slope);
      const double off = std::min(std::abs(here.gradient[i] - slope), off_twice);
      EXPECT_LE(off, 0.05 * norm) << "draw " << n << ", joint " << i + 1;
      ++compared;
    }
  }
  EXPECT_GT(compared, 50);
}

TEST(CollisionWorldTest, FindingFixedShapesAllocatesNothing) {
  CollisionWorld world(Options("clutter.xml"));
  std::array<Clearance, 16> near;
  std::size_t found = 0;
  test::RealtimeGuard guard;
  for (std::uint64_t n = 0; n < 200; ++n) found += world.NearFixed(Drawn(2, n), 0.1, near);
  const auto counts = guard.counts();
  EXPECT_EQ(counts.allocations, 0);
  EXPECT_EQ(counts.frees, 0);
  EXPECT_GT(found, 0);
}

TEST(CollisionWorldTest, NothingMovesFurtherThanTravelTells) {
  CollisionWorld world(Options("clutter.xml"));
  EngineView engine(Options("clutter.xml"));
  const mjModel& model = engine.model();
  double closest = 0;
  for (std::uint64_t n = 0; n < 2000; ++n) {
    const JointVector a = Drawn(3, 2 * n);
    JointVector b = a;
    // One joint by a little, or all of them.
    for (std::size_t i = 0; i < kJoints; ++i) {
      if (n % 8 == 7 || n % 8 == i) b[i] += 0.01 * ((n / 8) % 2 == 0 ? 1 : -1);
    }
    engine.Set(a, 0.08);
    const std::vector<double> positions(engine.data().geom_xpos,
                                        engine.data().geom_xpos + 3 * model.ngeom);
    engine.Set(b, 0.08);
    const double travel = world.Travel(a, b);
    for (int k = 0; k < model.ngeom; ++k) {
      const double* p = &positions[3 * static_cast<std::size_t>(k)];
      const double* r = engine.data().geom_xpos + 3 * k;
      const double moved = std::hypot(r[0] - p[0], r[1] - p[1], r[2] - p[2]);
      ASSERT_LE(moved, travel) << "shape " << k;
      closest = std::max(closest, moved / travel);
    }
  }
  EXPECT_GT(closest, 0.6);  // of the centres of shapes; their surfaces are further out
}

TEST(CollisionWorldTest, AHeldBodyMovesWithTheFlange) {
  CollisionWorld world(Options("clutter.xml"));
  const Transform F_T_B = At(0.01, -0.02, 0.11);
  world.Attach("box", F_T_B);
  for (std::uint64_t n = 0; n < 20; ++n) {
    const JointVector q = Drawn(4, n);
    static_cast<void>(world.IsFree(q));
    const Transform expected = model::Multiply(FlangeAt(q), F_T_B);
    const Transform X_WB = world.PoseOf("box");
    for (std::size_t i = 0; i < 16; ++i) EXPECT_NEAR(X_WB[i], expected[i], 1e-12);
  }
}

TEST(CollisionWorldTest, AHeldBodyTouchesTheSceneAndTheArmButNotTheFingers) {
  CollisionWorld world(Options("clutter.xml"));
  world.SetHandWidth(0.04);  // 10 mm less than the box
  world.Attach("box", At(0, 0, 0.1034));
  EXPECT_TRUE(world.IsFree(kReady)) << Describe(world.Touches(kReady));
  const JointVector above_table = Reaching(Down(0.5, -0.05, 0.55));
  world.Attach("box", At(0, 0, 0.32));
  EXPECT_EQ(NamesOf(world.Touches(above_table)), (NamePairs{{"box", "table"}}));
  // And in the middle of the elbow.
  const Transform elbow = world.PoseOf("panda_link4");
  world.Attach("box", model::Multiply(model::Inverse(FlangeAt(above_table)), elbow));
  EXPECT_THAT(Describe(world.Touches(above_table)), HasSubstr("panda_link4 and box overlap"));
}

TEST(CollisionWorldTest, AHeldBodyLengthensTheReach) {
  CollisionWorld world(Options("clutter.xml"));
  const JointVector before = world.reach();
  world.Attach("box", At(0, 0.3, 0.5));
  for (std::size_t i = 0; i < kJoints; ++i) EXPECT_GT(world.reach()[i], before[i]);
  world.Detach();
  EXPECT_EQ(world.reach(), before);
}

TEST(CollisionWorldTest, ABodyThatIsPutDownStandsWhereItWasPlaced) {
  CollisionWorld world(Options("clutter.xml"));
  const Transform placed = At(0.5, -0.1, 0.3);
  world.Place("box", placed);
  world.Attach("box", At(0, 0, 0.1034));
  static_cast<void>(world.IsFree(kReady));
  EXPECT_NE(world.PoseOf("box"), placed);
  world.Detach();
  static_cast<void>(world.IsFree(kReady));
  EXPECT_EQ(world.PoseOf("box"), placed);
}

TEST(CollisionWorldTest, WhatIsAllowedMayTouch) {
  CollisionWorld world(Options("clutter.xml"));
  world.Place("box", FlangeAt(kReady));  // in the middle of the hand
  const NamePairs both = NamesOf(world.Touches(kReady));
  EXPECT_TRUE(both.contains({"box", "panda_hand"}));
  for (const auto& [a, b] : both) world.Allow(b, a);
  EXPECT_TRUE(world.IsFree(kReady)) << Describe(world.Touches(kReady));
  world.ForbidAll();
  EXPECT_EQ(NamesOf(world.Touches(kReady)), both);
}

TEST(CollisionWorldTest, KnowsPairsThatTheSceneLists) {
  // A ball in the hand that collides with nothing but, when it is listed, the hand.
  const test::TemporaryFolder folder;
  const Transform X_WF = FlangeAt(kReady);
  const auto scene = [&](const char* pairs) {
    plant::MujocoPlantOptions options = Options("floor.xml");
    options.scene = folder / "ball.xml";
    std::ofstream(options.scene) << fmt::format(
        R"(<mujoco><worldbody><geom name="ball" type="sphere" size="0.05" pos="{} {} {}" contype="0" conaffinity="0"/></worldbody><contact>{}</contact></mujoco>)",
        X_WF[12], X_WF[13], X_WF[14], pairs);
    return options;
  };
  CollisionWorld unlisted(scene(""));
  EXPECT_TRUE(unlisted.IsFree(kReady));
  CollisionWorld listed(scene(R"(<pair geom1="ball" geom2="panda_hand_collision_0"/>)"));
  EXPECT_EQ(NamesOf(listed.Touches(kReady)), (NamePairs{{"ball", "panda_hand"}}));
}

/// Face to face, 1.1 m apart.
std::vector<plant::MujocoPlantOptions> Facing() {
  std::vector<plant::MujocoPlantOptions> arms(2, Options("floor.xml"));
  arms[0].prefix = "left/";
  arms[1].prefix = "right/";
  arms[1].pose = {.position = {1.1, 0, 0}, .yaw = M_PI};
  return arms;
}

TEST(CollisionWorldTest, TakesAnotherArmForAnObstacleWhereItIsPut) {
  CollisionWorld world(Facing(), 0);
  const JointVector ahead = Reaching(Down(0.55, 0, 0.4));
  world.PlaceArm(1, kReady, 0.08);
  EXPECT_TRUE(world.IsFree(ahead));
  world.PlaceArm(1, ahead, 0.08);  // the same place
  const NamePairs touching = NamesOf(world.Touches(ahead));
  EXPECT_TRUE(touching.contains({"left/panda_hand", "right/panda_hand"}));
  EXPECT_TRUE(world.IsFree(kReady)) << "the own arm moves, not the other one";
  EXPECT_THAT(MessageOf<InputError>([&] { world.PlaceArm(1, ahead, 0.09); }),
              HasSubstr("another arm"));
}

TEST(CollisionWorldTest, TakesTheOtherArmsFromTheSceneAsItIs) {
  const JointVector ahead = Reaching(Down(0.55, 0, 0.4));
  const std::shared_ptr<const mjModel> scene = plant::CompileArms(Facing());
  std::vector<double> qpos = plant::InitialPositions(*scene);
  for (std::size_t i = 0; i < kJoints; ++i) {
    const int joint =
        mj_name2id(scene.get(), mjOBJ_JOINT, fmt::format("right/panda_joint{}", i + 1).c_str());
    qpos.at(scene->jnt_qposadr[joint]) = ahead[i];
  }
  CollisionWorld world(Facing(), 0);
  world.PlaceArm(1, kReady, 0.08);
  world.ArrangeAs(*scene, qpos);
  EXPECT_TRUE(NamesOf(world.Touches(ahead)).contains({"left/panda_hand", "right/panda_hand"}));
  EXPECT_TRUE(world.IsFree(kReady)) << "the own arm stays";
}

TEST(CollisionWorldTest, MovesTheArmThatIsItsOwn) {
  CollisionWorld world(Facing(), 1);
  world.PlaceArm(0, kReady, 0.08);
  ASSERT_TRUE(world.IsFree(kReady));
  // A yaw of pi: from x = 1.1 m back by what the arm reaches ahead.
  EXPECT_NEAR(world.PoseOf("right/panda_hand")[12], 1.1 - FlangeAt(kReady)[12], 1e-6);
}

TEST(CollisionWorldTest, RefusesWhatItDoesNotKnow) {
  CollisionWorld world(Options("clutter.xml"));
  EXPECT_THAT(MessageOf<InputError>([&] { world.Allow("table", "tabel"); }),
              testing::AllOf(HasSubstr("'tabel'"), HasSubstr("shelf_upper")));
  EXPECT_THAT(MessageOf<InputError>([&] { world.Place("table", kIdentityTransform); }),
              testing::AllOf(HasSubstr("'table'"), HasSubstr("are: box")));
  EXPECT_THAT(MessageOf<InputError>([&] { world.Attach("box", Transform{}); }),
              HasSubstr("pose of 'box' is none"));
  EXPECT_THAT(MessageOf<InputError>([&] { world.SetHandWidth(0.09); }), HasSubstr("hand width"));
  EXPECT_THAT(MessageOf<InputError>([&] { static_cast<void>(world.PoseOf("cup")); }),
              HasSubstr("'cup'"));
}

}  // namespace
}  // namespace twin::planning::planning_collision_world_test
