#include <cstdint>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "scenario/scenario_examples.h"
#include "twin/core/error.h"
#include "twin/core/random.h"
#include "twin/scenario/scenario.h"

namespace twin::scenario::scenario_fuzz_test {
namespace {

/// Seeded mutations of a text: the same case number gives the same text.
class Mutator {
 public:
  explicit Mutator(std::uint64_t number) : number_(number) {}

  std::string Apply(std::string text) {
    const std::uint64_t edits = 1 + Draw(4);
    for (std::uint64_t i = 0; i < edits && !text.empty(); ++i) Edit(text);
    return text;
  }

 private:
  static constexpr std::string_view kTokens[] = {
      "nan", ".inf",     "-1",  "1e999",  "{",          "}",
      "[",   "]",        ":",   "- ",     "\n",         "  ",
      "\t",  "&a ",      "*a",  "!!map ", "|",          "\"",
      "'",   "\xff",     "s",   "true",   "~",          "<<: *a",
      "0",   "%",        "---", "...",    "#",          "18446744073709551616",
      "us",  "us us",    "\\x", "? ",     "scripted: ", "gamma: ",
      "off", "\xc2\xb5s"};

  std::uint64_t Draw(std::uint64_t below) { return random_.Bits(number_, draw_++)[0] % below; }

  void Edit(std::string& text) {
    const std::size_t at = Draw(text.size());
    const std::size_t length = std::min<std::size_t>(1 + Draw(12), text.size() - at);
    switch (Draw(5)) {
      case 0: text.erase(at, length); break;
      case 1: text.insert(at, kTokens[Draw(std::size(kTokens))]); break;
      case 2: text[at] = static_cast<char>(Draw(256)); break;
      case 3: text.insert(Draw(text.size()), text.substr(at, length)); break;
      default: text.resize(at); break;
    }
  }

  Random random_{20261121, RandomStream::kTest};
  std::uint64_t number_;
  std::uint32_t draw_ = 0;
};

TEST(ScenarioFuzzTest, AnyTextIsReadOrRefusedWithOneError) {
  constexpr std::uint64_t kCases = 3000;
  const std::string good[] = {test::FullText(), test::OtherText(), test::TouchedText(),
                              test::PosesText()};
  std::uint64_t refused = 0;
  for (std::uint64_t i = 0; i < kCases; ++i) {
    const std::string text = Mutator(i).Apply(good[i % std::size(good)]);
    SCOPED_TRACE(i);
    try {
      const Scenario scenario = Parse(text, "fuzz.yaml");
      EXPECT_EQ(Parse(ToYaml(scenario), "again.yaml"), scenario) << text;
    } catch (const Error& error) {
      ++refused;
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
    }
  }
  // Both ways must have been taken, or the test tests nothing.
  EXPECT_GT(refused, kCases / 4);
  EXPECT_LT(refused, kCases);
}

}  // namespace
}  // namespace twin::scenario::scenario_fuzz_test
