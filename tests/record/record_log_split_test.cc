#include "twin/record/log_split.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "record/sample_records.h"
#include "record/stuck_file.h"
#include "record/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/record/mcap_reader.h"
#include "twin/record/recorder.h"

namespace twin::record::record_log_split_test {
namespace {

using std::chrono::milliseconds;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// Names of the folder's files, sorted.
std::vector<std::string> Names(const TemporaryFolder& folder) {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(folder.path())) {
    names.push_back(file.path().filename());
  }
  std::ranges::sort(names);
  return names;
}

/// Cycles with their ticks, and a scene for every 40.
void PutCycles(Recorder& recorder, std::uint64_t from, std::uint64_t until) {
  for (std::uint64_t k = from; k < until; ++k) {
    recorder.Put(SampleCycle(k));
    if (k % 40 == 0) recorder.Put(SampleScene(k));
    recorder.Put(SampleTick(k));
  }
}

RecordingSummary Record(const std::filesystem::path& path, const LogSplit& split,
                        std::uint64_t cycles) {
  Recorder recorder(path, SampleRun(), FullRing::kWait, split);
  PutCycles(recorder, 0, cycles);
  return recorder.Finish();
}

/// Reads a file. @returns the numbers of its cycles, after checking that each has so many ticks,
/// and that ticks and scenes come after their cycle.
std::vector<std::uint64_t> CyclesOf(const std::filesystem::path& path,
                                    std::uint64_t ticks_of_each = 1) {
  std::vector<std::uint64_t> cycles;
  std::uint64_t ticks = 0;
  LogReader reader(path);
  EXPECT_FALSE(reader.truncated());
  EXPECT_EQ(reader.run().scenario_yaml, SampleRun().scenario_yaml);
  LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* cycle = std::get_if<record::CycleRecord>(&entry)) {
      cycles.push_back(cycle->state.message_id - 1000);
      EXPECT_EQ(cycle->state.m_load, SampleCycle(cycles.back()).state.m_load) << "its own config";
    } else if (const auto* tick = std::get_if<record::TickRecord>(&entry)) {
      ++ticks;
      EXPECT_EQ(tick->message_id - 1000, cycles.back());
    } else {
      EXPECT_FALSE(cycles.empty());
    }
  }
  EXPECT_EQ(ticks, ticks_of_each * cycles.size());
  return cycles;
}

TEST(LogSplitTest, ByTimeEachCycleIsInOneFile) {
  const TemporaryFolder folder;
  const RecordingSummary summary = Record(folder / "a.mcap", {.time = milliseconds(300)}, 1000);
  EXPECT_THAT(Names(folder),
              ElementsAre("a_0001.mcap", "a_0002.mcap", "a_0003.mcap", "a_0004.mcap"));
  std::uint64_t next = 0;
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::map<std::string, std::uint32_t> sequences;
  for (std::size_t number = 1; number <= 4; ++number) {
    const auto path = LogPart(folder / "a.mcap", number);
    const auto cycles = CyclesOf(path);
    EXPECT_EQ(cycles.size(), number < 4 ? 300U : 100U);
    for (const std::uint64_t k : cycles) EXPECT_EQ(k, next++);
    McapReader reader(path);
    while (const auto message = reader.Next()) {
      EXPECT_EQ(message->sequence, sequences[message->channel->topic]++);
    }
    messages += reader.message_count();
    bytes += std::filesystem::file_size(path);
  }
  EXPECT_EQ(next, 1000U);
  EXPECT_EQ(sequences["/robot/cycle"], 1000U);
  EXPECT_EQ(sequences["/robot/config"], 5U) << "in each file, and on change";
  EXPECT_EQ(summary.messages, messages);
  EXPECT_EQ(summary.bytes, bytes);
}

TEST(LogSplitTest, BySizeEachCycleIsInOneFile) {
  constexpr std::uint64_t kBytes = 400'000;
  const TemporaryFolder folder;
  Record(folder / "a.mcap", {.bytes = kBytes}, 2000);
  const auto names = Names(folder);
  ASSERT_GT(names.size(), 2U);
  std::uint64_t next = 0;
  for (const std::string& name : names) {
    for (const std::uint64_t k : CyclesOf(folder / name)) EXPECT_EQ(k, next++);
    const auto size = std::filesystem::file_size(folder / name);
    EXPECT_LT(size, kBytes + 2 * Recorder::kChunkBytes);
    EXPECT_TRUE(size >= kBytes || name == names.back()) << size;
  }
  EXPECT_EQ(next, 2000U);
}

TEST(LogSplitTest, SameRecordsGiveSameFiles) {
  const TemporaryFolder first;
  const TemporaryFolder second;
  const LogSplit split{.time = milliseconds(700), .bytes = 300'000};
  Record(first / "a.mcap", split, 1000);
  Record(second / "a.mcap", split, 1000);
  ASSERT_GT(Names(first).size(), 2U);
  ASSERT_EQ(Names(first), Names(second));
  for (const std::string& name : Names(first)) {
    EXPECT_EQ(ReadText(first / name), ReadText(second / name)) << name;
  }
}

TEST(LogSplitTest, WhenTimeGoesBackAFileIsNotLonger) {
  const TemporaryFolder folder;
  {
    Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {.time = milliseconds(300)});
    PutCycles(recorder, 500, 600);
    PutCycles(recorder, 0, 400);
    recorder.Finish();
  }
  EXPECT_EQ(CyclesOf(folder / "a_0001.mcap").size(), 100U + 300U);
  EXPECT_EQ(CyclesOf(folder / "a_0002.mcap").size(), 100U);
}

TEST(LogSplitTest, KeepsTheNewestAndReplacesNoEarlierLog) {
  const TemporaryFolder folder;
  const LogSplit split{.time = milliseconds(100), .keep = 3};
  Record(folder / "a.mcap", split, 200);
  const std::string earlier = ReadText(folder / "a_0002.mcap");
  std::ofstream(folder / "a_0000.mcap") << "no number";
  std::ofstream(folder / "a_0001x.mcap") << "no number";
  std::ofstream(folder / "a_0003.mcap") << "the user's";
  std::ofstream(folder / "ab_0001.mcap") << "another log";
  Record(folder / "a.mcap", split, 200);
  EXPECT_THAT(Names(folder),
              ElementsAre("a_0000.mcap", "a_0001x.mcap", "a_0002.mcap", "a_0003.mcap",
                          "a_0004.mcap", "a_0005.mcap", "ab_0001.mcap"))
      << "of four logs three";
  EXPECT_EQ(ReadText(folder / "a_0003.mcap"), "the user's");
  EXPECT_EQ(ReadText(folder / "a_0002.mcap"), earlier);
}

TEST(LogSplitTest, AnUnfinishedFileOfAKilledRunIsKeptAndCounts) {
  const TemporaryFolder folder;
  {
    Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {.time = milliseconds(100)});
    PutCycles(recorder, 0, 50);
  }
  EXPECT_THAT(Names(folder), ElementsAre("a_0001.mcap.partial"));
  Record(folder / "a.mcap", {.time = milliseconds(100), .keep = 2}, 100);
  EXPECT_THAT(Names(folder), ElementsAre("a_0001.mcap.partial", "a_0002.mcap"));
  Record(folder / "a.mcap", {.time = milliseconds(100), .keep = 2}, 100);
  EXPECT_THAT(Names(folder), ElementsAre("a_0002.mcap", "a_0003.mcap"));
}

TEST(LogSplitTest, TwoDoNotWriteOneLog) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {.time = milliseconds(100)});
  PutCycles(recorder, 0, 150);
  try {
    const Recorder second(folder / "a.mcap", SampleRun(), FullRing::kWait,
                          {.time = milliseconds(100)});
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("another run writes"));
  }
  recorder.Finish();
}

TEST(LogSplitTest, AFileThatCannotBeginEndsTheLogAndLeavesTheFilesBefore) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {.time = milliseconds(300)});
  std::filesystem::create_directory(folder / "a_0002.mcap");
  PutCycles(recorder, 0, 1000);
  try {
    recorder.Finish();
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("a_0002.mcap: it is a directory"));
  }
  EXPECT_EQ(CyclesOf(folder / "a_0001.mcap").size(), 300U);
  EXPECT_THAT(Names(folder), ElementsAre("a_0001.mcap", "a_0002.mcap"));
}

TEST(LogSplitTest, AFileThatCannotBeCompletedIsToldWhileTheNextIsWritten) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {.time = milliseconds(300)});
  std::filesystem::create_directory(folder / "a_0001.mcap");  // it takes the file's name
  for (std::uint64_t k = 0; recorder.Failure().empty(); ++k) PutCycles(recorder, k, k + 1);
  EXPECT_THAT(recorder.Failure(), HasSubstr("a_0001.mcap.partial: cannot be given the name"));
  EXPECT_THROW(recorder.Finish(), EnvironmentError);
  EXPECT_THAT(Names(folder),
              ElementsAre("a_0001.mcap", "a_0001.mcap.partial", "a_0002.mcap.partial"));
}

TEST(LogSplitTest, ADiskThatIsStuckAtAFilesEndHoldsUpNobody) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kDrop, {.time = milliseconds(100)});
  StuckFile file(folder / "a_0002.mcap.partial");  // takes 64 kB, and a file is larger
  for (std::uint64_t k = 0; k < 290; ++k) recorder.Put(SampleCycle(k));
  while (!std::filesystem::exists(folder / "a_0003.mcap.partial")) std::this_thread::yield();
  EXPECT_TRUE(std::filesystem::exists(folder / "a_0002.mcap.partial"));
  file.Release();
  EXPECT_EQ(recorder.Finish().dropped, 0U);
  EXPECT_EQ(CyclesOf(folder / "a_0001.mcap", 0).size(), 100U);
  EXPECT_EQ(CyclesOf(folder / "a_0003.mcap", 0).size(), 90U);
}

TEST(LogSplitTest, ReadsTimesAndSizes) {
  EXPECT_EQ(ParseLogSplit("1h").time, std::chrono::hours(1));
  EXPECT_EQ(ParseLogSplit("1.5 h").time, std::chrono::minutes(90));
  EXPECT_EQ(ParseLogSplit("90 s").time, std::chrono::seconds(90));
  EXPECT_EQ(ParseLogSplit("30min").time, std::chrono::minutes(30));
  EXPECT_EQ(ParseLogSplit("512MiB").bytes, std::uint64_t{512} << 20);
  EXPECT_EQ(ParseLogSplit("2 GB").bytes, 2'000'000'000U);
  EXPECT_FALSE(ParseLogSplit("1h").bytes);
  EXPECT_FALSE(ParseLogSplit("64KiB").time);
  for (const char* wrong : {"", "1", "h", "MiB", "1 MiB h", "-1h", "0 s", "50ms", "63KiB", "nan h",
                            "1e300 h", "1e300 GiB", "infGiB", "5 N", "1m"}) {
    EXPECT_THROW(static_cast<void>(ParseLogSplit(wrong)), InputError) << wrong;
  }
}

TEST(LogSplitTest, NamesItsFiles) {
  EXPECT_EQ(LogPart("logs/a.b.mcap", 7), "logs/a.b_0007.mcap");
  EXPECT_EQ(LogPart("log", 12345), "log_12345");
}

}  // namespace
}  // namespace twin::record::record_log_split_test
