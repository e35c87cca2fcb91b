#include "twin/scenario/profile.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_profile_test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr const char* kProfile = R"(profile: 1
robot: panda
identified: {date: 2026-11-26, by: nobody, log: [{file: run.mcap, seconds: 60}]}
holds_for: {speed: {unit: rad/s, values: [1, 1, 1, 1, 1, 1, 1]}, load: {from: 0 kg, to: 1.2 kg}}
scenario:
  plant:
    friction: {viscous: {unit: Nm s/rad, values: [1, 2, 3, 4, 5, 6, 7]}}
    armature: {unit: kg m^2, values: [0.5, 0.5, 0.5, 0.5, 0.2, 0.2, 0.2]}
    delay: {tau_J: 2.5 ms}
    noise: {q: 0.001 rad, tau_J: 0.1 Nm}
  link: {command_delay: {histogram: {edges: [0 ms, 1 ms, 2 ms], weights: [3, 1]}}}
  robot: {load: {mass: 1 kg, position: [0 m, 0 m, 0.1 m]}}
covariance:
  keys: ["plant.friction.viscous[0]", "plant.friction.viscous[1]", "plant.delay.tau_J", robot.load.mass]
  matrix: [[0.04, 0.03, 0, 0], [0.03, 0.04, 0, 0], [0, 0, 1.0e-8, 0], [0, 0, 0, 4]]
)";

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class ProfileTest : public ::testing::Test {
 protected:
  Scenario With(const std::string& keys, const std::string& robot = "profile: p.yaml",
                const std::string& profile = kProfile) {
    std::ofstream(folder_.path() / "p.yaml") << profile;
    return Parse("name: s\nrobot: {" + robot + "}\n" + keys + R"(
motion:
  trajectory:
    unit: rad
    waypoints:
      - {q: [0, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
      - {q: [0.1, -0.7854, 0, -2.3562, 0, 1.5708, 0.7854]}
)",
                 folder_.path() / "s.yaml");
  }
  std::string ErrorOf(const std::string& profile, const std::string& robot = "profile: p.yaml") {
    try {
      static_cast<void>(With("", robot, profile));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  }
  Scenario Drawn(int n) { return With("", "profile: p.yaml, profile_draw: " + std::to_string(n)); }

  twin::test::TemporaryFolder folder_;
};

TEST_F(ProfileTest, CountsWhereTheScenarioSaysNothing) {
  const Scenario all = With("");
  EXPECT_EQ(all.plant.arm.friction_law->viscous, (JointVector{1, 2, 3, 4, 5, 6, 7}));
  EXPECT_EQ(all.plant.arm.torque_delay, std::chrono::microseconds(2500));
  EXPECT_EQ(all.robot.load.m_load, 1);
  const Scenario some = With(
      "plant: {friction: residual, noise: {q: 0 rad}, mass_scale: 1.1}\nlink: {command_delay: 0 s}");
  EXPECT_FALSE(some.plant.arm.friction_law);
  EXPECT_EQ((*some.plant.arm.armature)[4], 0.2);
  EXPECT_EQ(some.plant.noise_q, 0);
  EXPECT_EQ(some.plant.noise_tau_J, 0.1);
  EXPECT_EQ(some.link, LinkSection());
}

TEST_F(ProfileTest, TheScenariosLoadIsAnotherBody) {
  const Scenario own = With("", "profile: p.yaml, load: {mass: 2 kg}, profile_draw: 3");
  EXPECT_EQ(own.robot.load.m_load, 2);
  EXPECT_EQ(own.robot.load.F_x_Cload, Vector3{});
}

TEST_F(ProfileTest, WhatIsWrittenStandsAlone) {
  const Scenario scenario = With("plant: {mass_scale: 1}");
  EXPECT_EQ(Parse(ToYaml(scenario), "elsewhere.yaml"), scenario);
  const Scenario drawn = Drawn(5);
  EXPECT_EQ(Parse(ToYaml(drawn), "elsewhere.yaml"), drawn);
}

TEST_F(ProfileTest, IsFoundBesideTheFolderOfScenarios) {
  std::filesystem::create_directories(folder_.path() / "profiles");
  std::ofstream(folder_.path() / "profiles" / "q.yaml") << kProfile;
  std::filesystem::create_directories(folder_.path() / "scenarios");
  const std::string text = ToYaml(With(""));
  const Scenario there = Parse(Replaced(text, "robot:", "robot:\n  profile: q.yaml"),
                               folder_.path() / "scenarios" / "s.yaml");
  EXPECT_EQ(there.places.profile->file.filename(), "q.yaml");
}

TEST_F(ProfileTest, ErrorsNameTheProfilesFileAndLine) {
  const std::string text = kProfile;
  EXPECT_THAT(ErrorOf(Replaced(text, "tau_J: 2.5 ms", "tau_J: 25 ms")),
              AllOf(HasSubstr("p.yaml:9: scenario.plant.delay.tau_J"), HasSubstr("20 ms")));
  EXPECT_THAT(ErrorOf(Replaced(text, "  link:", "  onboard: {}\n  link:")),
              AllOf(HasSubstr("p.yaml:11"), HasSubstr("accepted: plant, link, robot")));
  EXPECT_THAT(ErrorOf(Replaced(text, "[1, 2, 3, 4, 5, 6, 7]", "[-1, 2, 3, 4, 5, 6, 7]")),
              AllOf(HasSubstr("p.yaml:1"), HasSubstr("friction.viscous of joint 1")));
  EXPECT_THAT(ErrorOf(Replaced(text, "robot: panda", "robot: ur5")), HasSubstr("p.yaml:2: robot"));
  EXPECT_THAT(ErrorOf(Replaced(text, "profile: 1", "profile: 2")), HasSubstr("reads version 1"));
  EXPECT_THAT(ErrorOf(text, "profile: none.yaml"),
              AllOf(HasSubstr("s.yaml:2: robot.profile"), HasSubstr("there is no file")));
  EXPECT_THAT(ErrorOf(text, "profile_draw: 1"), HasSubstr("goes with robot.profile"));
  EXPECT_THAT(ErrorOf(Replaced(text, "[0.03, 0.04, 0, 0]", "[0.01, 0.04, 0, 0]")),
              HasSubstr("symmetric"));
  EXPECT_THAT(ErrorOf(Replaced(text, "[[0.04", "[[-0.04")), HasSubstr("semi-definite"));
  EXPECT_THAT(ErrorOf(Replaced(text, "robot.load.mass]", "robot.load.colour]"),
                      "profile: p.yaml, profile_draw: 1"),
              HasSubstr("robot.load.colour"));
}

TEST_F(ProfileTest, DrawsHaveTheProfilesCovariance) {
  constexpr int kDraws = 1000;
  double a = 0, b = 0, aa = 0, ab = 0, bb = 0;
  int clamped = 0;
  for (int n = 1; n <= kDraws; ++n) {
    const Scenario drawn = Drawn(n);
    const double x = drawn.plant.arm.friction_law->viscous[0] - 1;
    const double y = drawn.plant.arm.friction_law->viscous[1] - 2;
    a += x / kDraws, b += y / kDraws;
    aa += x * x / kDraws, ab += x * y / kDraws, bb += y * y / kDraws;
    EXPECT_EQ(drawn.plant.arm.friction_law->viscous[2], 3);
    EXPECT_GE(drawn.robot.load.m_load, 0);
    clamped += drawn.robot.load.m_load == 0 ? 1 : 0;
  }
  EXPECT_NEAR(a, 0, 0.025);
  EXPECT_NEAR(b, 0, 0.025);
  EXPECT_NEAR(aa, 0.04, 0.008);
  EXPECT_NEAR(ab, 0.03, 0.007);
  EXPECT_NEAR(bb, 0.04, 0.008);
  EXPECT_NEAR(clamped / double{kDraws}, 0.309, 0.06) << "below 0: half a deviation off the mean";
  EXPECT_EQ(Drawn(7), Drawn(7));
  EXPECT_EQ(Drawn(0), With(""));
}

TEST_F(ProfileTest, SaysWhatItDoesNotHoldFor) {
  const Profile profile = *With("").places.profile;
  JointVector speed{};
  EXPECT_EQ(profile.Excess(speed, 1), "");
  EXPECT_EQ(profile.Excess(speed, 2),
            "profile p.yaml: the load is 2 kg; the profile holds for 0 to 1.2 kg");
  speed[3] = 1.5;
  EXPECT_EQ(profile.Excess(speed, 1),
            "profile p.yaml: joint 4 moves at up to 1.5 rad/s; the profile holds for 1 rad/s");
}

TEST_F(ProfileTest, KeysOfOneArmAreReadAndWritten) {
  std::string links;
  for (int i = 0; i < 7; ++i) {
    links +=
        "    - {mass: 2 kg, position: [0 m, 0 m, 0.1 m], "
        "inertia: [0.1 kg m^2, 0.1 kg m^2, 0.1 kg m^2]}\n";
  }
  const Scenario scenario = With(
      "plant:\n  friction: {offset: {unit: Nm, values: [1, 0, 0, 0, 0, 0, -1]}}\n"
      "  elasticity: {unit: Nm/rad, values: [2000, 2000, 2000, 2000, 2000, 2000, 2000]}\n"
      "  links:\n" +
          links,
      "model: panda");
  EXPECT_EQ(scenario.plant.arm.friction_law->offset[6], -1);
  EXPECT_EQ(scenario.plant.elasticity, plant::ElasticityProfile::kStatic);
  EXPECT_EQ(scenario.plant.arm.links.size(), 7U);
  EXPECT_EQ(Parse(ToYaml(scenario), "again.yaml"), scenario);
}

}  // namespace
}  // namespace twin::scenario::scenario_profile_test
