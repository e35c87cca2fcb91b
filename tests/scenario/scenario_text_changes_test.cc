#include "twin/scenario/text_changes.h"

#include <gtest/gtest.h>

#include "twin/core/error.h"

namespace twin::scenario::scenario_text_changes_test {
namespace {

std::string Over(const std::string& text, const std::string& changes) {
  return WithChanges(text, "a.yaml", changes);
}

TEST(WithChangesTest, MergesMapsKeyByKey) {
  EXPECT_EQ(Over("link: {state_loss: 1 %, d_INT: 100 us}", R"({"link": {"state_loss": "2 %"}})"),
            "link:\n  state_loss: 2 %\n  d_INT: 100 us\n");
}

TEST(WithChangesTest, ReplacesListsAndValuesAndAddsKeys) {
  EXPECT_EQ(ToJson(Over("a: [1, 2]\nb: {c: 3}\n", R"({"a": [4], "b": 5, "d": {"e": 6}})"), "a"),
            R"({"a":[4],"b":5,"d":{"e":6}})");
}

TEST(WithChangesTest, RemovesWhatIsNull) {
  EXPECT_EQ(ToJson(Over("tick: {limiter: true, lambda: 1}", R"({"tick": {"limiter": null}})"), "a"),
            R"({"tick":{"lambda":1}})");
  EXPECT_EQ(ToJson(Over("a: 1", R"({"b": null})"), "a"), R"({"a":1})");
}

TEST(WithChangesTest, ChangesOneOfTwoKeysThatShareAValue) {
  EXPECT_EQ(ToJson(Over("a: &x {c: 1, d: 1}\nb: *x\n", R"({"a": {"c": 2}})"), "a"),
            R"({"a":{"c":2,"d":1},"b":{"c":1,"d":1}})");
}

TEST(WithChangesTest, KeepsAKeyThatIsGivenTwiceForTheReaderToRefuse) {
  EXPECT_EQ(Over("a: 1\na: 2\n", R"({"b": 3})"), "a: 1\na: 2\nb: 3\n");
}

TEST(WithChangesTest, KeepsTextsWithEveryCharacterOfJson) {
  const std::string text = R"({"description":"a: \"b\" # c\\ \n - d\té"})";
  EXPECT_EQ(ToJson(Over("description: x", text), "a"), text);
}

TEST(WithChangesTest, NamesTheTextThatIsInvalid) {
  const auto message = [](const std::string& text, const std::string& changes) {
    try {
      Over(text, changes);
    } catch (const InputError& error) {
      return std::string(error.what());
    }
    return std::string("none");
  };
  EXPECT_TRUE(message("a: [1", "{}").starts_with("a.yaml:")) << message("a: [1", "{}");
  EXPECT_TRUE(message("a: 1", "{").starts_with("changes:")) << message("a: 1", "{");
  EXPECT_TRUE(message("a: 1", "[2]").starts_with("changes:1: a map")) << message("a: 1", "[2]");
}

TEST(ToJsonTest, TellsNumbersFromTexts) {
  EXPECT_EQ(ToJson(R"(a: 1
b: 18446744073709551615
c: -0.5
d: 1e-3
e: "1"
f: 1 %
g: true
h:
i: nan
)",
                   "a"),
            R"({"a":1,"b":18446744073709551615,"c":-0.5,"d":0.001,"e":"1","f":"1 %","g":true,)"
            R"("h":null,"i":"nan"})");
}

}  // namespace
}  // namespace twin::scenario::scenario_text_changes_test
