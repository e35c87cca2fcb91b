#include "twin/run/told_events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <variant>
#include <vector>

#include "support/realtime_guard.h"
#include "support/temporary_folder.h"
#include "twin/record/log_reader.h"

namespace twin::run::run_told_events_test {
namespace {

using ::testing::ElementsAre;

record::RunInfo Info() {
  return {.scenario = "session",
          .seed = 1,
          .version = "0.1.0",
          .drive = "lockstep",
          .scenario_yaml = ""};
}

/// A log's events: "KIND at MS: TEXT".
std::vector<std::string> EventsOf(const std::filesystem::path& log) {
  record::LogReader reader(log);
  std::vector<std::string> events;
  record::LogEntry entry;
  while (reader.Next(entry)) {
    const auto* event = std::get_if<record::EventRecord>(&entry);
    if (event == nullptr) continue;
    const auto ms = event->at.time_since_epoch() / kCycle;
    events.push_back(event->kind + " at " + std::to_string(ms) + ": " + event->text);
  }
  return events;
}

TEST(ToldEventsTest, PutsEachLineBeforeTheNextCycle) {
  const twin::test::TemporaryFolder folder;
  RunRecords records;
  records.Log(folder / "a.mcap", Info(), record::FullRing::kWait);
  ToldEvents told(records);
  record::CycleRecord cycle;
  told.Tell("arm: 127.0.0.1:4033 connected; states go to its UDP port 7");
  cycle.at = Time(5 * kCycle);
  told.Put(cycle);
  told.Tell("arm: motion started: joint_position motion under joint_impedance");
  told.Tell("hand: grasp refused");
  cycle.at = Time(6 * kCycle);
  told.Put(cycle);
  told.Tell("arm: motion finished");
  told.Finish();
  records.Finish();
  EXPECT_THAT(EventsOf(folder / "a.mcap"),
              ElementsAre("client at 5: arm: 127.0.0.1:4033 connected; states go to its UDP port 7",
                          "motion at 6: started: joint_position motion under joint_impedance",
                          "hand at 6: grasp refused", "motion at 6: finished"));
}

TEST(ToldEventsTest, AllocatesNothingInACycleAndDropsWhatFindsNoRoom) {
  const twin::test::TemporaryFolder folder;
  RunRecords records;
  records.Log(folder / "a.mcap", Info(), record::FullRing::kWait);
  ToldEvents told(records);
  for (int i = 0; i < 100; ++i) told.Tell("arm: motion finished");
  record::CycleRecord cycle;
  const twin::test::RealtimeGuard guard;
  for (int k = 1; k <= 1000; ++k) {
    cycle.at = Time(k * kCycle);
    told.Tell("arm: motion finished");
    told.Put(cycle);
  }
  EXPECT_EQ(guard.counts(), twin::test::RealtimeGuard::Counts{});
  records.Finish();
  EXPECT_EQ(EventsOf(folder / "a.mcap").size(), 64U + 999U)
      << "64 find room before the first cycle";
}

}  // namespace
}  // namespace twin::run::run_told_events_test
