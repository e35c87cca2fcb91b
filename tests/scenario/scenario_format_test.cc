#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_format_test {
namespace {

/// The default of each key, in the words of the table, is what a scenario without the key has.
TEST(ScenarioFormatTest, TheTableHoldsTheDefaults) {
  const std::string least =
      "name: a\nmotion: {trajectory: {unit: rad, waypoints: [{q: [0, 0, 0, -1, 0, 1, 0]}, {q: [0, "
      "0, 0, -2, 0, 1, 0]}]}}\n";
  const std::string expected = ToYaml(Parse(least, "s.yaml"));
  const std::string table = KeyTable();
  const std::regex row(
      R"(\n\| `(robot|plant|link|onboard|tick|controller|render)\.(\w+)` \|[^|]*\| `([^`]+)` \|)");
  std::size_t rows = 0;
  for (std::sregex_iterator it(table.begin(), table.end(), row), end; it != end; ++it) {
    if (it->str(2) == "library") continue;  // an empty one is refused
    const std::string text = least + it->str(1) + ": {" + it->str(2) + ": " + it->str(3) + "}\n";
    SCOPED_TRACE(text);
    EXPECT_EQ(ToYaml(Parse(text, "s.yaml")), expected);
    ++rows;
  }
  EXPECT_GE(rows, 40u);
}

TEST(ScenarioFormatTest, TheTableInTheDocumentationIsUpToDate) {
  std::ifstream file(std::filesystem::path(TWIN_SOURCE_DIR) / "models/scenarios/KEYS.md");
  const std::string written(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(written, KeyTable()) << "write it anew: build/release/panda-twin schema --keys > "
                                    "models/scenarios/KEYS.md";
}

TEST(ScenarioFormatTest, TheTableSaysWhatEachKeyMeans) {
  std::istringstream table(KeyTable());
  for (std::string line; std::getline(table, line);) {
    EXPECT_FALSE(line.starts_with("| `") && line.ends_with("|  |")) << line;
  }
}

/// Why LoadServed() refuses a file of this text; empty: it does not.
std::string RefusalToServe(const std::string& text) {
  const twin::test::TemporaryFolder folder;
  std::ofstream(folder / "s.yaml") << text;
  try {
    const Scenario served = LoadServed(folder / "s.yaml");
    for (const reference::Waypoint& point : served.motion.waypoints) {
      EXPECT_EQ(point.q, *served.robot.q_start);
    }
    EXPECT_EQ(Parse(ToYaml(served), "s.yaml"), served);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ScenarioFormatTest, ARobotThatIsServedNeedsNoMotionOfItsOwn) {
  const std::string stands =
      "name: a\nrobot: {q_start: {unit: rad, values: [0, 0, 0, -1, 0, 1, 0]}}\n";
  EXPECT_EQ(RefusalToServe(stands), "");
  EXPECT_THROW(static_cast<void>(Parse(stands, "s.yaml")), InputError);
  EXPECT_THAT(RefusalToServe("name: a\n"), ::testing::HasSubstr("give robot.q_start"));
}

}  // namespace
}  // namespace twin::scenario::scenario_format_test
