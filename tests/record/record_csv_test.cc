#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "record/csv_file.h"
#include "record/sample_records.h"
#include "record/temporary_folder.h"
#include "twin/core/error.h"
#include "twin/record/export_log.h"
#include "twin/record/recorder.h"

namespace twin::record::record_csv_test {
namespace {

using Row = std::map<std::string, std::string>;

/// Rows of a CSV file whose fields hold no quoted commas, by the names of the heading.
std::vector<Row> ReadCsv(const std::filesystem::path& path) {
  std::istringstream text(ReadText(path));
  const auto split = [](const std::string& line) {
    std::vector<std::string> fields;
    std::istringstream stream(line + ",");
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
  };
  std::string line;
  std::getline(text, line);
  const auto names = split(line);
  std::vector<Row> rows;
  while (std::getline(text, line)) {
    const auto fields = split(line);
    EXPECT_EQ(fields.size(), names.size()) << path;
    Row& row = rows.emplace_back();
    for (std::size_t i = 0; i < names.size(); ++i) row[names[i]] = fields[i];
    EXPECT_EQ(row.size(), names.size()) << "a column comes twice";
  }
  return rows;
}

void Record(const std::filesystem::path& path, std::uint64_t cycles) {
  Recorder recorder(path, SampleRun(), FullRing::kWait);
  for (std::uint64_t k = 0; k < cycles; ++k) {
    if (k == 5) continue;  // its violation is told in a sentence with commas
    recorder.Put(SampleCycle(k));
    recorder.Put(SampleTick(k));
  }
  recorder.Event(Time(Duration(7)), "mode", "Move");
  recorder.Finish();
}

std::uint64_t Bits(const std::string& number) {
  return std::bit_cast<std::uint64_t>(std::strtod(number.c_str(), nullptr));
}
std::uint64_t Bits(double number) {
  return std::bit_cast<std::uint64_t>(number);
}

TEST(ExportCsvTest, NumbersReadBackBitByBit) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 5);
  ExportCsv(folder / "a.mcap", folder / "csv");
  const auto cycles = ReadCsv(folder / "csv" / "cycles.csv");
  const auto ticks = ReadCsv(folder / "csv" / "ticks.csv");
  ASSERT_EQ(cycles.size(), 5U);
  ASSERT_EQ(ticks.size(), 5U);
  for (std::size_t k = 0; k < 5; ++k) {
    const record::CycleRecord cycle = SampleCycle(k);
    EXPECT_EQ(cycles[k].at("at_ns"), std::to_string(k * 1'000'000));
    EXPECT_EQ(Bits(cycles[k].at("q[0]")), Bits(cycle.state.q[0]));
    EXPECT_EQ(Bits(cycles[k].at("dddq_d[6]")), Bits(cycle.dddq_d[6]));
    EXPECT_EQ(Bits(cycles[k].at("O_T_EE[15]")), Bits(cycle.state.O_T_EE[15]));
    EXPECT_EQ(cycles[k].at("fate"), k == 3 ? "held" : "served");
    EXPECT_EQ(Bits(ticks[k].at("q_c[3]")), Bits(SampleTick(k).command.q_c[3]));
    EXPECT_EQ(ticks[k].at("action"), k == 3 ? "skipped" : k == 4 ? "invalid" : "written");
  }
}

TEST(ExportCsvTest, TellsOfTheViabilityFilterWhereThereWasOne) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 5);
  ExportCsv(folder / "a.mcap", folder / "csv");
  const auto ticks = ReadCsv(folder / "csv" / "ticks.csv");
  ASSERT_EQ(ticks.size(), 5U);
  EXPECT_EQ(Bits(ticks[2].at("margin")), Bits(SampleTick(2).margin.value()));
  EXPECT_EQ(ticks[2].at("kept_back"), "2");
  EXPECT_EQ(ticks[1].at("margin"), "") << "no filter";
  EXPECT_EQ(ticks[1].at("kept_back"), "0");
}

TEST(ExportCsvTest, WritesTheConfigurationWhenItChanges) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 1001);
  const LogExport written = ExportCsv(folder / "a.mcap", folder.path());
  EXPECT_EQ(written.cycles, 1000U);
  EXPECT_EQ(written.events, 1U);
  const auto rows = ReadCsv(folder / "config.csv");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[1].at("at_ns"), "500000000");
  EXPECT_EQ(Bits(rows[2].at("m_ee")), Bits(SampleCycle(1000).state.m_ee));
}

TEST(ExportCsvTest, HasATableOfTheBaseWhereThereIsOne) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 5);
  ExportCsv(folder / "a.mcap", folder / "without");
  EXPECT_FALSE(std::filesystem::exists(folder / "without" / "base.csv"));
  Record(folder / "b.mcap", 10);
  ExportCsv(folder / "b.mcap", folder / "with");
  const auto rows = ReadCsv(folder / "with" / "base.csv");
  ASSERT_EQ(rows.size(), 1U);
  const BaseState base = SampleCycle(7).base.value();
  EXPECT_EQ(rows[0].at("at_ns"), "7000000");
  EXPECT_EQ(rows[0].at("mode"), "emergency_stop");
  EXPECT_EQ(Bits(rows[0].at("yaw")), Bits(base.odometry.yaw));
  EXPECT_EQ(Bits(rows[0].at("w_d")), Bits(base.twist_d.w));
  EXPECT_EQ(Bits(rows[0].at("dq_rear_right")), Bits(base.dq_wheels[3]));
}

TEST(ExportCsvTest, ReplacesEarlierFilesWithTheSameBytes) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 20);
  ExportCsv(folder / "a.mcap", folder.path());
  const std::string first = ReadText(folder / "cycles.csv");
  ExportCsv(folder / "a.mcap", folder.path());
  EXPECT_EQ(ReadText(folder / "cycles.csv"), first);
}

TEST(ExportCsvTest, LeavesNothingOfADamagedLog) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 1000);
  std::string bytes = ReadText(folder / "a.mcap");
  bytes[bytes.size() / 2] ^= 1;
  std::ofstream(folder / "a.mcap", std::ios::binary) << bytes;
  EXPECT_THROW(ExportCsv(folder / "a.mcap", folder / "csv"), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "csv"));
}

TEST(ExportCsvTest, ReportsAFolderThatCannotBeMade) {
  const TemporaryFolder folder;
  Record(folder / "a.mcap", 1);
  EXPECT_THROW(ExportCsv(folder / "a.mcap", folder / "a.mcap" / "csv"), EnvironmentError);
}

TEST(CsvFileTest, QuotesTextThatNeedsIt) {
  const TemporaryFolder folder;
  CsvFile csv(folder / "a.csv");
  csv.Add(std::string_view("plain"));
  csv.Add(std::string_view("a, \"b\"\n"));
  csv.AddFloat(0.1);
  csv.EndRow();
  csv.Commit();
  EXPECT_EQ(ReadText(folder / "a.csv"), "plain,\"a, \"\"b\"\"\n\",0.1\n");
}

TEST(CsvFileTest, ShowsThatAFloatIsOne) {
  const TemporaryFolder folder;
  CsvFile csv(folder / "a.csv");
  for (const double value : {1.0, -0.0, 1e22, 0.25, 5e-324, 123456789.0}) csv.AddFloat(value);
  csv.Add(1);
  csv.EndRow();
  csv.Commit();
  EXPECT_EQ(ReadText(folder / "a.csv"), "1.0,-0.0,1e+22,0.25,5e-324,123456789.0,1\n");
}

}  // namespace
}  // namespace twin::record::record_csv_test
