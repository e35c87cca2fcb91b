#include "application/pick.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "twin/core/hand_command.h"
#include "twin/core/setting.h"

namespace twin::application::application_grips_test {
namespace {

using plant::ObjectShape;
using plant::SceneObject;

constexpr Vector3 kUp{0, 0, 1};

/// Stands on the ground, turned about the vertical; or lies, rolled by a quarter.
SceneObject Make(ObjectShape shape, const Vector3& size, bool lies = false) {
  SceneObject object{.name = "it", .shape = shape, .size = size, .mass = 0.2};
  if (lies) object.X_WB = {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1};
  return object;
}

/// The hand's axis, from the palm to the tips, and where it closes, in the object's axes.
Vector3 Axis(const Grip& grip, std::size_t column) {
  return {grip.B_T_NE[4 * column], grip.B_T_NE[4 * column + 1], grip.B_T_NE[4 * column + 2]};
}

TEST(GripsTest, TakeABoxByEitherPairOfFacesBothWaysRound) {
  const std::vector<Grip> grips = GripsOf(Make(ObjectShape::kBox, {0.04, 0.06, 0.05}), kUp, {});
  ASSERT_EQ(grips.size(), 4U);
  for (const Grip& grip : grips) {
    EXPECT_TRUE(IsRigid(grip.B_T_NE));
    EXPECT_EQ(Axis(grip, 2), (Vector3{0, 0, -1})) << "from above";
    EXPECT_EQ(grip.width, std::abs(Axis(grip, 1)[0]) > 0.5 ? 0.04 : 0.06);
    EXPECT_EQ(grip.B_T_NE[14], 0) << "at half its height";
  }
  EXPECT_EQ(Axis(grips[0], 1)[0], -Axis(grips[1], 1)[0]);
}

TEST(GripsTest, LeaveOutWhatTheHandDoesNotSpan) {
  const std::vector<Grip> grips = GripsOf(Make(ObjectShape::kBox, {0.04, 0.09, 0.05}), kUp, {});
  ASSERT_EQ(grips.size(), 2U);
  for (const Grip& grip : grips) EXPECT_EQ(grip.width, 0.04);
  EXPECT_TRUE(GripsOf(Make(ObjectShape::kBox, {0.09, 0.09, 0.05}), kUp, {}).empty());
}

TEST(GripsTest, StayOffThePalmAndTheGround) {
  const auto height = [](double tall) {
    return GripsOf(Make(ObjectShape::kBox, {0.04, 0.04, tall}), kUp, {.palm = 0.01, .below = 0.005})
        .at(0)
        .B_T_NE[14];
  };
  // The palm is 37.4 mm above the middle between the fingertips, the tips 8.8 mm below.
  EXPECT_NEAR(height(0.12), 0.06 - 0.0274, 1e-12);
  EXPECT_NEAR(height(0.022), 0.0138 - 0.011, 1e-12);
  EXPECT_TRUE(GripsOf(Make(ObjectShape::kBox, {0.04, 0.04, 0.01}), kUp, {}).empty()) << "too flat";
}

TEST(GripsTest, TakeACanThatStandsAllAround) {
  const std::vector<Grip> grips =
      GripsOf(Make(ObjectShape::kCylinder, {0.06, 0.06, 0.05}), kUp, {});
  ASSERT_EQ(grips.size(), 8U);
  for (const Grip& grip : grips) {
    EXPECT_TRUE(IsRigid(grip.B_T_NE));
    EXPECT_EQ(grip.width, 0.06);
    EXPECT_NEAR(Axis(grip, 1)[2], 0, 1e-12);
  }
}

TEST(GripsTest, TakeACanThatLiesAcrossOrByItsEnds) {
  const std::vector<Grip> grips =
      GripsOf(Make(ObjectShape::kCylinder, {0.05, 0.05, 0.07}, true), kUp, {});
  ASSERT_EQ(grips.size(), 4U);
  for (const Grip& grip : grips) {
    EXPECT_NEAR(Axis(grip, 2)[1], -grip.B_up[1], 1e-12) << "from above, which is across its axis";
    EXPECT_EQ(grip.width, std::abs(Axis(grip, 1)[2]) > 0.5 ? 0.07 : 0.05);
  }
  EXPECT_EQ(GripsOf(Make(ObjectShape::kCylinder, {0.05, 0.05, 0.2}, true), kUp, {}).size(), 2U);
}

TEST(GripsTest, TakeABeamOffItsMiddleOnTheSideThatIsAskedFor) {
  const SceneObject beam = Make(ObjectShape::kBox, {0.22, 0.04, 0.04});
  EXPECT_EQ(GripsOf(beam, kUp, {}, {.off_centre = 0.07}).size(), 4U) << "either end, either way";
  const std::vector<Grip> grips =
      GripsOf(beam, kUp, {}, {.off_centre = 0.07, .B_side = {-0.1, 0, 0.3}});
  ASSERT_EQ(grips.size(), 2U);
  for (const Grip& grip : grips) {
    EXPECT_TRUE(IsRigid(grip.B_T_NE));
    EXPECT_NEAR(grip.B_T_NE[12], -0.07, 1e-12);
    EXPECT_EQ(grip.width, 0.04);
  }
  EXPECT_TRUE(GripsOf(beam, kUp, {}, {.off_centre = 0.1}).empty()) << "fingers beyond its end";
  const SceneObject can = Make(ObjectShape::kCylinder, {0.06, 0.06, 0.2});
  EXPECT_TRUE(GripsOf(can, kUp, {}, {.off_centre = 0.01}).empty()) << "it stands";
}

}  // namespace
}  // namespace twin::application::application_grips_test
