#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "record/log_fields.h"
#include "record/sample_records.h"
#include "record/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/record/column_reader.h"
#include "twin/record/columns.h"
#include "twin/record/log_reader.h"
#include "twin/record/recorder.h"

namespace twin::record::record_columns_test {
namespace {

constexpr std::uint64_t kCycles = 40;

/// A log of small chunks, so that a table comes from several.
std::vector<std::byte> SampleLog() {
  const TemporaryFolder folder;
  Recorder recorder(folder / "a.mcap", SampleRun(), FullRing::kWait, {}, 8192);
  for (std::uint64_t k = 0; k < kCycles; ++k) {
    recorder.Put(SampleCycle(k));
    recorder.Put(SampleTick(k));
    recorder.Put(SampleScene(k));
    if (k == 7) recorder.Event(Time(7 * kCycle), "mode", "Move");
  }
  recorder.Add(SamplePlan());
  recorder.Finish();
  return ReadBytes(folder / "a.mcap");
}

Table ReadAll(const ColumnReader& reader, std::string_view name, int threads = 1) {
  const TableInfo& info = FindTable(name);
  return reader.Read(info, info.Choose({}), {}, threads);
}

const Column& In(const Table& table, std::string_view name) {
  return *table.columns[table.info->Find(name)];
}

const std::string& TextAt(const Column& column, std::size_t row) {
  return column.texts[static_cast<std::size_t>(column.At<std::int32_t>(row))];
}

template <class Record>
std::vector<Record> RecordsOf(const std::vector<std::byte>& log) {
  LogReader reader(log, "log");
  std::vector<Record> records;
  LogEntry entry;
  while (reader.Next(entry)) {
    if (const auto* record = std::get_if<Record>(&entry)) records.push_back(*record);
  }
  return records;
}

/// Bit by bit.
void ExpectRow(const Column& column, std::size_t row, std::span<const double> expected) {
  ASSERT_EQ(column.width, expected.size()) << column.info->name;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(column.At<std::uint64_t>(row * column.width + i),
              std::bit_cast<std::uint64_t>(expected[i]))
        << column.info->name << ", row " << row;
  }
}

TEST(ColumnReaderTest, HasTheCyclesOfTheLogReader) {
  const auto log = SampleLog();
  const Table table = ReadAll(ColumnReader(log, "log"), "cycles");
  const auto cycles = RecordsOf<CycleRecord>(log);
  ASSERT_EQ(table.rows, kCycles);
  ASSERT_EQ(cycles.size(), kCycles);
  for (std::size_t row = 0; row < kCycles; ++row) {
    const CycleRecord& cycle = cycles[row];
    EXPECT_EQ(In(table, "at_ns").At<std::int64_t>(row), cycle.at.time_since_epoch().count());
    EXPECT_EQ(In(table, "message_id").At<std::uint64_t>(row), cycle.state.message_id);
    EXPECT_EQ(In(table, "dropped").At<std::uint32_t>(row), cycle.dropped);
    EXPECT_EQ(TextAt(In(table, "fate"), row), row == 3 ? "held" : "served");
    EXPECT_EQ(TextAt(In(table, "robot_mode"), row), Name(cycle.state.robot_mode));
    EXPECT_EQ(TextAt(In(table, "motion_generator_mode"), row),
              Name(cycle.state.motion_generator_mode));
    EXPECT_EQ(TextAt(In(table, "violation"), row),
              cycle.violated ? Describe(cycle.violation) : std::string());
    for (const auto& field : kCycleFields) {
      ExpectRow(In(table, field.name), row, field.values(cycle));
    }
  }
  EXPECT_EQ(TextAt(In(table, "errors"), 5),
            "joint_position_limits_violation|base_acceleration_invalid_reading");
}

TEST(ColumnReaderTest, HasTheTicksOfTheLogReader) {
  const auto log = SampleLog();
  const Table table = ReadAll(ColumnReader(log, "log"), "ticks");
  const auto ticks = RecordsOf<TickRecord>(log);
  ASSERT_EQ(table.rows, kCycles);
  for (std::size_t row = 0; row < kCycles; ++row) {
    const TickRecord& tick = ticks[row];
    EXPECT_EQ(In(table, "written_ns").At<std::int64_t>(row),
              tick.written.time_since_epoch().count());
    EXPECT_EQ(In(table, "command_message_id").At<std::uint64_t>(row), tick.command.message_id);
    EXPECT_EQ(In(table, "valid_elbow").At<std::uint8_t>(row), tick.command.valid_elbow ? 1 : 0);
    EXPECT_EQ(In(table, "kept_back").At<std::uint32_t>(row), tick.kept_back);
    if (tick.margin) {
      ExpectRow(In(table, "margin"), row, std::span(&*tick.margin, 1));
    } else {
      EXPECT_TRUE(std::isnan(In(table, "margin").At<double>(row)));
    }
    for (const auto& field : kTickFields) ExpectRow(In(table, field.name), row, field.values(tick));
    for (const auto& field : kCommandFields) {
      ExpectRow(In(table, field.name), row, field.values(tick.command));
    }
  }
}

TEST(ColumnReaderTest, HasARowForEachContact) {
  const auto log = SampleLog();
  const ColumnReader reader(log, "log");
  const Table contacts = ReadAll(reader, "contacts");
  const Table scenes = ReadAll(reader, "scenes");
  std::size_t row = 0;
  std::size_t at = 0;
  for (const SceneRecord& scene : RecordsOf<SceneRecord>(log)) {
    ExpectRow(In(scenes, "qpos"), at++, scene.Positions());
    for (const PointForce& contact : scene.Contacts()) {
      EXPECT_EQ(In(contacts, "at_ns").At<std::int64_t>(row), scene.at.time_since_epoch().count());
      ExpectRow(In(contacts, "p_W"), row, contact.p_W);
      ExpectRow(In(contacts, "force_W"), row++, contact.force_W);
    }
  }
  EXPECT_EQ(scenes.rows, kCycles);
  EXPECT_EQ(contacts.rows, row);
  EXPECT_GT(row, 40U);
}

TEST(ColumnReaderTest, HasTheRestOfALog) {
  const auto log = SampleLog();
  const ColumnReader reader(log, "log");
  const Table config = ReadAll(reader, "config");
  ASSERT_EQ(config.rows, 1U);
  ExpectRow(In(config, "I_load"), 0, SampleCycle(0).state.I_load);
  const Table base = ReadAll(reader, "base");
  ASSERT_EQ(base.rows, 1U);
  EXPECT_EQ(In(base, "at_ns").At<std::int64_t>(0), 7'000'000);
  EXPECT_EQ(TextAt(In(base, "mode"), 0), "emergency_stop");
  ExpectRow(In(base, "dq_wheels"), 0, SampleCycle(7).base.value().dq_wheels);
  const Table accelerometers = ReadAll(reader, "accelerometers");
  ASSERT_EQ(accelerometers.rows, 1U);
  EXPECT_EQ(In(accelerometers, "at_ns").At<std::int64_t>(0), 7'000'000);
  ExpectRow(In(accelerometers, "top"), 0, SampleCycle(7).state.accelerometer_top);
  ExpectRow(In(accelerometers, "bottom"), 0, SampleCycle(7).state.accelerometer_bottom);
  const Table events = ReadAll(reader, "events");
  ASSERT_EQ(events.rows, 1U);
  EXPECT_EQ(TextAt(In(events, "kind"), 0), "mode");
  const Table plans = ReadAll(reader, "plans");
  ASSERT_EQ(plans.rows, 1U);
  ExpectRow(In(plans, "q"), 0, SamplePlan().q.value());
  EXPECT_EQ(TextAt(In(plans, "object"), 0), "block");
  EXPECT_EQ(reader.run().scenario, "sample");
  EXPECT_EQ(reader.last_ns(), (kCycles - 1) * 1'000'000 + 200'000);
}

TEST(ColumnReaderTest, GivesTheSameOnSeveralThreads) {
  const auto log = SampleLog();
  const ColumnReader reader(log, "log");
  const Table one = ReadAll(reader, "cycles", 1);
  const Table four = ReadAll(reader, "cycles", 4);
  ASSERT_EQ(one.rows, four.rows);
  for (std::size_t i = 0; i < one.columns.size(); ++i) {
    EXPECT_EQ(one.columns[i]->values, four.columns[i]->values);
    EXPECT_EQ(one.columns[i]->texts, four.columns[i]->texts);
  }
}

TEST(ColumnReaderTest, ReadsAnIntervalAndItsColumns) {
  const auto log = SampleLog();
  const ColumnReader reader(log, "log");
  const TableInfo& info = FindTable("cycles");
  const std::vector<std::string> names = {"q"};
  const Table part = reader.Read(info, info.Choose(names), {10'000'000, 13'000'000}, 1);
  ASSERT_EQ(part.rows, 3U);
  ASSERT_EQ(part.columns.size(), 2U);
  EXPECT_EQ(part.columns[0]->At<std::int64_t>(0), 10'000'000);
  ExpectRow(*part.columns[1], 2, SampleCycle(12).state.q);
  EXPECT_LT(reader.BytesIn({10'000'000, 13'000'000}), reader.BytesIn({}) / 2);
  const Table slice = ReadAll(reader, "cycles").Between(10'000'000, 13'000'000);
  EXPECT_EQ(slice.begin, 10U);
  EXPECT_EQ(slice.rows, 3U);
}

TEST(ColumnReaderTest, HasWidthsAndNamesWithoutRows) {
  const auto log = SampleLog();
  const TableInfo& info = FindTable("cycles");
  const Table none = ColumnReader(log, "log").Read(info, info.Choose({}), {-2, -1}, 1);
  EXPECT_EQ(none.rows, 0U);
  EXPECT_EQ(In(none, "q").width, kJoints);
  EXPECT_EQ(In(none, "fate").texts, (std::vector<std::string>{"none", "served", "held"}));
}

TEST(ColumnReaderTest, ReadsWhatAKilledRunLeft) {
  auto log = SampleLog();
  log.resize(log.size() / 2);
  const ColumnReader reader(log, "log");
  EXPECT_TRUE(reader.truncated());
  const Table cycles = ReadAll(reader, "cycles");
  EXPECT_EQ(cycles.rows, RecordsOf<CycleRecord>(log).size());
  EXPECT_GT(cycles.rows, 5U);
}

TEST(ColumnReaderTest, RefusesAChunkWhoseCrcIsWrong) {
  auto log = SampleLog();
  log[log.size() / 2] ^= std::byte{1};
  const ColumnReader reader(log, "log");
  EXPECT_THROW(static_cast<void>(ReadAll(reader, "cycles")), InputError);
}

TEST(LogTablesTest, NameTheNearestColumn) {
  try {
    static_cast<void>(FindTable("cycles").Find("tau_j"));
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("did you mean tau_J?"));
  }
  EXPECT_THROW(CheckColumns(std::vector<std::string>{"q", "no_such"}), InputError);
  EXPECT_NO_THROW(CheckColumns(std::vector<std::string>{"q", "force_W"}));
  EXPECT_THROW(static_cast<void>(FindTable("cycle")), InputError);
}

TEST(LogTablesTest, HaveAUnitAndAMeaning) {
  for (const TableInfo& table : LogTables()) {
    EXPECT_TRUE(table.columns.front().name.ends_with("_ns")) << table.name;
    for (const ColumnInfo& column : table.columns) EXPECT_NE(column.meaning, "") << column.name;
  }
}

}  // namespace
}  // namespace twin::record::record_columns_test
