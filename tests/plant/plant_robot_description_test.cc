#include "plant/robot_description.h"

#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "plant/plant_fixture.h"
#include "twin/core/error.h"

namespace twin::plant::plant_robot_description_test {
namespace {

constexpr const char* kTwoLinks = R"(<robot name="r">
  <link name="a"><visual><geometry><mesh filename="package://p/a.dae"/></geometry></visual></link>
  <link name="b">
    <inertial>
      <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
      <mass value="2"/>
      <inertia ixx="1" iyy="2" izz="3" ixy="0.1" ixz="0.2" iyz="0.3"/>
    </inertial>
    <collision><geometry><box size="2 4 6"/></geometry></collision>
  </link>
  <joint name="j" type="revolute">
    <parent link="a"/><child link="b"/><origin xyz="0 0 5"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="3" velocity="4"/>
  </joint>
</robot>)";

std::string With(const std::string& from, const std::string& to) {
  std::string text = kTwoLinks;
  text.replace(text.find(from), from.size(), to);
  return text;
}

TEST(RobotDescriptionTest, ReadsLinksParentsFirst) {
  const RobotDescription robot = ParseUrdf(kTwoLinks, "r.urdf");
  ASSERT_EQ(robot.links.size(), 2u);
  EXPECT_EQ(robot.links[0].name, "a");
  EXPECT_EQ(robot.links[0].visual.at(0).mesh_uri, "package://p/a.dae");
  const Link& b = robot.links[1];
  EXPECT_EQ(b.parent, "a");
  EXPECT_EQ(b.joint, "j");
  EXPECT_EQ(b.axis, (Vector3{0, 1, 0}));
  EXPECT_EQ(b.X_PL.p, (Vector3{0, 0, 5}));
  EXPECT_EQ(b.q_min, -1);
  EXPECT_EQ(b.q_max, 2);
  EXPECT_EQ(b.tau_max, 3);
  EXPECT_EQ(b.collision.at(0).size, (Vector3{1, 2, 3}));
}

// A quarter turn about z: x of the inertial frame is y of the link, y is -x.
TEST(RobotDescriptionTest, TurnsTheInertiaIntoLinkAxes) {
  const RobotDescription robot = ParseUrdf(kTwoLinks, "r.urdf");
  const Inertial& inertial = robot.links[1].inertial.value();
  EXPECT_EQ(inertial.mass, 2);
  EXPECT_EQ(inertial.com, (Vector3{1, 2, 3}));
  const Matrix3 expected{2, -0.1, -0.3, -0.1, 1, 0.2, -0.3, 0.2, 3};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_NEAR(inertial.I[i], expected[i], 1e-15) << i;
}

TEST(RobotDescriptionTest, NamesAJointItDoesNotSupport) {
  const std::string message =
      MessageOf<InputError>([] { (void)ParseUrdf(With("\"revolute\"", "\"planar\""), "r.urdf"); });
  EXPECT_THAT(message, testing::StartsWith("r.urdf: joint 'j'"));
}

TEST(RobotDescriptionTest, NamesAJointWithoutATorque) {
  const std::string message = MessageOf<InputError>(
      [] { (void)ParseUrdf(With("effort=\"3\"", "effort=\"0\""), "r.urdf"); });
  EXPECT_EQ(message, "r.urdf: joint 'j' has the effort 0 Nm; it must be above 0");
}

TEST(RobotDescriptionTest, ReadsSlidesPadsAndWhatFollows) {
  std::string text = With("\"revolute\"", "\"prismatic\"");
  text.insert(text.find("<limit"), "<mimic joint=\"k\"/>");
  text.replace(text.find("<collision>"), 11, "<collision name=\"pad_left\">");
  const RobotDescription robot = ParseUrdf(text, "r.urdf");
  EXPECT_EQ(robot.links[1].joint_kind, JointKind::kPrismatic);
  EXPECT_EQ(robot.links[1].follows, "k");
  EXPECT_EQ(robot.links[1].q_max, 2);
  EXPECT_TRUE(robot.links[1].collision.at(0).pad);
  const RobotDescription plain = ParseUrdf(kTwoLinks, "r.urdf");
  EXPECT_EQ(plain.links[1].follows, "");
  EXPECT_FALSE(plain.links[1].collision.at(0).pad);
}

TEST(RobotDescriptionTest, NamesALinkThatDoesNotExist) {
  const std::string message = MessageOf<InputError>(
      [] { (void)ParseUrdf(With("<parent link=\"a\"/>", "<parent link=\"nobody\"/>"), "r.urdf"); });
  EXPECT_THAT(message, testing::StartsWith("r.urdf: not a valid URDF"));
  EXPECT_THAT(message, testing::HasSubstr("nobody"));
}

TEST(RobotDescriptionTest, RefusesEveryTruncation) {
  const std::string text = ReadText(BareOptions().urdf);
  const std::size_t end = text.find("</robot>");
  ASSERT_NE(end, std::string::npos);
  for (std::size_t length = 0; length < end; length += 97) {
    EXPECT_THROW((void)ParseUrdf(text.substr(0, length), "cut.urdf"), InputError) << length;
  }
}

TEST(RobotDescriptionTest, MountsAToolOnTheLinkItsRootNames) {
  RobotDescription robot = ParseUrdf(kTwoLinks, "r.urdf");
  const RobotDescription tool = ParseUrdf(
      R"(<robot name="t"><link name="b"/><link name="c"/>
         <joint name="k" type="fixed"><parent link="b"/><child link="c"/></joint></robot>)",
      "t.urdf");
  Mount(robot, tool, "t.urdf");
  ASSERT_EQ(robot.links.size(), 3u);
  EXPECT_EQ(robot.links[2].parent, "b");
  const std::string message = MessageOf<InputError>([&] { Mount(robot, tool, "t.urdf"); });
  EXPECT_THAT(message, testing::HasSubstr("link 'c'"));
}

constexpr const char* kShapes = R"(unit: m
colours: {red: [1, 0, 0, 1]}
links:
  a:
    - {shape: capsule, from: [0, 0, 0], to: [2, 0, 0], radius: 0.5, colour: red}
    - {shape: sphere, at: [1, 2, 3], radius: 0.1, colour: red, use: visual}
)";

TEST(PrimitiveShapesTest, ReplaceMeshesAndLieAlongTheirAxis) {
  RobotDescription robot = ParseUrdf(kTwoLinks, "r.urdf");
  UsePrimitives(kShapes, "p.yaml", robot);
  ASSERT_EQ(robot.links[0].visual.size(), 2u);
  ASSERT_EQ(robot.links[0].collision.size(), 1u);
  EXPECT_EQ(robot.links[1].collision.at(0).kind, ShapeKind::kBox);  // no mesh, so left alone
  const Shape& capsule = robot.links[0].visual[0];
  EXPECT_EQ(capsule.kind, ShapeKind::kCapsule);
  EXPECT_EQ(capsule.size, (Vector3{0.5, 1, 0}));
  EXPECT_EQ(capsule.X_LS.p, (Vector3{1, 0, 0}));
  // z turned onto x: a quarter turn about y.
  EXPECT_NEAR(capsule.X_LS.quat[0], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(capsule.X_LS.quat[2], std::sqrt(0.5), 1e-15);
}

TEST(PrimitiveShapesTest, NamesFileLineAndKey) {
  const auto message = [](const std::string& from, const std::string& to) {
    std::string text = kShapes;
    text.replace(text.find(from), from.size(), to);
    return MessageOf<InputError>([&text] {
      RobotDescription robot = ParseUrdf(kTwoLinks, "r.urdf");
      UsePrimitives(text, "p.yaml", robot);
    });
  };
  EXPECT_THAT(message("unit: m", "unit: mm"), testing::HasSubstr("p.yaml: line 1: unit"));
  EXPECT_THAT(message("radius: 0.5", "radius: -1"), testing::HasSubstr("p.yaml: line 5: radius"));
  EXPECT_THAT(message("radius: 0.5", "radios: 1"), testing::HasSubstr("unknown key 'radios'"));
  EXPECT_THAT(message("[2, 0, 0]", "[2, 0]"), testing::HasSubstr("line 5: to must be"));
  EXPECT_THAT(message("[2, 0, 0]", "[2, .nan, 0]"), testing::HasSubstr("finite"));
  EXPECT_THAT(message("shape: sphere", "shape: ball"), testing::HasSubstr("line 6: shape 'ball'"));
  EXPECT_THAT(message("0.1, colour: red", "0.1, colour: blue"),
              testing::HasSubstr("unknown colour 'blue'"));
  EXPECT_THAT(message("  a:", "  z:"), testing::HasSubstr("link 'a'"));
  EXPECT_THAT(message("links:", "links: ["), testing::StartsWith("p.yaml: "));
}

}  // namespace
}  // namespace twin::plant::plant_robot_description_test
