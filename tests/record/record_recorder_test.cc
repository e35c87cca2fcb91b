#include "twin/record/recorder.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <thread>
#include <vector>

#include "record/sample_records.h"
#include "record/stuck_file.h"
#include "record/temporary_folder.h"
#include "support/effort.h"
#include "support/realtime_guard.h"
#include "twin/core/error.h"
#include "twin/record/log_reader.h"
#include "twin/rt/host_time.h"

namespace twin::record::record_recorder_test {
namespace {

using ::testing::HasSubstr;

void PutCycles(Recorder& recorder, std::uint64_t count) {
  for (std::uint64_t k = 0; k < count; ++k) {
    recorder.Put(SampleCycle(k));
    recorder.Put(SampleTick(k));
  }
}

/// Number of records of a log, after checking that they are SampleCycle and SampleTick in turn.
std::uint64_t CountInOrder(LogReader& reader) {
  std::uint64_t count = 0;
  LogEntry entry;
  for (; reader.Next(entry); ++count) {
    const std::uint64_t k = count / 2;
    if (count % 2 == 0) {
      EXPECT_EQ(std::get<record::CycleRecord>(entry).state.q, SampleCycle(k).state.q);
    } else {
      EXPECT_EQ(std::get<record::TickRecord>(entry).q_ext, SampleTick(k).q_ext);
    }
  }
  return count;
}

std::string LogOf(std::uint64_t cycles) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  PutCycles(recorder, cycles);
  recorder.Event(Time(Duration(1)), "mode", "Move -> Idle");
  const RecordingSummary summary = recorder.Finish();
  std::string bytes = ReadText(folder / "a.mcap");
  EXPECT_EQ(summary.bytes, bytes.size());
  return bytes;
}

TEST(RecorderTest, SameRecordsGiveSameBytes) {
  constexpr std::uint64_t kCycles = test::Repetitions(3000);
  EXPECT_EQ(LogOf(kCycles), LogOf(kCycles));
}

TEST(RecorderTest, CountsWhatItWrote) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  PutCycles(recorder, 100);
  recorder.Event(Time(), "mode", "Idle");
  const RecordingSummary summary = recorder.Finish();
  EXPECT_EQ(summary.messages, 100U + 100U + 1U + 1U + SampleFrames(100))
      << "cycles, ticks, one event, one config, frames";
  EXPECT_EQ(summary.dropped, 0U);
}

TEST(RecorderTest, WithoutFinishKeepsScenesAndNoPlans) {
  const TemporaryFolder folder;
  {
    Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
    recorder.Put(SampleScene(1));
    recorder.Add(SamplePlan());
  }
  LogReader reader(folder / "a.mcap.partial");
  LogEntry entry;
  ASSERT_TRUE(reader.Next(entry));
  EXPECT_TRUE(std::holds_alternative<record::SceneRecord>(entry));
  EXPECT_FALSE(reader.Next(entry));
  EXPECT_TRUE(reader.truncated());
}

TEST(RecorderTest, ASceneTakesAtMostAKilobyte) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  constexpr std::uint64_t kScenes = 1000;
  for (std::uint64_t k = 0; k < kScenes; ++k) recorder.Put(SampleScene(k));
  EXPECT_LE(recorder.Finish().bytes, 1000 * kScenes);
}

/// A cycle of a joint motion with sensor noise: nothing Cartesian is commanded, nothing touches.
record::CycleRecord JointMotionCycle(std::uint64_t k) {
  record::CycleRecord cycle = SampleCycle(k);
  RobotState& s = cycle.state;
  const RobotState still;
  s.O_T_EE_c = still.O_T_EE_c;
  s.joint_contact = s.joint_collision = {};
  s.cartesian_contact = s.cartesian_collision = s.O_dP_EE_c = s.O_ddP_EE_c = {};
  s.elbow_c = s.delbow_c = s.ddelbow_c = {};
  return cycle;
}

TEST(RecorderTest, TheCanonicalRunTakesAtMostThirtyMegabytes) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  constexpr std::uint64_t kCycles = test::Repetitions(18'320);
  for (std::uint64_t k = 0; k < kCycles; ++k) {
    recorder.Put(JointMotionCycle(k));
    record::TickRecord tick = SampleTick(k);
    tick.command.O_T_EE_c = {};
    tick.command.O_dP_EE_c = {};
    tick.command.elbow_c = {};
    tick.command.tau_J_d = {};
    recorder.Put(tick);
  }
  EXPECT_LE(recorder.Finish().bytes, test::Repetitions(30'000'000));
}

TEST(RecorderTest, CutsLongEventsAndKeepsThemReadable) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  // The cut falls into a character of two bytes.
  const std::string head(1999, 'x');
  recorder.Event(Time(), "mode", fmt::format("{}\xc3\xbc and more", head));
  recorder.Finish();
  LogReader reader(folder / "a.mcap");
  LogEntry entry;
  ASSERT_TRUE(reader.Next(entry));
  EXPECT_EQ(std::get<EventRecord>(entry).text, fmt::format("{}?", head));
}

TEST(RecorderTest, WithoutFinishLeavesAllThatWasPutInThePartialFile) {
  const TemporaryFolder folder;
  { PutCycles(*std::make_unique<Recorder>(folder / "a.mcap", SampleRun(), FullRing::kWait), 50); }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap"));
  LogReader reader(folder / "a.mcap.partial");
  EXPECT_TRUE(reader.truncated());
  EXPECT_EQ(CountInOrder(reader), 100U);
}

TEST(RecorderTest, AllocatesNothingAndLocksNothingInPut) {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  const record::CycleRecord cycle = SampleCycle(0);
  const record::TickRecord tick = SampleTick(0);
  const record::SceneRecord scene = SampleScene(0);
  const test::RealtimeGuard guard;
  for (int k = 0; k < 2000; ++k) {
    recorder.Put(cycle);
    recorder.Put(tick);
    recorder.Put(scene);
    recorder.Event(Time(), "mode", "Move");
  }
  EXPECT_EQ(guard.counts(), test::RealtimeGuard::Counts{});
}

TEST(RecorderTest, InRealtimeDropsAndCountsWhatAStuckDiskCannotTake) {
  const TemporaryFolder folder;
  StuckFile file(folder / "a.mcap.partial");
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kDrop);
  // Two rings of 1024, and a chunk of 512 kB: of 4000 cycles most find their ring full.
  PutCycles(recorder, 4000);
  file.Release();
  const RecordingSummary summary = recorder.Finish();
  EXPECT_GT(summary.dropped, 2U * (4000 - 1024 - 512));
  EXPECT_LT(summary.dropped, 2U * 4000);
}

TEST(RecorderTest, InLockstepWaitsForASlowDiskAndLosesNothing) {
  const TemporaryFolder folder;
  StuckFile file(folder / "a.mcap.partial");
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  std::jthread producer([&recorder] { PutCycles(recorder, 2000); });
  file.Release();
  producer.join();
  const RecordingSummary summary = recorder.Finish();
  EXPECT_EQ(summary.dropped, 0U);
  EXPECT_EQ(summary.messages, 2U * 2000 + 4 + SampleFrames(2000))
      << "and one config for each 500 cycles, and frames";
}

/// What a log holds of each kind, after checking that each kind is in the order of its calls.
struct KindCounts {
  std::uint64_t cycles = 0;
  std::uint64_t ticks = 0;
  std::uint64_t events = 0;
};

KindCounts CountKindsInOrder(const std::filesystem::path& path) {
  KindCounts counts;
  Time cycle(Duration(-1));
  Time tick(Duration(-1));
  Time event(Duration(-1));
  const auto rises = [](Time& last, Time now) {
    EXPECT_LT(last, now);
    last = now;
  };
  LogReader reader(path);
  LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* record = std::get_if<record::CycleRecord>(&entry)) {
      ++counts.cycles;
      rises(cycle, record->at);
      // The content is of the same call, not torn between two.
      const auto k = static_cast<std::uint64_t>(record->at.time_since_epoch() / kCycle);
      EXPECT_EQ(record->state.message_id, k + 1000);
      EXPECT_EQ(record->dddq_d[6], static_cast<double>(k));
    } else if (const auto* answer = std::get_if<record::TickRecord>(&entry)) {
      ++counts.ticks;
      rises(tick, answer->read);
      EXPECT_EQ(answer->dq_ext[6], static_cast<double>(answer->message_id));
    } else {
      const auto& said = std::get<EventRecord>(entry);
      ++counts.events;
      rises(event, said.at);
      EXPECT_EQ(said.text, std::to_string(said.at.time_since_epoch().count()));
    }
    if (::testing::Test::HasFailure()) break;
  }
  return counts;
}

/// Now and then a pause, so that the rings run full and empty in turn.
void GiveTheWriterTime(int k) {
  if (k % 500 == 0) rt::Pause(std::chrono::microseconds(700));
}

TEST(RecorderTest, InRealtimeThreeThreadsPutWithoutHoldingUpEachOther) {
  constexpr int kRecords = test::Repetitions(20'000);
  constexpr int kEvents = 500;
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kDrop);
  {
    const std::jthread robot([&recorder] {
      record::CycleRecord cycle;
      for (int k = 0; k < kRecords; ++k) {
        cycle.at = Time(k * kCycle);
        cycle.state.message_id = static_cast<std::uint64_t>(k) + 1000;
        cycle.dddq_d[6] = k;
        recorder.Put(cycle);
        GiveTheWriterTime(k);
      }
    });
    const std::jthread communication([&recorder] {
      record::TickRecord tick;
      for (int k = 0; k < kRecords; ++k) {
        tick.read = tick.written = Time(k * kCycle);
        tick.message_id = static_cast<std::uint64_t>(k);
        tick.dq_ext[6] = k;
        recorder.Put(tick);
        GiveTheWriterTime(k);
      }
    });
    for (int k = 0; k < kEvents; ++k) {
      recorder.Event(Time(Duration(k)), "mode", std::to_string(k));
      GiveTheWriterTime(10 * k);
    }
  }
  const RecordingSummary summary = recorder.Finish();
  const KindCounts counts = CountKindsInOrder(folder / "a.mcap");
  EXPECT_EQ(counts.cycles + counts.ticks + counts.events + summary.dropped, 2U * kRecords + kEvents)
      << "what is not in the file was counted";
  EXPECT_GT(counts.cycles, 0U);
  EXPECT_GT(counts.ticks, 0U);
  EXPECT_GT(counts.events, 0U);
}

TEST(RecorderTest, InRealtimeAFloodOfOneKindCostsTheOthersNothing) {
  const TemporaryFolder folder;
  StuckFile file(folder / "a.mcap.partial");
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kDrop);
  const record::CycleRecord cycle = SampleCycle(0);
  for (int k = 0; k < 4000; ++k) recorder.Put(cycle);
  for (std::uint64_t k = 0; k < 1000; ++k) recorder.Put(SampleTick(k));
  for (int k = 0; k < 60; ++k) recorder.Event(Time(), "mode", "Idle");
  file.Release();
  const RecordingSummary summary = recorder.Finish();
  EXPECT_GT(summary.dropped, 0U);
  EXPECT_LE(summary.dropped, 4000U - 1024U) << "only cycles: ticks and events found room";
}

/// No file of this process may grow beyond a size, while this lives.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) : old_handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    const rlimit limit{.rlim_cur = bytes, .rlim_max = old_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }

 private:
  rlimit old_{};
  void (*old_handler_)(int);
};

TEST(RecorderTest, KeepsAFailureForFinishAndHoldsUpNobody) {
  const TemporaryFolder folder;
  const FileSizeLimit limit(200'000);
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait);
  PutCycles(recorder, 3000);
  try {
    recorder.Finish();
    FAIL() << "no exception";
  } catch (const EnvironmentError& error) {
    EXPECT_THAT(error.what(), HasSubstr("cannot write"));
    EXPECT_THAT(error.what(), HasSubstr("a.mcap.partial: File too large"));
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "a.mcap"));
}

TEST(RecorderTest, RefusesAFolderThatIsMissing) {
  EXPECT_THROW(Recorder("/nonexistent/a.mcap", SampleRun(), FullRing::kWait), EnvironmentError);
}

/// Records in a child process until it is killed. @returns after the file held `bytes` bytes.
void RecordAndKill(const std::filesystem::path& path, std::uintmax_t bytes) {
  const pid_t child = ::fork();
  if (child == 0) {
    Recorder recorder(path, SampleRun(), FullRing::kWait);
    PutCycles(recorder, 1'000'000);
    ::_exit(0);
  }
  auto partial = path;
  partial += ".partial";
  std::error_code missing;
  while (!std::filesystem::exists(partial, missing) ||
         std::filesystem::file_size(partial, missing) < bytes) {
    ASSERT_EQ(::waitpid(child, nullptr, WNOHANG), 0) << "the recording ended too early";
    std::this_thread::yield();
  }
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
}

TEST(RecorderTest, KilledWhileRecordingKeepsAllButTheOpenChunk) {
  const TemporaryFolder folder;
  RecordAndKill(folder / "a.mcap", 3'000'000);
  const auto size = std::filesystem::file_size(folder / "a.mcap.partial");
  LogReader reader(folder / "a.mcap.partial");
  EXPECT_TRUE(reader.truncated());
  EXPECT_EQ(reader.run().scenario, "sample");
  // A cycle, its tick and its share of the frames are 2.6 kB at most: what is read back fills the
  // file but for one chunk.
  EXPECT_GE(CountInOrder(reader) / 2 * 2600, size - Recorder::kChunkBytes);
}

}  // namespace
}  // namespace twin::record::record_recorder_test
