#include <filesystem>
#include <numbers>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario {
namespace {

std::filesystem::path Scenarios() {
  return std::filesystem::path(TWIN_SOURCE_DIR) / "models" / "scenarios";
}

TEST(ScenarioTest, ReadsEveryKey) {
  const Scenario s = Parse(test::FullText(), "s.yaml");
  EXPECT_EQ(s.name, "full");
  EXPECT_EQ(s.seed, 42u);
  EXPECT_EQ(s.robot.hand, plant::HandKind::kNone);
  EXPECT_EQ(s.robot.q_start.value()[1], -std::numbers::pi / 180 * 45);
  EXPECT_EQ(s.plant.kind, robot::PlantKind::kIdeal);
  EXPECT_EQ(s.plant.friction, plant::FrictionProfile::kBreakaway);
  EXPECT_FALSE(s.plant.armature);
  EXPECT_EQ(s.plant.noise_tau_J, 0.3);
  EXPECT_EQ(s.link.state_delay.median, std::chrono::microseconds(80));
  EXPECT_EQ(s.link.state_delay.offset, std::chrono::microseconds(20));
  EXPECT_EQ(s.link.command_delay.constant, std::chrono::nanoseconds(95'500));
  EXPECT_EQ(s.link.command_loss_percent, 2);
  EXPECT_EQ(s.onboard.abort_after_lost, 19u);
  EXPECT_EQ(s.tick.generator, loop::Generator::kNone);
  EXPECT_EQ(s.controller.rate_hz, 125);
  EXPECT_EQ(s.controller.clock_drift_ppm, -20);
  EXPECT_EQ(s.controller.feed_forward, reference::FeedForwardTime::kNominal);
  EXPECT_EQ(s.motion.interface, control::CommandInterface::kJointVelocity);
  EXPECT_EQ(s.motion.timing.duration, std::chrono::milliseconds(4500));
  ASSERT_EQ(s.motion.waypoints.size(), 3u);
  EXPECT_TRUE(s.motion.waypoints[1].stop);
  EXPECT_EQ(s.motion.waypoints[1].where, "s.yaml:49");
  EXPECT_EQ(s.render.lookat[2], 0.4);
  EXPECT_FALSE(s.record);
}

TEST(ScenarioTest, SurvivesBeingWrittenAndRead) {
  const Scenario scenario = Parse(test::FullText(), "s.yaml");
  const std::string text = ToYaml(scenario);
  EXPECT_EQ(Parse(text, "t.yaml"), scenario) << text;
  EXPECT_EQ(ToYaml(Parse(text, "t.yaml")), text);
}

TEST(ScenarioTest, WritesTextsThatYamlWouldMistake) {
  Scenario scenario = Parse(test::FullText(), "s.yaml");
  for (const char* text : {"", "true", "a: b # c", "\"quoted\" \\ back", "two\nlines\ttab\x01",
                           "- [x", "\xc3\xa4\xc3\xb6\xc3\xbc"}) {
    scenario.description = text;
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml").description, text);
  }
}

TEST(ScenarioTest, TakesDefaultsForWhatIsNotGiven) {
  const Scenario s = Parse(
      "name: a\nmotion:\n  trajectory:\n    unit: rad\n    waypoints:\n"
      "      - {q: [0, 0, 0, -1, 0, 1, 0]}\n      - {q: [0, 0, 0, -2, 0, 1, 0]}\n",
      "s.yaml");
  EXPECT_EQ(s.onboard, OnboardSection{});
  EXPECT_EQ(s.link, LinkSection{});
  EXPECT_EQ(s.controller, ControllerSection{});
  EXPECT_EQ(s.backend, "mujoco");
}

TEST(ScenarioTest, EveryExampleLoadsAndSurvivesTheRoundTrip) {
  std::size_t examples = 0;
  for (const auto& entry : std::filesystem::directory_iterator(Scenarios())) {
    if (entry.path().extension() != ".yaml" || entry.path().stem().extension() == ".hash") continue;
    SCOPED_TRACE(entry.path());
    const Scenario scenario = Load(entry.path());
    EXPECT_EQ(Parse(ToYaml(scenario), "t.yaml"), scenario);
    EXPECT_EQ(scenario.name, entry.path().stem().string());
    ++examples;
  }
  EXPECT_GE(examples, 5u);
}

}  // namespace
}  // namespace twin::scenario
