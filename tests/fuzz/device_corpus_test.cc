// The targets of operators' devices over their seeds, as they are and changed by seeded mutations:
// what libFuzzer does at length. Seeds are called good_... or bad_...

#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "fuzz/device_targets.h"
#include "fuzz/mutations.h"
#include "fuzz/seeds.h"
#include "plugins/devices/operator_message.h"
#include "twin/core/error.h"
#include "twin/teleop/operator_script.h"

namespace twin::devices::device_corpus_test {
namespace {

constexpr std::uint64_t kRounds = 20'000;

void FeedSeeds(const std::string& name, void (*target)(std::span<const std::byte>)) {
  std::vector<std::vector<std::byte>> whole{{}};
  for (const auto& [seed, bytes] : test::SeedsOf(name)) whole.push_back(bytes);
  ASSERT_GT(whole.size(), 5u);
  fci::fuzz::FeedMutations(target, whole, 1, kRounds);
}

TEST(DeviceCorpusTest, DatagramsSurviveTheirSeedsAndTheirMutations) {
  FeedSeeds("operator_datagram", &fuzz::OperatorDatagram);
}

TEST(DeviceCorpusTest, ScriptsSurviveTheirSeedsAndTheirMutations) {
  FeedSeeds("operator_script", &fuzz::OperatorScript);
}

TEST(DeviceCorpusTest, DatagramsAreReadAsTheyWereMeant) {
  for (const auto& [name, bytes] : test::SeedsOf("operator_datagram")) {
    const bool is_read = ParseSample(bytes).has_value() || ParseFeedback(bytes).has_value();
    EXPECT_EQ(is_read, name.starts_with("good_")) << name;
  }
}

TEST(DeviceCorpusTest, ScriptsAreReadAsTheyWereMeant) {
  for (const auto& [name, bytes] : test::SeedsOf("operator_script")) {
    std::istringstream in(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
    bool is_read = true;
    try {
      static_cast<void>(teleop::ReadOperatorScript(in, name));
    } catch (const InputError&) {
      is_read = false;
    }
    EXPECT_EQ(is_read, name.starts_with("good_")) << name;
  }
}

}  // namespace
}  // namespace twin::devices::device_corpus_test
