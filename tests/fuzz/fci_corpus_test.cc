// The targets of the wire over the seeds that fuzzing starts from, as they are and changed by
// seeded mutations: what libFuzzer does at length.

#include <cstddef>
#include <map>
#include <ostream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "fuzz/fci_targets.h"
#include "fuzz/mutations.h"
#include "fuzz/seeds.h"
#include "fuzz/session_targets.h"

namespace twin::fci::fci_corpus_test {
namespace {

using test::Seeds;
using test::SeedsOf;

constexpr std::uint64_t kRounds = 20'000;

struct Case {
  const char* name;
  fuzz::Target target;
};

void PrintTo(const Case& test_case, std::ostream* out) {
  *out << test_case.name;
}

class FciCorpusTest : public ::testing::TestWithParam<Case> {};

TEST_P(FciCorpusTest, SurvivesItsSeedsAndTheirMutations) {
  std::vector<std::vector<std::byte>> whole{{}};
  for (const auto& [name, bytes] : SeedsOf(GetParam().name)) whole.push_back(bytes);
  ASSERT_GT(whole.size(), 5u);
  fuzz::FeedMutations(GetParam().target, whole, 1, kRounds);
}

INSTANTIATE_TEST_SUITE_P(Targets, FciCorpusTest,
                         ::testing::Values(Case{"server_tcp", fuzz::ArmSession},
                                           Case{"server_udp", fuzz::CommandDatagram},
                                           Case{"client_tcp", fuzz::ArmAnswers},
                                           Case{"client_udp", fuzz::StateDatagram},
                                           Case{"gripper", fuzz::Gripper}),
                         [](const auto& info) { return std::string(info.param.name); });

/// How much a session's seed has said.
using Tally = fuzz::SessionTally;

TEST(FciCorpusSessionTest, ArmSessionsAreAnsweredAsTheyWereMeant) {
  const Seeds seeds = SeedsOf("server_tcp");
  const std::map<std::string, Tally> expected{
      {"setters", {12, 12, false}},
      {"motion", {2, 3, false}},
      {"every_mode", {13, 25, false}},
      {"stop", {4, 5, false}},
      {"many_stops", {67, 2, true}},  // the 65th that waits ends the session
      {"reflex", {6, 8, false}},
      {"user_stop", {5, 7, false}},
      {"refused_while_moving", {5, 6, false}},
      {"bytes_one_by_one", {3, 4, false}},
      {"wrong_version", {1, 1, true}},
      {"no_connect", {1, 0, true}},
      {"second_connect", {2, 1, true}},
      {"bad_values", {3, 3, false}},
      {"too_large", {1, 1, true}},
      {"unknown", {2, 1, true}},
  };
  ASSERT_EQ(seeds.size(), expected.size());
  for (const auto& [name, bytes] : seeds) {
    EXPECT_TRUE(fuzz::RunArmSession(bytes) == expected.at(name)) << name;
  }
}

TEST(FciCorpusSessionTest, HandSessionsAreAnsweredAsTheyWereMeant) {
  const std::map<std::string, Tally> expected{
      {"session_commands", {5, 5, false}},     {"session_aborted_by_the_next", {5, 5, false}},
      {"session_failures", {3, 3, false}},     {"session_bad_values", {3, 3, false}},
      {"session_wrong_version", {1, 1, true}}, {"session_bytes_one_by_one", {2, 2, false}},
  };
  const Seeds seeds = SeedsOf("gripper");
  for (const auto& [name, tally] : expected) {
    const std::vector<std::byte>& bytes = seeds.at(name);
    EXPECT_TRUE(fuzz::RunHandSession(fuzz::Bytes(bytes).subspan(1)) == tally) << name;
  }
}

}  // namespace
}  // namespace twin::fci::fci_corpus_test
