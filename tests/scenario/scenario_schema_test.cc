#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "scenario/schema.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_schema_test {

struct Inner {
  double share = 0.5;
  bool operator==(const Inner&) const = default;
};

struct Outer {
  std::string text = "a b";
  Duration wait = std::chrono::milliseconds(2);
  std::optional<double> far{};
  std::vector<Inner> items{};
};

static void Describe(Map& map, Inner& inner) {
  map.Require("share", Number(inner.share, 0, 1), "A share.");
}

static void Describe(Map& map, Outer& outer) {
  map.Add("text", Text(outer.text), "A text.");
  map.Add("wait", TimeSpan(outer.wait, Duration::zero(), std::chrono::seconds(1)), "A time.");
  map.Add("far",
          Optional(outer.far, [](double& x) { return Quantity(x, Dimension::kLength, 0, 9); }),
          "A length.");
  map.Add("items", ListOf(outer.items), "Items.");
}

namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

Outer Read(const std::string& text) {
  Outer outer;
  SectionOf(outer).read(YamlNode::Parse(text, "f.yaml"));
  return outer;
}

TEST(SchemaTest, ReadsWhatOneVisitDescribes) {
  const Outer outer = Read("wait: 3 us\nfar: 10 mm\nitems:\n  - {share: 0.25}\n");
  EXPECT_EQ(outer.text, "a b");
  EXPECT_EQ(outer.wait, std::chrono::microseconds(3));
  EXPECT_EQ(outer.far, 0.01);
  EXPECT_EQ(outer.items, std::vector<Inner>{{0.25}});
}

TEST(SchemaTest, WritesWhatOneVisitDescribes) {
  Outer outer{.far = 0.25, .items = {{0}, {1}}};
  EXPECT_EQ(SectionOf(outer).write(-1),
            "{text: \"a b\", wait: 2 ms, far: 0.25 m, items: [{share: 0}, {share: 1}]}");
  EXPECT_EQ(SectionOf(outer, Style::kBlock).write(2),
            "\n  text: \"a b\"\n  wait: 2 ms\n  far: 0.25 m\n  items:\n    - {share: 0}\n    - "
            "{share: 1}");
}

TEST(SchemaTest, ChecksTheRangesOfWhatNoFileGave) {
  Outer outer{.items = {{0}, {1.5}}};
  EXPECT_THAT([&] { SectionOf(outer).check("top"); },
              ThrowsMessage<InputError>("top.items[2].share: 1.5 is out of range; it must lie in "
                                        "[0, 1]"));
  outer = {.far = std::numeric_limits<double>::quiet_NaN()};
  EXPECT_THAT([&] { SectionOf(outer).check("top"); },
              ThrowsMessage<InputError>(HasSubstr("top.far: nan m is out")));
}

TEST(SchemaTest, RefusesUnknownAndMissingKeysByPlace) {
  EXPECT_THAT([] { (void)Read("text: a\nweit: 3 us\n"); },
              ThrowsMessage<InputError>("f.yaml:2: unknown key \"weit\"; did you mean \"wait\"? "
                                        "accepted: text, wait, far, items"));
  EXPECT_THAT([] { (void)Read("items:\n  - {}\n"); },
              ThrowsMessage<InputError>("f.yaml:2: items[1]: key \"share\" is missing"));
}

/// Scenarios made in C++ are held to the ranges of files.
TEST(ScenarioTest, ChecksScenariosThatNoFileGave) {
  const auto refuses = [](const std::string& key, const std::function<void(Scenario&)>& spoil) {
    Scenario scenario = Parse(test::TouchedText(), "s.yaml");
    spoil(scenario);
    EXPECT_THAT([&] { scenario.Validate(); }, ThrowsMessage<InputError>(HasSubstr(key + ": ")));
  };
  refuses("tick.low_pass", [](Scenario& s) { s.tick.low_pass_hz = 2000; });
  refuses("tick.stall_time", [](Scenario& s) { s.tick.stall_time = Duration::zero(); });
  refuses("onboard.K_x.rotation[2]", [](Scenario& s) { s.onboard.K_x[4] = 0; });
  refuses("onboard.load", [](Scenario& s) { s.onboard.load.I_load[0] = 1; });
  refuses("link.state_delay",
          [](Scenario& s) { s.link.state.delay.law = faults::ConstantDelay{Duration(-1)}; });
  refuses("perturbations[1].push", [](Scenario& s) {
    std::get<plant::Push>(s.perturbations[0]).rise = std::chrono::hours(1);
  });
  refuses("render.camera.distance", [](Scenario& s) { s.render.camera.distance = 0; });
}

}  // namespace
}  // namespace twin::scenario::scenario_schema_test
