#include "twin/server/control_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "fuzz/mutations.h"
#include "twin/core/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace twin::server::server_control_request_test {
namespace {

using ::testing::HasSubstr;

std::string RefusalOf(std::string_view line) {
  try {
    static_cast<void>(ParseControlRequest(line));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

std::string RefusalOf(const std::vector<std::string>& words) {
  try {
    static_cast<void>(ControlRequestOf(words));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ControlRequestTest, ReadsALineAndTheSameWordsAlike) {
  const auto expect = [](std::string_view line, const std::vector<std::string>& words,
                         const ControlRequest& meant) {
    EXPECT_EQ(ParseControlRequest(line), meant) << line;
    EXPECT_EQ(ControlRequestOf(words), meant) << line;
  };
  expect(R"({"do": "status"})", {"status"}, {});
  expect(R"({"do": "pause"})", {"pause"}, {.verb = ControlVerb::kPause});
  expect(R"({"cycles": 10, "do": "step"})", {"step", "10"},
         {.verb = ControlVerb::kStep, .cycles = 10});
  expect(R"({"do": "step"})", {"step"}, {.verb = ControlVerb::kStep, .cycles = 1});
  expect(R"({"do": "user-stop", "on": true})", {"user-stop", "press"},
         {.verb = ControlVerb::kUserStop, .on = true});
  expect(R"({"do": "user-stop", "on": false})", {"user-stop", "release"},
         {.verb = ControlVerb::kUserStop, .on = false});
  expect(R"({"do": "guiding", "on": true})", {"guiding", "on"},
         {.verb = ControlVerb::kGuiding, .on = true});
  expect(R"({"do": "recover"})", {"recover"}, {.verb = ControlVerb::kRecover});
  expect(R"({"do": "reset"})", {"reset"}, {.verb = ControlVerb::kReset});
  expect(R"({"do": "reset", "q": [0, -0.5, 0, -2, 1e-3, 1.5, 0.7]})",
         {"reset", "0", "-0.5", "0", "-2", "0.001", "1.5", "0.7"},
         {.verb = ControlVerb::kReset, .q = JointVector{0, -0.5, 0, -2, 1e-3, 1.5, 0.7}});
  expect(R"({"do": "place", "name": "box", "position": [0.5, -0.1, 0.3], "rpy": [0, 0, 1.57]})",
         {"place", "box", "0.5", "-0.1", "0.3", "0", "0", "1.57"},
         {.verb = ControlVerb::kPlace,
          .name = "box",
          .position = {0.5, -0.1, 0.3},
          .rpy = {0, 0, 1.57}});
  expect(R"({"do": "place", "position": [0.5, -0.1, 0.3], "name": "a box"})",
         {"place", "a box", "0.5", "-0.1", "0.3"},
         {.verb = ControlVerb::kPlace, .name = "a box", .position = {0.5, -0.1, 0.3}});
  expect(R"({"do": "snapshot"})", {"snapshot"}, {.verb = ControlVerb::kSnapshot, .name = "last"});
  expect(R"({"do": "restore", "name": "a"})", {"restore", "a"},
         {.verb = ControlVerb::kRestore, .name = "a"});
}

TEST(ControlRequestTest, SaysWhatIsWrongWithAPlace) {
  const auto line = [](const char* more) {
    return RefusalOf(std::string(R"({"do": "place", "name": "box")") + more + "}");
  };
  EXPECT_THAT(line(""), HasSubstr("\"position\" is missing"));
  EXPECT_THAT(RefusalOf(R"({"do": "place", "position": [0, 0, 0]})"),
              HasSubstr("\"name\" is missing"));
  for (const char* p :
       {"[]", "[0,0]", "[0,0,0,0]", "[0,0,\"1\"]", "[0,0,1e999]", "[0,0,100.1]", "0"}) {
    EXPECT_NE(line((std::string(", \"position\": ") + p).c_str()), "accepted") << p;
  }
  EXPECT_THAT(line(", \"position\": [0,0,0], \"rpy\": [0,0]"), HasSubstr("three finite angles"));
  using Words = std::vector<std::string>;
  EXPECT_THAT(RefusalOf(Words{"place", "box", "0", "0"}), HasSubstr("NAME X Y Z"));
  EXPECT_THAT(RefusalOf(Words{"place", "box", "0", "0", "nan"}), HasSubstr("[-100, 100]"));
}

TEST(ControlRequestTest, SaysWhatIsWrongWithAName) {
  for (const char* name : {"\"\"", "1", "null", "\"a\\nb\"", "\"\u00e4\""}) {
    EXPECT_THAT(RefusalOf(std::string(R"({"do": "snapshot", "name": )") + name + "}"),
                HasSubstr("printable ASCII"))
        << name;
  }
  using Words = std::vector<std::string>;
  EXPECT_THAT(RefusalOf(Words{"restore", std::string(65, 'a')}), HasSubstr("1 to 64"));
  EXPECT_THAT(RefusalOf(Words{"restore", "a", "b"}), HasSubstr("\"b\" is too much"));
}

TEST(ControlRequestTest, SaysWhatIsWrongWithALine) {
  EXPECT_THAT(RefusalOf("GET / HTTP/1.1\r"), HasSubstr(R"("GET / HTTP/1.1?" is not a request)"));
  EXPECT_THAT(RefusalOf("[]"), HasSubstr("is not a request"));
  EXPECT_THAT(RefusalOf("{}"), HasSubstr("no \"do\""));
  EXPECT_THAT(RefusalOf(R"({"do": "fly"})"), HasSubstr("choose one of status, pause, step"));
  EXPECT_THAT(RefusalOf(R"({"do": "pause", "cycles": 1})"), HasSubstr("no key \"cycles\""));
  EXPECT_THAT(RefusalOf(R"({"do": "guiding"})"), HasSubstr("\"on\" is missing"));
  EXPECT_THAT(RefusalOf(R"({"do": "guiding", "on": 1})"), HasSubstr("true or false"));
  for (const char* cycles : {"0", "-1", "1.5", "86400001", "1e99", "\"5\"", "null"}) {
    EXPECT_THAT(RefusalOf(std::string(R"({"do": "step", "cycles": )") + cycles + "}"),
                HasSubstr("[1, 86400000]"))
        << cycles;
  }
}

TEST(ControlRequestTest, ReadyIsThePoseInWhichFrankaDeliversTheArm) {
  const std::vector<std::string> words{"reset", "ready"};
  const double eighth = std::numbers::pi / 4;
  EXPECT_EQ(ControlRequestOf(words).q,
            (JointVector{0, -eighth, 0, -3 * eighth, 0, 2 * eighth, eighth}));
}

TEST(ControlRequestTest, SaysWhatIsWrongWithAPose) {
  for (const char* q : {"[]", "[0,0,0,0,0,0]", "[0,0,0,0,0,0,0,0]", "[0,0,0,0,0,0,\"1\"]", "null",
                        "0", "[0,0,0,0,0,0,1e999]"}) {
    EXPECT_NE(RefusalOf(std::string(R"({"do": "reset", "q": )") + q + "}"), "accepted") << q;
  }
  using Words = std::vector<std::string>;
  EXPECT_THAT(RefusalOf(Words{"reset", "home"}), HasSubstr("seven finite angles"));
  EXPECT_THAT(RefusalOf(Words{"reset", "0", "1"}), HasSubstr("seven finite angles"));
}

TEST(ControlRequestTest, SaysWhatIsWrongWithWords) {
  using Words = std::vector<std::string>;
  EXPECT_THAT(RefusalOf(Words{"user-stop"}), HasSubstr("press or release"));
  EXPECT_THAT(RefusalOf(Words{"user-stop", "on"}), HasSubstr("neither press nor release"));
  EXPECT_THAT(RefusalOf(Words{"guiding"}), HasSubstr("on or off"));
  EXPECT_THAT(RefusalOf(Words{"step", "x"}), HasSubstr("[1, 86400000]"));
  EXPECT_THAT(RefusalOf(Words{"step", "1", "2"}), HasSubstr("\"2\" is too much"));
  EXPECT_THAT(RefusalOf(Words{"resume", "now"}), HasSubstr("\"now\" is too much"));
}

void Feed(std::span<const std::byte> bytes) {
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
}

std::vector<std::byte> BytesOf(std::string_view text) {
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

TEST(ControlRequestTest, AnyBytesAreARequestOrRefusedInOneLine) {
  constexpr std::uint64_t kSeed = 12;
  RecordProperty("seed", static_cast<int>(kSeed));
  fci::fuzz::FeedMutations(
      &Feed,
      {BytesOf(R"({"do":"status"})"), BytesOf(R"({"do":"step","cycles":86400000})"),
       BytesOf(R"({"do":"user-stop","on":true})"), BytesOf(R"({"do":"guiding","on":false})"),
       BytesOf(R"({"do":"reset","q":[0,-0.5,0,-2,1e-3,1.5,0.7]})"),
       BytesOf(R"({"do":"place","name":"box","position":[0.5,-1e-3,0.3],"rpy":[0,0,1.57]})"),
       BytesOf(R"({"do":"snapshot"})"), BytesOf(R"({"do":"restore","name":"a b"})"),
       BytesOf("{\"do\":\"p\\u0061use\"}"), BytesOf("[[[[[[[[{\"do\":1}]]]]]]]]")},
      kSeed, 20'000);
}

}  // namespace
}  // namespace twin::server::server_control_request_test
