// A free body is put elsewhere between two steps.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <mujoco/mujoco.h>

#include "plant/plant_fixture.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/plant/observers.h"

namespace twin::plant::plant_place_test {
namespace {

using testing::HasSubstr;

/// A box of 50 mm on a table whose top is at z = 0.3 m, in the box's frame at z = 0.325 m.
class PlantPlaceTest : public testing::Test {
 protected:
  PlantPlaceTest() {
    MujocoPlantOptions options = DefaultOptions();
    options.scene = SourceDir() / "models" / "scenes" / "table_box.xml";
    plant_ = MujocoPlant::Create(options);
    plant_->Reset(kReady);
    box_ = FreeBodyNamed(plant_->model(), "box");
  }

  void Step(int count) {
    for (int k = 0; k < count; ++k) plant_->Step({.brakes = true});
  }
  /// x, y, z of the box, and its speed.
  [[nodiscard]] std::array<double, 3> Place() const {
    const double* p = plant_->data().xpos + 3 * box_;
    return {p[0], p[1], p[2]};
  }
  [[nodiscard]] double Speed() const {
    mjtNum twist[6];
    mj_objectVelocity(&plant_->model(), &plant_->data(), mjOBJ_BODY, box_, twist, 0);
    return mju_norm(twist, 6);
  }
  static Transform At(double x, double y, double z) {
    return {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, x, y, z, 1};
  }
  [[nodiscard]] std::vector<double> Motion() const {
    const mjData& data = plant_->data();
    std::vector<double> motion(data.qpos, data.qpos + plant_->model().nq);
    motion.insert(motion.end(), data.qvel, data.qvel + plant_->model().nv);
    motion.insert(motion.end(), data.qacc, data.qacc + plant_->model().nv);
    return motion;
  }

  std::unique_ptr<MujocoPlant> plant_;
  int box_ = 0;
};

TEST_F(PlantPlaceTest, ABoxOnTheTableStaysThere) {
  Step(200);
  EXPECT_FALSE(plant_->Place(box_, At(0.45, 0.2, 0.325)));
  EXPECT_NEAR(Place()[1], 0.2, 1e-12) << "at once";
  EXPECT_EQ(Speed(), 0);
  Step(500);
  EXPECT_NEAR(Place()[0], 0.45, 1e-4);
  EXPECT_NEAR(Place()[1], 0.2, 1e-4);
  EXPECT_NEAR(Place()[2], 0.325, 1e-3) << "it sinks in a little";
  EXPECT_LT(Speed(), 1e-3);
}

TEST_F(PlantPlaceTest, WhereItRestsItCanBePutAgain) {
  Step(500);
  const auto [x, y, z] = Place();
  EXPECT_LT(z, 0.325);
  EXPECT_FALSE(plant_->Place(box_, At(x, y, z)));
}

TEST_F(PlantPlaceTest, InTheAirItFallsFromRest) {
  ASSERT_FALSE(plant_->Place(box_, At(0.5, 0.2, 0.6)));
  Step(100);
  // Semi-implicit Euler: g h^2 n (n + 1) / 2.
  EXPECT_NEAR(Place()[2], 0.6 - 9.81 * 1e-6 * 100 * 101 / 2, 1e-9);
}

TEST_F(PlantPlaceTest, ItsTurnIsTheOneAskedFor) {
  // By a quarter about z: its x axis points along y.
  Transform X_WB{0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 0.5, 0.2, 0.325, 1};
  ASSERT_FALSE(plant_->Place(box_, X_WB));
  const double* R = plant_->data().xmat + 9 * box_;  // by rows
  EXPECT_NEAR(R[3], 1, 1e-12);
  EXPECT_NEAR(R[1], -1, 1e-12);
}

TEST_F(PlantPlaceTest, InsideSomethingItIsRefusedAndNothingChanges) {
  Step(200);
  const auto before = plant_->Save();
  Step(300);
  const std::vector<double> went_on = Motion();
  plant_->Restore(*before);
  const std::optional<Overlap> overlap = plant_->Place(box_, At(0.5, 0.2, 0.25));
  ASSERT_TRUE(overlap);
  EXPECT_EQ(PartOfShape(plant_->model(), overlap->geom), "table");
  // Its lower face is at 0.225 m, the table's top at 0.3 m; the engine halves that between boxes.
  EXPECT_LE(overlap->depth, 0.075 + 1e-6);
  EXPECT_GE(overlap->depth, 0.075 / 2 - 1e-6);
  Step(300);
  EXPECT_EQ(Motion(), went_on);
}

TEST_F(PlantPlaceTest, AllocatesNothing) {
  Step(1);
  const test::RealtimeGuard guard;
  const bool refused = plant_->Place(box_, At(0.5, 0.2, 0.25)).has_value();
  const bool placed = !plant_->Place(box_, At(0.5, 0.2, 0.4)).has_value();
  const auto counts = guard.counts();
  EXPECT_TRUE(refused);
  EXPECT_TRUE(placed);
  EXPECT_EQ(counts, test::RealtimeGuard::Counts());
}

TEST_F(PlantPlaceTest, NamesWhatThereIs) {
  const auto message = [this](const char* name) {
    return MessageOf<InputError>([&] { static_cast<void>(FreeBodyNamed(plant_->model(), name)); });
  };
  EXPECT_THAT(message("cup"), HasSubstr("no object \"cup\"; those that move freely: box"));
  EXPECT_THAT(message("table"), HasSubstr("\"table\" does not move freely"));
  EXPECT_THAT(message("panda_link3"), HasSubstr("does not move freely"));
}

}  // namespace
}  // namespace twin::plant::plant_place_test
