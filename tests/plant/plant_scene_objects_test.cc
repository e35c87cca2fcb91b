#include <array>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"
#include "twin/plant/compiled_model.h"
#include "twin/plant/scene_object.h"

namespace twin::plant::plant_scene_objects_test {
namespace {

using testing::HasSubstr;

/// Turned by 0.5 rad about z, at (0.5, 0.1, 0.3) m.
const Transform kSomewhere{
    std::cos(0.5), std::sin(0.5), 0,   0, -std::sin(0.5), std::cos(0.5), 0, 0, 0, 0, 1, 0,
    0.5,           0.1,           0.3, 1};

std::vector<SceneObject> OneOfEach() {
  return {{.name = "stand",
           .size = {0.4, 0.3, 0.2},
           .X_WB = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0.1, 1}},
          {.name = "brick", .size = {0.04, 0.05, 0.06}, .mass = 0.2, .X_WB = kSomewhere},
          {.name = "can",
           .shape = ObjectShape::kCylinder,
           .size = {0.05, 0.05, 0.08},
           .mass = 0.3,
           .X_WB = kSomewhere,
           .friction = 0.7},
          {.name = "ball", .shape = ObjectShape::kSphere, .size = {0.06, 0.06, 0.06}, .mass = 0.1}};
}

/// The same, written out for the engine to compile.
constexpr const char* kWritten = R"(<mujoco><worldbody>
<light pos="0 0 3" directional="true"/>
<geom name="floor" type="plane" size="3 3 0.1" rgba="0.7 0.7 0.7 1"/>
<body name="stand" pos="0.5 0 0.1"><geom type="box" size="0.2 0.15 0.1" mass="0"/></body>
<body name="brick" pos="0.5 0.1 0.3" quat="0.968912421710645 0 0 0.247403959254523"><freejoint/>
  <geom type="box" size="0.02 0.025 0.03" mass="0.2"/></body>
<body name="can" pos="0.5 0.1 0.3" quat="0.968912421710645 0 0 0.247403959254523"><freejoint/>
  <geom type="cylinder" size="0.025 0.04" mass="0.3" friction="0.7"/></body>
<body name="ball"><freejoint/><geom type="sphere" size="0.03" mass="0.1"/></body>
</worldbody></mujoco>)";

MujocoPlantOptions With(std::vector<SceneObject> objects) {
  MujocoPlantOptions options = BareOptions();
  options.objects = std::move(objects);
  return options;
}

class Pair {
 public:
  Pair(const CompiledModel& a, const CompiledModel& b) : a_(*a.model), b_(*b.model) {}

  [[nodiscard]] int BodyA(const std::string& name) const { return Body(a_, name); }
  [[nodiscard]] int BodyB(const std::string& name) const { return Body(b_, name); }

  /// Expects `count` numbers of two rows to agree.
  static void Expect(const mjtNum* a, const mjtNum* b, int count, const std::string& what) {
    for (int i = 0; i < count; ++i)
      EXPECT_NEAR(a[i], b[i], 1e-9 * (1 + std::abs(b[i]))) << what << i;
  }
  /// Moments of inertia in order, whatever order the engine has turned them to.
  static void ExpectMoments(const mjtNum* a, const mjtNum* b, const std::string& what) {
    std::array<double, 3> of_a{a[0], a[1], a[2]};
    std::array<double, 3> of_b{b[0], b[1], b[2]};
    std::ranges::sort(of_a);
    std::ranges::sort(of_b);
    Expect(of_a.data(), of_b.data(), 3, what);
  }

 private:
  static int Body(const mjModel& model, const std::string& name) {
    return mj_name2id(&model, mjOBJ_BODY, name.c_str());
  }
  const mjModel& a_;
  const mjModel& b_;
};

TEST(SceneObjectsTest, AreWhatTheEngineMakesOfTheSameBodies) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = BareOptions();
  options.scene = folder.Write("written.xml", kWritten);
  const CompiledModel written = CompileModel(options);
  const CompiledModel made = CompileModel(With(OneOfEach()));
  const Pair pair(made, written);
  const mjModel& a = *made.model;
  const mjModel& b = *written.model;
  for (const SceneObject& object : OneOfEach()) {
    const std::string& name = object.name;
    const int i = pair.BodyA(name);
    const int k = pair.BodyB(name);
    ASSERT_GT(i, 0);
    ASSERT_GT(k, 0);
    const int geom_a = a.body_geomadr[i];
    const int geom_b = b.body_geomadr[k];
    EXPECT_EQ(a.geom_type[geom_a], b.geom_type[geom_b]) << name;
    Pair::Expect(a.geom_size + 3 * geom_a, b.geom_size + 3 * geom_b, 3, name + " size ");
    Pair::Expect(a.geom_rbound + geom_a, b.geom_rbound + geom_b, 1, name + " bound ");
    Pair::Expect(a.geom_friction + 3 * geom_a, b.geom_friction + 3 * geom_b, 3,
                 name + " friction ");
    Pair::Expect(a.body_mass + i, b.body_mass + k, 1, name + " mass ");
    Pair::Expect(a.body_pos + 3 * i, b.body_pos + 3 * k, 3, name + " pos ");
    Pair::Expect(a.body_quat + 4 * i, b.body_quat + 4 * k, 4, name + " quat ");
    Pair::ExpectMoments(a.body_inertia + 3 * i, b.body_inertia + 3 * k, name + " inertia ");
    Pair::Expect(a.body_invweight0 + 2 * i, b.body_invweight0 + 2 * k, 2, name + " invweight ");
    if (!object.mass) continue;
    const int qpos_a = a.jnt_qposadr[a.body_jntadr[i]];
    const int qpos_b = b.jnt_qposadr[b.body_jntadr[k]];
    Pair::Expect(a.qpos0 + qpos_a, b.qpos0 + qpos_b, 7, name + " qpos0 ");
  }
  EXPECT_NEAR(a.stat.meaninertia, b.stat.meaninertia, 1e-9);
}

TEST(SceneObjectsTest, ChangeNothingOfTheRobot) {
  const CompiledModel without = CompileModel(BareOptions());
  const CompiledModel with = CompileModel(With(OneOfEach()));
  for (int body = 1; body <= mj_name2id(without.model.get(), mjOBJ_BODY, "panda_link8"); ++body) {
    Pair::Expect(with.model->body_mass + body, without.model->body_mass + body, 1, "mass ");
    Pair::Expect(with.model->body_invweight0 + 2 * body, without.model->body_invweight0 + 2 * body,
                 2, "invweight ");
  }
  EXPECT_EQ(with.model->stat.extent, CompileModel(With(OneOfEach())).model->stat.extent);
}

TEST(SceneObjectsTest, ShareOneCompiledModelWhateverTheyMeasure) {
  const TemporaryFolder folder;
  MujocoPlantOptions options = With(OneOfEach());
  options.cache = folder.path();
  (void)CompileModel(options);
  options.objects[1].size = {0.03, 0.03, 0.09};
  options.objects[1].shape = ObjectShape::kBox;
  options.objects[2].mass = 0.5;
  const CompiledModel other = CompileModel(options);
  const auto files = std::filesystem::directory_iterator(folder.path());
  EXPECT_EQ(std::distance(begin(files), end(files)), 1);
  const int brick = mj_name2id(other.model.get(), mjOBJ_BODY, "brick");
  EXPECT_EQ(other.model->geom_size[3 * other.model->body_geomadr[brick] + 2], 0.045);
}

/// How far an object has moved and leant after so many steps, with the arm on its brakes.
struct Rest {
  double moved = 0;  ///< m, level
  double sunk = 0;   ///< m
  double leans = 0;  ///< rad
  double speed = 0;  ///< m/s
};

Rest RestOf(const std::vector<SceneObject>& objects, const std::string& name) {
  const auto plant = MujocoPlant::Create(With(objects));
  const int body = mj_name2id(&plant->model(), mjOBJ_BODY, name.c_str());
  const mjData& data = plant->data();
  const std::array<double, 3> before{data.xpos[3 * body], data.xpos[3 * body + 1],
                                     data.xpos[3 * body + 2]};
  const double z_before = data.xmat[9 * body + 8];
  JointDrive drive;
  drive.brakes = true;
  for (int k = 0; k < 2000; ++k) {
    drive.tau = plant->GravityTorque(plant->sensors().q);
    plant->Step(drive);
  }
  const int dof = plant->model().body_dofadr[body];
  return {.moved = std::hypot(data.xpos[3 * body] - before[0], data.xpos[3 * body + 1] - before[1]),
          .sunk = before[2] - data.xpos[3 * body + 2],
          .leans = std::abs(std::acos(std::min(1.0, data.xmat[9 * body + 8])) -
                            std::acos(std::min(1.0, z_before))),
          .speed = std::hypot(data.qvel[dof], data.qvel[dof + 1], data.qvel[dof + 2])};
}

TEST(SceneObjectsTest, StandWhereTheyAreSet) {
  for (const ObjectShape shape : {ObjectShape::kBox, ObjectShape::kCylinder}) {
    std::vector<SceneObject> objects = OneOfEach();
    objects.resize(2);
    objects[1].shape = shape;
    objects[1].size = {0.05, 0.05, 0.1};
    objects[1].X_WB = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.5, 0, 0.25, 1};
    const Rest rest = RestOf(objects, "brick");
    EXPECT_LT(rest.moved, 1e-4) << static_cast<int>(shape);
    EXPECT_LT(std::abs(rest.sunk), 1e-3);
    EXPECT_LT(rest.leans, 2e-3);
    EXPECT_LT(rest.speed, 1e-3);
  }
}

TEST(SceneObjectsTest, AreRefusedWithTheirName) {
  const auto message = [](const SceneObject& object) {
    return MessageOf<InputError>([&] { Validate({object}); });
  };
  EXPECT_THAT(message({.name = "a b"}), HasSubstr("\"a b\": that is no name"));
  EXPECT_THAT(message({.name = "a", .size = {0, 1, 1}}), HasSubstr("object a: size"));
  EXPECT_THAT(message({.name = "a", .mass = -1}), HasSubstr("object a: mass"));
  EXPECT_THAT(message({.name = "a", .friction = 11}), HasSubstr("object a: friction"));
  EXPECT_THAT(message({.name = "a", .shape = ObjectShape::kCylinder, .size = {0.1, 0.2, 0.1}}),
              HasSubstr("must be the diameter"));
  EXPECT_THAT(MessageOf<InputError>([] {
                Validate({{.name = "a"}, {.name = "a"}});
              }),
              HasSubstr("two of that name"));
  EXPECT_THAT(MessageOf<InputError>([] { (void)CompileModel(With({{.name = "panda_link3"}})); }),
              HasSubstr("panda_link3"));
}

}  // namespace
}  // namespace twin::plant::plant_scene_objects_test
